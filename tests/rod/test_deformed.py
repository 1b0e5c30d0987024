import copy
import json
import pickle

import numpy as np
import pytest
from chains import clamping_near, energy_by_scipy, shape_drawn
from scipy.spatial.transform import Rotation

import loopelastica as le
from loopelastica.rod.deformed import Chain

POSE = [-0.4, -0.1, 0.5, 4.8, 1.4, 2.2]
FLIP, MIRROR = np.diag([1.0, -1.0, -1.0]), np.diag([1.0, -1.0, 1.0])


@pytest.mark.parametrize("free_spin", [False, True])
@pytest.mark.parametrize("torsion_ratio", [1.0, 0.7])
def test_straight_at_rest_it_comes_to_the_ideal_rod_with_the_square_of_its_segments(
    torsion_ratio, free_spin
):
    clamping = le.Clamping.from_parameters(POSE, free_spin)
    rod = le.solve(clamping, torsion_ratio)
    energies, lines, loads = [], [], []
    for segments in (25, 50, 100, 200):
        chain = le.RestShape.from_rates(0, 0, 0, segments).deform(clamping, torsion_ratio)
        assert chain.converged
        assert chain.stable
        energies.append(abs(chain.energy - rod.energy))
        lines.append(np.abs(chain.nodes - rod.centerline(segments + 1)).max())
        both = np.concatenate([chain.force, chain.moment])
        loads.append(np.abs(both - rod.loads).max())
    for errors, last in ((energies, 1e-3), (lines, 1e-5), (loads, 1e-2)):
        np.testing.assert_allclose(np.array(errors[:-1]) / errors[1:], 4, rtol=0.05)
        assert errors[-1] < last


def test_natural_twist_of_a_straight_rod_only_turns_its_end():
    clamping = le.Clamping.from_parameters(POSE)
    twisted = le.RestShape.from_rates(0, 0, 1.3, 40)
    turned = le.Clamping(clamping.position, clamping.rotation @ twisted.end_frame)
    straight = le.RestShape.from_rates(0, 0, 0, 40)
    assert twisted.deform(turned, 0.7).energy == pytest.approx(
        straight.deform(clamping, 0.7).energy, rel=1e-10
    )


@pytest.mark.parametrize("natural", [0.0, 2.0, np.pi, 2 * np.pi, 9.0])
def test_a_circular_rod_closed_to_a_ring_is_bent_evenly(natural):
    shape = le.RestShape.from_rates(0, natural, 0, 60)
    closed = le.Clamping([0, 0, 0], np.eye(3))
    rings = [
        chain
        for chain in shape.equilibria(closed)
        if chain.energy == pytest.approx(0.5 * (2 * np.pi - natural) ** 2, abs=1e-9)
    ]
    assert rings
    assert all(ring.stable for ring in rings)
    # a regular polygon
    radii = np.linalg.norm(rings[0].nodes[1:] - rings[0].nodes[1:].mean(axis=0), axis=1)
    np.testing.assert_allclose(radii, 1 / (120 * np.sin(np.pi / 60)), rtol=1e-9)
    assert np.abs(rings[0].force).max() < 1e-6


def test_rigid_motion_reversal_and_mirror_image_keep_the_energy(rng):
    for free_spin in (False, True):
        shape = shape_drawn(rng, 6)
        clamping = clamping_near(rng, shape, free_spin=free_spin)
        energy = shape.deform(clamping, 0.6).energy
        # from poses elsewhere
        place = Rotation.random(random_state=rng).as_matrix()
        moved = le.RestShape.from_poses(shape.points @ place.T + 5, place, place @ shape.end_frame)
        moved = le.RestShape(moved.steps, moved.end_frame, shape.stiffness)
        assert moved.deform(clamping, 0.6).energy == pytest.approx(energy, rel=1e-9)
        mirrored = le.RestShape(
            shape.steps @ MIRROR, MIRROR @ shape.end_frame @ MIRROR, shape.stiffness
        )
        assert mirrored.deform(clamping.mirrored(), 0.6).energy == pytest.approx(energy, rel=1e-9)
        if not free_spin:
            back = shape.end_frame @ FLIP
            reversed_shape = le.RestShape(
                -shape.steps[::-1] @ back, FLIP @ shape.end_frame.T @ FLIP, shape.stiffness[::-1]
            )
            turned = reversed_shape.deform(clamping.reversed(), 0.6)
            assert turned.energy == pytest.approx(energy, rel=1e-9)


