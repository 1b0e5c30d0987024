import numpy as np
import pytest
from chains import clamping_near, shape_drawn
from scipy.spatial.transform import Rotation

import loopelastica as le
from loopelastica.rod.kernels.chain import set_shape
from loopelastica.rod.kernels.chain_minimization import (
    _by_moving_the_end,
    deform_rows,
    new_room,
    new_rows,
)
from loopelastica.rod.kernels.rotations import quaternion_from_matrix


def rows_of(shape, clamping, torsion_ratio, turns, minimized):
    """One row from turns (m, 3, 3) of the segments to begin with."""
    rows = new_rows(1, len(shape.steps))
    guess = Rotation.from_matrix(turns).as_quat(scalar_first=True)[None]
    deform_rows(
        shape.steps[None].copy(), shape.end_frame[None].copy(), shape.stiffness[None].copy(),
        clamping.position[None] * shape.length, clamping.rotation[None].copy(), torsion_ratio,
        clamping.free_spin, np.ascontiguousarray(guess), minimized, rows,
    )  # fmt: skip
    return rows


@pytest.mark.parametrize("torsion_ratio", [0.8, 1.0, 1.5])
def test_a_twisted_ring_loses_its_stability_where_michell_and_zajac_say(torsion_ratio):
    m = 100
    shape, middles = le.RestShape.from_rates(0, 0, 0, m), (np.arange(m) + 0.5) / m
    ring = Rotation.from_rotvec(np.outer(2 * np.pi * middles, [0, 1, 0]))
    for share, index in ((0.94, 0), (1.06, 1)):
        turns = share * np.sqrt(3) / torsion_ratio
        spin = Rotation.from_rotvec(np.outer(2 * np.pi * turns * middles, [0, 0, 1]))
        end = Rotation.from_rotvec([0, 0, 2 * np.pi * turns]).as_matrix()
        clamping = le.Clamping([0, 0, 0], end)
        rows = rows_of(shape, clamping, torsion_ratio, (ring * spin).as_matrix(), False)
        assert rows.status[0] == le.Status.CONVERGED
        flat = 2 * np.pi**2 * (1 + torsion_ratio * turns**2)
        assert rows.energy[0] == pytest.approx(flat, rel=1e-3)
        assert (rows.morse_index[0] > 0) == index


def test_a_saddle_is_left_downhill_and_kept_otherwise():
    clamping = le.Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])
    shape = le.RestShape.from_rates(0, 0, 0, 20)
    saddle = next(chain for chain in shape.equilibria(clamping) if chain.index == 1)
    kept = rows_of(shape, clamping, 1.0, saddle.rotations[1:-1], False)
    assert kept.energy[0] == pytest.approx(saddle.energy, rel=1e-9)
    assert kept.morse_index[0] == 1
    left = rows_of(shape, clamping, 1.0, saddle.rotations[1:-1], True)
    assert left.energy[0] < saddle.energy - 0.1
    assert left.morse_index[0] == 0


# kernels that Python does not call otherwise are compiled one by one


def room_of(shape, clamping, torsion_ratio):
    room = new_room(len(shape.steps), clamping.free_spin)
    end = quaternion_from_matrix(shape.end_frame.copy())
    set_shape(room.chain, shape.steps.copy(), end, shape.stiffness.copy(), torsion_ratio)
    room.chain.frames[:, 0] = 1
    room.chain.frames[-1] = quaternion_from_matrix(clamping.rotation.copy())
    return room


@pytest.mark.slow
@pytest.mark.parametrize("free_spin", [False, True])
def test_moving_the_end_and_going_at_once_come_to_the_same(rng, free_spin):
    for _ in range(5):
        shape = shape_drawn(rng, 6, varied=False)
        clamping = clamping_near(rng, shape, away=0.2, free_spin=free_spin)
        position, at_once = clamping.position.copy(), shape.deform(clamping, 0.6)
        room = room_of(shape, clamping, 0.6)
        q = room.chain.frames[-1].copy()
        status, energy, index = _by_moving_the_end(room, position, q)
        assert (status, index) == (0, 0)
        assert energy == pytest.approx(at_once.energy, rel=1e-8)
