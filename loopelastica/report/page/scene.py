"""scene.js: what the page shows of one folder of results.

A script and not JSON, since a page that was opened from a disk may load scripts from beside it and
nothing else. Coordinates are those of the file, Å, to 0.01 Å, three numbers a point in one list.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import ArrayLike

from loopelastica._arrays import Array
from loopelastica._files import write_text
from loopelastica.folding.rank import Candidate
from loopelastica.folding.result import LoopFold
from loopelastica.molecule.hairpins import Hairpin
from loopelastica.molecule.setting import Chain, Setting
from loopelastica.molecule.trace import smoothed_curvature, smoothed_line, smoothed_phases
from loopelastica.report.records import candidate_row

if TYPE_CHECKING:
    from loopelastica.atoms.chemistry import LoopMolecule
    from loopelastica.report.atoms import LoopAtoms

SCENE: Final = "scene.js"
"""Name of the file."""

_HEAD: Final = "window.loopelasticaScene = "
_POINTS: Final = 8
"""Points per nucleotide at which curvature is shown."""
_MOST: Final = 161


def fold_scene(
    fold: LoopFold,
    setting: Setting,
    source: str,
    atoms: LoopAtoms | None = None,
    remarks: Sequence[str] = (),
) -> dict[str, Any]:
    """What the page shows of a folded loop.

    Parameters
    ----------
    fold : LoopFold
        With at least one candidate.
    setting : Setting
        What it is seen in.
    source : str
        Name of the file, or the sequence the hairpin was built from.
    atoms : LoopAtoms, optional
        Those of the candidates.
    remarks : sequence of str
        One sentence for each thing that a user should be aware of.

    Returns
    -------
    dict
        JSON-ready.
    """
    hairpin = fold.hairpin
    five, three = _in_chain(hairpin, setting.names_5), _in_chain(hairpin, setting.names_3)
    return {
        "row": {
            "file": source,
            "loop": hairpin.name,
            "closing_pair": hairpin.label,
            "sequence": hairpin.sequence,
            "nucleotides": len(hairpin),
        },
        "labels": _in_chain(hairpin, setting.names),
        # the strands are a stem
        "paired": True,
        "strands": [chain_of(five, setting.strand_5_A), chain_of(three, setting.strand_3_A)],
        "stem": flat(setting.stem_bonds_A),
        "own": _own(fold, setting),
        "neighbours": [neighbour(chain) for chain in setting.neighbours],
        "candidates": [_candidate(c, len(hairpin), atoms) for c in fold.candidates],
        "remarks": list(remarks),
    }


def _in_chain(hairpin: Hairpin, names: Iterable[str]) -> list[str]:
    return [f"{hairpin.chain}.{name}" if hairpin.chain else name for name in names]


def _own(fold: LoopFold, setting: Setting) -> dict[str, Any] | None:
    """The file's own loop."""
    if fold.backbone_A is None:
        return None
    return {**own_curve(fold.backbone_A), "bonds": flat(setting.loop_bonds_A)}


def _candidate(candidate: Candidate, n: int, atoms: LoopAtoms | None) -> dict[str, Any]:
    row = {**candidate_row(candidate), "touches": candidate.contacts.touched}
    if atoms is not None:
        columns = atoms.columns(candidate.rank)
        row |= {"sound": columns["atoms_sound"], "why": columns["atoms_not_sound_because"]}
    line, count = candidate.line, curve_points(n)
    points, _ = line.sampled()
    model = next((m for m in atoms.models if m.rank == candidate.rank), None) if atoms else None
    return {
        **row,
        **curve(points, candidate.trace, line.phases(count), line.curvature_per_A(count)),
        "atoms": None if model is None else sticks(model.molecule, model.positions_A),
    }