def test_energy_and_balance_are_those_of_scipys_rotations(rng):
    for free_spin in (False, True):
        shape = shape_drawn(rng, 6)
        chain = shape.deform(clamping_near(rng, shape, free_spin=free_spin), 0.6)
        assert chain.converged
        assert chain.energy == pytest.approx(energy_by_scipy(shape, 0.6, chain.rotations))
        steps = shape.steps / shape.length

        def lagrangian(k, v, chain=chain, shape=shape, steps=steps):
            turns = chain.rotations.copy()
            turns[k] = turns[k] @ Rotation.from_rotvec(v).as_matrix()
            end = np.einsum("kij,kj->i", turns[1:-1], steps)
            return energy_by_scipy(shape, 0.6, turns) - chain.force @ end

        h = 1e-5
        for k in range(1, 7):
            for axis in h * np.eye(3):
                assert abs(lagrangian(k, axis) - lagrangian(k, -axis)) / (2 * h) < 1e-6
        # what the start clamp takes up
        slope = [(lagrangian(0, v) - lagrangian(0, -v)) / (2 * h) for v in h * np.eye(3)]
        np.testing.assert_allclose(slope, -chain.moment, atol=1e-6)
        if free_spin:
            v = h * shape.end_frame[:, 2]
            assert abs(lagrangian(7, v) - lagrangian(7, -v)) / (2 * h) < 1e-6


def test_loads_grow_with_the_stiffness_and_one_hinge_may_be_stiff(rng):
    shape = shape_drawn(rng, 6)
    clamping = clamping_near(rng, shape)
    soft = shape.deform(clamping)
    for factor in (1e-9, 1e12):
        stiff = le.RestShape(shape.steps, shape.end_frame, factor * shape.stiffness)
        chain = stiff.deform(clamping)
        assert chain.energy == pytest.approx(factor * soft.energy, rel=1e-9)
        np.testing.assert_allclose(chain.force, factor * soft.force, rtol=1e-6)
        np.testing.assert_allclose(chain.moment, factor * soft.moment, rtol=1e-6)
    stiffness = shape.stiffness.copy()
    stiffness[3] = 1e8
    rigid = le.RestShape(shape.steps, shape.end_frame, stiffness).deform(clamping)
    assert rigid.converged
    assert np.abs(rigid.rotations[3] - rigid.rotations[4]).max() < 1e-5
    assert rigid.energy > soft.energy


def test_the_index_is_that_of_the_hessian_on_what_the_ends_allow(rng):
    seen = set()
    for m, free_spin in ((5, False), (5, True), (8, False)):
        shape = shape_drawn(rng, m, turn=0.3)
        clamping = clamping_near(rng, shape, away=1.0, free_spin=free_spin)
        for chain in shape.equilibria(clamping, 0.6)[:8]:
            seen.add(chain.index)
            assert dense_index(chain) == chain.index
            assert chain.stable == (chain.index == 0)
    assert len(seen) > 2


def dense_index(chain):
    """Negative eigenvalues of the Lagrangian's Hessian in the kernel of the constraint."""
    shape, m = chain.shape, len(chain.nodes) - 1
    free, steps = chain.clamping.free_spin, shape.steps / shape.length
    size, axis = 3 * m + free, shape.end_frame[:, 2]

    def turned(b):
        turns = chain.rotations.copy()
        vectors = np.vstack([b[: 3 * m].reshape(m, 3), b[-1] * axis if free else np.zeros(3)])
        turns[1:] = turns[1:] @ Rotation.from_rotvec(vectors).as_matrix()
        return turns

    def end(b):
        return np.einsum("kij,kj->i", turned(b)[1:-1], steps)

    def lagrangian(b):
        return energy_by_scipy(shape, chain.torsion_ratio, turned(b)) - chain.force @ end(b)

    h, one = 1e-4, np.eye(size)
    slopes = np.array([(end(h * e) - end(-h * e)) / (2 * h) for e in one])
    kernel = np.linalg.svd(slopes.T)[2][3:]
    hessian = [
        [
            lagrangian(h * (a + b)) - lagrangian(h * (a - b))
            - lagrangian(h * (b - a)) + lagrangian(-h * (a + b))
            for b in kernel
        ]
        for a in kernel
    ]  # fmt: skip
    return int((np.linalg.eigvalsh(np.array(hessian) / (4 * h * h)) < 0).sum())


def test_equilibria_are_distinct_lowest_first_and_below_the_bound():
    clamping = le.Clamping.from_parameters(POSE)
    shape = le.RestShape.from_rates(0, 0, 0, 40)
    found = shape.equilibria(clamping)
    energies = [chain.energy for chain in found]
    assert energies == sorted(energies)
    assert all(chain.converged for chain in found)
    for i, chain in enumerate(found):
        for other in found[:i]:
            assert np.abs(chain.rotations - other.rotations).max() > 1e-6
    # the ideal rod's, to the error of the segments
    ideal = [rod for rod in le.equilibria(clamping) if rod.energy < 62]
    for rod in ideal:
        near = [c for c in found if c.energy == pytest.approx(rod.energy, rel=6e-3)]
        assert rod.index in [chain.index for chain in near]
    below = shape.equilibria(clamping, energy_max=30)
    assert [chain.energy for chain in below] == pytest.approx([e for e in energies if e <= 30])
    assert shape.equilibria(clamping, energy_max=1) == []
    assert shape.deform(clamping).energy == pytest.approx(energies[0], rel=1e-9)


