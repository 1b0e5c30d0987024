import numpy as np
import pytest
from draws import closed_ring
from scipy.spatial.transform import Rotation

import loopelastica as le
from loopelastica.rod._same import SAME, mark, same
from loopelastica.rod.kernels.records import Status

FIGURE_6 = le.Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])
ON_ONE_LINE = le.Clamping([0, 0, 0.5], np.eye(3))


def changed(rod, **values):
    return le.Equilibrium.from_dict({**rod.to_dict(), **values})


def about_the_line(rod, angle):
    """A rod between ends on one line, turned about it with its frames turned back."""
    turn = Rotation.from_rotvec([0, 0, angle]).as_matrix()
    loads = np.concatenate([turn @ rod.loads[:3], turn @ rod.loads[3:]])
    return le.Equilibrium(
        rod.clamping, rod.torsion_ratio, loads, rod.energy, rod.residual, Status.CONVERGED
    )


def test_an_equilibrium_is_the_same_as_its_copy():
    rods = le.equilibria(FIGURE_6, energy_max=50)
    for i, rod in enumerate(rods):
        assert [same(rod, changed(other, index=None)) for other in rods] == [
            i == k for k in range(len(rods))
        ]


def test_what_did_not_converge_is_the_same_as_nothing():
    rod = le.solve(FIGURE_6)
    failed = changed(rod, status=int(Status.STALLED))
    assert not same(rod, failed)
    assert not same(failed, failed)


def test_rods_turned_about_the_line_of_both_ends_are_one_family():
    rod = le.solve(ON_ONE_LINE)
    for angle in (0.3, 2.0, -1.1):
        other = about_the_line(rod, angle)
        assert np.abs(other.loads - rod.loads).max() > 1.0
        assert np.abs(mark(rod) - mark(other)).max() < SAME
        assert same(rod, other)


def test_mirror_images_on_one_line_are_two_families():
    low = [rod for rod in le.equilibria(ON_ONE_LINE) if rod.energy < 30]
    one, other = (rod for rod in low if rod.energy > 25)
    assert one.energy == pytest.approx(other.energy, abs=1e-6)
    assert not same(one, other)


def test_rings_with_other_twist_are_other_families():
    assert same(closed_ring(1), closed_ring(1))
    assert not same(closed_ring(1), closed_ring(1, twist=1.0))
    assert not same(closed_ring(1, twist=1.0), closed_ring(1, twist=-1.0))
