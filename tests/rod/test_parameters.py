"""Physical parameters: domain, loads and back, clamping, symmetries, the paper's figures."""

import doctest
import math

import numpy as np
import pytest

from loopelastica.rod import parameters
from loopelastica.rod.kernels import closed_form, cubic, elliptic, finite_rod
from loopelastica.rod.parameters import PhysicalParameters, a_min, forceless

FIG_6 = [
    PhysicalParameters(-0.3112, -0.2178, -0.7406, 3.4, 0.5, 4.7988),
    PhysicalParameters(1.0462, 1.5606, 3.2264, 0.64, 1.8, 3.1601),
]
Q_6 = np.array([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])
FIG_7 = {
    6: PhysicalParameters(-0.406, 0.159, -0.840, 3.0, 0.2, 6.426),
    25: PhysicalParameters(-0.0902, 0.2088, -0.7700, 3.0, 0.3, 9.7339),
    51: PhysicalParameters(0.5900, -1.3469, 2.9949, 3.0, 0.7, 4.0924),
    175: PhysicalParameters(-0.215, -0.215, 2.0001, 3.0, 6.4, 13.25),
}
Q_7 = np.array([0.0, 0.0, 0.7, 2 * math.pi * 0.42, 0.0, 0.0])
# torsion ratios for which spin, mirror and loads are tested
RATIOS = (1.0, 0.7, 1.6)


def random_parameters(rng, reach=10.0):
    lam, t_p = rng.uniform(-reach, reach, 2)
    a = a_min(lam, t_p) + 10 ** rng.uniform(-2, 2)
    period = PhysicalParameters(lam, t_p, a, 0.0, 0.0, 1.0).period
    return PhysicalParameters(
        lam, t_p, a, rng.uniform(0, 2 * math.pi), rng.uniform(0, period), rng.uniform(0.1, 4)
    )


def circular(x, turn):
    return (x + turn / 2) % turn - turn / 2


def pose_error(clamping, q):
    from loopelastica.rod.clamping import Clamping

    target = Clamping.from_parameters(q)
    trace = np.trace(target.rotation.T @ clamping.rotation)
    angle = math.acos(max(-1.0, min(1.0, (trace - 1) / 2)))
    return max(np.abs(clamping.position - target.position).max(), angle)


def refined(start, q, torsion_ratio, steps=60):
    """Newton in the six loads, by differences, with least squares where the rank is 5."""
    from loopelastica.rod.clamping import Clamping

    target = Clamping.from_parameters(q)

    def miss(f):
        line, frames = finite_rod.rod_along(
            *finite_rod.physical_from_loads(*f, torsion_ratio), torsion_ratio, np.ones(1)
        )
        r = target.rotation.T @ frames[0]
        turn = 0.5 * np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]])
        return np.concatenate([line[0] - target.position, turn])

    f = start.loads(torsion_ratio)
    for _ in range(steps):
        e = miss(f)
        if np.abs(e).max() < 1e-13:
            break
        h = 1e-6 * max(1.0, np.abs(f).max())
        jacobian = np.column_stack([(miss(f + h * d) - miss(f - h * d)) / (2 * h)
                                    for d in np.eye(6)])  # fmt: skip
        step = np.linalg.lstsq(jacobian, -e, rcond=1e-7)[0]
        scale = 1.0
        while np.abs(miss(f + scale * step)).max() > np.abs(e).max() and scale > 1e-3:
            scale /= 2
        f = f + scale * step
    found = PhysicalParameters.from_loads(f, torsion_ratio)
    assert found is not None
    return found


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ({"length": 0.0}, "length"),
        ({"length": -1.0}, "length"),
        ({"lam": math.nan}, "lam"),
        ({"phi0": math.inf}, "phi0"),
        ({"a": -1.7}, "a"),
    ],
)
def test_a_bad_parameter_is_named(change, name):
    good = {"lam": 0.5, "t_p": -0.3, "a": 0.0, "phi0": 0.0, "s_ini": 0.0, "length": 1.0}
    with pytest.raises(ValueError, match=f"`{name}`"):
        PhysicalParameters(**(good | change))


def test_bad_arguments_are_named():
    p = FIG_6[0]
    with pytest.raises(ValueError, match="`torsion_ratio`"):
        p.loads(0.0)
    with pytest.raises(ValueError, match="`n`"):
        p.centerline(1)
    with pytest.raises(ValueError, match="`n`"):
        p.frames([0.0, 1.5])
    with pytest.raises(ValueError, match="`loads`"):
        PhysicalParameters.from_loads([1.0, 2.0])
    with pytest.raises(ValueError, match="`moment`"):
        forceless([1.0, 2.0, math.nan], 3)


def test_the_least_a_itself_is_allowed_whatever_its_rounding():
    rng = np.random.default_rng(0)
    for lam, t_p in rng.uniform(-10, 10, (300, 2)):
        PhysicalParameters(lam, t_p, a_min(lam, t_p), 0.0, 0.0, 1.0)


