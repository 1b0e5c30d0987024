"""Folds as a table."""

import csv
import sys

import gapped
import numpy as np
import pytest

import loopelastica as le
from loopelastica._files import data_path
from loopelastica.molecule.nucleotides import read_structure
from loopelastica.report.folder import write_fold

HAIRPIN = data_path("hairpins/2koc.pdb")


@pytest.fixture(scope="module")
def folds():
    return [
        *le.fold(HAIRPIN, all_models=False),
        *le.fold(HAIRPIN, all_models=False, length_per_nucleotide_A=2.0),
    ]


def test_a_row_per_candidate_and_one_per_failure(folds):
    pytest.importorskip("pandas")
    table = le.to_dataframe(folds)
    n = len(folds[0].candidates)
    assert len(table) == n + 1
    assert table["rank"][:n].tolist() == list(range(1, n + 1))
    assert table["rmsd_A"][0] == folds[0].candidates[0].rmsd_A
    assert set(table["loop"]) == {"A6-9"}
    assert table["failure"].notna().tolist() == [False] * n + [True]
    assert "no rod fits" in table["failure"][n]
    assert len(le.to_dataframe([])) == 0


def test_its_columns_are_those_of_the_file(folds, tmp_path):
    pytest.importorskip("pandas")
    write_fold(tmp_path / "a", HAIRPIN, folds[0], read_structure(HAIRPIN), plot=False)
    with (tmp_path / "a" / "ranking.csv").open() as file:
        rows = list(csv.DictReader(file))
    table = le.to_dataframe(folds[:1])
    assert ["file", *rows[0], "failure"] == list(table.columns)
    assert set(table["file"]) == {str(HAIRPIN)}
    assert [float(row["energy_per_A"]) for row in rows] == table["energy_per_A"].tolist()


def test_without_pandas_the_extra_is_named(folds, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(le.MissingDependencyError, match=r"loopelastica\[table\]"):
        le.to_dataframe(folds)


@pytest.mark.parametrize("results", [1.0, None, "abc", [1], object(), np.array(5.0)])
def test_what_is_no_result_is_refused(results):
    with pytest.raises(ValueError, match="`results`"):
        le.to_dataframe(results)


@pytest.fixture(scope="module")
def filling(tmp_path_factory):
    """One strand is filled, the bases of the other are not known."""
    pytest.importorskip("rdkit")
    atoms = [*gapped.chain({6, 7}), "TER", *gapped.chain({9}, name="B", moved=40.0)]
    path = tmp_path_factory.mktemp("filling") / "ab.pdb"
    return le.fill(gapped.pdb(path, atoms, head=gapped.seqres()))


def test_a_filling_has_a_row_per_strand(filling):
    pytest.importorskip("pandas")
    table = le.to_dataframe(filling)
    assert table["file"].tolist() == ["ab.pdb", "ab.pdb"]
    assert table["chain"].tolist() == ["A", "B"]
    assert table["first"].tolist() == ["6", "9"]
    assert table["status"].tolist() == ["filled", "refused"]
    assert table["sound"][0]
    assert table["expected_rmsd_A"][0] == round(float(filling.strands[0].expected_rmsd_A[1]), 2)
    assert np.isnan(table["expected_rmsd_A"][1])
    assert "has no sequence" in table["reason"][1]


def test_several_fillings_are_one_table(filling):
    pytest.importorskip("pandas")
    one = le.to_dataframe(filling)
    table = le.to_dataframe([filling, filling])
    assert list(table.columns) == list(one.columns)
    assert len(table) == 4
    assert len(le.to_dataframe(one for one in (filling,))) == 2


def test_its_columns_are_those_of_a_run(filling):
    pytest.importorskip("pandas")
    from loopelastica.batch.fills import COLUMNS

    assert [*le.to_dataframe(filling).columns, "folder"] == list(COLUMNS)


@pytest.fixture(scope="module")
def scans():
    return [
        *le.scan(HAIRPIN, extend_5_max=0, extend_3_max=0),
        *le.scan(HAIRPIN, extend_5_max=0, extend_3_max=0, length_per_nucleotide_A=2.0),
    ]


def test_a_scan_has_a_row_per_shape_and_one_per_failure(scans):
    pytest.importorskip("pandas")
    table = le.to_dataframe(scans)
    n = len(scans[0].candidates)
    assert table["rank"][:n].tolist() == list(range(1, n + 1))
    assert table["energy_per_A"][:n].is_monotonic_increasing or table["touching"][:n].any()
    assert table["stem_extend_5"][:n].tolist() == [0] * n
    assert table["file"][:n].tolist() == [str(HAIRPIN)] * n
    failed = table["failure"].notna()
    assert failed.sum() == sum(scan.failure is not None for scan in scans)
    assert len(le.to_dataframe(scans[0])) == n


def test_hairpins_have_a_row_each():
    pytest.importorskip("pandas")
    hairpins = le.find_hairpins(HAIRPIN)
    for given in (hairpins, hairpins[0], [*hairpins]):
        table = le.to_dataframe(given)
        assert table["loop"].tolist() == ["A6-9"]
        assert table["closing_pair"].tolist() == ["A.C5–A.G10"]
        assert table["nucleotides"].tolist() == [4]
        assert table["absent"].tolist() == [0]
        assert table["stem_pairs"].tolist() == [5]


def test_models_have_a_row_each_and_a_built_hairpin_all_its_candidates(models):
    pytest.importorskip("pandas")
    table = le.to_dataframe(models)
    assert table["rank"].tolist() == [model.rank for model in models]
    assert table["sound"].tolist() == [model.checks.sound for model in models]
    assert table["worst_bond_A"].tolist() == [model.checks.worst_bond_A for model in models]
    built = le.build("GGC(GAA)GCC", rna=False, candidates=2)
    table = le.to_dataframe(built)
    assert table["rank"].tolist() == [1, 2]
    assert set(table["sequence"]) == {"GGC(GAA)GCC"}
    assert table["shape"].tolist() == [c.shape for c in built.loop.candidates]


def test_equilibria_have_a_row_each():
    pytest.importorskip("pandas")
    clamping = le.Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])
    rods = le.equilibria(clamping, energy_max=30)
    table = le.to_dataframe(rods)
    assert table["energy"].tolist() == [rod.energy for rod in rods]
    np.testing.assert_array_equal(table[["F1", "F2", "F3"]], [rod.loads[:3] for rod in rods])


def test_one_result_and_a_list_of_it_are_the_same_table(folds):
    pandas = pytest.importorskip("pandas")
    pandas.testing.assert_frame_equal(le.to_dataframe(folds[0]), le.to_dataframe(folds[:1]))
    pandas.testing.assert_frame_equal(le.to_dataframe(folds), le.Folds(folds).to_dataframe())


def test_two_kinds_are_no_table(folds, scans):
    with pytest.raises(ValueError, match=r"`results` holds LoopFold and LoopScan; .* of one kind"):
        le.to_dataframe([*folds, *scans])
    for odd in ([folds[0], 3], le.LoopFold, {"a": 1}, "2koc.pdb"):
        with pytest.raises(ValueError, match="`results`"):
            le.to_dataframe(odd)
