"""Twist, polar writhe and net winding on curves whose values are known."""

import math

import numpy as np
import pytest

import loopelastica as le
from loopelastica.rod import writhe as module
from loopelastica.rod.parameters import PhysicalParameters
from loopelastica.rod.writhe import net_winding, polar_writhe, twist, writhe

Z = np.array([0.0, 0.0, 1.0])


def helix(turns, climb, n=600):
    """Unit-radius helix about z; `climb` is the z component of its tangent."""
    s = np.linspace(0, 2 * math.pi * turns, n)
    flat = math.sqrt(1 - climb**2)
    points = np.column_stack([np.cos(s), np.sin(s), s * climb / flat])
    tangents = np.column_stack([-flat * np.sin(s), flat * np.cos(s), np.full(n, climb)])
    return points, tangents


def random_turn(rng):
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q * np.linalg.det(q)


# solutions of Figures 6 and 7, to 1e-10 (test_parameters finds them from the printed values)
FIG_6 = (
    PhysicalParameters(-0.3112, -0.2178, -0.7406, 3.4, 0.5, 4.7988),
    PhysicalParameters(1.0462, 1.5606, 3.2264, 0.64, 1.8, 3.1601),
)
FIG_7 = (
    (PhysicalParameters(-0.40609647538077387, 0.1592833682554201, -0.8404006438611749,
                        3.0555482290827767, 0.15743006813354055, 6.425605212295275), 0.42),
    (PhysicalParameters(-0.09022015523528884, 0.2087530089142807, -0.7699791039135504,
                        2.9740058291545632, 0.25167540768812446, 9.733887356899627), 0.42),
    (PhysicalParameters(0.5900486144508998, -1.3469013976369302, 2.99493178482035,
                        3.001947569663348, 0.7032497966742652, 4.092374132226546), -1.58),
    (PhysicalParameters(-0.21523285662860786, -0.21524804915732873, 2.000142513120719,
                        2.674842268753415, 6.440454075708826, 13.254437134078938), -1.58),
)  # fmt: skip


@pytest.mark.parametrize("climb", [0.9, 0.5, 0.1])
@pytest.mark.parametrize("turns", [0.3, 1.0, 3.5])
def test_polar_writhe_of_a_helix_between_planes_across_its_axis(turns, climb):
    points, tangents = helix(turns, climb)
    assert polar_writhe(points, tangents, Z) == pytest.approx(turns * (1 - climb), abs=2e-4)
    mirror = np.array([1, -1, 1])
    assert polar_writhe(points * mirror, tangents * mirror, Z) == pytest.approx(
        -turns * (1 - climb), abs=2e-4
    )


def test_polar_writhe_of_a_straight_and_of_a_planar_curve_is_zero():
    s = np.linspace(0, 1, 50)
    angle = 4 * np.sin(7 * s)  # rises and falls, does not cross itself
    tangents = np.column_stack([np.sin(angle), 0 * s, np.cos(angle)])
    points = np.cumsum(tangents, axis=0)
    points = points + 30 * s[:, None] * np.array([1, 0, 0])
    edges = np.gradient(points, axis=0)
    edges /= np.linalg.norm(edges, axis=1)[:, None]
    assert abs(polar_writhe(points, edges, Z)) < 1e-12
    straight = s[:, None] * Z
    assert polar_writhe(straight, np.tile(Z, (50, 1)), Z) == 0


