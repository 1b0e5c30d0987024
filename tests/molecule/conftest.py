"""Structures that the tests of the molecule share."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

from loopelastica.molecule.hairpins import Hairpins, find_hairpins
from loopelastica.molecule.nucleotides import Structure, read_structure

ROOT = Path(__file__).parents[2]
SHARED = ROOT / ".." / "shared" / "hairpins"


@pytest.fixture(scope="session")
def hairpins_folder() -> Path:
    """Folder of real structures beside the checkout."""
    if not SHARED.is_dir():
        pytest.skip("the folder of real structures, ../shared/hairpins, is not here")
    return SHARED


@pytest.fixture(scope="session")
def structure_of(hairpins_folder: Path) -> Callable[[str], Structure]:
    """Read a real structure by its file's name, each once for all tests."""
    return cache(lambda name: read_structure(hairpins_folder / name))


@pytest.fixture(scope="session")
def found_in(structure_of: Callable[[str], Structure]) -> Callable[[str], Hairpins]:
    """Hairpins of a real structure by its file's name, found once."""
    return cache(lambda name: find_hairpins(structure_of(name)))


@pytest.fixture
def pdb(tmp_path: Path) -> Callable[..., Path]:
    """Write atom records, one list per model, as a PDB file."""

    def write(*models: list[str], name: str = "some.pdb") -> Path:
        path = tmp_path / name
        text = "".join(
            f"MODEL     {k:4d}\n" + "\n".join(lines) + "\nENDMDL\n"
            for k, lines in enumerate(models, start=1)
        )
        path.write_text(text + "END\n")
        return path

    return write
