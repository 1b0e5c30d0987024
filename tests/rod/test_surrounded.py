import itertools

import numpy as np
import pytest
from draws import directions
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

import loopelastica as le
from loopelastica.rod.curves import standard_guesses
from loopelastica.rod.kernels.obstacles import SOFTENED
from loopelastica.rod.surrounded import surrounded_rods

ARCH = [0, 0, 0], [0, 0, 1], [10, 0, 0], [0, 0, -1], 24.0
# across the free arch: the rod has to go round it
WALL = np.array([[5, y, z] for y in range(-2, 3) for z in range(3, 7)], dtype=float)


def free_rod(rng):
    """A free-spin clamping with its lowest rod, and that rod's span."""
    (position,), (rotation,) = (
        directions(rng, 1) * rng.uniform(0.3, 0.9),
        Rotation.random(1, random_state=rng).as_matrix(),
    )
    rod = le.solve(le.Clamping(position, rotation, free_spin=True))
    return rod, ([0, 0, 0], [0, 0, 1], position, rotation[:, 2], 1.0)


def crowd(rng, n, ends=((0, 0, 0), (10, 0, 0)), size=14.0):
    """Points at random, none nearer than 3.5 to an end."""
    points = rng.uniform(-size, size, (20 * n, 3)) + (5, 0, 0)
    far = np.all([np.linalg.norm(points - end, axis=1) > 3.5 for end in ends], axis=0)
    return points[far][:n]


# what it is without obstacles


def test_without_obstacles_it_is_the_ideal_rod_to_second_order(rng):
    for _ in range(4):
        rod, span = free_rod(rng)
        errors, energies = [], []
        for segments in (32, 64, 128):
            found = surrounded_rods(
                *span, guesses=[rod.centerline(101)], segments=segments, self_repulsion=0
            )[0]
            assert found.converged
            assert found.stable
            assert found.contact_energy == found.self_energy == 0
            errors.append(np.abs(found.points(101) - rod.poses(101)[:, :3]).max())
            energies.append(found.energy - rod.energy)
        assert errors[-1] < 5e-4
        assert 10 < errors[0] / errors[2] < 25
        # arcs are some of the curves that the rod could take
        assert energies[0] > energies[1] > energies[2] > 0
        assert 3.5 < energies[0] / energies[1] < 4.6
        assert 3.5 < energies[1] / energies[2] < 4.6


def test_obstacles_out_of_reach_change_nothing():
    far = [[5, 40, 0], [-30, 0, 0]]
    (free,), (other,) = (surrounded_rods(*ARCH, points) for points in (None, far))
    assert np.array_equal(free.node_tangent, other.node_tangent)
    assert (free.nearest, free.nearest_obstacle) == (None, None)
    assert other.nearest == pytest.approx(30, abs=0.1)
    assert other.nearest_obstacle == 1


def test_the_smaller_the_stiffness_the_nearer_to_the_free_rod():
    free = surrounded_rods(*ARCH)[0]
    away = []
    for stiffness in (1e-2, 1e-4, 1e-6, 0.0):
        rods = surrounded_rods(*ARCH, WALL, stiffness=stiffness, guesses=[free.points(99)])
        away.append(np.abs(rods[0].points(50) - free.points(50)).max())
    assert away[0] > 10 * away[1] > 100 * away[2] > 0
    assert away[3] < 1e-6


# what obstacles do


def test_a_rod_driven_through_a_wall_goes_round_it():
    through = surrounded_rods(*ARCH)[0]
    assert np.linalg.norm(through.points(400)[:, None] - WALL, axis=2).min() < 3.5
    rods = surrounded_rods(*ARCH, WALL)
    assert rods[0].converged
    assert rods[0].nearest > 4.5
    assert rods[0].energy > through.energy
    # two ways round, mirror images; the one through the wall costs more
    left, right = rods[:2]
    assert left.total == pytest.approx(right.total, rel=1e-9)
    assert np.allclose(left.points(9), right.points(9) * (1, -1, 1), atol=1e-6)
    assert all(a.total <= b.total for a, b in itertools.pairwise(rods))