def test_end_frames_fix_the_sum_of_twist_and_polar_writhe_modulo_one():
    """Curves that rise and fall at random: two independent ways to the same number."""
    rng = np.random.default_rng(0)
    s = np.linspace(0, 1, 3001)
    for _ in range(15):
        wave = sum(rng.normal(size=3) * np.sin(math.pi * k * s + rng.normal())[:, None] / k
                   for k in range(1, 6))  # fmt: skip
        tangents = wave + rng.normal(size=3)
        tangents /= np.linalg.norm(tangents, axis=1)[:, None]
        points = np.cumsum(0.5 * (tangents[1:] + tangents[:-1]), axis=0) / 3000
        points = np.vstack([np.zeros(3), points])
        d1 = np.cross(tangents, rng.normal(size=3))
        d1 /= np.linalg.norm(d1, axis=1)[:, None]
        frames = np.stack([d1, np.cross(tangents, d1), tangents], axis=2)
        direction = rng.normal(size=3)
        total = twist(frames) + polar_writhe(points, tangents, direction)
        assert total == pytest.approx(net_winding(points, frames, None, direction), abs=1e-3)
        # few points choose the same integer
        coarse = net_winding(points[::15], frames[::15], twist(frames), direction)
        assert coarse == pytest.approx(net_winding(points, frames, None, direction), abs=1e-12)


def test_rigid_motion_changes_nothing():
    rng = np.random.default_rng(1)
    p = FIG_7[3][0]
    line, frames = p.centerline(300), p.frames(300)
    before = net_winding(line, frames), writhe(line), twist(frames)
    turn, shift = random_turn(rng), rng.normal(size=3)
    line, frames = line @ turn.T + shift, turn @ frames
    assert (net_winding(line, frames), writhe(line), twist(frames)) == pytest.approx(before)


def test_one_more_turn_of_the_frame_is_one_more_net_winding():
    p = FIG_6[0]
    line, frames = p.centerline(300), p.frames(300)
    angle = 2 * math.pi * np.linspace(0, 1, 300)
    spin = np.zeros((300, 3, 3))
    spin[:, 0, 0] = spin[:, 1, 1] = np.cos(angle)
    spin[:, 1, 0], spin[:, 0, 1], spin[:, 2, 2] = np.sin(angle), -np.sin(angle), 1
    more = frames @ spin
    assert twist(more) - twist(frames) == pytest.approx(1, abs=1e-12)
    assert net_winding(line, more) - net_winding(line, frames) == pytest.approx(1, abs=1e-12)


def test_twist_of_a_rod_is_its_moment_over_its_rigidity():
    for p, _ in FIG_7:
        expected = p.loads(0.7)[5] / (0.7 * 2 * math.pi)
        assert twist(p.frames(2000, 0.7)) == pytest.approx(expected, abs=1e-6)


def test_figure_6_prints_0_1_and_1_1():
    for p, printed in zip(FIG_6, (0.1, 1.1), strict=True):
        line, frames = p.centerline(200), p.frames(200)
        found = net_winding(line, frames, p.loads()[5] / (2 * math.pi))
        q = p.clamping().parameters
        assert found == pytest.approx(printed, abs=0.05)
        expected = (q[3] + q[5]) / (2 * math.pi)
        assert math.remainder(found - expected, 1.0) == pytest.approx(0, abs=1e-12)
        along_start = net_winding(line, frames, p.loads()[5] / (2 * math.pi), frames[0][:, 2])
        assert along_start == pytest.approx(found, abs=1e-12)


def test_figure_7_prints_0_42_and_minus_1_58_which_differ_by_an_integer():
    found = []
    for p, printed in FIG_7:
        turns = p.loads(0.7)[5] / (0.7 * 2 * math.pi)
        found.append(net_winding(p.centerline(300, 0.7), p.frames(300, 0.7), turns))
        assert found[-1] == pytest.approx(printed, abs=1e-8)
    assert found[0] - found[2] == pytest.approx(2.0, abs=1e-8)
    assert found[1] - found[3] == pytest.approx(2.0, abs=1e-8)


def test_opposite_end_tangents_have_a_net_winding_too():
    s = np.linspace(0, math.pi, 200)
    points = np.column_stack([np.cos(s), 0 * s, np.sin(s)])
    tangents = np.column_stack([-np.sin(s), 0 * s, np.cos(s)])
    d2 = np.tile([0.0, 1.0, 0.0], (200, 1))
    frames = np.stack([np.cross(d2, tangents), d2, tangents], axis=2)
    assert math.isfinite(net_winding(points, frames))


