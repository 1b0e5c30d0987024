"""What an input says besides its atoms."""

import gzip

import pytest

from loopelastica.molecule.nucleotides import read_structure
from loopelastica.molecule.origin import origin_of

CELL = "CRYST1   54.981   33.389   61.921  90.00  90.20  90.00 P 1 21 1      4"


def test_a_pdb_file_has_a_cell_and_ends_of_chains(tmp_path, koc_lines):
    path = tmp_path / "cell.pdb.gz"
    path.write_bytes(gzip.compress("\n".join([CELL, *koc_lines, "TER", "END", ""]).encode()))
    origin = origin_of(read_structure(path))
    assert origin.cell == pytest.approx((54.981, 33.389, 61.921, 90.0, 90.2, 90.0))
    assert origin.space_group == "P 1 21 1"
    assert origin.ends == {len(koc_lines) - 1}


@pytest.mark.parametrize("length", ["1.000", "0.000", "  nan"])
def test_a_placeholder_is_no_cell(tmp_path, koc_lines, length):
    path = tmp_path / "fake.pdb"
    fake = f"CRYST1{length:>9s}{length:>9s}{length:>9s}  90.00  90.00  90.00 P 1           1"
    path.write_text("\n".join([fake, *koc_lines, "END", ""]))
    origin = origin_of(read_structure(path))
    assert origin.cell is None
    assert origin.space_group == ""
    assert origin.ends is None


def test_an_mmcif_file_has_a_cell(tmp_path, write_cif):
    path = write_cif(tmp_path / "cell.cif", "A")
    assert origin_of(read_structure(path)).cell is None
    cell = {"length_a": 54.981, "length_b": 33.389, "length_c": 61.921,
            "angle_alpha": 90, "angle_beta": 90.2, "angle_gamma": 90}  # fmt: skip
    lines = [f"_cell.{name} {value}" for name, value in cell.items()]
    lines.append("_symmetry.space_group_name_H-M 'P 1 21 1'")
    path.write_text("\n".join([path.read_text(), "#", *lines, ""]))
    origin = origin_of(read_structure(path))
    assert origin.cell == pytest.approx(tuple(cell.values()))
    assert origin.space_group == "P 1 21 1"


def test_a_universe_has_its_box(koc):
    universe = koc.universe.copy()
    assert origin_of(read_structure(universe)).cell is None
    universe.dimensions = [40.0, 41.0, 42.0, 90.0, 90.0, 90.0]
    assert origin_of(read_structure(universe)).cell == (40.0, 41.0, 42.0, 90.0, 90.0, 90.0)