def test_energies_are_those_of_the_line_that_is_given_back(rng):
    points = crowd(rng, 60)
    rod = surrounded_rods(*ARCH, points, self_repulsion=0)[0]
    s = np.linspace(0, 1, 20001)
    bends = np.linalg.norm(np.diff(rod.frames(s)[:, :, 2], axis=0), axis=1)
    assert 0.5 * (bends**2).sum() * 20000 == pytest.approx(rod.energy, rel=1e-3)
    nodes = rod.points(rod.node_s)
    distance = np.linalg.norm(nodes[:, None] - points, axis=2)
    overlap = np.maximum(5 - distance, 0)
    widths = 0.5 * np.convolve(np.diff(rod.node_s), [1, 1])
    # one factor of the length makes it dimensionless, one is that of the line
    contact = 0.5 * 0.05 * (widths[:, None] * overlap**2).sum() * 24**2
    assert contact == pytest.approx(rod.contact_energy, rel=3e-3)
    assert rod.total == rod.energy + rod.contact_energy + rod.self_energy


def test_scipy_finds_the_same_minimum_of_the_same_energy(rng):
    # segments of the sketch's kind: another discretization in other variables, by its own Newton
    points, k, cutoff, n = crowd(rng, 40) / 24, 0.05 * 24**4, 5 / 24, 8
    rods = surrounded_rods(*ARCH, 24 * points, segments=n, self_repulsion=0)
    rod = rods[0]
    end = np.array([10, 0, 0]) / 24

    def nodes(x):
        u = np.vstack([[0, 0, 1], x.reshape(-1, 3), [0, 0, -1]])
        u = u / np.linalg.norm(u, axis=1)[:, None]
        angle = np.arccos(np.clip((u[1:] * u[:-1]).sum(axis=1), -1, 1))
        middle = u[1:] + u[:-1]
        middle /= np.linalg.norm(middle, axis=1)[:, None]
        chords = np.sinc(angle / 2 / np.pi)[:, None] * middle / n
        return angle, np.vstack([np.zeros(3), np.cumsum(chords, axis=0)])

    def energy(x):
        angle, r = nodes(x)
        d = np.sqrt(((r[:, None] - points) ** 2).sum(axis=2) + (SOFTENED * cutoff) ** 2)
        each = (np.maximum(cutoff - d, 0) ** 2).sum(axis=1)
        each[[0, -1]] *= 0.5
        return 0.5 * n * (angle**2).sum() + 0.5 * k * each.sum() / n

    x = (rod.node_tangent[1:-1] + 0.05 * rng.normal(size=(n - 1, 3))).ravel()
    closed = {"type": "eq", "fun": lambda x: nodes(x)[1][-1] - end}
    oracle = minimize(
        energy, x, method="SLSQP", constraints=[closed], options={"maxiter": 500, "ftol": 1e-12}
    )
    assert oracle.success
    assert oracle.fun == pytest.approx(rod.total, rel=1e-6)
    assert np.abs(24 * nodes(oracle.x)[1] - rod.points(rod.node_s)).max() < 0.02


def test_a_rod_keeps_away_from_itself():
    # two turns with a pitch of 4, below the cutoff
    span = [0, 0, 0], [1, 0, 0], [0, 0, 4.0], [1, 0, 0], 62.0
    angle = np.linspace(0, 4 * np.pi, 300)
    coil = np.stack([4.9 * np.sin(angle), 4.9 * (1 - np.cos(angle)), angle / np.pi], axis=1)
    loose, own = (
        surrounded_rods(*span, guesses=[coil], self_repulsion=strength)[0] for strength in (0, 4)
    )
    assert loose.converged
    assert own.converged
    assert loose.self_energy == 0 < own.self_energy
    assert loose.energy < own.energy

    def energy(rod):
        # as so many points per cutoff, where two to four cutoffs of rod are between
        s, r = 62 * rod.node_s, rod.points(rod.node_s)
        width = 0.5 * np.convolve(np.diff(s), [1, 1])
        overlap = np.maximum(5 - np.linalg.norm(r[:, None] - r, axis=2), 0)
        ramp = np.clip((np.abs(s[:, None] - s) - 10) / 10, 0, 1)
        pairs = 0.5 * width[:, None] * width * ramp * overlap**2
        return 62 * 0.5 * 0.05 * 4 / 5 * pairs.sum()

    assert energy(own) == pytest.approx(own.self_energy, rel=0.02)
    assert own.total < loose.energy + energy(loose)


# the line that is given back


