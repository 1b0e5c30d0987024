"""Every loop answered from the shapes of others, at three levels of honesty.

- *strict*: nothing of its family, which for GNRA and UNCG is the whole motif;
- *relatives out* (what a user gets for a loop of unknown sequence): nothing of its family, but
  other sequences of GNRA or UNCG stay;
- *entry out* (what a user gets for any loop): nothing of its own entry.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica.folding.known import Known, known_shapes
from loopelastica.folding.library import Library
from loopelastica.folding.motifs import typical_spread_A
from loopelastica.folding.shape_table import ShapeTable, rms_A
from loopelastica.molecule.trace import rmsd_A
from loopelastica.studies.motifs.corpus import StudyLoop

STRICT: Final = "strict"
RELATIVES: Final = "relatives out"
ENTRY: Final = "entry out"
ALONE: Final = ("rod", "further rod", "mean")
"""Kinds of answers that there are without a library."""
LEVELS: Final = (RELATIVES, STRICT, ENTRY)


def rows_of(loops: Sequence[StudyLoop], library: Library, level: str) -> Iterator[dict[str, Any]]:
    """A row per loop and answer.

    Parameters
    ----------
    loops : sequence of StudyLoop
    library : Library
        Of these loops.
    level : str
        One of `LEVELS`.

    Yields
    ------
    dict
        What is known of the loop, ``kind``, ``place`` from 1, ``spread_A`` and ``rmsd_A``.
    """
    by_source = {loop.found.shape.source: loop for loop in loops}
    for loop in loops:
        known = known_of(loop, library, by_source, level)
        if known is None:
            continue
        about = {
            "source": loop.found.shape.source, "loop": loop.loop, "family": loop.family,
            "acid": loop.hairpin.kind, "motif": loop.motif, "n": loop.n, "level": level,
        }  # fmt: skip
        errors = rms_A(known.weighted.nodes_A, loop.native_A)
        for place, answer in enumerate(known.answers(loop.rods), start=1):
            row = {
                **about,
                "kind": answer.kind,
                "place": place,
                "energy": answer.energy,
                "spread_A": known.spread_A(answer.trace_A),
                "rmsd_A": rmsd_A(answer.trace_A, loop.native_A),
                "least_energy_A": float(errors[np.argmin(known.energies)]),
                "oracle_A": float(errors.min()),
            }
            yield row
            if answer.kind in ALONE:
                # the same without a library that tells how far shapes lie from it
                kind = f"{answer.kind} alone"
                yield {**row, "kind": kind, "place": 0, "spread_A": typical_spread_A(loop.n)}


def known_of(
    loop: StudyLoop, library: Library, by_source: Mapping[str, StudyLoop], level: str
) -> Known | None:
    """What is known of a loop at a level."""
    table = library.of_length(loop.n, None if loop.hairpin.is_dna else False)
    return known_shapes(
        loop.hairpin, loop.poses, table.take(~_left_out(loop, table, by_source, level))
    )


def _left_out(
    loop: StudyLoop, table: ShapeTable, by_source: Mapping[str, StudyLoop], level: str
) -> NDArray[np.bool_]:
    out = table.of_entries([loop.found.entry])
    if level == ENTRY:
        return out
    others = [by_source[source] for source in table.sources.tolist()]
    family = np.array([other.family == loop.family for other in others])
    if level == RELATIVES and loop.motif:
        family &= np.array([other.motif != loop.motif for other in others])
    return np.asarray(out | table.relatives(loop.found.shape.sequence) | family)


def per_sequence(
    rows: Sequence[Mapping[str, Any]], values: Array
) -> tuple[list[Mapping[str, Any]], Array]:
    """One row and the mean of its values for each distinct loop sequence."""
    first: dict[tuple[str, int], Mapping[str, Any]] = {}
    lists: dict[tuple[str, int], list[float]] = {}
    for row, value in zip(rows, values.tolist(), strict=True):
        key = row["loop"], row["n"]
        first.setdefault(key, row)
        lists.setdefault(key, []).append(value)
    return list(first.values()), np.array([np.mean(lists[key]) for key in first])
