"""The Jacobians of the error."""

import numpy as np
import pytest
from draws import loads as random_loads
from paper_rods import end, pose

from loopelastica.rod.clamping import Clamping
from loopelastica.rod.paper import ERRORS, FORWARD
from loopelastica.rod.paper import errors as kernels
from loopelastica.rod.paper import newton as paper_newton

# the printed method is compiled for its tests alone
pytestmark = pytest.mark.slow


@pytest.mark.parametrize("error", ["eps2", "eps3"])
def test_both_jacobians_are_that_of_the_error(rng, error):
    f = random_loads(rng, 1, force=20, moment=6)[0]
    target, y = pose(Clamping.from_parameters([0.3, 0, 0.4, 1, 1.2, 2])), np.empty(7)
    central, fine = np.empty((6, 6)), np.empty((6, 6))
    args = (f, target, ERRORS[error], 1.0, FORWARD["numerical"], y)
    assert paper_newton.central_jacobian(*args, central)
    assert paper_newton.ridders_jacobian(*args, fine)
    # an independent difference of fourth order
    h, exact = 1e-3, np.empty((6, 6))
    for c in range(6):
        values = {}
        for k in (-2, -1, 1, 2):
            moved, e = f.copy(), np.empty(6)
            moved[c] += k * h
            kernels.error(ERRORS[error], end(moved, forward="numerical"), target, e)
            values[k] = e
        exact[:, c] = (8 * (values[1] - values[-1]) - values[2] + values[-2]) / (12 * h)
    assert fine == pytest.approx(exact, abs=1e-7)
    assert central == pytest.approx(exact, abs=1e-5)