def test_the_line_ends_where_it_should_and_is_as_long(rng):
    points = crowd(rng, 80)
    for rod in surrounded_rods(*ARCH, points):
        line = rod.points(5001)
        assert np.abs(line[[0, -1]] - [[0, 0, 0], [10, 0, 0]]).max() < 1e-9
        steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
        assert steps.sum() == pytest.approx(24, rel=1e-6)
        assert steps.max() / steps.min() < 1 + 1e-4
        frames = rod.frames(5001)
        assert np.abs(frames[0] - np.eye(3)).max() < 1e-12
        end = rod.start_frame.T @ [0, 0, -1]
        assert np.abs(frames[-1, :, 2] - end).max() < 1e-9
        assert np.abs(np.einsum("kji,kjl->kil", frames, frames) - np.eye(3)).max() < 1e-12
        # tangent along the line; no turn about it
        along = np.diff(rod.centerline(5001), axis=0)
        along /= np.linalg.norm(along, axis=1)[:, None]
        assert np.abs(along - frames[:-1, :, 2]).max() < 5e-3
        twist = np.einsum("ki,ki->k", np.diff(frames[:, :, 0], axis=0), frames[:-1, :, 1])
        assert np.abs(twist).sum() < 1e-3
        assert rod.twist == 0


def test_places_are_given_in_any_order_and_in_the_given_start_frame(rng):
    frame = Rotation.from_rotvec([0, 0, 0.7]).as_matrix()
    rod = surrounded_rods(*ARCH, start_frame=frame)[0]
    s = np.array([0.9, 0.0, 0.4, 0.4, 1.0])
    assert np.allclose(24 * rod.centerline(s) @ frame.T, rod.points(s), atol=1e-9)
    assert np.allclose(rod.points(s), rod.points(np.sort(s))[[3, 0, 1, 2, 4]], atol=1e-12)
    assert np.abs(rod.frames(s)[1] - np.eye(3)).max() < 1e-12
    with pytest.raises(ValueError, match=r"`n` has an arc length outside \[0, 1\]"):
        rod.centerline([1.5])


def test_nearest_is_the_least_distance_of_any_obstacle(rng):
    points = crowd(rng, 200)
    for rod in surrounded_rods(*ARCH, points)[:3]:
        distance = np.linalg.norm(rod.points(4001)[:, None] - points, axis=2).min(axis=0)
        assert rod.nearest == pytest.approx(distance.min(), abs=1e-5)
        assert rod.nearest_obstacle == distance.argmin()


def test_records_cannot_be_changed_and_survive_pickling():
    import pickle

    rod = surrounded_rods(*ARCH, WALL)[0]
    for one in (rod, pickle.loads(pickle.dumps(rod))):
        with pytest.raises(ValueError, match="read-only"):
            one.node_tangent[0] = 0
    assert np.array_equal(one.points(7), rod.points(7))


# symmetries


@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_moving_turning_and_scaling_everything_does_the_same_to_the_rod(seed):
    rng = np.random.default_rng(seed)
    start, t0, end, t1, length = (np.asarray(part, dtype=float) for part in ARCH)
    points, scale = crowd(rng, 60), 10.0 ** rng.uniform(-3, 3)
    turn, shift = Rotation.random(random_state=rng).as_matrix(), rng.normal(size=3) * 30
    guesses = standard_guesses(*ARCH)[:3]

    def there(x):
        return scale * (x @ turn.T + shift)

    for a in surrounded_rods(*ARCH, points, guesses=guesses, segments=16):
        (b,) = surrounded_rods(
            there(start), turn @ t0, there(end), turn @ t1, scale * float(length), there(points),
            guesses=[there(a.points(400))], segments=16, cutoff=5 * scale,
            stiffness=0.05 / scale**4,
        )  # fmt: skip
        assert a.total == pytest.approx(b.total, rel=1e-6)
        assert np.abs(there(a.points(9)) - b.points(9)).max() < 1e-4 * scale
        assert a.nearest * scale == pytest.approx(b.nearest, rel=1e-4)


