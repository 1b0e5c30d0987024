"""Single strands of systems, made by hand and at random."""

import numpy as np
import pytest

from loopelastica.nanostructures.singles import single_strands
from loopelastica.nanostructures.system import System


def system(strands, pairs, circular=(), order=None):
    """Strands of so many nucleotides from 5' to 3', pairs of them, and an order in the file."""
    n = sum(strands)
    n3, pair = np.full(n, -1), np.full(n, -1)
    strand = np.repeat(np.arange(len(strands)), strands)
    end = np.cumsum(strands)
    for i, (first, last) in enumerate(zip(end - strands, end - 1, strict=True)):
        n3[first:last] = np.arange(first + 1, last + 1)
        if i in circular:
            n3[last] = first
    for one, other in pairs:
        pair[one], pair[other] = other, one
    order = np.arange(n) if order is None else np.asarray(order)
    place = np.append(np.argsort(order), -1)
    n3, pair, strand = place[n3[order]], place[pair[order]], strand[order]
    n5 = np.full(n, -1)
    n5[n3[n3 >= 0]] = np.flatnonzero(n3 >= 0)
    zeros = np.zeros((n, 3))
    return System(
        name="made",
        base=np.full(n, "T"),
        strand=strand,
        n3=n3,
        n5=n5,
        pair=pair,
        placed=pair >= 0,
        centre=zeros,
        a1=zeros.copy(),
        a3=zeros.copy(),
        label=tuple(f"nucleotide {i}" for i in range(n)),
        strand_name=tuple(f"strand {i}" for i in range(len(strands))),
        colour=("",) * len(strands),
        rna=np.zeros(len(strands), dtype=bool),
        box=np.zeros(3),
    )


def summary(made):
    return [(str(s.kind), s.nucleotides.tolist(), s.before, s.after) for s in single_strands(made)]


@pytest.mark.parametrize(
    ("made", "expected"),
    [
        (system([8], [(0, 7), (1, 6)]), [("hairpin", [2, 3, 4, 5], 1, 6)]),
        (system([5, 2], [(0, 6), (4, 5)]), [("linker", [1, 2, 3], 0, 4)]),
        # a bulge: beside it the helix goes on
        (system([3, 2], [(0, 4), (2, 3)]), [("linker", [1], 0, 2)]),
        (system([4, 2], [(2, 5), (3, 4)]), [("tail 5'", [0, 1], -1, 2)]),
        (system([4, 2], [(0, 5), (1, 4)]), [("tail 3'", [2, 3], 1, -1)]),
        (system([3], []), [("free strand", [0, 1, 2], -1, -1)]),
        (system([4], [], circular=[0]), [("circle", [0, 1, 2, 3], -1, -1)]),
        # a circle with a pair: the run goes through the seam
        (system([5, 1], [(2, 5)], circular=[0]), [("linker", [3, 4, 0, 1], 2, 2)]),
        (system([2, 2], [(0, 3), (1, 2)]), []),
    ],
)
def test_each_kind_is_found_with_its_neighbours(made, expected):
    assert summary(made) == expected


def test_two_tails_and_a_hairpin_come_in_the_order_of_the_file():
    made = system([10], [(2, 7), (3, 6)])
    assert [one[0] for one in summary(made)] == ["tail 5'", "hairpin", "tail 3'"]


def test_a_strand_listed_from_3_to_5_is_read_from_5_to_3():
    made = system([8], [(0, 7), (1, 6)], order=range(7, -1, -1))
    assert summary(made) == [("hairpin", [5, 4, 3, 2], 6, 1)]


def test_every_nucleotide_without_a_partner_is_in_one_single_strand(rng):
    for _ in range(50):
        strands = rng.integers(1, 30, 6)
        n = int(strands.sum())
        chosen = rng.permutation(n)[: 2 * int(rng.integers(0, n // 2 + 1))]
        made = system(
            strands, chosen.reshape(-1, 2), np.flatnonzero(rng.random(6) < 0.3), rng.permutation(n)
        )
        singles = single_strands(made)
        met = np.concatenate([s.nucleotides for s in singles] or [np.array([], dtype=int)])
        assert sorted(met.tolist()) == np.flatnonzero(made.pair < 0).tolist()
        for one in singles:
            np.testing.assert_array_equal(made.n3[one.nucleotides[:-1]], one.nucleotides[1:])
            if one.kind == "circle":
                assert made.n3[one.nucleotides[-1]] == one.nucleotides[0]
                continue
            assert made.n5[one.nucleotides[0]] == one.before
            assert made.n3[one.nucleotides[-1]] == one.after
            assert all(end < 0 or made.pair[end] >= 0 for end in (one.before, one.after))
