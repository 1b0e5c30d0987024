"""2KOC with atoms, which most tests look at."""

import pytest

import loopelastica as le
from loopelastica._files import data_path
from loopelastica.atoms.model import build_atoms
from loopelastica.atoms.write import LoopAtoms
from loopelastica.molecule.nucleotides import read_structure

pytest.importorskip("rdkit")


@pytest.fixture(scope="session")
def koc():
    return read_structure(data_path("hairpins/2koc.pdb"))


@pytest.fixture(scope="session")
def fold(koc):
    (loop,) = le.fold(koc, all_models=False, stem_extend_5=0, stem_extend_3=0, taper=0)
    return loop


@pytest.fixture(scope="session")
def models(koc, fold):
    return build_atoms(koc, fold, max_candidates=2)


@pytest.fixture(scope="session")
def atoms(koc, fold, models):
    return LoopAtoms(koc, fold, tuple(models), koc.positions(0))
