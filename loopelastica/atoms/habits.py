"""How often nucleotides of loops are C2'-endo, and syn: what a score of their shapes begins with.

    ln p/(1 − p) = Σ of what holds: all, DNA; of RNA first, second, last but one, last, a loop of
    three, a loop of four, A, G, U, G that is last

The terms are fitted to loops of the databank, each sequence counted once
(``loopelastica studies motifs``; ``data/motifs.json``), and say little: families that had no part
in the fit are described better than by the mean, but the likelier pucker is almost always the
commoner one. Of DNA there are too few loops to tell places apart. Loops of a motif are as its
loops are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from loopelastica._arrays import Array, Record
from loopelastica.atoms.states import States
from loopelastica.folding.motifs import Motif, habit_terms

TERMS: Final = ("all", "DNA", "first", "second", "last but one", "last", "three", "four", "A", "G",
                "U", "G last")  # fmt: skip
LEAST: Final = 0.02
"""No state is rarer: a table of some hundred loops cannot say so."""


@dataclass(frozen=True, slots=True, eq=False)
class Habits(Record):
    """Shares of C2'-endo and of syn.

    Attributes
    ----------
    c2_endo, syn : (n,) array
        Of each nucleotide of a strand, 0 to 1.
    """

    c2_endo: Array
    syn: Array

    def costs(self, k: int, states: States) -> Array:
        """Minus the logarithm of how frequent each state (s,) of nucleotide k is."""
        c2_endo, syn = (np.clip(p[k], LEAST, 1.0 - LEAST) for p in (self.c2_endo, self.syn))
        share = np.where(states.c2_endo, c2_endo, 1.0 - c2_endo)
        share *= np.where(states.syn, syn, 1.0 - syn)
        return np.asarray(-np.log(share))


def usual(letters: Sequence[str], is_dna: Sequence[bool]) -> Habits:
    """What is usual of a sequence.

    Parameters
    ----------
    letters, is_dna : sequence
        Parent base and sugar of each nucleotide of a strand, 5' to 3'.

    Returns
    -------
    Habits

    Examples
    --------
    >>> habits = usual("UUCG", [False] * 4)
    >>> habits.c2_endo.round(2), habits.syn.round(2)
    (array([0.19, 0.34, 0.35, 0.33]), array([0.05, 0.08, 0.08, 0.28]))
    """
    found = holds(letters, is_dna)
    c2_endo, syn = (1.0 / (1.0 + np.exp(-found @ terms)) for terms in habit_terms())
    return Habits(c2_endo, syn)


def holds(letters: Sequence[str], is_dna: Sequence[bool]) -> Array:
    """Which of the terms hold (n, 12) of each nucleotide of a strand; 1 or 0."""
    n = len(letters)
    rows = [
        (1, 1, *(False,) * 10) if dna else
        (1, 0, k == 0, k == 1, k == n - 2, k == n - 1, n == 3, n == 4,
         letter == "A", letter == "G", letter in "UT", letter == "G" and k == n - 1)
        for k, (letter, dna) in enumerate(zip(letters, is_dna, strict=True))
    ]  # fmt: skip
    return np.array(rows, dtype=np.float64).reshape(n, len(TERMS))


def of_motif(motif: Motif) -> Habits:
    """What is usual of the loops of a motif."""
    return Habits(motif.c2_endo, motif.syn)
