from pathlib import Path

import pytest

import loopelastica as le
from loopelastica import datafiles

STRUCTURES = [name for name in datafiles.__all__ if name.startswith("RNA_")]


@pytest.mark.parametrize("name", STRUCTURES)
def test_each_structure_has_hairpins_and_is_the_entry_that_it_is_called(name):
    path = Path(getattr(datafiles, name))
    assert path.name.split(".")[0].upper() == name.removeprefix("RNA_")
    assert le.find_hairpins(path)


def test_every_structure_that_is_shipped_has_a_name():
    named = {Path(getattr(datafiles, name)) for name in STRUCTURES}
    assert named == set(Path(datafiles.RNA_2KOC).parent.iterdir())


def test_the_library_is_the_one_that_fold_uses():
    shipped = le.load_library(datafiles.LOOPS)
    first = le.fold(datafiles.RNA_430D, all_models=False)[0].candidates[0]
    named = le.fold(datafiles.RNA_430D, all_models=False, library=datafiles.LOOPS)[0].candidates[0]
    assert len(shipped) > 500
    assert (first.shape, first.energy_per_A) == (named.shape, named.energy_per_A)
