import json

import numpy as np
import pytest
from draws import load_drawn

import loopelastica as le


def test_an_equilibrium_survives_json_and_takes_points_or_arc_lengths(rng):
    position, rotation = (a[0] for a in load_drawn(rng, 1))
    rod = le.solve(le.Clamping(position, rotation), 0.7)
    again = le.Equilibrium.from_dict(json.loads(json.dumps(rod.to_dict())))
    np.testing.assert_array_equal(again.centerline(11), rod.centerline(11))
    s = np.array([0.7, 0.1, 1.0])
    np.testing.assert_allclose(rod.centerline(s)[[1, 0, 2]], rod.centerline(np.sort(s)))
    assert rod.curvature(11).shape == (11,)
    for wrong in (0, [[0.5]], [1.5], [np.nan]):
        with pytest.raises(ValueError, match="`n`"):
            rod.centerline(wrong)


def test_physical_parameters_and_net_winding_of_a_solution(rng):
    for position, rotation in zip(*load_drawn(rng, 5, 0.7), strict=True):
        rod = le.solve(le.Clamping(position, rotation), 0.7)
        closed_form = rod.physical.clamping(0.7)
        np.testing.assert_allclose(closed_form.position, position, atol=1e-8)
        np.testing.assert_allclose(closed_form.rotation, rotation, atol=1e-8)
        # all equilibria of one clamping have net windings an integer apart
        others = le.equilibria(rod.clamping, 0.7)
        apart = np.array([r.net_winding - rod.net_winding for r in others])
        np.testing.assert_allclose(apart, np.round(apart), atol=1e-8)
        assert rod.writhe + rod.twist == pytest.approx(rod.net_winding)
    circle = le.solve(le.Clamping.from_parameters([0, 0, 1, 0.5, 0, 0]))
    assert circle.physical is None
