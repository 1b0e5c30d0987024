"""Where nucleotides stand in the sequence of record."""

from __future__ import annotations

from itertools import pairwise

import gemmi
import numpy as np
import pytest

from loopelastica.molecule.alignment import align, disagreements
from loopelastica.molecule.polymer import Monomer
from loopelastica.molecule.record import Listed


def listed(letters):
    return [Listed((letter,), letter, False) for letter in letters]


def there(letters, numbers):
    return [
        Monomer("A", number, "", letter, letter, False)
        for letter, number in zip(letters, numbers, strict=True)
    ]


def between(numbers):
    return [b - a - 1 for a, b in pairwise(numbers)]


def test_deleted_stretches_are_found_again(rng):
    for _ in range(200):
        n = int(rng.integers(20, 60))
        letters = "".join(rng.choice(list("ACGU"), n))
        kept = sorted(rng.choice(n, size=int(rng.integers(8, n)), replace=False).tolist())
        joined = [b - a == 1 for a, b in pairwise(kept)]
        numbers = [k + 100 for k in kept]
        monomers = there([letters[k] for k in kept], numbers)
        # numbers of their own begin: only their differences count
        found = align(monomers, listed(letters), joined, between(numbers), None)
        assert found is not None
        assert disagreements(monomers, listed(letters), found) == []
        # letters leave no more than a choice of where all of it begins
        assert len({a - b for a, b in zip(found, kept, strict=True)}) == 1


def test_letters_count_more_than_numbers():
    monomers = there("GGACC", [1, 2, 3, 4, 5])
    found = align(monomers, listed("GGAUUUCC"), [True, True, False, True], [0, 0, 0, 0], 0)
    assert found == [0, 1, 2, 6, 7]


def test_bonded_neighbours_stay_together():
    monomers = there("GGUUCC", [1, 2, 3, 4, 5, 6])
    joined = [True, True, True, False, True]
    assert align(monomers, listed("GGUUUUCC"), joined, [0] * 5, 0) == [0, 1, 2, 3, 6, 7]
    joined = [True, False, True, True, True]
    assert align(monomers, listed("GGUUUUCC"), joined, [0] * 5, 0) == [0, 1, 4, 5, 6, 7]


def test_a_record_that_is_too_short():
    assert align(there("GGCC", [1, 2, 3, 4]), listed("GGC"), [True] * 3, [0] * 3, 0) is None


def test_unknown_and_modified_bases_fit_and_others_do_not():
    record = [*listed("GG"), Listed(("5MU",), "U", False), Listed(("A", "G"), "A", False)]
    monomers = there("GNUG", [1, 2, 3, 4])
    found = align(monomers, record, [True] * 3, [0] * 3, 0)
    assert found == [0, 1, 2, 3]
    assert disagreements(monomers, record, found) == []
    assert disagreements(there("GGCC", [1, 2, 3, 4]), record, found) == [2, 3]


@pytest.mark.parametrize("seed", range(5))
def test_as_good_as_the_alignment_of_gemmi(seed):
    # an oracle of another kind, where letters alone decide
    rng = np.random.default_rng(seed)
    letters = "".join(rng.choice(list("ACGU"), 60))
    begin = int(rng.integers(10, 30))
    kept = [*range(begin), *range(begin + 12, 60)]
    result = gemmi.align_string_sequences(
        list(letters), [letters[k] for k in kept], [0] * (len(kept) + 1)
    )
    joined = [b - a == 1 for a, b in pairwise(kept)]
    found = align(there([letters[k] for k in kept], kept), listed(letters), joined, [0] * 47, None)
    assert found is not None
    matches = sum(letters[a] == letters[b] for a, b in zip(found, kept, strict=True))
    assert matches == result.match_count == len(kept)
