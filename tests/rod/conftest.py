import sys
from pathlib import Path

import numpy as np
import pytest

from loopelastica.rod._starts import problem_of
from loopelastica.rod.kernels import records
from loopelastica.rod.kernels.discrete_rod import DiscreteRod

# the random rods that several tests draw
sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture(scope="session")
def problem():
    """From a clamping and a torsion ratio to a problem as kernels take it."""
    return problem_of


@pytest.fixture(scope="session")
def start():
    """From the fields of a start to its record."""

    def record(*values, **named):
        return records.starts_array((records.Start(*values, **named),))[0]

    return record


@pytest.fixture(scope="session")
def room():
    """Room for a solution; `room()`."""

    def new():
        nodes = records.Nodes(np.empty(records.SEGMENTS + 1), np.empty((records.SEGMENTS + 1, 7)))
        return records.Solution(np.zeros(6), nodes, np.zeros(1, records.LAYERS))

    return new


@pytest.fixture(scope="session")
def discrete_rod():
    """Room for a discrete rod of n segments, its hinges equally far apart."""

    def new(n):
        return DiscreteRod(np.linspace(0.0, 1.0, n + 1), np.zeros((n + 2, 4)))

    return new
