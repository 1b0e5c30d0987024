"""Folds as a table."""

import csv
import sys

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
    assert [*rows[0], "failure"] == list(table.columns)
    assert [float(row["energy_per_A"]) for row in rows] == table["energy_per_A"].tolist()


def test_without_pandas_the_extra_is_named(folds, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(le.MissingDependencyError, match=r"loopelastica\[table\]"):
        le.to_dataframe(folds)


@pytest.mark.parametrize("results", [1.0, None, "abc", [1], object(), np.array(5.0)])
def test_what_is_no_result_is_refused(results):
    with pytest.raises(ValueError, match="`results`"):
        le.to_dataframe(results)
