"""Candidates in the molecule: where along the chain the ranked line lies."""

import dataclasses

import numpy as np
import pytest

import loopelastica as le
from loopelastica.folding.clamping import clamping_of
from loopelastica.folding.hypotheses import Hypothesis, straight_rods
from loopelastica.folding.rank import rank
from loopelastica.molecule.clamp_rule import StemClamp
from loopelastica.molecule.contacts import Contacts
from loopelastica.molecule.ends import stem_ends
from loopelastica.molecule.hairpins import find_hairpins


@pytest.mark.parametrize(("phase", "seen"), [(0.6, False), (0.4, True), (0.5, True)])
@pytest.mark.parametrize("extend_5", [0, 1])
def test_the_line_begins_half_a_nucleotide_beyond_the_stem(koc, phase, seen, extend_5):
    """An atom on the line's first point counts where it is two nucleotides or more away."""
    (hairpin,) = find_hairpins(koc)
    clamp = StemClamp(extend_5, 0, 0.0, 7.0)
    ends = stem_ends(koc.nucleotides, hairpin, koc.positions(0), clamp)
    rod = le.solve(clamping_of(ends, free_spin=True))
    atom = ends.start_origin_A[None], np.array([extend_5 + phase - 2.0])
    (candidate,) = rank(straight_rods(hairpin, [rod], ends), 10.0, atom, None)
    assert (candidate.contacts.stem_A < 1e-9) == seen
    last = ends.end_origin_A[None], np.array([len(hairpin) + 0.5 + 2.0 + 0.5 - phase])
    (candidate,) = rank(straight_rods(hairpin, [rod], ends), 10.0, last, None)
    assert (candidate.contacts.stem_A < 1e-6) == seen


@pytest.mark.parametrize(("away", "seen"), [(1.9, False), (2.0, True)])
def test_nucleotides_that_continue_the_stem_lie_at_whole_places_of_the_chain(koc, away, seen):
    (hairpin,) = find_hairpins(koc)
    ends = stem_ends(koc.nucleotides, hairpin, koc.positions(0), StemClamp(1, 1, 0.0, 9.0))
    rod = le.solve(clamping_of(ends, free_spin=True))
    first = ends.continued_5_A[:1], np.array([1.0 - away])
    last = ends.continued_3_A[:1], np.array([4.0 + away])
    for atom in (first, last):
        (candidate,) = rank(straight_rods(hairpin, [rod], ends), 10.0, atom, None)
        assert (candidate.contacts.stem_A < 1e-9) == seen


@pytest.fixture(scope="module")
def answers(fold):
    """Three rods of one place and one of a place before them that costs more."""
    rods = straight_rods(fold.hairpin, [c.rod for c in fold.candidates], fold.ends)
    dear = dataclasses.replace(rods[1], shape="dear", place=-1)
    cheap = dataclasses.replace(rods[0], shape="cheap", place=500)
    return [*rods[::-1], dear, cheap]


NOWHERE = np.full((1, 3), 1e4), np.array([-9.0])


def places(candidates, name):
    return [getattr(c, name) for c in candidates]


def untouched(monkeypatch):
    """Nothing touches anything."""
    monkeypatch.setattr("loopelastica.folding.rank.contacts", lambda *_: Contacts(9.0, 9.0))


def test_the_default_order_is_that_of_the_places_then_of_the_energy(answers, monkeypatch):
    untouched(monkeypatch)
    ranked = rank(answers, 10.0, NOWHERE, None)
    assert places(ranked, "rank") == [1, 2, 3, 4, 5]
    assert places(ranked, "shape") == ["dear", *["straight rod"] * 3, "cheap"]
    energies = places(ranked[1:4], "energy_per_A")
    assert energies == sorted(energies)


def test_by_energy_all_are_in_one_row_whatever_they_are(answers, monkeypatch):
    untouched(monkeypatch)
    ranked = rank(answers, 10.0, NOWHERE, None, "energy")
    energies = places(ranked, "energy_per_A")
    assert energies == sorted(energies)
    assert places(ranked, "rank") == places(ranked, "rank_energy") == [1, 2, 3, 4, 5]


def test_both_orders_are_known_to_each_candidate(answers, monkeypatch):
    untouched(monkeypatch)
    by_place, by_energy = (rank(answers, 10.0, NOWHERE, None, o) for o in ("default", "energy"))
    for one in by_place:
        other = by_energy[one.rank_energy - 1]
        assert (one.shape, one.energy_per_A) == (other.shape, other.energy_per_A)


@pytest.mark.parametrize("order", ["default", "energy"])
def test_what_touches_comes_last_in_both_orders(answers, order):
    ranked = rank(answers, 10.0, NOWHERE, None, order)
    touching = [c.contacts.touching for c in ranked]
    assert any(touching)
    assert touching == sorted(touching)
    assert ranked[-1].shape != "cheap"


def test_energies_of_chains_are_per_length_of_their_steps(chains):
    first = chains.candidates[0]
    assert first.length_A == pytest.approx(np.linalg.norm(first.line.shape.steps_A, axis=1).sum())
    assert first.energy_per_A == pytest.approx(first.line.energy / first.length_A)
    assert first.energy_kT == pytest.approx(10.0 * first.energy_per_A)


def test_candidates_are_cut_off_in_the_order_asked_for(koc, of_chains, monkeypatch):
    monkeypatch.setattr("loopelastica.folding.fold.hypotheses", of_chains)
    for order in ("default", "energy"):
        (all_of_them,) = le.fold(koc, all_models=False, rank=order)
        (two,) = le.fold(koc, all_models=False, rank=order, max_candidates=2)
        for one, other in zip(two.candidates, all_of_them.candidates[:2], strict=True):
            assert (one.shape, one.rank, one.rank_energy) == (
                other.shape, other.rank, other.rank_energy,
            )  # fmt: skip


def test_models_are_compared_by_rank_whatever_line_that_is(koc, of_chains, monkeypatch):
    monkeypatch.setattr("loopelastica.folding.fold.hypotheses", of_chains)
    (loop,) = le.fold(koc)
    first = loop.candidates[0]
    assert first.shape == "like 2koc A.5-A.10"
    assert first.rmsd_models_A.shape == (20,)
    # the shape is the eighth model's own
    assert first.rmsd_models_A[7] < 0.2
    assert np.argmin(first.rmsd_models_A) == 7


def test_of_what_touches_only_rods_lose_their_place(chains, monkeypatch):
    monkeypatch.setattr("loopelastica.folding.rank.contacts", lambda *_: Contacts(1.0, 9.0))
    chain, _, rod = chains.candidates[:3]
    answers = [
        Hypothesis(c.line, c.shape, c.expected_rmsd_A, place)
        for place, c in enumerate((rod, chain))
    ]
    assert places(rank(answers, 10.0, NOWHERE, None), "shape") == [chain.shape, rod.shape]