@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 10**6), mirrored=st.booleans())
def test_the_reversed_and_the_mirrored_problem_have_the_reversed_and_mirrored_rods(seed, mirrored):
    rng = np.random.default_rng(seed)
    t0, t1 = directions(rng, 2)
    points, flip = crowd(rng, 60), np.array([1, 1, -1 if mirrored else 1])
    guesses = standard_guesses([0, 0, 0], t0, [10, 0, 0], t1, 24.0)[:3]
    order = slice(None, None, 1 if mirrored else -1)
    span = [0, 0, 0], t0 * flip, [10, 0, 0], t1 * flip, 24
    if not mirrored:
        span = [10, 0, 0], -t1, [0, 0, 0], -t0, 24
    for a in surrounded_rods([0, 0, 0], t0, [10, 0, 0], t1, 24, points, guesses=guesses):
        # a saddle may be left to another side: what is found here is a minimum there
        (b,) = surrounded_rods(*span, points * flip, guesses=[(a.points(400) * flip)[order]])
        assert a.total == pytest.approx(b.total, rel=1e-6)
        assert np.abs((a.points(9) * flip)[order] - b.points(9)).max() < 1e-3


# what is hard


@pytest.mark.parametrize("distance", [0.95, 0.99, 0.9999])
def test_a_stretched_rod_converges_to_the_ideal_one(rng, distance):
    for t0, t1 in zip(directions(rng, 8), directions(rng, 8), strict=True):
        span = [0, 0, 0], t0, [distance, 0, 0], t1, 1.0
        rods = surrounded_rods(*span, crowd(rng, 100) / 24, cutoff=0.2, stiffness=1e4)
        assert rods[0].converged
        free = surrounded_rods(*span, self_repulsion=0)[0]
        frames = []
        for tangent in (t0, t1):
            across = np.cross(tangent, directions(rng, 1)[0])
            across /= np.linalg.norm(across)
            frames.append(np.stack([across, np.cross(tangent, across), tangent], axis=1))
        clamping = le.Clamping.from_frames(
            [0, 0, 0], frames[0], [distance, 0, 0], frames[1], 1.0, free_spin=True
        )
        assert free.energy == pytest.approx(le.solve(clamping).energy, rel=0.1)


@pytest.mark.parametrize("nucleotides", [1, 2, 9])
def test_rods_of_one_to_nine_nucleotides_converge_from_every_guess(rng, nucleotides):
    length = 5.5 * nucleotides
    for t0, t1 in zip(directions(rng, 4), directions(rng, 4), strict=True):
        end = [0.6 * length, 0, 0]
        points = crowd(rng, 200, ([0, 0, 0], end), length)
        for guess in standard_guesses([0, 0, 0], t0, end, t1, length):
            (rod,) = surrounded_rods([0, 0, 0], t0, end, t1, length, points, guesses=[guess])
            assert rod.converged
            assert rod.stable
            assert rod.residual <= 1e-8


def test_a_rod_of_forty_nucleotides_among_thousands_of_obstacles(rng):
    end = np.array([60.0, 0, 0])
    points = crowd(rng, 4000, ([0, 0, 0], end), 60)
    guess = standard_guesses([0, 0, 0], [0, 0, 1], end, [0, 0, -1], 200.0, bends=False)
    rod = surrounded_rods(
        [0, 0, 0], [0, 0, 1], end, [0, 0, -1], 200.0, points, guesses=guess, segments=160
    )[0]
    assert rod.converged
    assert rod.nearest > 2


@pytest.mark.parametrize("stiffness", [1e-8, 1.0, 100.0, 1e4, 1e6])
def test_obstacles_may_be_soft_or_hard(stiffness):
    rod = surrounded_rods(*ARCH, WALL, stiffness=stiffness)[0]
    assert rod.converged
    assert np.isfinite([rod.energy, rod.contact_energy, rod.residual]).all()
    if stiffness >= 100:
        assert rod.nearest > 4.9


def test_obstacles_on_the_rod_and_on_its_ends():
    free = surrounded_rods(*ARCH)[0]
    for points in (free.points(5), free.points(free.node_s), [[0, 0, 0]], [[10, 0, 0], [0, 0, 0]]):
        rods = surrounded_rods(*ARCH, points, guesses=[free.points(200)])
        assert rods[0].converged
        assert rods[0].stable
    # those on the inside have been left
    away = surrounded_rods(*ARCH, free.points(5)[1:-1])[0]
    assert away.nearest > 2


def test_one_guess_may_be_a_straight_line_or_a_point():
    folded = [[0, 0, 0], [0, 0, -9], [9, 9, 9]]
    for guess in ([[0, 0, 0], [10, 0, 0]], [[3, 3, 3], [3, 3, 3]], folded):
        (rod,) = surrounded_rods(*ARCH, WALL, guesses=[guess])
        assert rod.converged


