"""Structures that the tests of the molecule share."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path

import pytest

from loopelastica.molecule.hairpins import Hairpins, find_hairpins
from loopelastica.molecule.nucleotides import Structure, read_structure

# records of files with gaps
sys.path.insert(0, str(Path(__file__).parent))

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


# --- 2KOC with nucleotides taken out --------------------------------------------------------------


@pytest.fixture
def lines(koc_lines) -> Callable[..., list[str]]:
    """Heavy atoms of 2KOC without some of its nucleotides; numbers and names by choice."""

    from chain_files import numbered

    def take(
        without: Iterable[int] = (6, 7, 8, 9),
        *,
        chain: str = "A",
        number: Callable[[int], str] = lambda n: f"{n:4d} ",
        keep: Callable[[int, str], bool] = lambda n, atom: True,
    ) -> list[str]:
        return [
            f"{line[:21]}{chain}{number(numbered(line))}{line[27:]}"
            for line in koc_lines
            if line[76:78].strip() != "H"
            and numbered(line) not in set(without)
            and keep(numbered(line), line[12:16].strip())
        ]

    return take


@pytest.fixture
def entry(tmp_path):
    """Write records of a PDB file and read it."""
    from loopelastica.molecule.entry import read_entry

    def read(*records: Iterable[str], name: str = "gap.pdb"):
        path = tmp_path / name
        path.write_text("\n".join([line for group in records for line in group] + ["END", ""]))
        return read_entry(path)

    return read


@pytest.fixture
def cif(tmp_path):
    """Write categories of an mmCIF file and read it."""
    from loopelastica.molecule.entry import read_entry

    def read(*categories: Iterable[str], name: str = "gap.cif"):
        path = tmp_path / name
        rows = [line for category in categories for line in category]
        path.write_text("\n".join(["data_gap", *rows, ""]))
        return read_entry(path)

    return read
