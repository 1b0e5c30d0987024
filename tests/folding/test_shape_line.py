"""Lines of a strand that have the shape of others: which, in what order, what is expected."""

import gapped
import numpy as np
import pytest
from loop_shapes import found

from loopelastica.folding.known import FIRST, library_at
from loopelastica.folding.library import Library
from loopelastica.folding.line import StrandLine, strand_lines
from loopelastica.folding.motifs import errors_of
from loopelastica.folding.shape_line import (
    MOST_BENT,
    expected_error,
    known_strand,
    library_lines,
)
from loopelastica.folding.shape_table import FoundLoop
from loopelastica.molecule.ends import fit_stem
from loopelastica.molecule.entry import read_entry
from loopelastica.molecule.gaps import find_gaps
from loopelastica.molecule.hairpins import find_hairpins
from loopelastica.molecule.obstacles import crowding, obstacles
from loopelastica.molecule.polymer import HeavyAtoms
from loopelastica.molecule.shapes import LoopShape, loop_shape
from loopelastica.molecule.strand_ends import flank_poses, strand_ends
from loopelastica.molecule.surroundings import heavy_atoms

ROD = "rod in its surroundings"


def strand(path, strands=None):
    entry = read_entry(path)
    (gap,) = find_gaps(entry, 0, strands).gaps
    return gap, strand_ends(gap), heavy_atoms(entry).without({m.label for m in gap.replaces})


@pytest.fixture(scope="module")
def loop(tmp_path_factory):
    """2KOC without its loop, UUCG."""
    return strand(gapped.gapped(tmp_path_factory.mktemp("shape") / "a.pdb", {6, 7, 8, 9}))


@pytest.fixture(scope="module")
def own(koc):
    """The loop of 2KOC as a library has it, by any sequence."""
    made, _ = loop_shape(koc.nucleotides, find_hairpins(koc)[0], koc.positions(0))

    def named(sequence, entry="9xyz"):
        shape = LoopShape(sequence, False, made.steps_A, made.end_frame, f"{entry} A.1-A.6")
        return FoundLoop(shape, entry, 0.5)

    return named


def lines(strand, library, most=4):
    known = known_strand(*strand, library)
    return known, library_lines(*strand, known, strand_lines(*strand, most))


def test_the_poses_of_the_flanks_are_those_of_the_stem(loop, koc):
    gap, *_ = loop
    poses = flank_poses(gap.before, gap.after)
    stem = fit_stem(koc.nucleotides, find_hairpins(koc)[0], koc.positions(0)).closing()
    assert np.linalg.norm(poses.position_A - stem.position_A) < 2.0
    assert np.degrees(np.arccos((np.trace(poses.rotation.T @ stem.rotation) - 1) / 2)) < 20.0


def test_the_same_sequence_comes_before_the_rods(loop, own):
    known, found_lines = lines(loop, Library.of([own("GUUCGC"), own("AACACU", "8xyz")]))
    assert known.loop.sequence == "CUUCGG"
    shapes = [line.shape for line in found_lines]
    assert shapes[:2] == ["motif UNCG, same sequence, 1 loop", ROD]
    first = found_lines[0]
    assert first.trace.shape == (4, 3)
    assert first.carried == ()
    assert first.stable
    assert first.residual < 1e-6
    assert first.contact_energy_per_A is None
    assert first.nearest_A > 2.0
    assert first.nearest_atom.startswith("A.")
    assert repr(first).startswith("<ShapeLine motif UNCG, same sequence, 1 loop: E/K0 ")


def test_a_motif_comes_before_the_rods(loop, own):
    _, found_lines = lines(loop, Library.of([own("GUACGC"), own("AACACU", "8xyz")]))
    assert [line.shape for line in found_lines[:2]] == ["motif UNCG, 1 loop", ROD]


def test_a_mean_that_errs_more_than_the_rod_comes_after_it(loop):
    others = Library.of(found("GACACC", f"{k + 1}xyz", seed=k, bend=0.3) for k in range(6))
    _, found_lines = lines(loop, others)
    names = [line.shape for line in found_lines]
    assert names[:2] == [ROD, "mean of 6 loops"]
    assert names[2].startswith("library ")
    assert names[2].endswith("xyz A.1-A.9 (ACAC)")
    assert len(set(names[:FIRST])) == FIRST


