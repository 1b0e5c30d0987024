"""Candidates in the molecule: where along the chain the ranked line lies."""

import numpy as np
import pytest

import loopelastica as le
from loopelastica.folding.clamping import clamping_of
from loopelastica.folding.rank import rank
from loopelastica.molecule.clamp_rule import StemClamp
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
    (candidate,) = rank([rod], ends, 10.0, atom, None)
    assert (candidate.contacts.stem_A < 1e-9) == seen
    last = ends.end_origin_A[None], np.array([len(hairpin) + 0.5 + 2.0 + 0.5 - phase])
    (candidate,) = rank([rod], ends, 10.0, last, None)
    assert (candidate.contacts.stem_A < 1e-6) == seen


@pytest.mark.parametrize(("away", "seen"), [(1.9, False), (2.0, True)])
def test_nucleotides_that_continue_the_stem_lie_at_whole_places_of_the_chain(koc, away, seen):
    (hairpin,) = find_hairpins(koc)
    ends = stem_ends(koc.nucleotides, hairpin, koc.positions(0), StemClamp(1, 1, 0.0, 9.0))
    rod = le.solve(clamping_of(ends, free_spin=True))
    first = ends.continued_5_A[:1], np.array([1.0 - away])
    last = ends.continued_3_A[:1], np.array([4.0 + away])
    for atom in (first, last):
        (candidate,) = rank([rod], ends, 10.0, atom, None)
        assert (candidate.contacts.stem_A < 1e-9) == seen
