"""Continuation in an end angle (Fig. 6)."""

import math

import numpy as np
import pytest
from paper_rods import FIG_6, FIG_6_FIRST, FIG_6_SECOND, end, matrix, pose, rod

from loopelastica.rod.clamping import Clamping
from loopelastica.rod.paper import continue_angle
from loopelastica.rod.paper import errors as kernels
from loopelastica.rod.paper import newton as paper_newton
from loopelastica.rod.parameters import PhysicalParameters

# the printed method is compiled for its tests alone
pytestmark = pytest.mark.slow


def newton_from(printed, clamping, torsion_ratio=1.0):
    """Algorithm 1 from the six printed physical parameters."""
    f, target = PhysicalParameters(*printed).loads(torsion_ratio), pose(clamping)
    status, _ = paper_newton.newton(f, target, kernels.EPS3, torsion_ratio, 0, 1e-10, False)
    assert status == paper_newton.CONVERGED
    return f


def test_figure_6_both_solutions_and_the_way_between_them():
    from loopelastica.rod.writhe import net_winding

    first = newton_from((-0.3, -0.2, -0.7, 3.4, 0.5, 4.8), FIG_6)
    second = newton_from((1.1, 1.5, 3.1, 0.64, 1.8, 3.3), FIG_6)
    assert rod(PhysicalParameters.from_loads(first)) == pytest.approx(FIG_6_FIRST, abs=6e-5)
    assert rod(PhysicalParameters.from_loads(second)) == pytest.approx(FIG_6_SECOND, abs=6e-5)

    branch = continue_angle(first, FIG_6, which="phi", turns=1.0)
    assert branch.converged
    assert branch.angles[-1] - branch.angles[0] == pytest.approx(math.tau, abs=1e-14)
    assert branch.loads[-1] == pytest.approx(second, abs=1e-6)
    windings = []
    for f in (branch.loads[0], branch.loads[-1]):
        p = PhysicalParameters.from_loads(f)
        windings.append(net_winding(p.centerline(300), p.frames(300), turns=f[5] / math.tau))
    assert [round(w, 1) for w in windings] == [0.1, 1.1]
    assert windings[1] - windings[0] == pytest.approx(1, abs=1e-8)
    # and back again
    home = continue_angle(branch.loads[-1], FIG_6, which="phi", turns=-1.0)
    assert home.loads[-1] == pytest.approx(branch.loads[0], abs=1e-6)


def test_continuation_adapts_its_step_and_says_where_a_branch_ends():
    first = newton_from((-0.3, -0.2, -0.7, 3.4, 0.5, 4.8), FIG_6)
    branch = continue_angle(first, FIG_6, which="theta", turns=-2.0)
    steps = np.abs(np.diff(branch.angles))
    assert steps.min() < 0.5 * steps.max()
    if not branch.converged:
        assert abs(branch.angles[-1] - branch.angles[0]) < 2 * math.tau
    for f, angle in zip(branch.loads[::9], branch.angles[::9], strict=True):
        q = FIG_6.parameters
        q[4] = angle
        assert matrix(end(f)) == pytest.approx(Clamping.from_parameters(q).rotation, abs=1e-7)


def test_continuation_names_bad_arguments():
    with pytest.raises(ValueError, match="`which`"):
        continue_angle(np.ones(6), FIG_6, which="chi")
    with pytest.raises(ValueError, match="`error`"):
        continue_angle(np.ones(6), FIG_6, error="eps0")
    with pytest.raises(ValueError, match="`loads`"):
        continue_angle(np.ones(5), FIG_6)
