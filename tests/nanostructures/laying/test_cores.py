"""Lines through helices."""

from dataclasses import replace

import numpy as np
from chained import line

from loopelastica.nanostructures.laying.cores import Cores
from loopelastica.nanostructures.laying.volume import clear


def through(chains, box=0.0, shift=0.0):
    """The line and a helix that it goes through, a little beside its axis."""
    heights = 0.39 * np.arange(-20, 21)
    middle = chains.sites.mean(axis=0)
    cores = middle + np.stack([np.full(41, 0.2), heights, np.full(41, 0.1)], axis=1)
    moved = replace(chains, cores=cores, box=np.full(3, box))
    moved.sites[:] += shift
    return moved


def distance(chains, shift=0.0):
    apart = chains.sites - shift - (chains.cores[20])
    return np.linalg.norm(apart[:, [0, 2]], axis=1)


def slack(n=14):
    """A line whose ends are nearer to each other than its bonds are long."""
    chains = line(n, gap=0.6)
    chains.bond[:] = 0.7564
    return chains


def test_a_line_that_goes_through_a_helix_comes_out_of_it():
    chains = through(slack())
    assert distance(chains).min() < 0.3
    ends = chains.sites[[0, -1]].copy()
    clear(chains, np.array([0]), move=True, repulsion=Cores)
    assert distance(chains).min() > 1.0
    np.testing.assert_array_equal(chains.sites[[0, -1]], ends)


def test_a_line_comes_out_of_the_image_of_a_helix_in_a_periodic_box():
    free, boxed = through(slack()), through(slack(), box=40.0, shift=40.0)
    for chains in (free, boxed):
        clear(chains, np.array([0]), move=True, repulsion=Cores)
    np.testing.assert_allclose(boxed.sites - 40.0, free.sites, atol=1e-6)


def test_what_is_outside_of_helices_is_not_pushed():
    chains = slack()
    chains = replace(chains, cores=np.array([[1.4, 0.0, 3.0]]))
    force = np.zeros((2, 12, 3))
    found = Cores(chains, np.arange(1, 13))
    found.push(force)
    assert not force.any()
    assert not found.stiffness().any()
