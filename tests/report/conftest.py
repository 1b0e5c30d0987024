"""Folders that are written."""

import sys
from pathlib import Path

import pytest

import loopelastica as le
from loopelastica._files import data_path
from loopelastica.molecule.nucleotides import read_structure
from loopelastica.report.folder import write_fold
from loopelastica.report.pdb import WholeStructure

# strands and deletions that several tests share
sys.path.insert(0, str(Path(__file__).parent))


def _written(path, folder, **options):
    structure = read_structure(path)
    fold = le.fold(structure, all_models=False, **options)[0]
    out = folder / "out" / "loop"
    write_fold(out, path, fold, structure, plot=False, whole=WholeStructure(structure))
    return out, fold


@pytest.fixture(scope="session")
def written():
    """Fold the first loop of a file and write its folder."""
    return _written


@pytest.fixture(scope="session")
def refused(koc):
    """2KOC with a line that is too short."""
    (loop,) = le.fold(koc, length_per_nucleotide_A=2.0, all_models=False)
    return loop


@pytest.fixture(scope="session")
def shipped(tmp_path_factory):
    return _written(data_path("hairpins/2koc.pdb"), tmp_path_factory.mktemp("shipped"))


@pytest.fixture(scope="session")
def gap_folder():
    folder = Path(__file__).resolve().parents[3] / "shared" / "gaps"
    if not folder.is_dir():
        pytest.skip("the structures with gaps are not beside this checkout (../shared/gaps)")
    return folder


@pytest.fixture
def of_lines(tmp_path, atoms):
    """The built loop of 2KOC in a file of other lines, whose nucleotides are the same."""
    from loopelastica.report.atoms import LoopAtoms

    def made(lines, name="lines.pdb", models=atoms.models, **options):
        path = tmp_path / name
        path.write_text("\n".join([*lines, "END", ""]))
        structure = read_structure(path)
        return LoopAtoms(structure, atoms.fold, models, structure.positions(0), **options)

    return made
