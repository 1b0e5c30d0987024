"""What stands in the way of a strand, and how crowded it is there."""

import gapped
import numpy as np
import pytest

from loopelastica.molecule.entry import read_entry
from loopelastica.molecule.gaps import find_gaps
from loopelastica.molecule.obstacles import crowding, obstacles, own_atoms
from loopelastica.molecule.strand_ends import strand_ends
from loopelastica.molecule.surroundings import heavy_atoms


def hetero(name, number, atoms):
    return [
        f"HETATM{900 + k:5d} {atom:>4} {name:>3} L{number:4d}    "
        f"{x:8.3f}{y:8.3f}{z:8.3f}  1.00 20.00          {element:>2}"
        for k, (atom, element, (x, y, z)) in enumerate(atoms, start=1)
    ]


@pytest.fixture(scope="module")
def seen(tmp_path_factory):
    """2KOC without U6 and U7, with a ligand, a water, an ion, a protein far away and O3' of U6."""
    folder = tmp_path_factory.mktemp("obstacles")
    bare = read_entry(gapped.gapped(folder / "bare.pdb", {6, 7}))
    (gap,) = find_gaps(bare).gaps
    ends = strand_ends(gap)
    middle = (ends.start_origin_A + ends.end_origin_A) / 2
    chain = gapped.chain({7, *((6, atom) for atom in _all_but_o3())})
    more = [
        *hetero("LIG", 1, [("C1", "C", middle), ("C2", "C", middle + 1.0)]),
        *hetero("HOH", 2, [("O", "O", middle + 2.0)]),
        *hetero("MG", 3, [("MG", "MG", middle + 3.0)]),
        *hetero("FAR", 4, [("C1", "C", middle + 60.0), ("C2", "C", middle + 61.0)]),
    ]
    path = gapped.pdb(folder / "a.pdb", [*chain, "TER", *more], head=gapped.seqres())
    entry = read_entry(path)
    (gap,) = find_gaps(entry).gaps
    return gap, strand_ends(gap), heavy_atoms(entry)


def _all_but_o3():
    return {line[12:16].strip() for line in gapped.chain() if int(line[22:26]) == 6} - {"O3'"}


def labels(atoms, rows):
    return {atoms.labels[atoms.residue[row]] for row in rows}


def test_the_strand_and_its_flanks_are_its_own(seen):
    gap, _, atoms = seen
    own = labels(atoms, np.flatnonzero(own_atoms(gap, atoms)))
    assert own == {"A.C5", "A.U6", "A.C8"}


def test_all_but_waters_ions_and_its_own_atoms_stand_in_its_way(seen):
    gap, ends, atoms = seen
    found = labels(atoms, obstacles(gap, ends, atoms))
    assert "L.LIG1" in found
    assert "A.G9" in found
    assert "A.A4" in found
    assert not found & {"A.C5", "A.U6", "A.C8", "L.HOH2", "L.MG3", "L.FAR4"}


def test_a_chain_of_single_atoms_stands_in_the_way(seen, tmp_path):
    _, ends, _ = seen
    middle = (ends.start_origin_A + ends.end_origin_A) / 2
    trace = hetero("ALA", 1, [("CA", "C", middle)]) + hetero("ALA", 2, [("CA", "C", middle + 2.0)])
    atoms = [*gapped.chain({6, 7}), "TER", *trace]
    entry = read_entry(gapped.pdb(tmp_path / "a.pdb", atoms, head=gapped.seqres()))
    (gap,) = find_gaps(entry).gaps
    found = heavy_atoms(entry)
    assert {"L.ALA1", "L.ALA2"} <= labels(found, obstacles(gap, strand_ends(gap), found))


def test_no_atom_that_a_line_can_come_near_is_left_out(seen):
    gap, ends, atoms = seen
    rows = set(obstacles(gap, ends, atoms).tolist())
    middle = (ends.start_origin_A + ends.end_origin_A) / 2
    apart = np.linalg.norm(atoms.positions_A - middle, axis=1)
    single = np.bincount(atoms.residue)[atoms.residue] == 1
    near = np.flatnonzero(
        (apart < ends.length_A / 2 + 5.0) & ~own_atoms(gap, atoms) & ~atoms.water & ~single
    )
    assert set(near.tolist()) <= rows


def test_crowding_counts_atoms_around_the_chord_per_nucleotide(seen):
    _, ends, _ = seen
    start, end = ends.start_origin_A, ends.end_origin_A
    along = (end - start) / np.linalg.norm(end - start)
    across = np.cross(along, [0.0, 0.0, 1.0])
    across /= np.linalg.norm(across)
    inside = [start, (start + end) / 2 + 9.9 * across, end + 9.9 * along, start - 9.9 * along]
    outside = [(start + end) / 2 + 10.1 * across, end + 10.1 * along, start - 10.1 * along]
    assert crowding(ends, np.array(inside + outside)) == len(inside) / ends.n
    assert crowding(ends, np.zeros((0, 3))) == 0.0
