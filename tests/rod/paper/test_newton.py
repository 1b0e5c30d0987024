"""Algorithms 1 and 2."""

import numpy as np
import pytest
from paper_rods import end, pose

from loopelastica.rod.clamping import Clamping
from loopelastica.rod.paper import ERRORS, FORWARD
from loopelastica.rod.paper import errors as kernels
from loopelastica.rod.paper import newton as paper_newton
from loopelastica.rod.parameters import PhysicalParameters

# the printed method is compiled for its tests alone
pytestmark = pytest.mark.slow


def test_the_line_search_stops_at_the_first_step_with_armijos_decrease():
    """Along a step that overshoots, j is the least exponent that passes line 7."""
    f = PhysicalParameters(0.5, 0.3, 1.0, 0.0, 0.4, 2.5).loads()
    target = end(1.15 * f)
    y, e = np.empty(7), np.empty(6)
    j, a, d = np.empty((6, 6)), np.empty((6, 7)), np.empty(6)
    kind = ERRORS["eps3"]
    paper_newton.error_at(f, target, kind, 1.0, 0, y, e)
    paper_newton.central_jacobian(f, target, kind, 1.0, 0, y, j)
    assert paper_newton.newton_step(j, e, a, d)
    assert d == pytest.approx(-np.linalg.solve(j, e))
    cost, trial = 0.5 * e @ e, np.empty(6)

    def exponent():
        """The least j that passes."""
        for k in range(51):
            kernels.error(kind, end(f + 0.45**k * d), target, trial)
            if 0.5 * trial @ trial - cost < 1e-4 * 0.45**k * decrease:
                return k
        return None

    decrease = (j.T @ e) @ d
    while not (passed := exponent()):  # until it is far too long, in the right direction
        d *= 2.0
        decrease *= 2.0
    moved = f.copy()
    assert paper_newton.line_search(
        moved, d, decrease, cost, target, kind, 1.0, 0, y, np.empty(6), e
    )
    assert moved == pytest.approx(f + 0.45**passed * d, rel=1e-14)
    # uphill no step passes, and the loads stay
    stay = f.copy()
    assert not paper_newton.line_search(
        stay, -d, decrease, cost, target, kind, 1.0, 0, y, np.empty(6), e
    )
    assert np.array_equal(stay, f)


def test_a_hopeless_target_is_given_up_after_nine_restarts():
    target = pose(Clamping.from_parameters([1.2, 0, 0.4, 1, 1.2, 2]))  # longer than the rod
    guess = np.array([0.5, 0.3, 1.0, 0.4, 2.5])
    status, iterations, restarts, ridders = paper_newton.invert(
        guess, target, 2, 1.0, FORWARD["analytic"], 1e-7, 9, np.empty(6)
    )
    assert status != paper_newton.CONVERGED
    assert restarts == 9
    assert ridders == 10
    assert iterations <= 20 * 41


def test_guesses_enter_newton_with_eta_2_zero(rng):
    for _ in range(20):
        p = np.array([*rng.uniform(-2, 2, 2), 4.5, rng.uniform(0, 3), rng.uniform(0.2, 4)])
        f = np.empty(6)
        paper_newton.reduced_loads(p, p[3], 0.7, f)
        y = end(f, 0.7)
        assert y[1] == pytest.approx(0, abs=1e-10)
        assert y[0] >= 0
        back = PhysicalParameters.from_loads(f, 0.7)
        assert [back.lam, back.t_p, back.a, back.length] == pytest.approx(p[[0, 1, 2, 4]])
