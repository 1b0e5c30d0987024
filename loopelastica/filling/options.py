"""Options of :func:`loopelastica.fill`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from loopelastica._checks import file_name, flag, optional, positive, whole
from loopelastica.folding.options import Options, option
from loopelastica.molecule.reading import MAX_ATOMS, MAX_SIZE_MB, Limits
from loopelastica.molecule.requests import requests
from loopelastica.molecule.selection import likeness


def _strands(argument: str, value: Any) -> tuple[str, ...] | None:
    """Strands as they are written, each of them understood."""
    return None if value is None else tuple(request.text for request in requests(value))


@dataclass(frozen=True, slots=True, kw_only=True)
class FillOptions(Options):
    """What is filled, and how often.

    Attributes
    ----------
    strands : str or list of str, optional
        Strands by their first and last nucleotide, "A.6-9", with their sequence where the file has
        none or another one is wanted, "A.6-9=UUCG". One that is there is built anew. Default: all
        internal gaps, with the file's sequence of record.
    repair : bool
        Build anew what is broken: bonds over 2 Å in the chain, wrong hands, clashes inside a
        strand. Otherwise no existing atom moves.
    hydrogens : bool
        Add hydrogens, by their wwPDB names: to what is built, completed or repaired where the
        file's other nucleotides have hydrogens, to every nucleotide where they have none.
    no_5_phosphate : bool
        Take off phosphates at 5' ends of chains, which force fields refuse.
    candidates : int
        Most models of each strand, 1 or more; the first is the one that is expected to be nearest.
    like : str, optional
        A strand of another structure that these are like, by the nucleotides before and after it,
        "FILE:A.4-A.9"; or "FILE", any strand of it with the same letters, else its hairpin loops.
        Those of equal length are deformed onto the ends and lend their sugars and bases.
    library : str, optional
        File of a library of loops, or a folder of structures to take them from. Its shapes are
        candidates too where the ends of a strand are like those of a hairpin loop: their mean, by
        the error to expect before or after the first rod, and single ones. Default: none.
    max_size_MB, max_atoms : float, int
        How large a file may be: megabytes after decompression, atoms of a model.
    """

    strands: str | Sequence[str] | None = option(None, _strands)
    repair: bool = option(False, flag)
    hydrogens: bool = option(False, flag)
    no_5_phosphate: bool = option(False, flag)
    candidates: int = option(1, whole(1))
    like: str | None = option(None, optional(likeness))
    library: str | None = option(None, optional(file_name))
    max_size_MB: float = option(MAX_SIZE_MB, positive)
    max_atoms: int = option(MAX_ATOMS, whole(1))

    @property
    def limits(self) -> Limits:
        """How large a file may be."""
        return Limits(self.max_size_MB, self.max_atoms)