def test_parameters_come_back_from_loads():
    rng = np.random.default_rng(1)
    for _ in range(500):
        p, ratio = random_parameters(rng), rng.choice(RATIOS)
        q = PhysicalParameters.from_loads(p.loads(ratio), ratio)
        assert q is not None
        assert abs(circular(q.phi0 - p.phi0, 2 * math.pi)) < 1e-10
        assert abs(circular(q.s_ini - p.s_ini, p.period)) < 1e-10
        for name in ("lam", "t_p", "a", "length"):
            assert abs(getattr(q, name) - getattr(p, name)) < 1e-11 * (1 + abs(p.a))
        assert 0 <= q.s_ini < p.period * (1 + 1e-15)


def test_loads_come_back_from_parameters_for_any_size_of_force_and_moment():
    rng = np.random.default_rng(2)
    for _ in range(500):
        f = rng.normal(size=6) * np.repeat(10 ** rng.uniform([-1, -2], [3, 1]), 3)
        ratio = rng.choice(RATIOS)
        p = PhysicalParameters.from_loads(f, ratio)
        assert p is not None
        error = np.abs(p.loads(ratio) - f)
        scale = 1 + f[3:] @ f[3:] / np.linalg.norm(f[:3])
        assert error[:3].max() < 1e-13 * scale * np.linalg.norm(f[:3])
        assert error[3:].max() < 1e-13 * scale * (1 + np.linalg.norm(f[3:]))


@pytest.mark.parametrize(
    "loads",
    [
        [0, 0, 9.0, 0, 0, 0],
        [0, 0, -9.0, 0, 0, 0],
        [0, 0, 9.0, 0, 0, 3.0],  # shares (λ, t_P, a) with a homoclinic rod
        [0, 0, 9.0, 0, 0, -30.0],
        [0, 0, 9.0, 0, 0, 6.0],  # |λ| = 2: triple root
        [0, 0, -9.0, 0, 0, 3.0],
        [4.0, 0, 0, 0, 0, 0],
        [0, 4.0, 0, 1.0, 0, 0],
        [0, 0, 5.0, 3.0, 0, 0],
    ],
)
def test_straight_and_planar_loads_give_the_rod_they_belong_to(loads):
    p = PhysicalParameters.from_loads(loads, 0.7)
    assert p is not None
    assert np.allclose(p.loads(0.7), loads, atol=1e-13 * max(1, np.abs(loads).max()))
    if not np.any(np.array(loads)[[0, 1, 3, 4]]):
        assert np.allclose(p.centerline(5), np.linspace(0, 1, 5)[:, None] * [0, 0, 1], atol=1e-13)
        turn = loads[5] / 0.7
        assert np.allclose(p.frames(2, 0.7)[-1][:, 0], [math.cos(turn), math.sin(turn), 0])


def test_no_force_no_parameters():
    assert PhysicalParameters.from_loads([0, 0, 0, 1, 2, 3]) is None
    assert PhysicalParameters.from_loads([1e-12, 0, 0, 0, 0, 0]) is None


def test_a_small_force_meets_the_forceless_rod():
    moment = np.array([0.7, -1.1, 2.0])
    line, frames = forceless(moment, 5, 0.7)
    for force in (1e-4, 1e-6):
        p = PhysicalParameters.from_loads([force, 0, 0, *moment], 0.7)
        assert p is not None
        assert np.abs(p.centerline(5, 0.7) - line).max() < 0.3 * force + 1e-9
        assert np.abs(p.frames(5, 0.7) - frames).max() < 0.5 * force + 1e-8


def test_centerline_and_frames_belong_together_and_to_the_loads():
    rng = np.random.default_rng(3)
    for _ in range(20):
        p, ratio = random_parameters(rng, 3.0), rng.choice(RATIOS)
        arc = 0.3 + np.array([-2e-4, -1e-4, 0.0, 1e-4, 2e-4])
        line, frames = p.centerline(arc, ratio), p.frames(arc, ratio)
        weights = np.array([1, -8, 0, 8, -1]) / 12e-4
        assert np.allclose(weights @ line, frames[2][:, 2], atol=1e-6)
        force, start_moment = p.loads(ratio)[:3], p.loads(ratio)[3:]
        moment = start_moment + np.cross(force, line[2])
        tangent = frames[2][:, 2]
        omega = moment + (1 / ratio - 1) * (moment @ tangent) * tangent
        spin = np.tensordot(weights, frames, 1) @ frames[2].T
        cross = np.array([[0, -omega[2], omega[1]], [omega[2], 0, -omega[0]],
                          [-omega[1], omega[0], 0]])  # fmt: skip
        assert np.allclose(spin, cross, atol=1e-5 * (1 + np.abs(omega).max() ** 2))


