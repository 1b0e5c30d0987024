from pathlib import Path

import numpy as np
import pytest

import loopelastica as le
from loopelastica._files import data_path
from loopelastica.molecule.nucleotides import read_structure

SHARED = Path(__file__).resolve().parents[2] / "shared"


@pytest.fixture(scope="session")
def hairpin_folder():
    folder = SHARED / "hairpins"
    if not folder.is_dir():
        pytest.skip("the reference structures are not beside this checkout (../shared/hairpins)")
    return folder


@pytest.fixture(scope="session")
def rod_folder():
    folder = SHARED / "rods"
    if not folder.is_dir():
        pytest.skip("the reference equilibria are not beside this checkout (../shared/rods)")
    return folder


@pytest.fixture
def rng():
    return np.random.default_rng(20181115)


# 2KOC: RNA, UUCG, 20 NMR models; most tests look at it


@pytest.fixture(scope="session")
def koc():
    return read_structure(data_path("hairpins/2koc.pdb"))


@pytest.fixture(scope="session")
def koc_lines():
    """Atom records of its first model."""
    text = data_path("hairpins/2koc.pdb").read_text().split("ENDMDL")[0]
    return [line for line in text.splitlines() if line.startswith(("ATOM", "HETATM"))]


@pytest.fixture(scope="session")
def fold(koc):
    (loop,) = le.fold(koc, all_models=False, stem_extend_5=0, stem_extend_3=0, taper=0)
    return loop


@pytest.fixture(scope="session")
def models(koc, fold):
    pytest.importorskip("rdkit")
    return le.build_atoms(koc, fold, max_candidates=2)


@pytest.fixture(scope="session")
def atoms(koc, fold, models):
    from loopelastica.report.atoms import LoopAtoms

    return LoopAtoms(koc, fold, tuple(models), koc.positions(0))
