import importlib.util
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from loopelastica.rod._library import UNITS, _stored, stored_rods
from loopelastica.rod.kernels.shooting import ends

TOOL = Path(__file__).resolve().parents[2] / "data" / "make_rods.py"


@pytest.fixture(scope="module")
def make_rods():
    spec = importlib.util.spec_from_file_location("make_rods", TOOL)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_stored_rods_reach_their_stored_poses():
    for free_spin in (False, True):
        stored = _stored(free_spin)[::500]
        positions, quaternions = ends(stored[:, :6].copy(), 1.0, 3.0)
        moderate = np.linalg.norm(stored[:, :3], axis=1) < 60
        np.testing.assert_allclose(positions[moderate], stored[moderate, 6:9], atol=1e-3)
        dots = np.abs((quaternions * stored[:, 9:]).sum(1))[moderate]
        assert dots.min() > 1 - 1e-4


def test_a_stored_rod_is_its_own_nearest_neighbour_after_any_turn_of_the_start_frame(rng):
    for torsion_ratio in (1.0, 0.7):
        loads = _stored(False)[rng.integers(0, 20_000, 50), :6]
        positions, quaternions = ends(loads, torsion_ratio, 3.0)
        turn = Rotation.from_rotvec([0, 0, 0.9])
        rotations = (
            turn * Rotation.from_quat(quaternions, scalar_first=True) * turn.inv()
        ).as_matrix()
        nearest, known = stored_rods(torsion_ratio, False).nearest(
            turn.apply(positions), rotations, 2, within=1e-3
        )
        assert (known >= 1).all()
        for part in (slice(0, 3), slice(3, 6)):
            np.testing.assert_allclose(nearest[:, 0, part], turn.apply(loads[:, part]), atol=1e-2)


def test_no_rod_is_known_where_none_is_near():
    far = np.array([[0.0, 0.0, -0.9999]])
    _, known = stored_rods(1.0, False).nearest(far, np.eye(3)[None], 3, within=0.05)
    assert known[0] == 0


def test_the_tool_draws_loads_as_the_shipped_file_has_them(make_rods):
    for free_spin in (False, True):
        count = make_rods.SIZES[free_spin][0]
        drawn = make_rods.draw_loads(count, np.random.default_rng(make_rods.SEED))
        shipped = _stored(free_spin)[: len(drawn), :6]
        expected = drawn * [1, 1, 1, 1, 1, not free_spin]
        np.testing.assert_allclose(shipped, expected, rtol=0.0, atol=0.501 * UNITS[0])


def test_the_tool_writes_rods_that_reach_their_poses(make_rods, tmp_path):
    make_rods.write(tmp_path / "rods.npz", {False: (6, 6), True: (6, 6)}, seed=3)
    assert [path.name for path in tmp_path.iterdir()] == ["rods.npz"]
    with np.load(tmp_path / "rods.npz") as archive:
        for name in ("clamped", "free"):
            assert archive[name].dtype == np.int16
            rods = archive[name] * UNITS
            assert rods.shape[1] == 13
            assert 6 < len(rods) <= 12
            positions, quaternions = ends(rods[:, :6].copy(), 1.0, 3.0)
            np.testing.assert_allclose(positions, rods[:, 6:9], atol=1e-3)
            assert np.abs((quaternions * rods[:, 9:]).sum(1)).min() > 1 - 1e-4
        assert not archive["free"][:6, 5].any()
        # the second half are lowest rods of slack poses
        assert np.linalg.norm(archive["clamped"][6:, 6:9] * UNITS[6], axis=1).max() < 0.9501
