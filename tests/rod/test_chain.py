import numpy as np
import pytest
from chains import clamping_near, shape_drawn
from scipy.spatial.transform import Rotation

from loopelastica import Status
from loopelastica.rod.chain import deform_batch


def problems(rng, k, m):
    """k shapes of m segments in ångströms, and ends to deform them to."""
    shapes = [shape_drawn(rng, m) for _ in range(k)]
    clampings = [clamping_near(rng, shape) for shape in shapes]
    return shapes, (
        np.array([6.0 * shape.steps for shape in shapes]),
        np.array([shape.end_frame for shape in shapes]),
        np.array([6.0 * s.length * c.position for s, c in zip(shapes, clampings, strict=True)]),
        np.array([clamping.rotation for clamping in clampings]),
        np.array([shape.stiffness for shape in shapes]),
    ), clampings  # fmt: skip


def test_a_batch_is_its_rows_one_by_one(rng):
    shapes, given, clampings = problems(rng, 12, 6)
    batch = deform_batch(*given, torsion_ratio=0.7)
    assert len(batch) == 12
    assert batch.converged.all()
    assert batch.stable.all()
    assert batch.residual.max() < 1e-8
    for row, (shape, clamping) in enumerate(zip(shapes, clampings, strict=True)):
        chain = shape.deform(clamping, 0.7)
        assert batch.energy[row] == pytest.approx(chain.energy, rel=1e-9)
        np.testing.assert_allclose(
            batch.nodes[row], 6.0 * shape.length * chain.nodes, atol=1e-7 * shape.length
        )
        np.testing.assert_allclose(batch.rotations[row], chain.rotations[1:-1], atol=1e-8)
        alone = deform_batch(*(values[row] for values in given), torsion_ratio=0.7)
        np.testing.assert_array_equal(alone.nodes[0], batch.nodes[row])


def test_one_shape_goes_with_all_ends_and_one_end_with_all_shapes(rng):
    _, (steps, ends, positions, rotations, _), _ = problems(rng, 5, 4)
    near = positions[:1] + 0.1 * rng.normal(size=(5, 3))
    one_shape = deform_batch(steps[0], ends[0], near, rotations)
    assert one_shape.converged.all()
    for row in range(5):
        alone = deform_batch(steps[0], ends[0], near[row], rotations[row])
        np.testing.assert_array_equal(alone.nodes[0], one_shape.nodes[row])
    one_end = deform_batch(steps, ends, near[0], rotations[0])
    assert one_end.converged.all()
    for row in range(5):
        alone = deform_batch(steps[row], ends[row], near[0], rotations[0])
        np.testing.assert_array_equal(alone.nodes[0], one_end.nodes[row])


def test_the_segments_keep_their_lengths_and_the_chain_reaches_its_end(rng):
    _, given, _ = problems(rng, 12, 7)
    batch = deform_batch(*given)
    vectors = np.diff(batch.nodes, axis=1)
    np.testing.assert_allclose(vectors, np.einsum("rkij,rkj->rki", batch.rotations, given[0]))
    np.testing.assert_allclose(batch.nodes[:, -1], given[2], atol=1e-7)
    np.testing.assert_array_equal(batch.nodes[:, 0], 0)


def test_a_row_that_cannot_be_is_a_status_and_the_others_go_on(rng):
    _, (steps, ends, positions, rotations, stiffness), _ = problems(rng, 9, 5)
    steps[1, 2, 0] = np.nan
    steps[2, 3] = 0.0
    ends[3] *= 2
    positions[4] = np.inf
    rotations[5] = np.diag([1, 1, -1])
    stiffness[6, 0] = -1
    positions[7] *= 100
    # its longest segment keeps the ends apart
    steps[8, 0] *= 100
    batch = deform_batch(steps, ends, positions, rotations, stiffness)
    bad, apart = Status.BAD_INPUT, Status.UNREACHABLE
    assert batch.status.tolist() == [Status.CONVERGED, *6 * [bad], apart, apart]
    assert np.isfinite(batch.nodes).all()
    assert np.isfinite(batch.rotations).all()
    assert np.isinf(batch.energy[1:]).all()
    assert np.isinf(batch.residual[1:]).all()
    assert not batch.stable[1:].any()
    assert (batch.index[1:] == -1).all()
    good = deform_batch(steps[0], ends[0], positions[0], rotations[0], stiffness[0])
    assert batch.energy[0] == good.energy[0]


def test_hard_poses_all_converge(rng):
    for m, torsion_ratio in ((4, 1.0), (6, 0.2), (10, 5.0)):
        k = 20
        steps, ends = rng.normal(size=(k, m, 3)), Rotation.random(k, random_state=rng).as_matrix()
        sizes = np.linalg.norm(steps, axis=2)
        near = np.maximum(2 * sizes.max(axis=1) - sizes.sum(axis=1), 0)
        share = np.where(rng.uniform(size=k) < 0.3, 0.9999, rng.uniform(0.01, 0.98, k))
        reach = near + share * (sizes.sum(axis=1) - near)
        places = rng.normal(size=(k, 3))
        places *= (reach / np.linalg.norm(places, axis=1))[:, None]
        frames = Rotation.random(k, random_state=rng).as_matrix()
        batch = deform_batch(steps, ends, places, frames, None, torsion_ratio)
        assert batch.converged.all()
        assert batch.stable.all()
        assert batch.residual.max() < 1e-8


def test_no_rows_are_no_chains():
    batch = deform_batch(
        np.empty((0, 4, 3)), np.empty((0, 3, 3)), np.empty((0, 3)), np.empty((0, 3, 3))
    )
    assert len(batch) == 0
    assert batch.nodes.shape == (0, 5, 3)


@pytest.mark.parametrize(
    ("changed", "name"),
    [
        ({"steps": np.zeros((2, 0, 3))}, "steps"),
        ({"steps": np.zeros((2, 1, 3))}, "steps"),
        ({"steps": np.zeros((2, 4, 2))}, "steps"),
        ({"steps": "many"}, "steps"),
        ({"end_frames": np.eye(2)}, "end_frames"),
        ({"positions": np.zeros((2, 2))}, "positions"),
        ({"positions": np.zeros((3, 3))}, "positions"),
        ({"rotations": np.zeros((2, 3))}, "rotations"),
        ({"stiffness": np.ones(4)}, "stiffness"),
        ({"torsion_ratio": 0}, "torsion_ratio"),
        ({"torsion_ratio": np.nan}, "torsion_ratio"),
    ],
)
def test_arguments_that_do_not_fit_are_named(rng, changed, name):
    _, (steps, ends, positions, rotations, stiffness), _ = problems(rng, 2, 4)
    given = {
        "steps": steps, "end_frames": ends, "positions": positions, "rotations": rotations,
        "stiffness": stiffness,
    }  # fmt: skip
    with pytest.raises(ValueError, match=f"`{name}`"):
        deform_batch(**(given | changed))
