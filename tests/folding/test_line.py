"""Lines between the ends of a strand, among what is there."""

import math

import gapped
import numpy as np
import pytest

from loopelastica.errors import StructureError
from loopelastica.folding import line as module
from loopelastica.folding.line import strand_lines
from loopelastica.molecule.entry import read_entry
from loopelastica.molecule.gaps import find_gaps
from loopelastica.molecule.polymer import HeavyAtoms
from loopelastica.molecule.strand_ends import strand_ends
from loopelastica.molecule.surroundings import heavy_atoms
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.solve import solve


def gap_and_atoms(path):
    entry = read_entry(path)
    (gap,) = find_gaps(entry).gaps
    return gap, strand_ends(gap), heavy_atoms(entry)


@pytest.fixture(scope="module")
def two(tmp_path_factory):
    """U6 and U7 of 2KOC are missing."""
    return gap_and_atoms(gapped.gapped(tmp_path_factory.mktemp("line") / "a.pdb", {6, 7}))


@pytest.fixture(scope="module")
def seven(tmp_path_factory):
    return gap_and_atoms(
        gapped.gapped(tmp_path_factory.mktemp("line") / "a.pdb", set(range(4, 11)))
    )


def somewhere(*positions):
    """A ligand of carbons."""
    n = len(positions)
    return HeavyAtoms(
        positions_A=np.array(positions, dtype=float).reshape(-1, 3),
        element=np.full(n, "C"),
        name=np.array([f"C{k + 1}" for k in range(n)], dtype=np.str_),
        residue=np.zeros(n, dtype=np.int64),
        labels=("L.LIG1",),
        water=np.zeros(n, dtype=np.bool_),
        metal=np.zeros(n, dtype=np.bool_),
        places=(("L", 1, "", "LIG"),),
    )


NOTHING = somewhere()


def test_a_line_goes_from_end_to_end_by_its_tangents(two):
    gap, ends, atoms = two
    (line,) = strand_lines(gap, ends, atoms)
    s = np.linspace(0.0, 1.0, 401)
    points = ends.to_file(line.rod.centerline(s))
    np.testing.assert_allclose(points[0], ends.start_origin_A, atol=1e-6)
    np.testing.assert_allclose(points[-1], ends.end_origin_A, atol=1e-6)
    steps = np.diff(points, axis=0)
    assert np.linalg.norm(steps, axis=1).sum() == pytest.approx(ends.length_A, rel=1e-3)
    for step, frame in ((steps[0], ends.start_frame), (steps[-1], ends.end_frame)):
        assert step @ frame[:, 2] / np.linalg.norm(step) == pytest.approx(1.0, abs=1e-3)


def test_its_trace_has_a_point_per_nucleotide_on_the_line(two):
    gap, ends, atoms = two
    (line,) = strand_lines(gap, ends, atoms)
    assert line.trace.shape == (2, 3)
    on_it = ends.to_file(line.rod.centerline(np.array([0.25, 0.75])))
    np.testing.assert_allclose(line.trace, on_it, atol=1e-6)


def test_without_atoms_it_is_the_ideal_rod(seven):
    gap, ends, _ = seven
    (line,) = strand_lines(gap, ends, NOTHING)
    clamping = Clamping.from_frames(
        ends.start_origin_A, ends.start_frame, ends.end_origin_A, ends.end_frame, ends.length_A,
        free_spin=True,
    )  # fmt: skip
    free = solve(clamping)
    assert line.rod.energy == pytest.approx(free.energy, rel=0.01)
    assert line.contact_energy_per_A == pytest.approx(0.0, abs=1e-9)
    assert line.nearest_A is None
    assert line.nearest_atom == ""
    s = np.linspace(0.0, 1.0, 21)
    apart = ends.to_file(line.rod.centerline(s)) - ends.to_file(free.centerline(s))
    assert np.linalg.norm(apart, axis=1).max() < 0.15


def test_an_atom_on_the_line_pushes_it_aside_at_a_cost(seven):
    gap, ends, _ = seven
    (free,) = strand_lines(gap, ends, NOTHING)
    atom = ends.to_file(free.rod.centerline(np.array([0.5])))[0] + 0.3
    (line,) = strand_lines(gap, ends, somewhere(atom, atom + 20.0))
    assert line.nearest_A > 2.5
    points = ends.to_file(line.rod.centerline(np.linspace(0, 1, 2001)))
    assert line.nearest_A == pytest.approx(np.linalg.norm(points - atom, axis=1).min(), abs=0.02)
    assert line.nearest_atom == "L.LIG1 C1"
    assert line.energy_per_A > free.energy_per_A
    assert line.contact_energy_per_A > 0.0


def test_the_least_energy_comes_first_and_candidates_differ(seven):
    gap, ends, atoms = seven
    lines = strand_lines(gap, ends, atoms, most=4)
    assert [line.rank for line in lines] == list(range(1, len(lines) + 1))
    assert len(lines) > 1
    sums = [line.energy_per_A + line.contact_energy_per_A for line in lines]
    assert sums == sorted(sums)
    for k, line in enumerate(lines):
        for other in lines[:k]:
            assert np.abs(line.trace - other.trace).max() > 0.5
    (first,) = strand_lines(gap, ends, atoms)
    np.testing.assert_array_equal(first.trace, lines[0].trace)


def test_energies_are_in_one_unit(two):
    gap, ends, atoms = two
    (line,) = strand_lines(gap, ends, atoms)
    assert line.energy_per_A * ends.length_A == pytest.approx(line.rod.energy)
    assert math.isfinite(line.contact_energy_per_A)
    assert repr(line).startswith("<StrandLine 1: E/K0 ")


def test_where_no_rod_is_found_the_strand_is_refused_by_its_name(two, monkeypatch):
    class Lost:
        converged = False
        message = "the ends are too far apart"

    monkeypatch.setattr(module, "rods_among", lambda *_, **__: (Lost(),))
    with pytest.raises(StructureError, match=r"A\.6-7: no line was found .*the ends are too far"):
        strand_lines(*two)
