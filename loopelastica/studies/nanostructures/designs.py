"""Families of designs with single strands, drawn at random by scadnano.

A design is made by its family, its number and a seed, so that each can be drawn again alone. Even
numbers have scadnano's default geometry, odd ones one in which crossovers between neighbouring
helices are within the window of bonds (``relax_helix_rolls``).
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from loopelastica.studies.nanostructures.sheet import Sheet

Draw = Callable[[Sheet, int], None]

# a base pair of a helix, and a bond of a strand that is not taut
_RISE_NM: Final = 0.332
_BOND_NM: Final = 0.64


@dataclass(frozen=True, slots=True)
class Family:
    """Designs of one kind.

    Attributes
    ----------
    key : str
        Of files of its designs.
    name : str
        What tables call it.
    draw : callable
        Puts so many single strands, or nearly so many, on a sheet.
    strands : int
        Single strands of a design.
    designs : tuple of int
        Designs of the quick study and of the full one.
    """

    key: str
    name: str
    draw: Draw
    strands: int
    designs: tuple[int, int]


def drawn(family: Family, number: int, seed: int, strands: int | None = None) -> Any:
    """A design of a family.

    Parameters
    ----------
    family : Family
    number : int
        Which one, from 0.
    seed : int
        Of the study.
    strands : int, optional
        Single strands; default: those of the family.

    Returns
    -------
    scadnano.Design
        The same for the same arguments.
    """
    sheet = Sheet(np.random.default_rng([seed, number, *family.key.encode()]), number)
    family.draw(sheet, family.strands if strands is None else strands)
    return sheet.design()


def _hairpin(sheet: Sheet, helix: int, loop: int, stem: int, end: int = 0) -> None:
    """A hairpin whose loop is behind the offsets of its stem, or before them."""
    forward, back = (sheet.domain(helix, up, end, end + stem) for up in (True, False))
    sheet.strand(*((forward, loop, back) if end >= 0 else (back, loop, forward)))


def _lone_hairpins(sheet: Sheet, strands: int) -> None:
    """Every length of 3 to 60, or so many spread evenly, each far from the others."""
    for group, loop in enumerate(np.linspace(3, 60, strands).round().astype(int).tolist()):
        _hairpin(sheet, sheet.far(0, group), loop, sheet.between(8, 21))


def _lattice_hairpins(sheet: Sheet, strands: int) -> None:
    """Helices side by side with a loop at either end."""
    count = (strands + 1) // 2
    side = int(np.ceil(np.sqrt(count)))
    for k in range(count):
        helix = sheet.helix(k % side, k // side)
        for end in (0, -40):
            _hairpin(sheet, helix, sheet.between(3, 60), sheet.between(8, 16), end)


def _linkers(sheet: Sheet, strands: int) -> None:
    """Linkers of 2 to 60 between helices one, two or three apart, of any direction and offset."""
    for group in range(strands):
        apart, stem = sheet.between(1, 3), sheet.between(12, 24)
        helices = [sheet.far(column, group) for column in range(apart + 1)]
        forward = sheet.rng.random() < 0.5
        # parallel strands go on where the first ends, antiparallel ones come back
        begin = sheet.between(-10, 10) + (stem if forward else 0)
        ends = begin, begin + stem
        sheet.strand(
            sheet.domain(helices[0], True, 0, stem), sheet.between(2, 60),
            sheet.domain(helices[-1], forward, *ends),
        )  # fmt: skip
        sheet.strand(sheet.domain(helices[0], False, 0, stem))
        sheet.strand(sheet.domain(helices[-1], not forward, *ends))
        for helix in helices[1:-1]:
            sheet.duplex(helix, -12, 60)


def _unpaired(sheet: Sheet, strands: int) -> None:
    """Unpaired domains: gaps within a helix, and strands that cross to the next one unpaired."""
    for group in range(strands):
        one, other = sheet.far(0, group), sheet.far(1, group)
        stem, free, more = sheet.between(10, 20), sheet.between(1, 24), sheet.between(0, 12)
        if group % 2:
            whole = stem + free + 16
            sheet.strand(sheet.domain(one, True, 0, whole))
            sheet.strand(sheet.domain(one, False, stem + free, whole))
            sheet.duplex(other, 0, whole)
        else:
            turn = stem + free
            back = sheet.domain(other, False, turn - more - stem, turn)
            sheet.strand(sheet.domain(one, True, 0, turn), back)
            sheet.strand(sheet.domain(other, True, turn - more - stem, turn - more))
        sheet.strand(sheet.domain(one, False, 0, stem))


def _spacers(sheet: Sheet, strands: int) -> None:
    """Bundles whose staples cross from helix to helix with two to six nucleotides in between."""
    side = 2 if strands < 12 else 3
    helices = [sheet.helix(k % side, k // side) for k in range(side * side)]
    pairs = sheet.neighbours()
    columns = -(-strands // max(len(helices) // 2, 1))
    for column in range(columns):
        start, free = 16 * column, set(helices)
        for at in sheet.rng.permutation(len(pairs)).tolist():
            one, other = pairs[at]
            if {one, other} <= free:
                free -= {one, other}
                down = sheet.domain(one, False, start, start + 16)
                up = sheet.domain(other, True, start, start + 16)
                sheet.strand(down, sheet.between(2, 6), up)
                sheet.strand(sheet.domain(one, True, start, start + 16))
                sheet.strand(sheet.domain(other, False, start, start + 16))
        for helix in sorted(free):
            sheet.duplex(helix, start, start + 16)


def _tails(sheet: Sheet, strands: int) -> None:
    """Tails of 1 to 40 at nicks and at the ends of helices that are side by side."""
    extension = sheet.package.Extension
    count = -(-strands // 8)
    side = int(np.ceil(np.sqrt(count)))
    for k in range(count):
        helix, half = sheet.helix(k % side, k // side), sheet.between(10, 16)
        for forward, start in itertools.product((True, False), (0, half)):
            five, three = (extension(sheet.between(1, 40)) for _ in range(2))
            sheet.strand(five, sheet.domain(helix, forward, start, start + half), three)


def _crowd(sheet: Sheet, strands: int) -> None:
    """A lattice cut into short duplexes whose strands go from one to any other near it."""
    side, stem, period = max(2, int(np.ceil(strands ** (1 / 3)))), 14, 20
    helices = [sheet.helix(k % side, k // side) for k in range(side * side)]
    across = sheet.places()
    left = [
        (helix, period * k, forward)
        for helix in helices
        for k in range(-(-strands // len(helices)))
        for forward in (True, False)
    ]
    left = [left[at] for at in sheet.rng.permutation(len(left)).tolist()]
    for _ in range(strands):
        helix, start, forward = left.pop()
        # along the helix, the end of the strand and where the next domain can begin
        leaves = start + stem * forward
        enters = np.array([begin + stem * (not onward) for _, begin, onward in left])
        apart = np.hypot(
            np.linalg.norm(across[[one for one, *_ in left]] - across[helix], axis=1),
            _RISE_NM * (enters - leaves),
        )
        at = int(np.argmin(apart + sheet.rng.uniform(0, 4, len(left))))
        other, begin, onward = left.pop(at)
        # ends are on the surface of helices, up to 2 nm further than axes
        enough = int(np.ceil((apart[at] + 2.0) / _BOND_NM))
        sheet.strand(
            sheet.domain(helix, forward, start, start + stem), enough + sheet.between(0, 20),
            sheet.domain(other, onward, begin, begin + stem),
        )  # fmt: skip
    for helix, start, forward in left:
        sheet.strand(sheet.domain(helix, forward, start, start + stem))


def _many_hairpins(sheet: Sheet, strands: int) -> None:
    for k in range(strands):
        _hairpin(sheet, sheet.helix(k % 40, k // 40), 6, 10)


def _lone_linkers(sheet: Sheet, strands: int) -> None:
    for group in range(strands):
        _linker(sheet, sheet.far(0, group), sheet.far(1, group), sheet.between(4, 12))


def _overlapping(length: int) -> Draw:
    def draw(sheet: Sheet, strands: int) -> None:
        for k in range(strands):
            one, other = (sheet.helix(k % 20 * 2 + side, k // 20) for side in (0, 1))
            _linker(sheet, one, other, length)

    return draw


def _linker(sheet: Sheet, one: int, other: int, length: int, stem: int = 16) -> None:
    """From one helix back along the other."""
    there, back = sheet.domain(one, True, 0, stem), sheet.domain(other, False, 0, stem)
    sheet.strand(there, length, back)
    sheet.strand(sheet.domain(one, False, 0, stem))
    sheet.strand(sheet.domain(other, True, 0, stem))


FAMILIES: Final[Sequence[Family]] = (
    Family("hairpins", "hairpins of 3–60, each alone", _lone_hairpins, 58, (2, 2)),
    Family("hairpin-lattices", "hairpins of 3–60, side by side", _lattice_hairpins, 32, (2, 16)),
    Family("linkers", "linkers of 2–60, one to three apart", _linkers, 12, (2, 32)),
    Family("unpaired", "gaps and unpaired crossovers", _unpaired, 12, (2, 32)),
    Family("spacers", "spacers of 2–6 at crossovers", _spacers, 32, (2, 16)),
    Family("tails", "tails of 1–40", _tails, 32, (2, 16)),
    Family("crowds", "crowds", _crowd, 36, (2, 20)),
)
"""Designs of random strands."""

LARGE: Final[Sequence[Family]] = (
    Family("many-hairpins", "hairpins of 6, one design", _many_hairpins, 1000, (2, 2)),
    Family("many-linkers", "linkers of 4–12, one design", _lone_linkers, 1000, (2, 2)),
    Family("many-short", "linkers of 5 that overlap, one design", _overlapping(5), 1000, (2, 2)),
    Family("many-long", "linkers of 30 that overlap, one design", _overlapping(30), 1000, (2, 2)),
    Family("many-mixed", "hairpins of 3–60, one design", _lattice_hairpins, 1000, (2, 2)),
    Family("many-crowded", "a crowd, one design", _crowd, 1000, (2, 2)),
)
"""Designs of published size, by repetition."""
