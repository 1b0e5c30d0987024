"""Error against run time: ours, the paper's method and what a user would write with SciPy.

``_forward`` compares the ways from loads to the end of the rod, ``_inverse`` the ways from a
clamping to a rod, ``_omissions`` what is saved by leaving out what a scene does not need, and
``_cold`` what the first call after an installation costs.
"""

from pathlib import Path
from typing import Any

import numpy as np

from loopelastica.studies.bench import _accuracy_plots, _cold, _forward, _inverse, _omissions
from loopelastica.studies.bench._machine import setting
from loopelastica.studies.bench._report import markdown_table, write_csv, write_text

__all__ = ["run"]

Row = dict[str, Any]

_SEED = 2026
# default and full: rods of the forward part, targets of each set, and of our large sample
_RODS = (4, 40)
_TARGETS = {
    "load-drawn": (16, 300),
    "pose-drawn, |η| < 0.95": (8, 200),
    "stiff, 0.95 < |η| < 0.9999": (3, 60),
}
_LARGE = (2000, 20000)

_INVERSE_NOTE = (
    "An answer's error is the sum of what is missing at the start, from node to node and at the"
    " end, by an integration of its own. “Claimed” is what the method itself calls a success;"
    " “× ours” is the median time (of a batch: the mean) over the mean of our batch on the same"
    " targets. `solve_bvp` and `least_squares` start from a Hermite line and from no load, then"
    " from random loads until they have succeeded, 20 guesses are made or 6 s are spent."
    " The paper's method uses its grid l = 2, δ = 0.5. The large sample is judged by our residual"
    " on a second mesh."
)


def _ratios(inverse: dict[str, list[Row]]) -> list[str]:
    """What the issue of speed comes down to, a line per set."""
    lines = []
    for targets, rows in inverse.items():
        by_name = {row["method"]: row for row in rows}
        peer = by_name[_inverse.PEER]["time_median_ms"]
        ours, large = by_name[_inverse.OURS], by_name[_inverse.LARGE]
        lines.append(
            f"- {targets}: median of `solve_bvp` over mean of our batch"
            f" {peer / ours['time_mean_ms']:.0f} × on the same {ours['sample']} targets,"
            f" {peer / large['time_mean_ms']:.0f} × by our mean of {large['sample']:,d}"
        )
    return lines


def _markdown(
    forward: list[Row], inverse: dict[str, list[Row]], omissions: list[Row], cold: list[Row]
) -> str:
    parts = [
        "# Error against run time", "", f"{setting()}; processor time of the working thread.",
        "", "## Forward", "", markdown_table(forward, _forward.COLUMNS),
        "", "## Inverse", "", _INVERSE_NOTE, "", *_ratios(inverse),
    ]  # fmt: skip
    for targets, rows in inverse.items():
        parts += ["", f"### {targets}", "", markdown_table(rows, _inverse.COLUMNS)]
    parts += ["", "## What a scene does not need is left out", "", _omissions.NOTE, ""]
    parts += [markdown_table(omissions, _omissions.COLUMNS)]
    if cold:
        parts += ["", "## Cold start", "", _cold.NOTE, "", markdown_table(cold, _cold.COLUMNS)]
    return "\n".join(parts) + "\n"


def run(
    out: Path, full: bool = False, cold: bool = False, seed: int = _SEED, progress: bool = True
) -> list[Row]:
    """Measure error and run time of all methods on the same targets.

    Parameters
    ----------
    out : Path
        Folder for ``forward.csv``, ``inverse.csv``, ``omissions.csv``, ``cold.csv``,
        ``accuracy.md`` and ``accuracy.png``.
    full : bool
        Large samples, some forty minutes, and the cold start; otherwise two or three minutes.
    cold : bool
        Measure the cold start, some minutes of compiling.
    seed : int
        Of the random targets and guesses.
    progress : bool
        Show a bar on standard error.

    Returns
    -------
    list of dict
        The lines of ``inverse.csv``.

    Raises
    ------
    MissingDependencyError
        If mpmath, which computes the reference, is not installed.
    """
    from tqdm import tqdm

    out = Path(out)
    sizes = {targets: both[full] for targets, both in _TARGETS.items()}
    total = _RODS[full] + sum(sizes.values()) + 1 + (full or cold)
    inverse = {}
    with tqdm(total=total, disable=not progress, unit="target") as bar:
        bar.set_description("forward")
        forward = _forward.measure(_RODS[full], np.random.default_rng(seed), bar.update)
        for targets, sample in sizes.items():
            bar.set_description(targets)
            # the same targets in whatever order the sets come
            rng = np.random.default_rng([seed, *targets.encode()])
            inverse[targets] = _inverse.measure(targets, sample, _LARGE[full], rng, bar.update)
        bar.set_description("omissions")
        omissions = _omissions.measure(full, np.random.default_rng(seed))
        bar.update()
        starts: list[Row] = []
        if full or cold:
            bar.set_description("cold start")
            starts = _cold.measure()
            bar.update()
    rows = [row for part in inverse.values() for row in part]
    write_csv(out / "forward.csv", forward)
    write_csv(out / "inverse.csv", rows)
    write_csv(out / "omissions.csv", omissions)
    if starts:
        write_csv(out / "cold.csv", starts)
    write_text(out / "accuracy.md", _markdown(forward, inverse, omissions, starts))
    _accuracy_plots.draw(forward, inverse, out / "accuracy.png", setting())
    return rows
