"""Sequence patterns that could have been motifs, and what they are worth.

For each loop with the pattern the mean over others with it, of other families (of GNRA and UNCG,
which are one family each, of other sequences), is compared with the mean over all loops of its
length. A pattern that does not gain is no motif.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

from loopelastica.folding.library import Library
from loopelastica.folding.motifs import pattern_fits
from loopelastica.folding.shape_table import letters_of
from loopelastica.molecule.trace import rmsd_A
from loopelastica.studies.motifs.corpus import StudyLoop
from loopelastica.studies.motifs.judge import RELATIVES, known_of, per_sequence

PATTERNS: Final = {
    "GNRA": "GNRA",
    "UNCG": "UNCG",
    "YNNG tetraloops": "YNNG",
    "UNNG tetraloops": "UNNG",
    "GNNA tetraloops": "GNNA",
    "U first of four": "UNNN",
    "A first of four": "ANNN",
    "C first of four": "CNNN",
    "U second of four (U-turn)": "NUNN",
    "GNRNA (GNRA with one more)": "GNRNA",
    "U second of five (U-turn)": "NUNNN",
    "U second of six (U-turn)": "NUNNNN",
    "U second of seven (U-turn)": "NUNNNNN",
    "anticodon": "YUNNNRN",
    "T loop": "UUCRANN",
    "DNA triloop GNA": "GNA",
}


def trial_rows(loops: Sequence[StudyLoop], library: Library) -> list[dict[str, Any]]:
    """One row per pattern.

    Parameters
    ----------
    loops : sequence of StudyLoop
    library : Library
        Of these loops.

    Returns
    -------
    list of dict
        ``pattern``, counts, and medians and means of the error by the mean over the pattern and
        over all, Å; None where nothing of another family has the pattern.
    """
    by_source = {loop.found.shape.source: loop for loop in loops}
    return [_trial(name, pattern, loops, library, by_source) for name, pattern in PATTERNS.items()]


def _trial(
    name: str,
    pattern: str,
    loops: Sequence[StudyLoop],
    library: Library,
    by_source: Mapping[str, StudyLoop],
) -> dict[str, Any]:
    of = [
        loop
        for loop in loops
        if loop.hairpin.is_dna == name.startswith("DNA")
        and pattern_fits(pattern, letters_of(loop.found.shape.sequence)[None])[0]
    ]
    judged, own, over_all = [], [], []
    for loop in of:
        known = known_of(loop, library, by_source, RELATIVES)
        if known is None:
            continue
        among = pattern_fits(pattern, known.table.letters) & (known.weighted.weights > 0.0)
        among &= known.table.is_dna == loop.hairpin.is_dna
        if among.any():
            judged.append({"loop": loop.loop, "n": loop.n})
            own.append(rmsd_A(known.weighted.among(among).mean_A, loop.native_A))
            over_all.append(rmsd_A(known.weighted.mean_A, loop.native_A))
    row: dict[str, Any] = {
        "name": name,
        "pattern": pattern,
        "loops": len(of),
        "sequences": len({loop.loop for loop in of}),
        "families": len({loop.family for loop in of}),
    }
    for column, values in (("own", own), ("all", over_all)):
        each = per_sequence(judged, np.array(values))[1] if judged else np.empty(0)
        row[f"{column}_median_A"] = float(np.median(each)) if len(each) else None
        row[f"{column}_mean_A"] = float(np.mean(each)) if len(each) else None
        row["judged"] = len(each)
    return row
