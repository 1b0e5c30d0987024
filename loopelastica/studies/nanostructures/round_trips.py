"""Files of oxDNA written, read, laid anew and written again: what is paired stays."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from loopelastica.nanostructures.nanostructure import nanostructure
from loopelastica.nanostructures.oxdna.files import line_order
from loopelastica.nanostructures.oxdna.topology import Form
from loopelastica.studies.nanostructures.measures import measured

Row = dict[str, Any]
Index = NDArray[np.int64]

_FORMS: Final[tuple[Form, ...]] = ("old", "new")
# lines of a configuration before those of nucleotides
_HEADER: Final = 3


def round_trips(designs: Iterable[Path]) -> list[Row]:
    """Send designs through files of oxDNA, with both forms of the topology.

    Parameters
    ----------
    designs : iterable of Path
        Of scadnano; those with refused strands are left out, for they have no files.

    Returns
    -------
    list of dict
        A row per design and form: ``paired`` nucleotides of the design, those whose partner is
        another or ``lost`` when the files are read, lines of paired nucleotides that have
        ``changed`` when the configuration is written again, whether the ``topology`` is the same,
        and bonds of single strands out of the window (``broken``) and centres too ``close`` then.
    """
    rows = []
    for path in designs:
        found = nanostructure(path)
        if not found.refused:
            with TemporaryDirectory() as folder:
                for form in _FORMS:
                    first, second = (Path(folder) / f"{form}{k}.top" for k in (1, 2))
                    found.write(first, form=form)
                    pair = _in_lines(found.system.pair, line_order(found.system, form))
                    row = {"design": path.name, "form": form}
                    rows.append(row | _again(first, second, form, pair))
    return rows


def _in_lines(pair: Index, order: Index) -> Index:
    """Partners as numbers of lines, of nucleotides as numbers of lines."""
    line = np.empty(len(order) + 1, dtype=np.int64)
    line[order], line[-1] = np.arange(len(order)), -1
    found: Index = line[pair[order]]
    return found


def _again(first: Path, second: Path, form: Form, pair: Index) -> Row:
    """What has become of a written design when it is read, laid and written again."""
    again = nanostructure(first)
    again.write(second, form=form)
    before, after = (
        path.with_suffix(".dat").read_bytes().splitlines()[_HEADER:] for path in (first, second)
    )
    paired = np.flatnonzero(again.system.pair >= 0)
    start = measured(again.system, again.strands)
    return {
        "paired": int((pair >= 0).sum()),
        "lost": int((pair != again.system.pair).sum()),
        "changed": sum(before[i] != after[i] for i in paired.tolist()),
        "topology": first.read_bytes() == second.read_bytes(),
        "broken": start["broken"],
        "close": start["close"],
    }
