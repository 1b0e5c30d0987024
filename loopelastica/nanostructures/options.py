"""Options of :func:`loopelastica.nanostructure`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from loopelastica._checks import file_name, one_of, optional, positive, whole
from loopelastica.folding.options import Options, option


@dataclass(frozen=True, slots=True, kw_only=True)
class NanostructureOptions(Options):
    """What is read, and how single strands are laid.

    Attributes
    ----------
    other : str, optional
        Of a pair of oxDNA files the other one; default: beside the first, of the same stem.
    pairs : {"energy", "geometry"}
        Base pairs of oxDNA files: by the energy of hydrogen bonds between complementary bases, or
        by geometry alone, as if all bases fitted, for designs whose sequences do not. Files without
        any complementary bases are taken by geometry in both cases.
    helices : {"drawn", "fitted"}
        Helices of a design: where it draws them, or shifted, rolled and turned so that strands can
        cross between them by bonds of the model.
    tails : {"straight", "relaxed"}
        Single strands with a free end: straight, or rods of least energy in their surroundings.
    sample : int
        Number of worm-like chains to draw, clamped at both ends, beside the rods of least energy.
    seed : int
        Of the samples, and of the bases that a design leaves open.
    persistence_length_nm : float, optional
        Of a single strand; default: that of :mod:`loopelastica.nanostructures.laying.lay`.
    """

    other: str | None = option(None, optional(file_name))
    pairs: str = option("energy", one_of("energy", "geometry"))
    helices: str = option("drawn", one_of("drawn", "fitted"))
    tails: str = option("straight", one_of("straight", "relaxed"))
    sample: int = option(0, whole(0))
    seed: int = option(0, whole(0))
    persistence_length_nm: float | None = option(None, optional(positive))

    @property
    def laying(self) -> dict[str, Any]:
        """Those of them that say how strands are laid, where they are given."""
        names = ("tails", "sample", "seed", "persistence_length_nm")
        given = {name: getattr(self, name) for name in names}
        return {name: value for name, value in given.items() if value is not None}
