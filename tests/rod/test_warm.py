import os
import subprocess
import sys
from pathlib import Path

import pytest

import loopelastica

ROOT = Path(loopelastica.__file__).resolve().parents[1]

USES = """
from numba.core import event
with event.install_recorder("numba:compile") as compiled:
    import numpy as np
    import loopelastica as le
    from scipy.spatial.transform import Rotation
    rng = np.random.default_rng(3)
    frames = Rotation.random(40, random_state=rng).as_matrix()
    places = rng.normal(size=(40, 3))
    places /= np.linalg.norm(places, axis=1, keepdims=True)
    places *= rng.uniform(0.01, 0.9999, (40, 1))
    for free_spin in (False, True, 0, 1):
        for lowest in (False, True):
            batch = le.solve_batch(places, frames, 0.7, free_spin, lowest=lowest)
            assert batch.converged.all()
            assert any(len(rod.layers) for rod in batch)
            for rod in batch:
                rod.frames(5)
    for k in range(4):
        clamping = le.Clamping(places[k], frames[k], free_spin=k % 2)
        rods = le.equilibria(clamping, rounds=1)
        rods[0].poses_without_spin(3), rods[0].moment(3), rods[0].curvature(3)
        le.barriers(rods), le.equilibria(clamping).evidence
        rod = le.solve(clamping, guess=rods[0].loads)
        rod.physical.centerline(4), rod.physical.frames(4), rod.net_winding, rod.writhe, rod.turns
        near = le.Clamping(0.999 * places[k], frames[k], free_spin=k % 2)
        le.continue_clamping(rod, near)
        if not k % 2:
            le.twist_end(rod, 0.05)
    from loopelastica.rod.surrounded import surrounded_rods
    for obstacles in (None, places[:0], places):
        ends = (0, 0, 0), (0, 0, 1), (0.4, 0, 0), frames[0][:, 2]
        surrounded_rods(*ends, 1, obstacles, cutoff=0.3, stiffness=1, max_iterations=3)
    from loopelastica.rod.chain import deform_batch
    steps = places[:24].reshape(4, 6, 3)
    deform_batch(steps, frames[:4], steps.sum(axis=1) / 2, frames[4:8], torsion_ratio=0.7)
    deform_batch(steps[0], frames[0], steps.sum(axis=1) / 2, frames[4:8], np.ones(7))
    shape = le.RestShape.from_rates(0, lambda s: 2 * s, 1, 20)
    for free_spin in (False, True):
        clamping = le.Clamping(0.9 * shape.clamping.position, frames[0], free_spin)
        shape.deform(clamping, guess=shape.deform(clamping)), shape.equilibria(clamping, 2)
    le.equilibria(le.Clamping([0, 0, 0.5], np.eye(3)), 0.7).evidence
    aligned = le.solve(le.Clamping([0, 0, 0.5], np.eye(3)))
    le.continue_clamping(aligned, le.Clamping([0, 0.1, 0.5], np.eye(3)))
print(*sorted({e.data["dispatcher"].py_func.__name__ for _, e in compiled.buffer}))
"""


@pytest.mark.slow
def test_nothing_is_left_to_be_compiled_after_warm(tmp_path):
    environment = os.environ | {"LOOPELASTICA_CACHE": str(tmp_path), "PYTHONPATH": str(ROOT)}

    def run(*arguments):
        command = [sys.executable, "-W", "error::UserWarning", *arguments]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout.strip()

    assert run("-m", "loopelastica", "warm") == f"compiled: {tmp_path}"
    assert run("-c", USES) == ""