def test_both_tangents_along_the_chord():
    span = [0, 0, 0], [1, 0, 0], [10, 0, 0], [1, 0, 0], 20.0
    rod = surrounded_rods(*span)[0]
    ideal = le.solve(le.Clamping([0, 0, 0.5], np.eye(3), free_spin=True))
    assert rod.converged
    assert rod.stable
    assert rod.energy == pytest.approx(ideal.energy, rel=0.02)


def test_a_rod_as_long_as_its_chord_is_straight():
    (rod,) = surrounded_rods([0, 0, 0], [2, 0, 0], [10, 0, 0], [1, 0, 0], 10, [[5, 4, 0]])
    assert rod.converged
    assert rod.stable
    assert rod.energy < 1e-12
    assert rod.contact_energy > 0
    assert rod.nearest == pytest.approx(4)
    assert np.allclose(rod.points(3), [[0, 0, 0], [5, 0, 0], [10, 0, 0]])


# failures are statuses


def test_too_few_iterations_and_too_little_time_are_statuses():
    (rod,) = surrounded_rods(*ARCH, WALL, max_iterations=1)
    assert (rod.converged, rod.status) == (False, le.Status.TOO_MANY_ITERATIONS)
    assert "guess" in rod.message
    assert rod.energy == rod.total == rod.residual == np.inf
    assert rod.stable is None
    assert np.isfinite(rod.points(5)).all()
    (rod,) = surrounded_rods(*ARCH, WALL, max_iterations=1, time_limit_s=1e-9)
    assert rod.status == le.Status.OUT_OF_TIME
    # what was found in time stays
    rods = surrounded_rods(*ARCH, WALL, time_limit_s=1e-9)
    assert len(rods) == 1
    assert rods[0].converged


def test_a_stiffness_beyond_all_numbers_is_a_status():
    (rod,) = surrounded_rods(*ARCH, WALL, stiffness=1e308)
    assert not rod.converged
    assert np.isfinite(rod.points(5)).all()


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"length": 9.0}, "`length` is 9 and the ends are 10 apart"),
        ({"length": 0}, "`length`"),
        ({"length": np.nan}, "`length`"),
        ({"end": [0, 0, 0]}, "`end` is the same point as `start`"),
        ({"start": [0, np.inf, 0]}, "`start`"),
        ({"end": [0, 1]}, "`end`"),
        ({"start_tangent": [0, 0, 0]}, "`start_tangent` is zero"),
        ({"end_tangent": "up"}, "`end_tangent`"),
        ({"length": 10}, "`start_tangent` is not along the line"),
        ({"obstacles": [1, 2, 3]}, "`obstacles`"),
        ({"obstacles": [[1, 2, np.nan]]}, "`obstacles`"),
        ({"cutoff": 0}, "`cutoff`"),
        ({"stiffness": -1}, "`stiffness`"),
        ({"self_repulsion": -0.1}, "`self_repulsion`"),
        ({"segments": 3}, "`segments`"),
        ({"segments": 10**6}, "`segments`"),
        ({"tolerance": 0}, "`tolerance`"),
        ({"max_iterations": 0}, "`max_iterations`"),
        ({"time_limit_s": 0}, "`time_limit_s`"),
        ({"guesses": []}, "`guesses` is empty"),
        ({"guesses": [[[0, 0, 0]]]}, "`guesses`"),
        ({"start_frame": np.eye(3)[::-1]}, "`start_frame`"),
        ({"start_frame": [[0, 0, 1], [1, 0, 0], [0, 1, 0]]}, "`start_frame`"),
    ],
)
def test_impossible_arguments_are_named(changed, message):
    names = "start", "start_tangent", "end", "end_tangent", "length"
    with pytest.raises(ValueError, match=message):
        surrounded_rods(**dict(zip(names, ARCH, strict=True)) | changed)


def test_the_curvature_of_its_arcs_is_the_turning_of_its_tangents():
    rod = surrounded_rods(*ARCH, WALL)[0]
    s = np.linspace(0.0, 1.0, 4001)
    tangents = rod.frames(s)[:, :, 2]
    turning = np.linalg.norm(np.diff(tangents, axis=0), axis=1) / np.diff(s)
    curvature = rod.curvature(0.5 * (s[1:] + s[:-1]))
    # an interval in which two arcs meet has a bit of each
    assert (np.abs(turning - curvature) < 1e-3 * curvature.max()).mean() > 0.95
    assert 0.5 * (curvature**2).mean() == pytest.approx(rod.energy, rel=1e-3)
