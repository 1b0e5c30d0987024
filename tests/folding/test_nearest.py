"""The estimate of an energy, and which shapes of a large table it keeps."""

from pathlib import Path

import numpy as np
import pytest
from loop_shapes import found
from scipy.spatial.transform import Rotation
from scipy.stats import spearmanr

from loopelastica.batch.shapes import build_library
from loopelastica.folding.nearest import estimated_energy, nearest
from loopelastica.folding.shape_table import empty_table, table_of
from loopelastica.molecule.ends import ClosingPoses
from loopelastica.rod.chain import deform_batch

LOOPS = Path(__file__).resolve().parents[3] / "shared" / "loops"
N = 6
LETTERS = np.array(list("ACGU"))


@pytest.fixture(scope="module")
def table():
    rng = np.random.default_rng(3)
    draws = ["".join(rng.choice(LETTERS, N + 2)) for _ in range(400)]
    return table_of(N, [found(s, f"{k}", seed=k) for k, s in enumerate(draws)])


def poses(position, rotation):
    return ClosingPoses(np.zeros(3), np.eye(3), np.asarray(position), np.asarray(rotation))


@pytest.fixture(scope="module")
def stem(table):
    """Where the shapes' ends are on the average, so that none is far off."""
    middle = Rotation.from_matrix(table.end_frames).mean().as_matrix()
    return poses(table.steps_A.sum(axis=1).mean(axis=0), middle)


def deformed(table, stem):
    return deform_batch(table.steps_A, table.end_frames, stem.position_A, stem.rotation)


def test_a_shape_on_its_own_stem_costs_nothing(table):
    for k in range(5):
        one = table.take(np.array([k]))
        energy = estimated_energy(one, one.steps_A[0].sum(axis=0), one.end_frames[0])
        assert energy == pytest.approx([0.0], abs=1e-12)


@pytest.mark.parametrize("seed", range(6))
def test_for_small_changes_it_is_the_energy_of_the_deformed_chain(table, seed):
    """To second order: an error of the third in the size of the change."""
    rng = np.random.default_rng(seed)
    one = table.take(np.array([seed]))
    end, frame = one.steps_A[0].sum(axis=0), one.end_frames[0]
    shift, turn = rng.normal(size=3), rng.normal(size=3)
    for size in (1e-2, 1e-3):
        moved = poses(
            end + 10.0 * size * shift, Rotation.from_rotvec(size * turn).as_matrix() @ frame
        )
        estimate = estimated_energy(one, moved.position_A, moved.rotation)
        batch = deformed(one, moved)
        assert batch.converged.all()
        np.testing.assert_allclose(estimate, batch.energy, rtol=30 * size)


def test_it_orders_shapes_nearly_as_their_deformation_does(table, stem):
    batch = deformed(table, stem)
    assert batch.converged.all()
    estimate = estimated_energy(table, stem.position_A, stem.rotation)
    assert spearmanr(estimate, batch.energy).statistic > 0.9
    kept = nearest(table, stem, "A" * (N + 2), most=80)
    assert np.isin(np.argsort(batch.energy)[:5], kept).all()


def test_it_does_not_depend_on_the_unit_nor_on_what_else_is_estimated(table, stem):
    every = estimated_energy(table, stem.position_A, stem.rotation)
    larger = table.take(np.arange(len(table)))
    object.__setattr__(larger, "steps_A", 2.5 * table.steps_A)
    scaled = estimated_energy(larger, 2.5 * stem.position_A, stem.rotation)
    np.testing.assert_allclose(scaled, every, rtol=1e-10)
    for k in (0, 7, 399):
        one = table.take(np.array([k]))
        np.testing.assert_allclose(
            estimated_energy(one, stem.position_A, stem.rotation), every[k : k + 1], rtol=1e-12
        )


def test_the_least_are_kept_and_all_of_the_same_loop(table, stem):
    estimate = estimated_energy(table, stem.position_A, stem.rotation)
    worst = int(np.argmax(estimate))
    sequence = f"A{table.sequence(worst)[1:-1]}A"
    kept = nearest(table, stem, sequence, most=50)
    least = np.argsort(estimate)[:50]
    assert set(kept.tolist()) == {worst, *least.tolist()}
    assert (np.diff(kept) > 0).all()


def test_what_is_left_out_is_never_kept(table, stem):
    first = nearest(table, stem, "A" * (N + 2), most=50)
    without = np.zeros(len(table), dtype=bool)
    without[first[:30]] = True
    sequence = table.sequence(int(first[0]))
    second = nearest(table, stem, sequence, most=50, without=without)
    assert len(second) == 50
    assert not without[second].any()


def test_small_tables_are_kept_whole(table, stem):
    assert nearest(table, stem, "A" * (N + 2)).tolist() == list(range(400))
    without = np.ones(len(table), dtype=bool)
    without[[5, 9]] = False
    assert nearest(table, stem, "A" * (N + 2), without=without).tolist() == [5, 9]
    assert nearest(empty_table(N), stem, "A" * (N + 2)).tolist() == []
    assert estimated_energy(empty_table(N), stem.position_A, stem.rotation).tolist() == []


def test_a_shape_that_is_straight_at_rest_has_a_finite_energy(table):
    straight = table.take(np.array([0]))
    object.__setattr__(straight, "steps_A", np.tile([0.0, 0.0, 5.0], (1, N + 1, 1)))
    object.__setattr__(straight, "end_frames", np.eye(3)[None])
    assert estimated_energy(straight, np.array([0.0, 0.0, 35.0]), np.eye(3)) == pytest.approx([0])
    assert np.isfinite(estimated_energy(straight, np.array([0.0, 0.0, 10.0]), np.eye(3))).all()


@pytest.mark.slow
@pytest.mark.skipif(not LOOPS.is_dir(), reason="the loops are not beside this checkout")
def test_of_real_loops_a_fifth_holds_the_five_of_least_energy(tmp_path):
    """Each loop's stem against all loops of its length that are no relatives."""
    library = build_library(LOOPS, tmp_path / "loops.lib").library
    assert len(library) > 750
    rng = np.random.default_rng(1)
    kept_all = []
    for n in (4, 5, 6, 7):
        table = library.of_length(n, is_dna=False)
        for k in rng.choice(len(table), 10, replace=False):
            stem = poses(table.steps_A[k].sum(axis=0), table.end_frames[k])
            others = table.take(~table.relatives(table.sequence(k)))
            least = np.argsort(deformed(others, stem).energy)[:5]
            kept = nearest(others, stem, table.sequence(k), most=max(15, len(others) // 5))
            kept_all.append(np.isin(least, kept).mean())
    assert np.mean(kept_all) > 0.97
