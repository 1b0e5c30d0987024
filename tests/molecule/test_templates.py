"""A template is a strand of another structure: its shape, and atoms that travel with it."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from loopelastica.errors import StructureError
from loopelastica.molecule.ends import fit_stem
from loopelastica.molecule.hairpins import find_hairpins
from loopelastica.molecule.nucleotides import BACKBONE, atom_positions
from loopelastica.molecule.strand_ends import flank_poses
from loopelastica.molecule.templates import hairpin_template, monomer_of, strand_template


@pytest.fixture
def hairpin(koc):
    (found,) = find_hairpins(koc)
    return found


@pytest.fixture
def loop(koc, hairpin):
    return hairpin_template(koc.nucleotides, hairpin, koc.positions(0), "2koc")


def at_rest(template):
    return np.broadcast_to(np.eye(3), (len(template) + 1, 3, 3))


def test_it_says_what_it_is(loop):
    assert loop.name == "like 2koc A.5-A.10"
    assert (len(loop), loop.shape.sequence) == (4, "CUUCGG")
    assert [one.label for one in loop.nucleotides] == ["A.U6", "A.U7", "A.C8", "A.G9"]
    assert "like 2koc A.5-A.10" in repr(loop)


def test_on_its_own_stem_every_atom_is_where_it_was(koc, hairpin, loop):
    poses = fit_stem(koc.nucleotides, hairpin, koc.positions(0)).closing()
    carried = loop.carried(loop.shape.nodes_A, at_rest(loop), poses)
    for one, row in zip(carried, hairpin.loop, strict=True):
        own = monomer_of(koc.nucleotides, int(row), koc.positions(0)).atoms_A
        assert set(one.atoms_A) == set(own)
        assert len(own) >= 20
        for name, at in one.atoms_A.items():
            np.testing.assert_allclose(at, own[name], atol=1e-4)


def test_any_strand_is_carried_by_the_nucleotides_beside_it(koc):
    positions = koc.positions(0)
    strand = strand_template(koc.nucleotides, 1, 4, positions, "2koc")
    assert (strand.name, len(strand)) == ("like 2koc A.2-A.5", 2)
    beside = (monomer_of(koc.nucleotides, row, positions) for row in (1, 4))
    carried = strand.carried(strand.shape.nodes_A, at_rest(strand), flank_poses(*beside))
    own = atom_positions(koc.nucleotides, positions, BACKBONE)[2:4]
    found = [[one.atoms_A[name] for name in BACKBONE] for one in carried]
    np.testing.assert_allclose(found, own, atol=1e-4)


def test_a_nucleotide_moves_with_its_node_and_the_mean_turn_of_both_steps(loop, koc, hairpin):
    poses = fit_stem(koc.nucleotides, hairpin, koc.positions(0)).closing()
    nodes = loop.shape.nodes_A + np.arange(6)[:, None]
    turns = np.array(at_rest(loop))
    turns[0], turns[1] = (Rotation.from_rotvec([0, 0, a]).as_matrix() for a in (0.2, 0.6))
    (first, *_) = loop.carried(nodes, turns, poses)
    rest, mean = loop.nucleotides[0], Rotation.from_rotvec([0, 0, 0.4]).as_matrix()
    for name, at in rest.atoms_A.items():
        local = nodes[1] + mean @ (at - loop.shape.nodes_A[1])
        np.testing.assert_allclose(first.atoms_A[name], poses.to_file(local), atol=1e-9)


def test_a_template_has_no_place(koc, hairpin, loop, rng):
    turn, shift = Rotation.random(random_state=rng).as_matrix(), rng.uniform(-50, 50, 3)
    moved = hairpin_template(koc.nucleotides, hairpin, koc.positions(0) @ turn.T + shift, "2koc")
    np.testing.assert_allclose(moved.shape.steps_A, loop.shape.steps_A, atol=1e-4)
    np.testing.assert_allclose(
        moved.nucleotides[2].atoms_A["C4'"], loop.nucleotides[2].atoms_A["C4'"], atol=1e-4
    )


@pytest.mark.parametrize("n", [3, 5])
def test_respaced_it_is_the_same_line_for_another_number_and_has_no_atoms(loop, n):
    other = loop.respaced(n)
    assert len(other) == n
    assert other.nucleotides == ()
    assert other.name == f"like 2koc A.5-A.10, 4 → {n} nucleotides"
    np.testing.assert_allclose(other.shape.nodes_A[-1], loop.shape.nodes_A[-1], atol=1e-9)
    np.testing.assert_array_equal(other.shape.end_frame, loop.shape.end_frame)
    poses = None
    assert other.carried(other.shape.nodes_A, at_rest(other), poses) == ()


def test_respaced_for_its_own_number_it_stays(loop):
    np.testing.assert_allclose(loop.respaced(4).shape.steps_A, loop.shape.steps_A, atol=1e-9)


def test_a_loop_that_lacks_backbone_atoms_is_refused(koc, hairpin):
    positions = np.array(koc.positions(0))
    positions[koc.nucleotides.columns(["C4'"])[6, 0]] = np.nan
    with pytest.raises(StructureError, match=r"A\.C5–A\.G10: backbone atoms .* missing"):
        hairpin_template(koc.nucleotides, hairpin, positions, "2koc")
    with pytest.raises(StructureError, match=r"A\.C5–A\.G10: backbone atoms .* missing"):
        strand_template(koc.nucleotides, 4, 9, positions, "2koc")


def test_a_loop_on_a_stem_that_is_no_helix_is_refused(koc, hairpin):
    with pytest.raises(StructureError, match=r"A\.C5–A\.G10: .* no A or B helix; its loop is no"):
        hairpin_template(koc.nucleotides, hairpin, 1.4 * koc.positions(0), "2koc")


def test_a_strand_with_a_break_or_without_nucleotides_is_refused(koc):
    positions = np.array(koc.positions(0))
    with pytest.raises(StructureError, match=r"A\.C5–A\.U6: no unbroken strand"):
        strand_template(koc.nucleotides, 4, 5, positions, "2koc")
    later = koc.nucleotides.atom_index[7:]
    positions[later[later >= 0]] += 20.0
    with pytest.raises(StructureError, match=r"A\.C5–A\.G10: no unbroken strand"):
        strand_template(koc.nucleotides, 4, 9, positions, "2koc")
