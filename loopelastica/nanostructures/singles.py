"""The single strands of a nanostructure: maximal runs of nucleotides without a partner."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Record
from loopelastica.nanostructures.system import System


class SingleKind(StrEnum):
    """What a single strand lies between."""

    HAIRPIN = "hairpin"
    """Two nucleotides that are partners of each other."""
    LINKER = "linker"
    """Two paired nucleotides, not of each other; of one helix or of two."""
    TAIL_5 = "tail 5'"
    """The 5' end of its strand and a paired nucleotide."""
    TAIL_3 = "tail 3'"
    """A paired nucleotide and the 3' end of its strand."""
    FREE = "free strand"
    """Both ends of a strand that is paired nowhere."""
    CIRCLE = "circle"
    """Nothing: a circular strand that is paired nowhere."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Single(Record):
    """A maximal run of nucleotides without a partner.

    Attributes
    ----------
    kind : SingleKind
        A string too: "hairpin", "linker", "tail 5'", "tail 3'", "free strand" or "circle".
    nucleotides : (n,) array of int
        Their indices in the system, from 5' to 3'.
    before, after : int
        The paired nucleotide on the 5' and on the 3' side; −1 where there is none.
    """

    kind: SingleKind
    nucleotides: NDArray[np.int64]
    before: int
    after: int

    def __len__(self) -> int:
        """Return the number of nucleotides."""
        return len(self.nucleotides)

    def __repr__(self) -> str:
        return f"<Single: {self.kind} of {len(self)} between {self.before} and {self.after}>"


def single_strands(system: System) -> tuple[Single, ...]:
    """Find every maximal run of nucleotides without a partner.

    A crossover without nucleotides is a bond and no single strand.

    Parameters
    ----------
    system : System
        From a design or from oxDNA's files.

    Returns
    -------
    tuple of Single
        In the order of their first nucleotides in the system.
    """
    # lists: indexing arrays one by one would take most of the time
    pair, n3, n5 = system.pair.tolist(), system.n3.tolist(), system.n5.tolist()
    single = [partner < 0 for partner in pair]
    # a run begins after a paired nucleotide or a 5' end; what none of these comes to is a circle
    begins = [i for i, own in enumerate(single) if own and (n5[i] < 0 or not single[n5[i]])]
    met = [False] * len(pair)
    found = [_run(i, single, met, n3, n5, pair) for i in begins]
    found += [
        _run(i, single, met, n3, n5, pair) for i, own in enumerate(single) if own and not met[i]
    ]
    return tuple(sorted(found, key=lambda one: int(one.nucleotides[0])))


def _run(
    first: int, single: list[bool], met: list[bool], n3: list[int], n5: list[int], pair: list[int]
) -> Single:
    run, here = [], first
    while here >= 0 and single[here] and not met[here]:
        met[here] = True
        run.append(here)
        here = n3[here]
    circle = here >= 0 and single[here]
    before, after = (-1, -1) if circle else (n5[first], here)
    return Single(_kind(circle, before, after, pair), np.array(run), before, after)


def _kind(circle: bool, before: int, after: int, pair: list[int]) -> SingleKind:
    if circle:
        return SingleKind.CIRCLE
    if before < 0:
        return SingleKind.FREE if after < 0 else SingleKind.TAIL_5
    if after < 0:
        return SingleKind.TAIL_3
    return SingleKind.HAIRPIN if pair[before] == after else SingleKind.LINKER
