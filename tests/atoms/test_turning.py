"""Groups that turn: where they go alone, beside others, and before acceptors."""

import numpy as np
import pytest

from loopelastica.atoms.turning import turned

# carrier, its neighbour, a neighbour of that
GROUP = np.array([[[0.0, 0, 0], [-1.43, 0, 0], [-1.9, 1.4, 0]]])
NOTHING = np.zeros((0, 3))
NONE = np.zeros(0, dtype=bool)


def torsion_deg(hydrogen, group=GROUP[0]):
    x, b, c = group
    axis = (b - x) / np.linalg.norm(b - x)
    across = [v - axis * (v @ axis) for v in (hydrogen - x, c - b)]
    cosine = across[0] @ across[1] / np.prod([np.linalg.norm(v) for v in across])
    return np.rad2deg(np.arccos(np.clip(cosine, -1, 1)))


@pytest.mark.parametrize("count", [1, 2, 3])
def test_alone_a_group_is_staggered(count):
    (found,) = turned(GROUP, [count], np.array([0.96]), NOTHING, NONE, NOTHING)
    assert found.shape == (count, 3)
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 0.96)
    for hydrogen in found:
        assert min(abs(torsion_deg(hydrogen) - place) for place in (60, 180)) < 1e-6
    if count == 3:
        apart = np.linalg.norm(found - np.roll(found, 1, axis=0), axis=1)
        np.testing.assert_allclose(apart, apart[0])


def test_a_hydroxyl_turns_to_an_acceptor_and_away_from_anything_else():
    acceptor = np.array([[0.9, 0.0, -2.6]])
    (to,) = turned(GROUP, [1], np.array([0.96]), acceptor, np.array([True]), NOTHING)
    (away,) = turned(GROUP, [1], np.array([0.96]), acceptor, np.array([False]), NOTHING)
    assert np.linalg.norm(to - acceptor) < 2.1
    assert np.linalg.norm(away - acceptor) > 2.4


def test_groups_that_face_each_other_keep_their_hydrogens_apart():
    other = np.array([[[0.0, 0, 2.2], [-1.43, 0, 2.2], [-1.9, 1.4, 2.2]]])
    groups = np.concatenate([GROUP, other])
    # what would bring both to the same place
    push = np.array([[1.0, 0.0, -2.0], [1.0, 0.0, 4.2]])
    found = turned(groups, [1, 1], np.full(2, 0.96), push, np.zeros(2, bool), NOTHING)
    assert np.linalg.norm(found[0] - found[1]) > 1.8


def test_groups_do_not_depend_on_others_that_are_far(rng):
    shifts = 100.0 * np.arange(3)[:, None, None] * np.array([1.0, 0, 0])
    groups = GROUP + shifts
    points = rng.normal(size=(6, 3)) * 0.2 + [1.5, 1.5, 0]
    near = np.concatenate([points, points + shifts[1], points + shifts[2]])
    found = turned(groups, [1, 1, 1], np.full(3, 0.96), near, np.zeros(18, bool), NOTHING)
    for one, shift in zip(found, shifts, strict=True):
        np.testing.assert_allclose(one - shift[0], found[0], atol=1e-9)


def test_a_neighbour_in_line_still_gives_a_place():
    group = np.array([[[0.0, 0, 0], [-1.4, 0, 0], [-2.8, 0, 0]]])
    (found,) = turned(group, [3], np.array([1.09]), NOTHING, NONE, NOTHING)
    assert np.isfinite(found).all()
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1.09)
