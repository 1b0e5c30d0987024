"""Clampings next to the straight rod: all are solved, and by the lowest rod there is."""

import numpy as np
import pytest
from beam import Beam
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import loopelastica as le
from loopelastica.rod.kernels.records import Method

RATIOS = (0.3, 1.0, 2.0, 100.0)


def poses(rng, n, shortest=-8.0, longest=-6.0, off=(-10.0, -1.0), tilt=(-10.0, -1.0)):
    """1 − |r|, distance from the start's axis and tilt of the end: powers of ten; any spin."""

    def powers(low, high):
        return 10 ** rng.uniform(low, high, n)

    across, azimuth = powers(*off), rng.uniform(-np.pi, np.pi, n)
    height = np.sqrt((1 - powers(shortest, longest)) ** 2 - across**2)
    position = np.array([across * np.cos(azimuth), across * np.sin(azimuth), height]).T
    lean, towards, spin = powers(*tilt), *rng.uniform(-np.pi, np.pi, (2, n))
    leaning = np.array([lean * np.cos(towards), lean * np.sin(towards), 0 * lean]).T
    spun = np.array([0 * spin, 0 * spin, spin]).T
    return position, (Rotation.from_rotvec(leaning) * Rotation.from_rotvec(spun)).as_matrix()


def test_the_one_that_was_not_solved():
    end = Rotation.from_rotvec([0.007228248806193672, -0.004479267886115128, 1.9553019825659332])
    position = [-1.3447308292856978e-08, 1.493692914432134e-09, 0.9999999614642715]
    clamping = le.Clamping(position, end.as_matrix())
    rod = le.solve(clamping)
    assert rod.converged
    assert rod.energy == pytest.approx(sum(Beam(clamping, 1.0).lowest()), rel=1e-5)
    assert 1.90 < rod.energy < 1.93
    assert le.equilibria(clamping, rounds=1)[0].energy == pytest.approx(rod.energy, rel=1e-9)


@pytest.mark.parametrize("free_spin", [False, True])
@pytest.mark.parametrize("torsion_ratio", RATIOS)
@pytest.mark.parametrize("n", [100, pytest.param(3000, marks=pytest.mark.slow)])
def test_all_are_solved(rng, n, torsion_ratio, free_spin):
    position, rotation = poses(rng, n)
    batch = le.solve_batch(position, rotation, torsion_ratio, free_spin)
    assert batch.converged.all()
    # the layers of tilts up to 0.2, at their stiffest
    assert batch.energy.max() < 2e3 + 60 * torsion_ratio


@pytest.mark.parametrize("free_spin", [False, True])
@pytest.mark.parametrize("torsion_ratio", RATIOS)
@pytest.mark.parametrize(
    ("n", "shortest", "longest"),
    [(1, -8, -6), *(pytest.param(*row, marks=pytest.mark.slow)
                    for row in ((2, -8, -6), (2, -8.9, -8), (2, -6, -4)))],
)  # fmt: skip
def test_the_lowest_is_that_of_an_independent_beam(
    rng, n, shortest, longest, torsion_ratio, free_spin
):
    if (n, longest) != (2, -6) and torsion_ratio > 2.0:
        pytest.skip("the beam of so much twist takes long: one of the slow tests has it")
    for position, rotation in zip(*poses(rng, n, shortest, longest), strict=True):
        clamping = le.Clamping(position, rotation, free_spin)
        rod = le.solve(clamping, torsion_ratio)
        bending, twisting = Beam(clamping, torsion_ratio).lowest()
        # leading order in the angles, up to 0.2; and the beam's elements
        assert rod.energy == pytest.approx(
            bending + twisting, abs=0.02 * bending + 1e-3 * twisting + 1e-9
        )