def test_writhe_of_a_trefoil_agrees_with_the_gauss_integral():
    def trefoil(s):
        return np.column_stack([
            np.sin(s) + 2 * np.sin(2 * s), np.cos(s) - 2 * np.cos(2 * s), -np.sin(3 * s)
        ])  # fmt: skip

    s = np.linspace(0, 2 * math.pi, 600, endpoint=False)
    t = np.column_stack([
        np.cos(s) + 4 * np.cos(2 * s), -np.sin(s) + 4 * np.sin(2 * s), -3 * np.cos(3 * s)
    ])  # fmt: skip
    gap = trefoil(s)[:, None] - trefoil(s)[None]
    distance = np.linalg.norm(gap, axis=2)
    np.fill_diagonal(distance, np.inf)
    density = np.einsum("ijk,ijk->ij", gap, np.cross(t[:, None], t[None])) / distance**3
    gauss = density.sum() * (2 * math.pi / 600) ** 2 / (4 * math.pi)
    curve = trefoil(np.linspace(0, 2 * math.pi, 301))
    assert abs(gauss) > 3
    assert writhe(curve) == pytest.approx(gauss, abs=0.02)
    assert writhe(curve * [1, 1, -1]) == pytest.approx(-writhe(curve))


def ring(n=101):
    s = np.linspace(0, 2 * math.pi, n)
    points = np.column_stack([np.cos(s), np.sin(s), 0 * s])
    tangents = np.column_stack([-np.sin(s), np.cos(s), 0 * s])
    normal = np.tile(Z, (n, 1))
    return points, np.stack([normal, np.cross(tangents, normal), tangents], axis=2)


def spun(frames, turns):
    angle = 2 * math.pi * turns * np.linspace(0, 1, len(frames))
    spin = np.zeros((len(frames), 3, 3))
    spin[:, 0, 0] = spin[:, 1, 1] = np.cos(angle)
    spin[:, 1, 0], spin[:, 0, 1], spin[:, 2, 2] = np.sin(angle), -np.sin(angle), 1
    return frames @ spin


@pytest.mark.parametrize("turns", [0, 1, -2])
def test_a_planar_ring_has_no_writhe_and_links_by_its_twist(turns):
    points, frames = ring()
    assert writhe(points) == pytest.approx(0, abs=1e-12)
    assert net_winding(points, spun(frames, turns), turns) == pytest.approx(turns, abs=1e-12)
    # what closes it to rounding only closes it
    points = points.copy()
    points[-1] += [1e-12, -1e-12, 1e-12]
    assert net_winding(points, spun(frames, turns), turns) == pytest.approx(turns, abs=1e-9)


def test_a_closed_knot_links_by_twist_and_gauss_integral():
    """Lk = Tw + Wr is an integer, though neither is; an open cut of it has another winding."""
    s = np.linspace(0, 2 * math.pi, 601)
    points = np.column_stack([
        np.sin(s) + 2 * np.sin(2 * s), np.cos(s) - 2 * np.cos(2 * s), -np.sin(3 * s)
    ])  # fmt: skip
    t = np.column_stack([
        np.cos(s) + 4 * np.cos(2 * s), -np.sin(s) + 4 * np.sin(2 * s), -3 * np.cos(3 * s)
    ])  # fmt: skip
    t /= np.linalg.norm(t, axis=1)[:, None]
    points[-1], t[-1] = points[0], t[0]
    d1 = Z - t[:, 2:] * t
    d1 /= np.linalg.norm(d1, axis=1)[:, None]
    frames = np.stack([d1, np.cross(t, d1), t], axis=2)
    linked = net_winding(points, frames)
    assert linked == pytest.approx(round(linked), abs=1e-12)
    # framed by the vertical it links as often as its crossings seen from above say
    assert abs(linked) == 3
    assert twist(frames) + writhe(points) == pytest.approx(linked, abs=0.01)


