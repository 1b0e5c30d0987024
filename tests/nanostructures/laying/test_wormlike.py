"""Worm-like chains against closed forms, a quadrature and another way of drawing."""

import numpy as np
import pytest

from loopelastica.nanostructures.laying.wormlike import free_chain, held_chains, stiffness

UP = np.array([0.0, 0.0, 1.0])


@pytest.mark.parametrize("ratio", [1e-7, 0.01, 0.5, 3.0, 20.0])
def test_hinges_have_the_persistence_length(ratio):
    kappa = stiffness(ratio)
    cosine = 1 - 1 / kappa if kappa > 300 else 1 / np.tanh(kappa) - 1 / kappa
    assert cosine == pytest.approx(np.exp(-ratio), rel=1e-6, abs=1e-8)


def test_free_chains_have_the_correlation_and_the_size_of_closed_form(rng):
    ratio, count, bond = 0.4, 12, 0.7
    kappa = stiffness(ratio)
    chains = np.array([free_chain(np.zeros(3), UP, bond, kappa, count, rng) for _ in range(6000)])
    bonds = np.diff(chains, axis=1, prepend=0.0) / bond
    np.testing.assert_allclose(np.linalg.norm(bonds, axis=2), 1.0, atol=1e-12)
    cosine = np.exp(-ratio)
    for far in (1, 2, 4):
        found = np.einsum("mki,mki->mk", bonds[:, far:], bonds[:, :-far]).mean()
        assert found == pytest.approx(cosine**far, abs=0.01)
    assert bonds[:, 0, 2].mean() == pytest.approx(cosine, abs=0.012)
    size = bond**2 * (
        count * (1 + cosine) / (1 - cosine) - 2 * cosine * (1 - cosine**count) / (1 - cosine) ** 2
    )
    assert (chains[:, -1] ** 2).sum(axis=1).mean() == pytest.approx(size, rel=0.03)


def generators(count, *seed):
    return [np.random.default_rng([*seed, k]) for k in range(count)]


def test_a_held_nucleotide_is_where_a_quadrature_has_it():
    # two bonds and their ends: all that is free is the angle about the line between the ends
    count, kappa = 3000, 2.0
    chain = np.array([[0.0, 0, 0], [0.5, 0, 0.6], [1.0, 0, 0]])
    clamps = np.array([[0.0, 0.6, 0.8], [0.8, 0.6, 0.0]])
    found = held_chains(
        [chain] * count,
        np.tile(clamps, (count, 1, 1)),
        np.full(count, kappa),
        generators(count, 3),
    )
    angle = np.linspace(0, 2 * np.pi, 20001)
    middle = np.stack([0.5 + 0 * angle, 0.6 * np.sin(angle), 0.6 * np.cos(angle)], axis=1)
    size = np.linalg.norm(chain[1])
    energy = (middle @ clamps[0] + (chain[2] - middle) @ clamps[1]) / size
    weight = np.exp(kappa * energy)
    expected = np.trapezoid(weight[:, None] * middle, angle, axis=0) / np.trapezoid(weight, angle)
    np.testing.assert_allclose(np.mean([one[1] for one in found], axis=0), expected, atol=0.02)


def test_crankshafts_leave_the_distribution_of_free_chains_as_it_is(rng):
    # a free chain, held where its end happens to be, with its last bond for a clamp
    ratio, count, chains = 0.5, 6, 2500
    kappa = stiffness(ratio)
    free = np.zeros((chains, count + 1, 3))
    for one in free:
        one[1:] = free_chain(np.zeros(3), UP, 1.0, kappa, count, rng)
    clamps = np.stack([np.tile(UP, (chains, 1)), free[:, -1] - free[:, -2]], axis=1)
    held = np.array(
        held_chains(list(free[:, :-1]), clamps, np.full(chains, kappa), generators(chains, 5))
    )
    assert np.linalg.norm(held - free[:, :-1], axis=2).max() > 1
    steps = np.diff(held, axis=1)
    steps = np.concatenate([clamps[:, :1], steps, clamps[:, 1:]], axis=1)
    cosine = np.einsum("mki,mki->mk", steps[:, 1:], steps[:, :-1])
    np.testing.assert_allclose(cosine.mean(axis=0), np.exp(-ratio), atol=0.03)
    far = np.einsum("mki,mki->mk", steps[:, 2:], steps[:, :-2])
    np.testing.assert_allclose(far.mean(axis=0), np.exp(-2 * ratio), atol=0.04)


def test_held_chains_keep_their_ends_and_their_bonds(rng):
    chains = [np.cumsum(rng.normal(size=(n, 3)), axis=0) for n in (3, 9, 30)]
    clamps = np.tile([UP, UP], (3, 1, 1))
    found = held_chains(chains, clamps, np.full(3, 1.5), generators(3, 1))
    for before, after in zip(chains, found, strict=True):
        np.testing.assert_array_equal(after[[0, -1]], before[[0, -1]])
        lengths = [np.linalg.norm(np.diff(one, axis=0), axis=1) for one in (before, after)]
        np.testing.assert_allclose(*lengths, rtol=1e-9)
        assert np.abs(after - before).max() > 0.1


def test_a_chain_does_not_depend_on_the_others(rng):
    chains = [np.cumsum(rng.normal(size=(n, 3)), axis=0) for n in (12, 5, 20)]
    clamps = np.tile([UP, UP], (3, 1, 1))
    together = held_chains(chains, clamps, np.full(3, 1.5), generators(3, 1))
    alone = held_chains(chains[:1], clamps[:1], np.full(1, 1.5), generators(1, 1))
    np.testing.assert_array_equal(together[0], alone[0])


def test_a_closed_chain_moves():
    angle = 2 * np.pi * np.arange(8) / 7
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    (found,) = held_chains([ring], np.array([[UP, UP]]), np.ones(1), generators(1, 0))
    assert np.isfinite(found).all()
    assert np.abs(found - ring).max() > 0.1


def test_no_chains_are_no_trouble():
    assert held_chains([], np.zeros((0, 2, 3)), np.zeros(0), []) == []
