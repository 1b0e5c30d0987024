"""What a structure holds: its hairpins, secondary structure and what is odd about it."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from loopelastica._files import sha256
from loopelastica.errors import StructureError
from loopelastica.molecule.clamp_rule import STEM_RMS_MAX_A
from loopelastica.molecule.ends import stem_ends
from loopelastica.molecule.hairpins import Hairpin, Hairpins
from loopelastica.molecule.nucleotides import Structure, enumerated
from loopelastica.report.records import about, partners, program

_PLAIN = {"A", "C", "G", "U", "DA", "DC", "DG", "DT", "DU"}


def listing(structure: Structure, hairpins: Hairpins) -> dict[str, Any]:
    """Everything that `loopelastica hairpins` finds, ready for JSON.

    Parameters
    ----------
    structure : Structure
        What was read.
    hairpins : Hairpins
        What was found in it.

    Returns
    -------
    dict
        Input, chains, modified residues, remarks and hairpins; lengths in Å.
    """
    table = structure.nucleotides
    source = None if structure.source is None else Path(structure.source)
    return {
        **program(),
        "input": {
            "file": structure.name,
            "sha256": None if source is None else sha256(source),
            "models": structure.n_models,
            "nucleotides": len(table),
        },
        "chains": secondary_structure(structure, hairpins),
        "modified": modified(structure),
        "remarks": remarks(structure, hairpins),
        "hairpins": [_hairpin(structure, hairpin) for hairpin in hairpins],
    }


def secondary_structure(structure: Structure, hairpins: Hairpins) -> list[dict[str, str]]:
    """Sequence and dot-bracket of each chain, in the order of the file.

    Parameters
    ----------
    structure, hairpins
        As for :func:`listing`.

    Returns
    -------
    list of dict
        ``chain``, ``first``, ``last``, ``sequence`` and ``dot_bracket``; the brackets of all
        chains, joined, are what the option ``dot_bracket`` takes.
    """
    table = structure.nucleotides
    starts = [0, *(np.flatnonzero(table.chain[1:] != table.chain[:-1]) + 1).tolist(), len(table)]
    return [
        {
            "chain": str(table.chain[a]),
            "first": table.number(a),
            "last": table.number(b - 1),
            "sequence": "".join(table.letter[a:b]),
            "dot_bracket": hairpins.dot_bracket[a:b],
        }
        for a, b in pairwise(starts)
    ]


def modified(structure: Structure) -> dict[str, str]:
    """Parent base of each nucleotide whose residue name is not the one of a plain base.

    Where half of the names or more are of that kind they are another program's names for plain
    bases, and nothing is listed.
    """
    table = structure.nucleotides
    odd = np.flatnonzero(~np.isin(table.resname, list(_PLAIN)))
    if 2 * len(odd) >= len(table):
        return {}
    return {table.label(int(row)): str(table.letter[row]) for row in odd}


def remarks(structure: Structure, hairpins: Hairpins) -> list[str]:
    """One sentence for each thing about the file that a user should be aware of.

    Parameters
    ----------
    structure, hairpins
        As for :func:`listing`.

    Returns
    -------
    list of str
    """
    parents = [f"{label} ({letter})" for label, letter in modified(structure).items()]
    named = [f"modified residues and their parents: {enumerated(parents)}"] if parents else []
    return [*structure.remarks, *named, *hairpins.remarks]


def _hairpin(structure: Structure, hairpin: Hairpin) -> dict[str, Any]:
    rms_A, refusal = stem_check(structure, hairpin)
    return {
        "name": hairpin.name,
        **about(hairpin),
        "nucleotides": len(hairpin),
        "absent": int((hairpin.loop < 0).sum()),
        "stem_pairs": hairpin.n_pairs,
        "stem_rms_A": rms_A,
        "regular": rms_A is not None and rms_A <= STEM_RMS_MAX_A,
        "refusal": refusal,
        **partners(hairpin),
    }


def stem_check(structure: Structure, hairpin: Hairpin) -> tuple[float | None, str | None]:
    """Misfit of the ideal strands to the stem, or why they cannot be laid on it (model 1).

    Parameters
    ----------
    structure : Structure
        What was read.
    hairpin : Hairpin
        One of its hairpins.

    Returns
    -------
    rms_A : float or None
        Å.
    refusal : str or None
    """
    try:
        ends = stem_ends(structure.nucleotides, hairpin, structure.positions(0))
    except StructureError as error:
        return None, str(error)
    return ends.rms_A, None