@pytest.fixture(scope="module")
def rings():
    return le.equilibria(le.Clamping(np.zeros(3), np.eye(3)), rounds=2)


def test_closed_rods_link_by_twist_and_writhe(rings):
    known = {19.739: {0}, 39.478: {1, -1}}
    for energy, linking in known.items():
        found = [rod for rod in rings if abs(rod.energy - energy) < 1e-3]
        assert {rod.turns for rod in found} == linking
        for rod in found:
            assert rod.writhe == pytest.approx(0, abs=1e-6)
            assert rod.net_winding == pytest.approx(rod.twist, abs=1e-6)


def test_a_rod_that_passes_through_itself_has_no_winding(rings):
    twice = [rod for rod in rings if abs(rod.energy - 78.957) < 1e-3]
    for rod in twice:  # the ring that runs round twice
        assert rod.net_winding is None
        assert rod.writhe is None
        assert rod.turns is None


def looped(*moment):
    """A rod with one loop in the middle, nearly in a plane, from its loads."""
    loads = [0.0, 0.0, 60.0, *moment]
    rod = le.solve(le.PhysicalParameters.from_loads(loads, 1.0).clamping(), guess=loads)
    assert rod.converged
    np.testing.assert_allclose(rod.loads, loads, atol=1e-6)
    return rod


def test_a_planar_loop_passes_through_itself():
    rod = looped(0.0, 15.2, 0.0)
    assert np.abs(rod.centerline(200)[:, 1]).max() < 1e-9
    assert rod.net_winding is None


@pytest.mark.parametrize("moment", [1e-2, 1e-4, 1e-6])
def test_a_loop_that_just_misses_itself_winds_one_way(moment):
    """Nearer than a polygon resolves; the mirror image winds the other way."""
    rod, mirror = looped(0.0, 15.2, moment), looped(0.0, 15.2, -moment)
    assert abs(rod.net_winding) > 0.9
    assert mirror.net_winding == pytest.approx(-rod.net_winding, abs=1e-6)


def test_ends_that_meet_in_a_corner_have_no_winding():
    corner = le.Clamping(np.zeros(3), [[1, 0, 0], [0, 0, -1], [0, 1, 0]])
    rod = le.solve(corner)
    assert rod.converged
    assert rod.net_winding is None
    assert rod.turns is None


def test_a_free_spin_fixes_no_turns():
    clamping = le.Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2], free_spin=True)
    rod = le.solve(clamping)
    assert rod.turns is None
    assert math.isfinite(rod.net_winding)
    with pytest.raises(ValueError, match="`turns`"):
        le.equilibria(clamping, turns=1)


def test_half_a_turn_counts_upwards_on_either_side_of_rounding():
    for spin in (math.pi - 1e-12, math.pi, -math.pi + 1e-12):
        c, s = math.cos(spin), math.sin(spin)
        rod = le.solve(le.Clamping([0.1, 0.05, 0.9], [[c, -s, 0], [s, c, 0], [0, 0, 1]]))
        assert rod.turns == math.floor(rod.net_winding + 0.5 + 1e-9)
        assert rod.turns in ((1,) if rod.twist > 0 else (0,))


def test_bad_arguments_are_named():
    points, tangents = helix(1, 0.5, 5)
    with pytest.raises(ValueError, match="`direction`"):
        polar_writhe(points, tangents, [0, 0, 0])
    with pytest.raises(ValueError, match="`tangents`"):
        polar_writhe(points, tangents[:3], Z)
    with pytest.raises(ValueError, match="`points`"):
        polar_writhe(points[:, :2], tangents, Z)
    with pytest.raises(ValueError, match="`points`"):
        polar_writhe(np.repeat(points, 2, axis=0), np.repeat(tangents, 2, axis=0), Z)
    with pytest.raises(ValueError, match="`frames`"):
        twist(tangents)
    assert module.__all__ == ["net_winding", "polar_writhe", "twist", "writhe"]
