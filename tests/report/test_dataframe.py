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