def test_a_straight_chain_turned_about_the_line_of_its_ends_is_listed_once():
    shape = le.RestShape.from_rates(0, 0, 0, 10)
    found = shape.equilibria(le.Clamping([0, 0, 0.8], np.eye(3)), energy_max=20)
    energies = np.array([chain.energy for chain in found])
    assert len(found) > 0
    assert np.diff(energies).min(initial=1) > 1e-6


def test_a_guess_leads_to_the_equilibrium_beside_it(rng):
    clamping = le.Clamping.from_parameters(POSE)
    shape = le.RestShape.from_rates(0, 0, 0, 40)
    second = [chain for chain in shape.equilibria(clamping) if chain.stable][1]
    near = le.Clamping(clamping.position + 0.001, clamping.rotation)
    chain = shape.deform(near, guess=second)
    assert chain.energy == pytest.approx(second.energy, rel=0.01)
    with pytest.raises(ValueError, match="`guess` has 40 segments"):
        shape_drawn(rng, 4).deform(clamping, guess=second)
    with pytest.raises(ValueError, match="`guess`"):
        shape.deform(clamping, guess=le.solve(clamping))


def test_what_cannot_be_is_refused_by_name(rng):
    shape = shape_drawn(rng, 5)
    far = le.Clamping([0, 0.8, 0.8], np.eye(3))
    long_step = le.RestShape([[0, 0, 1.0], [0, 0, 10.0], [0, 1.0, 0]], np.eye(3))
    for method in (le.RestShape.deform, le.RestShape.equilibria):
        with pytest.raises(ValueError, match=r"`clamping` has its ends 1\.13"):
            method(shape, far)
        with pytest.raises(ValueError, match=r"`clamping` .* longest segment"):
            method(long_step, le.Clamping([0, 0, 0.1], np.eye(3)))
        with pytest.raises(ValueError, match="`clamping`"):
            method(shape, [0, 0, 0.5])
        with pytest.raises(ValueError, match="`torsion_ratio`"):
            method(shape, shape.clamping, -1)
    with pytest.raises(ValueError, match="`energy_max`"):
        shape.equilibria(shape.clamping, energy_max=np.nan)


@pytest.fixture(scope="module")
def stretched():
    """Curved at rest, clamped exactly as far as it is long: the force would be infinite."""
    shape = le.RestShape.from_rates(0, 2, 0, 8)
    return shape.deform(le.Clamping([0, 0.6, 0.8], shape.end_frame))


def test_a_failure_is_a_status_with_finite_numbers(stretched):
    assert not stretched.converged
    assert stretched.status in (le.Status.STALLED, le.Status.TOO_MANY_ITERATIONS)
    assert stretched.stable is None
    assert stretched.energy == stretched.residual == np.inf
    for values in (stretched.nodes, stretched.rotations, stretched.force, stretched.curvature(9)):
        assert np.isfinite(values).all()
    assert "no start" in repr(stretched)
    np.testing.assert_allclose(stretched.nodes, stretched.shape.points)


def test_a_chain_survives_its_dictionary_copies_and_pickles(rng, stretched):
    shape = shape_drawn(rng, 5)
    solved = shape.deform(clamping_near(rng, shape), 0.7)
    for chain in (solved, stretched):
        read = Chain.from_dict(json.loads(json.dumps(chain.to_dict(), allow_nan=False)))
        for other in (read, copy.deepcopy(chain), pickle.loads(pickle.dumps(chain))):
            assert other.to_dict() == chain.to_dict()
            assert other.energy == chain.energy
            assert not other.nodes.flags.writeable
    values = solved.to_dict()
    with pytest.raises(ValueError, match="`values`"):
        Chain.from_dict([])
    with pytest.raises(ValueError, match="`nodes`"):
        Chain.from_dict(values | {"nodes": values["nodes"][1:]})
    with pytest.raises(KeyError):
        Chain.from_dict({"shape": values["shape"]})


def test_the_smooth_curve_passes_the_nodes_with_a_steady_curvature():
    shape = le.RestShape.from_rates(0, 3.0, 0, 50)
    chain = shape.deform(shape.clamping)
    s = np.linspace(0, 1, 51)
    np.testing.assert_allclose(chain.centerline(s), chain.nodes, atol=1e-12)
    assert chain.centerline(7).shape == (7, 3)
    np.testing.assert_allclose(chain.curvature(201), 3.0, rtol=5e-3)
    jumps = np.diff(chain.curvature(20001))
    assert np.abs(jumps).max() < 1e-3
    given = chain.centerline([0, 1e-6], [[0, 1, 0], [0, 0, 2]])
    np.testing.assert_allclose(np.diff(given, axis=0)[0] / 1e-6, [0, 1, 0], atol=1e-3)
    with pytest.raises(ValueError, match="`tangents`"):
        chain.centerline(3, [[0, 0, 0], [0, 0, 1]])
    with pytest.raises(ValueError, match="`n`"):
        chain.curvature(0)
