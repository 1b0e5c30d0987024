import os
import subprocess
import sys

import numpy as np
from scipy.spatial.transform import Rotation

import loopelastica as le
from loopelastica.rod._middles import draw, middles
from loopelastica.rod.kernels.middle import ends_from_middle

PRINT = "from loopelastica.rod._middles import middles; print(middles(0.7, False).loads.sum(0))"


def test_drawn_rods_are_the_same_in_every_process():
    other = subprocess.run(
        [sys.executable, "-c", PRINT], env=os.environ, capture_output=True, text=True, check=True
    )
    assert other.stdout == f"{middles(0.7, False).loads.sum(0)}\n"
    assert len(other.stdout) > 20


def test_a_free_spin_has_no_torsion_moment(rng):
    assert not middles(1.0, True).loads[:, 5].any()
    assert not draw(rng, 50, 1.0, True)[:, 5].any()
    assert draw(rng, 50, 1.0, False)[:, 5].any()


def test_a_drawn_rod_is_the_nearest_to_its_own_end():
    for free_spin in (False, True):
        rods = middles(0.7, free_spin)
        chosen = rods.loads[::1000].copy()
        n = len(chosen)
        p, q, energies = np.empty((n, 3)), np.empty((n, 4)), np.empty(n)
        ends_from_middle(chosen, 0.7, 4.0, p, q, energies)
        assert energies.max() < 170
        for loads, place, quaternion in zip(chosen, p, q, strict=True):
            frame = Rotation.from_quat(quaternion, scalar_first=True).as_matrix()
            near = rods.nearest(le.Clamping(place, frame, free_spin), 3)
            size = 1 + np.abs(loads).max()
            assert np.abs(near - loads).max(axis=1).min() < 0.1 * size