@pytest.mark.parametrize("torsion_ratio", RATIOS)
def test_the_rod_obeys_the_equations_of_another_integrator(rng, torsion_ratio):
    """Pieces of it, integrated with matrices for frames, arrive where the next one begins."""
    for position, rotation in zip(*poses(rng, 4), strict=True):
        rod = le.solve(le.Clamping(position, rotation), torsion_ratio)
        assert np.abs(rod.centerline(2)[-1] - position).max() < 1e-9
        assert np.abs(rod.frames(2)[-1] - rotation).max() < 1e-8
        root = np.sqrt(np.linalg.norm(rod.loads[:3]))
        layer = np.linspace(0, min(0.5, 25 / max(root, 1)), 13)
        s = np.unique(np.concatenate([layer, np.linspace(0, 1, 9), 1 - layer]))
        r, frames, moment = rod.centerline(s), rod.frames(s), rod.moment(s)
        # ρ = r − r(s) counts from the piece's start: F × r is no difference of large numbers
        force = rod.loads[:3]

        def slope(_, y, force=force, m0=None):
            frame = y[3:].reshape(3, 3)
            m = m0 + np.cross(force, y[:3])
            local = frame.T @ m
            local[2] /= torsion_ratio
            return np.concatenate([frame[:, 2], np.cross(frame @ local, frame.T).T.ravel()])

        for i in range(len(s) - 1):
            span = s[i + 1] - s[i]
            if root * span > 6:
                continue  # errors grow by exp(root · span); there a tense rod is straight
            y0 = np.concatenate([np.zeros(3), frames[i].ravel()])
            end = solve_ivp(
                slope, (0, span), y0, "DOP853", rtol=1e-11, atol=1e-13, args=(force, moment[i])
            ).y[:, -1]
            # the moment is the sum of terms of size F
            room = 1e-8 + 1e-15 * root**3
            assert np.abs(end[:3] - (r[i + 1] - r[i])).max() < room
            assert np.abs(end[3:].reshape(3, 3) - frames[i + 1]).max() < room * max(root, 1)


@pytest.mark.slow
@pytest.mark.parametrize("free_spin", [False, True])
@pytest.mark.parametrize("torsion_ratio", RATIOS)
def test_no_list_begins_with_another_rod(rng, torsion_ratio, free_spin):
    for position, rotation in zip(*poses(rng, 3), strict=True):
        clamping = le.Clamping(position, rotation, free_spin)
        rods = le.equilibria(clamping, torsion_ratio, rounds=1, time_limit_s=20)
        lowest = le.solve(clamping, torsion_ratio).energy
        assert rods[0].energy == pytest.approx(lowest, rel=1e-6)
        assert rods[0].index == 0


def test_buckling_of_the_clamped_rod_by_its_twist():
    """Largest tension of instability: 4π² of compression without twist, none at M3 = 2 · 4.493."""
    from loopelastica.rod.kernels.nearly_straight import buckling_tension

    assert buckling_tension(0.0) == pytest.approx(-4 * np.pi**2, rel=1e-9)
    assert buckling_tension(2 * 4.493409457909064) == pytest.approx(0.0, abs=1e-5)
    assert buckling_tension(-3.0) == buckling_tension(3.0)


def test_methods_take_over_from_each_other():
    """From buckled to tense: the linear theory's nodes, then two boundary layers."""
    end = Rotation.from_rotvec([0, 0, 1.0]).as_matrix()
    methods = []
    for across in (1e-6, 1e-3, 1e-1):
        height = np.sqrt((1 - 1e-7) ** 2 - across**2)
        methods.append(le.solve(le.Clamping([across, 0, height], end)).method)
    assert methods == [Method.NEARLY_STRAIGHT, Method.NEARLY_STRAIGHT, Method.BOUNDARY_LAYERS]


@pytest.mark.parametrize("tolerance", [1e-9, 1e-11])
@pytest.mark.parametrize("free_spin", [False, True])
def test_ends_exactly_in_line_are_kept_exactly(free_spin, tolerance):
    """Where a tilt has to choose the direction it must not stay."""
    end = Rotation.from_rotvec([0, 0, 2.0]).as_matrix()
    for height in (0.992, 0.9999, 1 - 1e-7):
        clamping = le.Clamping([0, 0, height], end, free_spin)
        rod = le.solve(clamping, 0.5, tolerance=tolerance)
        assert rod.converged
        apart = rod.frames(2)[-1] - end
        assert np.abs(apart[:, 2] if free_spin else apart).max() < 1e-10
        assert np.abs(rod.centerline(2)[-1] - clamping.position).max() < 1e-10
