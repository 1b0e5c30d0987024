"""The independent evaluation of a rod."""

import math

import numpy as np
import pytest

import loopelastica as le
from loopelastica.studies.bench import poses
from loopelastica.studies.bench.judge import independent


@pytest.mark.parametrize("gap", [0.5, 0.05, 1e-4, 1e-6])
def test_the_independent_evaluation_sees_a_wrong_rod(rng, gap):
    position, rotation = (a[0] for a in poses.shell(rng, 1, 1.0 - gap, 1.0 - gap))
    rod = le.solve(le.Clamping(position, rotation), 0.7)
    misfit, energy = independent(rod)
    assert misfit < 1e-9
    assert energy < 1e-8
    values = rod.to_dict()
    values["loads"] = list(np.array(values["loads"]) * (1 + 1e-5))
    values["energy"] *= 1 + 1e-5
    misfit, energy = independent(le.Equilibrium.from_dict(values))
    assert misfit > 1e-8
    assert math.isfinite(energy)