def test_special_values_neither_raise_nor_give_nan():
    rng = np.random.default_rng(7)
    values = [0.0, 1.0, -1.0, 2.0, -2.0, 1e-8, -1e-8, 1e-160, 1e3, 0.5]
    for loads in rng.choice(values, (3000, 6)):
        p = PhysicalParameters.from_loads(loads)
        if p is None:
            continue
        # next to a straight rod a tilt of 1e-8 is the last digit of a
        assert np.abs(p.loads() - loads).max() < 2e-8 * (1 + np.abs(loads).max() ** 2)
        frames = p.frames(3)
        assert np.abs(frames @ frames.transpose(0, 2, 1) - np.eye(3)).max() < 1e-14
    special = [0.0, 1.0, -1.0, 2.0, -2.0, 2 + 4e-16, -3.0, 1e-9, -1e-17, 1e-160]
    for lam in special:
        for t_p in special:
            least = a_min(lam, t_p)
            for a in (least, least + 1e-15, least + 1e-8, least + 1.0, max(least, 2.0)):
                for s_ini in (0.0, -30.0):
                    p = PhysicalParameters(lam, t_p, a, 1.0, s_ini, 2.0)
                    assert p.period > 0
                    assert np.linalg.norm(p.clamping(0.7).position) < 1 + 1e-12


def test_clamping_is_the_last_point_and_frame():
    p = FIG_6[0]
    c = p.clamping(0.7)
    assert np.allclose(c.position, p.centerline(3, 0.7)[-1], atol=1e-15)
    assert np.allclose(c.rotation, p.frames(3, 0.7)[-1], atol=1e-14)
    assert np.allclose(p.frames(3)[0], np.eye(3), atol=1e-15)


def test_phi0_turns_the_start_frame_by_eq_15_and_16():
    rng = np.random.default_rng(4)
    for _ in range(20):
        p = random_parameters(rng)
        reduced, angle = p.reduced(0.7)
        c = reduced.clamping(0.7)
        assert abs(c.position[1]) < 1e-13
        assert c.position[0] >= 0
        back = c.turned(angle)
        assert np.allclose(back.position, p.clamping(0.7).position, atol=1e-12)
        assert np.allclose(back.rotation, p.clamping(0.7).rotation, atol=1e-12)


@pytest.mark.parametrize("ratio", RATIOS)
def test_mirror_image_has_the_mirrored_clamping(ratio):
    rng = np.random.default_rng(5)
    rods = [random_parameters(rng) for _ in range(20)]
    rods.append(PhysicalParameters(1.3, -1.3, 1.0, 0.4, 0.3, 3.0))
    rods.append(PhysicalParameters(0.0, 0.0, 1.0, 0.4, 0.3, 3.0))
    for p in rods:
        c, mirror = p.clamping(ratio).mirrored(), p.mirrored().clamping(ratio)
        assert np.allclose(mirror.position, c.position, atol=1e-12)
        assert np.allclose(mirror.rotation, c.rotation, atol=1e-12)


def test_period_is_that_of_the_distance_from_the_axis():
    rng = np.random.default_rng(6)
    for _ in range(20):
        p = random_parameters(rng)
        c, scale = closed_form.constants(p.lam, p.t_p, p.a)
        places = np.array([0.3, 1.3, -0.3, 0.5, 0.0]) * p.period
        rho = [math.hypot(*closed_form.rod_at(s, c, scale)[4:6]) for s in places]
        assert rho[:3] == pytest.approx([rho[0]] * 3, abs=1e-12)
        assert rho[3] < rho[0] < rho[4]
    assert math.isinf(PhysicalParameters(1.0, 1.0, 2.0, 0.0, 0.0, 1.0).period)


def test_the_two_solutions_of_figure_6():
    for printed in FIG_6:
        assert pose_error(printed.clamping(), Q_6) < 0.15  # the printed p and q are rounded
        found = refined(printed, Q_6, 1.0)
        assert pose_error(found.clamping(), Q_6) < 1e-10
        for name in ("lam", "t_p", "a", "length"):
            assert getattr(found, name) == pytest.approx(getattr(printed, name), abs=6e-5)


@pytest.mark.parametrize("rank", [6, 25, 51])
def test_solutions_of_figure_7(rank):
    printed = FIG_7[rank]
    assert pose_error(printed.clamping(0.7), Q_7) < 0.2
    found = refined(printed, Q_7, 0.7)
    assert pose_error(found.clamping(0.7), Q_7) < 1e-10
    for name in ("lam", "t_p", "a", "length"):
        assert getattr(found, name) == pytest.approx(getattr(printed, name), abs=2e-3)


def test_doctests_of_the_kernels_and_of_this_module():
    assert doctest.testmod(parameters, extraglobs={"np": np}).failed == 0
    runner, finder = doctest.DocTestRunner(), doctest.DocTestFinder()
    for module in (closed_form, cubic, elliptic, finite_rod):
        for name, kernel in vars(module).items():
            if getattr(kernel, "__module__", None) == module.__name__:
                for test in finder.find(getattr(kernel, "py_func", kernel), name,
                                        globs=vars(module).copy()):  # fmt: skip
                    runner.run(test)
    assert runner.tries >= 4
    assert runner.failures == 0
