"""What stands in the way of a hairpin loop in a Universe."""

import numpy as np
import pytest

from loopelastica.molecule.ends import stem_ends
from loopelastica.molecule.hairpins import find_hairpins
from loopelastica.molecule.neighbours import neighbours, one_location
from loopelastica.molecule.nucleotides import read_structure


def hetero(resname, number, atoms, altloc=" "):
    return [
        f"HETATM{900 + k:5d} {name:^4s}{altloc}{resname:>3s} L{number:4d}    "
        f"{x:8.3f}{y:8.3f}{z:8.3f}  1.00  0.00          {element:>2s}"
        for k, (name, element, (x, y, z)) in enumerate(atoms)
    ]


@pytest.fixture
def seen(tmp_path, koc, koc_lines):
    """Names of what is in the way of 2KOC's loop, with some more atoms in the file."""
    (hairpin,) = find_hairpins(koc)
    ends = stem_ends(koc.nucleotides, hairpin, koc.positions(0))
    middle = 0.5 * (ends.start_origin_A + ends.end_origin_A)

    def seen(*lines, line_A=None):
        path = tmp_path / "more.pdb"
        path.write_text("\n".join([*koc_lines, *lines, "END", ""]))
        structure = read_structure(path)
        (found,) = find_hairpins(structure)
        positions = structure.positions(0)
        places = neighbours(structure).around(
            found, ends, middle[None] if line_A is None else line_A, positions
        )
        if places is None:
            return None
        atoms = structure.universe.atoms
        rows = [int(np.flatnonzero((positions == place).all(axis=1))[0]) for place in places]
        return {f"{atoms[row].resname}{atoms[row].resid}:{atoms[row].name}" for row in rows}

    return seen, middle


def test_only_its_own_hairpin_is_no_surroundings(seen):
    look, _ = seen
    assert look() is None


def test_a_ligand_is_in_the_way_and_so_is_the_stem_but_for_the_closing_pair(seen):
    look, middle = seen
    found = look(*hetero("LIG", 1, [("C1", "C", middle + 2.0), ("C2", "C", middle + 3.0)]))
    assert {"LIG1:C1", "LIG1:C2", "A4:C4'"} <= found
    assert not any(name.startswith(("C5:", "U6:", "U7:", "C8:", "G9:", "G10:")) for name in found)
    assert not any(name.split(":")[1].startswith("H") for name in found)


def test_what_gives_way_or_is_far_is_not_in_the_way(seen):
    look, middle = seen
    assert look(*hetero("HOH", 1, [("O", "O", middle + 2.0)])) is None
    assert look(*hetero("MG", 1, [("MG", "MG", middle + 2.0)])) is None
    assert look(*hetero("LIG", 1, [("H1", "H", middle + 2.0)])) is None
    assert look(*hetero("LIG", 1, [("C1", "C", middle + 60.0)])) is None
    # in reach of some line, but not near this one
    assert look(*hetero("LIG", 1, [("C1", "C", middle + [0.0, 0.0, 12.0])])) is None


def test_of_alternative_locations_one_is_in_the_way(seen):
    look, middle = seen
    both = [
        *hetero("LIG", 1, [("C1", "C", middle + 2.0)], "A"),
        *hetero("LIG", 1, [("C1", "C", middle + 4.0)], "B"),
    ]
    found = look(*both, *hetero("LIG", 2, [("C9", "C", middle + 3.0)]))
    assert {"LIG1:C1", "LIG2:C9"} <= found


def test_atoms_without_a_place_are_nowhere(koc):
    (hairpin,) = find_hairpins(koc)
    ends = stem_ends(koc.nucleotides, hairpin, koc.positions(0))
    nowhere = np.full_like(koc.positions(0), np.nan)
    assert neighbours(koc).around(hairpin, ends, np.zeros((1, 3)), nowhere) is None


def test_one_location_is_left_whatever_its_letter(tmp_path, koc_lines):
    path = tmp_path / "alternatives.pdb"
    place = np.array([60.0, 60.0, 60.0])
    ligand = [
        line
        for altloc in "BC"
        for line in hetero("LIG", 1, [("C1", "C", place), ("C2", "C", place + 1.5)], altloc)
    ]
    path.write_text("\n".join([*koc_lines, *ligand, "END", ""]))
    left = one_location(read_structure(path))
    assert left[: len(koc_lines)].all()
    assert left[len(koc_lines) :].tolist() == [True, True, False, False]
