import numpy as np
import pytest
from draws import pose_drawn

import loopelastica as le
from loopelastica.rod.stability import _inertia, assess, conjugate_points


@pytest.mark.parametrize(
    ("torsion_ratio", "free_spin"), [(0.7, False), (1.0, False), (1.5, False), (1.0, True)]
)
def test_conjugate_points_agree_with_the_inertia_of_the_discrete_hessian(
    rng, torsion_ratio, free_spin
):
    seen = set()
    for position, rotation in zip(*pose_drawn(rng, 6), strict=True):
        rods = le.equilibria(le.Clamping(position, rotation, free_spin), torsion_ratio, rounds=1)
        assert rods[0].stable
        for rod in rods:
            root = np.sqrt(np.linalg.norm(rod.loads[:3]))
            if root > 25:
                continue
            assert conjugate_points(rod) == _inertia(rod, root, 128) == rod.index
            seen.add(rod.index)
    assert {0, 1} <= seen


def test_planar_arch_s_and_loop_over_a_chord():
    rods = le.equilibria(le.Clamping([0, 0, 0.9], np.eye(3)))
    # the arch is the only minimum without twist; higher planar modes have more ways down
    arch = next(rod for rod in rods if abs(rod.energy - 4.0504) < 1e-3)
    wave = next(rod for rod in rods if abs(rod.energy - 16.2016) < 1e-3)
    assert arch.stable
    assert wave.index >= 2


def test_the_index_is_computed_when_asked_and_kept():
    rod = le.solve(le.Clamping([0, 0, 0.5], np.eye(3)))
    assert rod.index is None
    assert rod.stable is None
    judged = assess(rod)
    assert judged.stable is True
    assert le.Equilibrium.from_dict(judged.to_dict()).index == 0
    assert assess(judged) is judged
    straight = le.solve(le.Clamping.from_parameters([0, 0, 1, 2.0, 0, 0]))
    assert assess(straight).stable
