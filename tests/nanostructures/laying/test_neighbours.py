"""Soft repulsion against a sum over all pairs."""

import numpy as np
import pytest
from chained import crowd

from loopelastica.nanostructures.laying.bases import MIDDLE, REACH
from loopelastica.nanostructures.laying.neighbours import Neighbours


def energy(chains):
    """Of the repulsion of the first ten, pair by pair, and where it comes from."""
    shares = (0.0, REACH, MIDDLE * REACH)
    reaches = {(0, 0): 0.74, (0, 1): 0.55, (1, 0): 0.55, (1, 1): 0.37, (2, 2): 0.65}
    total = 0.0
    for i in range(10):
        for j in range(len(chains.sites)):
            if j == i or (j < 10 and j < i):
                continue
            bonded = chains.n3[i] == j or chains.n5[i] == j
            for (a, b), reach in reaches.items():
                if bonded and a == b and a != 1:
                    continue
                apart = (
                    chains.sites[i] + shares[a] * chains.direction[i]
                    - chains.sites[j] - shares[b] * chains.direction[j]
                )  # fmt: skip
                if chains.box[0]:
                    apart = apart - chains.box * np.round(apart / chains.box)
                total += 30.0 * max(reach - np.linalg.norm(apart), 0.0) ** 2
    return total


@pytest.mark.parametrize("box", [0.0, 2.6])
def test_the_repulsion_is_the_slope_of_an_energy_of_all_pairs(rng, box):
    chains = crowd(rng, box=box)
    rows = np.arange(10)
    force = np.zeros((2, 10, 3))
    Neighbours(chains, rows).push(force)
    assert np.abs(force).max() > 1
    eps = 1e-6
    for kind, values in enumerate((chains.sites, chains.direction)):
        for i in (0, 4, 9):
            for k in range(3):
                slope = 0.0
                for sign in (1, -1):
                    values[i, k] += sign * eps
                    slope += sign * energy(chains) / (2 * eps)
                    values[i, k] -= sign * eps
                assert force[kind, i, k] == pytest.approx(-slope, abs=1e-4)


def test_the_repulsion_is_stiff_along_lines_between_sites_only():
    chains = crowd(np.random.default_rng(0), n=2, side=0.0)
    chains.sites[1] = [0.7, 0.0, 0.0]
    chains.direction[:] = [[-1.0, 0, 0], [1, 0, 0]]
    chains.n3[:], chains.n5[:] = -1, -1
    found = Neighbours(chains, np.array([0]))
    found.push(np.zeros((2, 1, 3)))
    np.testing.assert_allclose(found.stiffness()[0, 0], np.diag([60.0, 0, 0]), atol=1e-12)
    assert not found.stiffness()[1].any()
    # twice as much where both move
    both = Neighbours(chains, np.array([0, 1]))
    both.push(np.zeros((2, 2, 3)))
    np.testing.assert_allclose(both.stiffness()[0, 1], np.diag([120.0, 0, 0]), atol=1e-12)
