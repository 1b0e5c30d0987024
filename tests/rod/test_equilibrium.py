import copy
import json
import pickle

import numpy as np
import pytest
from draws import load_drawn

import loopelastica as le
from loopelastica.rod.kernels.records import Method, Status
from loopelastica.rod.stability import assess

FIGURE_6 = [-0.4, -0.1, 0.5, 4.8, 1.4, 2.2]


@pytest.fixture(scope="module")
def rods():
    """A rod that its nodes determine, one of boundary layers, and one of loads alone."""
    slack = le.solve(le.Clamping.from_parameters([0.1, 0.2, 0.9, 4.8, 1.4, 2.2]), 0.7)
    tense = le.solve(le.Clamping.from_parameters([0.1, 0.2, 0.97, 4.8, 1.4, 2.2]), 0.7)
    alone = le.solve(slack.clamping, 0.7, guess=slack.loads)
    assert len(slack.node_s) > 1
    assert len(tense.layers) == 1
    assert len(alone.node_s) == 1
    assert len(alone.layers) == 0
    return slack, tense, alone


def test_an_equilibrium_survives_json_and_takes_points_or_arc_lengths(rng):
    position, rotation = (a[0] for a in load_drawn(rng, 1))
    rod = le.solve(le.Clamping(position, rotation), 0.7)
    again = le.Equilibrium.from_dict(json.loads(json.dumps(rod.to_dict())))
    np.testing.assert_array_equal(again.centerline(11), rod.centerline(11))
    s = np.array([0.7, 0.1, 1.0])
    np.testing.assert_allclose(rod.centerline(s)[[1, 0, 2]], rod.centerline(np.sort(s)))
    assert rod.curvature(11).shape == (11,)
    for wrong in (0, [[0.5]], [1.5], [np.nan]):
        with pytest.raises(ValueError, match="`n`"):
            rod.centerline(wrong)


def test_physical_parameters_and_net_winding_of_a_solution(rng):
    for position, rotation in zip(*load_drawn(rng, 5, 0.7), strict=True):
        rod = le.solve(le.Clamping(position, rotation), 0.7)
        closed_form = rod.physical.clamping(0.7)
        np.testing.assert_allclose(closed_form.position, position, atol=1e-8)
        np.testing.assert_allclose(closed_form.rotation, rotation, atol=1e-8)
        # all equilibria of one clamping have net windings an integer apart
        others = le.equilibria(rod.clamping, 0.7, rounds=1)
        apart = np.array([r.net_winding - rod.net_winding for r in others])
        np.testing.assert_allclose(apart, np.round(apart), atol=1e-8)
        assert rod.writhe + rod.twist == pytest.approx(rod.net_winding)
    circle = le.solve(le.Clamping.from_parameters([0, 0, 1, 0.5, 0, 0]))
    assert circle.physical is None


def test_every_kind_of_rod_survives_json_pickle_and_copies(rods):
    s = np.linspace(0, 1, 7)
    for rod in (*rods, assess(rods[0])):
        text = json.dumps(rod.to_dict(), allow_nan=False)
        for again in (
            le.Equilibrium.from_dict(json.loads(text)),
            pickle.loads(pickle.dumps(rod)),
            copy.copy(rod),
            copy.deepcopy(rod),
        ):
            assert json.dumps(again.to_dict()) == text
            np.testing.assert_array_equal(again.poses(s), rod.poses(s))
            assert (again.status, again.method, again.index) == (
                rod.status, rod.method, rod.index,
            )  # fmt: skip
            assert isinstance(again.status, Status)
            assert isinstance(again.method, Method)
            assert again.layers.dtype == rod.layers.dtype
            for name in ("loads", "node_s", "node_pose", "layers"):
                assert not getattr(again, name).flags.writeable


def test_a_rod_that_did_not_converge_survives_json_without_infinities():
    rod = le.Equilibrium(
        le.Clamping([0, 0, 0.5], np.eye(3)), 1.0, np.zeros(6), np.inf, np.inf, Status.STALLED
    )
    values = json.loads(json.dumps(rod.to_dict(), allow_nan=False))
    assert values["energy"] is values["residual"] is None
    again = le.Equilibrium.from_dict(values)
    assert again.energy == again.residual == np.inf
    assert again.status == Status.STALLED
    assert not again.converged


def test_a_rod_is_one_short_line(rods):
    for rod in rods:
        assert repr(rod) == f"<Equilibrium: energy {rod.energy:.6g}, residual {rod.residual:.1e}>"
        assert rod._repr_html_() == repr(rod)[1:-1]
    assert repr(assess(rods[0])).endswith(", index 0>")
    unsolved = le.Equilibrium(
        le.Clamping([0, 0, 0.5], np.eye(3)), 1.0, np.zeros(6), np.inf, np.inf, Status.STALLED
    )
    assert repr(unsolved) == "<Equilibrium: no start led to a solution>"
    for rod in (*rods, unsolved):
        assert "\n" not in repr(rod)
        assert len(repr(rod)) < 100


def test_every_status_has_words():
    from loopelastica.rod.equilibrium import MESSAGES

    assert set(MESSAGES) == set(Status)
    assert len(set(MESSAGES.values())) == len(Status)


def test_the_caller_may_write_to_arrays_that_were_handed_over():
    loads, node_s = np.zeros(6), np.zeros(1)
    rod = le.Equilibrium(
        le.Clamping([0, 0, 0.5], np.eye(3)), 1.0, loads, 0.0, 0.0, Status.CONVERGED, node_s=node_s
    )
    loads[0] = node_s[0] = 1.0
    assert rod.loads[0] == rod.node_s[0] == 0


def test_moment_and_curvature_are_those_of_the_center_line(rods):
    s, h = np.linspace(0.1, 0.9, 9), 1e-4
    for rod in rods:
        before, here, after = (rod.centerline(s + d) for d in (-h, 0, h))
        bent = np.linalg.norm(before - 2 * here + after, axis=1) / h**2
        np.testing.assert_allclose(rod.curvature(s), bent, rtol=1e-3, atol=1e-3)
        tangents = rod.frames(s)[:, :, 2]
        # M3 = M·t is constant and K30 times the twist
        m3 = (rod.moment(s) * tangents).sum(axis=1)
        size = 1 + np.abs(rod.loads).max()
        np.testing.assert_allclose(m3, rod.loads[5], atol=1e-9 * size)
        assert rod.twist == pytest.approx(rod.loads[5] / 0.7 / (2 * np.pi))


def test_frames_without_spin_differ_by_the_twist_of_the_torsion_ratio(rods):
    from scipy.spatial.transform import Rotation

    s = np.array([0.0, 0.3, 0.8, 1.0])
    for rod in rods:
        plain, full = (
            Rotation.from_quat(poses[:, 3:], scalar_first=True)
            for poses in (rod.poses_without_spin(s), rod.poses(s))
        )
        extra = rod.loads[5] * (1 / 0.7 - 1) * s
        spun = plain * Rotation.from_rotvec(np.outer(extra, [0, 0, 1]))
        assert (spun.inv() * full).magnitude().max() < 1e-9


def test_turns_of_a_rod_whose_points_meet_to_rounding():
    # two of the points that the writhe is taken of were 7e-18 apart
    clamping = le.Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2]).reversed()
    rods = le.equilibria(clamping, rounds=1)
    assert all(isinstance(rod.turns, int) for rod in rods)
