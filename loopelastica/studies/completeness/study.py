"""How complete lists of equilibria are, and whether what they say of it holds.

Poses are drawn at random; at each an independent search collects rods (``search``), and the lists
of `equilibria`, by default and with the largest effort, are searched for them (``compare``).
`Equilibria.unseen` says how probably a rod below the bound, found by a search of another kind, is
not in the list; here it stands beside the share that was missing.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np

from loopelastica._files import write_csv, write_json, write_text
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.equilibria import ENERGY_SPAN, equilibria
from loopelastica.studies.bench.poses import shell
from loopelastica.studies.completeness.compare import EFFORTS, INDICES, judged
from loopelastica.studies.completeness.report import draw, markdown
from loopelastica.studies.completeness.search import Rod, rod_at, search
from loopelastica.studies.completeness.tables import reliability

__all__ = ["pose", "run"]

Row = dict[str, Any]

_SEED = 2026
# poses, default and full; starts of the independent search at each
_POSES, _STARTS = (24, 200), 1000
# positions are uniform below this |η|: beyond it random loads hardly ever arrive
_REACH = 0.95
# kinds of poses take turns: four with fixed frames and K30 = 1, two with free spin, two others
_KINDS = ("fixed", "free spin", "fixed", "torsion", "fixed", "free spin", "fixed", "torsion")
_TORSION = (0.1, 10.0)
_MISSED = (
    *("pose", "kind", "torsion_ratio", "effort", "energy", "index", "hits", "force", "torsion"),
    *("periods", "turns", "residual", "F1", "F2", "F3", "M1", "M2", "M3"),
)


def pose(seed: int, number: int) -> tuple[Clamping, float, str]:
    """A pose of the study.

    Parameters
    ----------
    seed, number : int
        Of the study, and of the pose in it.

    Returns
    -------
    clamping : Clamping
        Position uniform in a ball, rotation uniform.
    torsion_ratio : float
        1, or log-uniform between 0.1 and 10 where the kind is "torsion".
    kind : str
        "fixed", "free spin" or "torsion".
    """
    rng = np.random.default_rng([seed, number])
    kind = _KINDS[number % len(_KINDS)]
    positions, rotations = shell(rng, 1, 0.0, _REACH)
    torsion_ratio = float(np.exp(rng.uniform(*np.log(_TORSION)))) if kind == "torsion" else 1.0
    return Clamping(positions[0], rotations[0], kind == "free spin"), torsion_ratio, kind


def _hit(out: Path, seed: int, number: int) -> list[Rod]:
    """Rods that the independent search hits at a pose, from an earlier run if there was one."""
    clamping, torsion_ratio, _ = pose(seed, number)
    path = out / "partial" / f"hits-{number}.json"
    label = [seed, _STARTS]
    try:
        kept = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        kept = None
    if not isinstance(kept, dict) or kept.get("label") != label:
        rng = np.random.default_rng([seed, number, _STARTS])
        rods = search(clamping, torsion_ratio, _STARTS, rng, 1.01 * ENERGY_SPAN)
        kept = {"label": label, "rods": [[*rod.middle.tolist(), rod.hits] for rod in rods]}
        write_json(path, kept)
    return [rod_at(np.array(m), clamping, torsion_ratio, int(hits)) for *m, hits in kept["rods"]]


def run(out: Path, full: bool = False, seed: int = _SEED, progress: bool = True) -> list[Row]:
    """Judge lists of equilibria by an independent search.

    Parameters
    ----------
    out : Path
        Folder for ``poses.csv`` (a row per pose and effort), ``missed.csv`` (a row per rod that a
        list lacks), ``reliability.csv``, ``report.md`` and ``completeness.png``. A run into the
        same folder takes what the search hit from an earlier one; lists are made anew.
    full : bool
        200 poses instead of 24.
    seed : int
        Of the random poses and loads.
    progress : bool
        Show a bar on standard error.

    Returns
    -------
    list of dict
        The lines of ``poses.csv``.
    """
    from loopelastica._progress import progress_bar

    out = Path(out)
    rows: list[Row] = []
    missed: list[Row] = []
    first, ratio, _ = pose(seed, 0)
    # compiled, and the guess library loaded, before the clock starts
    equilibria(first, ratio, rounds=1)
    for number in progress_bar(range(_POSES[full]), shown=progress, unit="pose"):
        clamping, torsion_ratio, kind = pose(seed, number)
        rods = _hit(out, seed, number)
        label = {"pose": number, "kind": kind, "torsion_ratio": torsion_ratio}
        parameters = zip(
            ("eta1", "eta2", "eta3", "psi", "theta", "phi"),
            clamping.parameters.tolist(),
            strict=True,
        )
        where = dict(parameters)
        for effort in EFFORTS:
            row, lacking = judged(rods, clamping, torsion_ratio, effort)
            rows.append({**label, **where, **row})
            missed += [{**label, **rod} for rod in lacking]
    bins = reliability(rows)
    write_csv(out / "poses.csv", rows)
    write_csv(out / "missed.csv", missed, _MISSED)
    write_csv(out / "reliability.csv", bins)
    write_text(out / "report.md", markdown(rows, bins, INDICES, _STARTS))
    draw(rows, bins, INDICES, out / "completeness.png")
    return rows