def curve(points_A: Array, trace_A: Array, phases: Array, curvature: Array) -> dict[str, Any]:
    """A candidate's line, with a point for each nucleotide.

    Parameters
    ----------
    points_A : (m, 3) array
        Of the line.
    trace_A : (n, 3) array
        Its nucleotides.
    phases : (k,) array
        Where its curvature is known, in nucleotides from the one before.
    curvature : (k,) array
        1/Å.

    Returns
    -------
    dict
    """
    return {
        "line": flat(points_A),
        "trace": flat(trace_A),
        "phases": _rounded(phases, 2),
        "curvature": _rounded(curvature, 4),
    }


def curve_points(nucleotides: int) -> int:
    """At how many points of a line curvature is shown."""
    return min(_POINTS * nucleotides + 1, _MOST)


def own_curve(centroids_A: Array) -> dict[str, Any]:
    """The smooth line of the file's own nucleotides.

    Parameters
    ----------
    centroids_A : (n + 2, 3) array
        Of their backbones, with those of the nucleotides before and after.

    Returns
    -------
    dict
        As of a candidate's.
    """
    nucleotides = len(centroids_A) - 2
    n = curve_points(nucleotides)
    return curve(
        smoothed_line(centroids_A, n),
        centroids_A[1:-1],
        smoothed_phases(nucleotides, n),
        smoothed_curvature(centroids_A, n),
    )


def sticks(molecule: LoopMolecule, positions_A: Array) -> dict[str, Any]:
    """Atoms and bonds of a model.

    Parameters
    ----------
    molecule : LoopMolecule
    positions_A : (N, 3) array
        In the coordinates of the file.

    Returns
    -------
    dict
    """
    return {
        "elements": list(molecule.symbols),
        "names": list(molecule.names),
        "residues": list(molecule.residue),
        "points": flat(positions_A),
        "bonds": [k for bond in molecule.bonds for k in bond],
    }


def chain_of(labels: Sequence[str], points_A: ArrayLike) -> dict[str, Any]:
    """Places with names; those that are nowhere are left out.

    Parameters
    ----------
    labels : sequence of str
    points_A : (n, 3) array_like

    Returns
    -------
    dict
    """
    points = np.asarray(points_A, dtype=np.float64).reshape(-1, 3)
    there = np.isfinite(points).all(axis=1)
    named = [labels[k] for k in np.flatnonzero(there).tolist()]
    return {"labels": named, "points": flat(points[there])}


def neighbour(chain: Chain) -> dict[str, Any]:
    """A stretch of a chain that is near."""
    return chain_of(chain.labels, chain.points_A)


def flat(points: ArrayLike) -> list[float]:
    """Coordinates in one list, to 0.01 Å."""
    return _rounded(points, 2)


def _rounded(values: ArrayLike, digits: int) -> list[float]:
    # adding zero makes -0.0 a zero
    rounded: list[float] = (np.round(np.ravel(np.asarray(values)), digits) + 0.0).tolist()
    return rounded


def write_scene(
    path: Path, items: Sequence[Mapping[str, Any]], provenance: Mapping[str, Any]
) -> None:
    """Write what the page shows of a folder.

    Parameters
    ----------
    path : Path
        The file.
    items : sequence of mapping
        A loop or a strand each.
    provenance : mapping
        Version, input and options; and the folder's files.
    """
    write_text(path, f"{_HEAD}{script_json({**provenance, 'items': list(items)})};\n")


def read_scene(path: Path) -> dict[str, Any] | None:
    """What `write_scene` has written; None where that is not there, or something else is."""
    try:
        text = path.read_text(encoding="utf-8")
        content = json.loads(text.removeprefix(_HEAD).rstrip().removesuffix(";"))
    except (OSError, ValueError, RecursionError):
        return None
    return content if isinstance(content, dict) and "items" in content else None


def script_json(content: Any) -> str:
    r"""JSON that can stand in a script of a page: no letter of it ends the script or a line.

    >>> script_json({"name": "</script>\u2028"})
    '{"name":"\\u003c/script>\\u2028"}'
    """
    text = json.dumps(content, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c")