@pytest.mark.parametrize("sequence", ["UUCG", "GAAA", "ACAC", "CUUG", "UUUU"])
def test_of_mean_and_rod_the_one_that_errs_less_is_first(tmp_path, sequence):
    any_loop = strand(gapped.gapped(tmp_path / "a.pdb", {6, 7, 8, 9}), f"A.6-9={sequence}")
    _, found_lines = lines(any_loop, library_at(None))
    gap, ends, atoms = any_loop
    crowded = crowding(ends, atoms.positions_A[obstacles(gap, ends, atoms)])
    middle = [expected_error(line, crowded)[1] for line in found_lines[:2]]
    assert middle == sorted(middle)
    assert {isinstance(line, StrandLine) for line in found_lines[:2]} == {True, False}
    assert not found_lines[0].shape.startswith("library ")
    assert not found_lines[1].shape.startswith("library ")


@pytest.mark.parametrize("bend", [0.0, 1.0])
def test_a_single_loop_that_does_not_fit_the_ends_is_not_sure_of_itself(loop, bend):
    known, found_lines = lines(loop, Library.of([found("CUUCGG", "9xyz", bend=bend)]))
    assert 2.0 < known.energies.min() < MOST_BENT
    names = [line.shape for line in found_lines]
    assert names[:2] == [ROD, "motif UNCG, same sequence, 1 loop"]
    assert expected_error(found_lines[1], 30.0)[1] > 2.0


def test_of_rods_each_is_there_once_and_in_its_order(loop):
    known = known_strand(*loop, library_at(None))
    rods = strand_lines(*loop, 4)
    found_lines = library_lines(*loop, known, rods)
    assert [line for line in found_lines if isinstance(line, StrandLine)] == list(rods)


def test_dna_has_the_rod_first(tmp_path):
    dna = strand(gapped.gapped(tmp_path / "dna.pdb", {6, 7, 8, 9}, dna=True))
    known, found_lines = lines(dna, library_at(None))
    assert known.loop.is_dna
    assert found_lines[0].shape == ROD
    assert found_lines[1].shape.startswith("library ")


@pytest.mark.parametrize(
    ("gone", "reason"),
    [
        ({7}, "the library has no other loop of 1 nucleotide"),
        ({6, 7}, "the library has no other loop of 2 nucleotides"),
        ({2, 3, 4}, "its ends are not like those of a hairpin loop"),
        ({10, 11, 12}, "its ends are not like those of a hairpin loop"),
    ],
)
def test_a_strand_that_no_hairpin_loop_is_like_says_why(tmp_path, gone, reason):
    assert (
        known_strand(*strand(gapped.gapped(tmp_path / "a.pdb", gone)), library_at(None)) == reason
    )


def test_a_strand_of_more_nucleotides_than_a_library_holds_says_so(tmp_path):
    path = gapped.gapped(
        tmp_path / "a.pdb",
        {6, 7, 8, 9},
        places=[*gapped.PLACES[:9], *((number + 10, "") for number in range(10, 15))],
    )
    long = strand(path, f"A.6-19={14 * 'A'}")
    assert (
        known_strand(*long, library_at(None)) == "the library has no other loop of 14 nucleotides"
    )


def test_nothing_is_known_from_its_own_entry(loop, own):
    library = Library.of([own("GUUCGC", "9xyz")])
    nothing = known_strand(*loop, library, ("9xyz",))
    assert nothing == "the library has no other loop of 4 nucleotides"


def test_expected_errors_are_of_the_kind_and_less_where_the_loop_is_known(loop):
    _, found_lines = lines(loop, library_at(None))
    for line in found_lines:
        low, middle, high = expected_error(line, 30.0)
        assert 0.0 <= low < middle < high
    assert expected_error(found_lines[0], 30.0)[1] < expected_error(found_lines[1], 30.0)[1]
    known = known_strand(*loop, library_at(None))
    first = found_lines[0]
    errors = errors_of("motif UNCG").at(known.spread_A(first.trace), first.chain.energy, 4)
    np.testing.assert_allclose(first.expected_rmsd_A, errors)


def test_atoms_in_its_way_make_a_shape_lighter(loop):
    gap, ends, atoms = loop
    library = library_at(None)
    free = known_strand(gap, ends, atoms, library)
    k = int(np.argmax(free.weighted.weights))
    at = np.repeat(free.poses.to_file(free.weighted.nodes_A[k]), 3, axis=0)
    n = len(at)
    ligand = HeavyAtoms(
        positions_A=at,
        element=np.full(n, "C"),
        name=np.array([f"C{k + 1}" for k in range(n)], dtype=np.str_),
        residue=np.zeros(n, dtype=np.int64),
        labels=("L.LIG1",),
        water=np.zeros(n, dtype=np.bool_),
        metal=np.zeros(n, dtype=np.bool_),
        places=(("L", 1, "", "LIG"),),
    )
    crowded = known_strand(gap, ends, ligand, library)
    assert crowded.weighted.weights[k] < 0.5 * free.weighted.weights[k]
