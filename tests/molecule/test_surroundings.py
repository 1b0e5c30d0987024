"""Heavy atoms of a model, and their images in the crystal."""

from __future__ import annotations

import gemmi
import numpy as np
import pytest
from chain_files import SEQUENCE, seqres

from loopelastica._files import data_path
from loopelastica.molecule.entry import read_entry
from loopelastica.molecule.surroundings import heavy_atoms, symmetry_mates

CELL = "CRYST1   40.000   45.000   50.000  90.00 100.00  90.00 P 1 21 1      2"
WATER = "HETATM 9001  O   HOH A 201      20.000  20.000  20.000  1.00 10.00           O"
MAGNESIUM = "HETATM 9002 MG    MG A 202      22.000  20.000  20.000  1.00 10.00          MG"


def test_heavy_atoms_are_those_that_are_no_hydrogen(koc):
    atoms = heavy_atoms(read_entry(data_path("hairpins/2koc.pdb")), model=4)
    assert set(atoms.element) == {"C", "N", "O", "P"}
    chosen = koc.universe.select_atoms("not element H").indices
    np.testing.assert_allclose(atoms.positions_A, koc.positions(4)[chosen], atol=1e-4)
    assert atoms.labels[:2] == ("A.G1", "A.G2")
    assert len(atoms.labels) == 14
    assert not atoms.metal.any()
    assert not atoms.water.any()


def test_waters_and_metals_are_marked(entry, lines):
    atoms = heavy_atoms(entry(lines(), [WATER, MAGNESIUM]))
    assert atoms.labels[-2:] == ("A.HOH201", "A.MG202")
    assert np.flatnonzero(atoms.water).tolist() == [len(atoms.name) - 2]
    assert np.flatnonzero(atoms.metal).tolist() == [len(atoms.name) - 1]
    assert atoms.element[-1] == "MG"


def test_elements_by_name_where_there_is_no_symbol(entry, koc_lines):
    bare = [line[:76] for line in koc_lines]
    ions = [line[:76] for line in (WATER, MAGNESIUM)]
    atoms = heavy_atoms(entry(bare, ions))
    assert set(atoms.element) == {"C", "N", "O", "P", "MG"}
    assert atoms.metal.sum() == 1


def test_of_alternative_locations_one_is_listed(entry, lines):
    there = lines()
    other = [f"{x[:16]}B{x[17:54]}{0.6:6.2f}{x[60:]}" for x in there if x[22:26] == "   3"]
    first = [f"{x[:16]}A{x[17:54]}{0.4:6.2f}{x[60:]}" if x[22:26] == "   3" else x for x in there]
    assert len(heavy_atoms(entry(first, other)).name) == len(there)


def by_brute_force(structure, points, radius):
    """Every operation of the space group with every translation of three cells each way."""
    group = gemmi.find_spacegroup_by_name(structure.spacegroup_hm)
    own = np.array([a.pos.tolist() for c in structure[0] for r in c for a in r])
    fractional = np.array([structure.cell.fractionalize(gemmi.Position(*x)).tolist() for x in own])
    found = []
    for operation in group.operations():
        moved = np.array([operation.apply_to_xyz(list(x)) for x in fractional])
        for shift in np.ndindex(7, 7, 7):
            cells = moved + np.array(shift) - 3
            if operation == gemmi.Op() and shift == (3, 3, 3):
                continue
            placed = [structure.cell.orthogonalize(gemmi.Fractional(*x)).tolist() for x in cells]
            distance = np.linalg.norm(np.array(placed)[:, None] - points, axis=2).min(axis=1)
            found += [placed[k] for k in np.flatnonzero(distance <= radius)]
    return np.array(sorted(found)).reshape(-1, 3)


def test_mates_are_those_of_the_space_group(entry, lines):
    crystal = entry([CELL], lines(keep=lambda n, atom: atom == "P"))
    points = heavy_atoms(crystal).positions_A[[2, 7]] + 5.0
    mates = symmetry_mates(crystal, points, 22.0)
    assert len(mates) > 10
    np.testing.assert_allclose(
        sorted(mates.tolist()), by_brute_force(crystal.structure, points, 22.0), atol=2e-3
    )


@pytest.mark.parametrize(
    "header",
    [
        [],
        ["CRYST1    1.000    1.000    1.000  90.00  90.00  90.00 P 1           1"],
        ["EXPDTA    SOLUTION NMR", CELL],
        ["EXPDTA    ELECTRON MICROSCOPY", CELL],
    ],
)
def test_no_crystal_has_no_mates(entry, lines, header):
    found = entry(header, seqres(SEQUENCE), lines())
    assert symmetry_mates(found, heavy_atoms(found).positions_A[:3], 30.0).shape == (0, 3)
    assert symmetry_mates(found, [], 30.0).shape == (0, 3)
