"""Error against run time: ours, the paper's method and what a user would write with SciPy.

``forward`` compares the ways from loads to the end of the rod, ``inverse`` the ways from a clamping
to a rod.
"""

from pathlib import Path
from typing import Any

import numpy as np

from loopelastica._files import write_csv, write_text
from loopelastica.studies.bench import accuracy_plots
from loopelastica.studies.bench import forward as forward_ways
from loopelastica.studies.bench import inverse as inverse_ways
from loopelastica.studies.bench.machine import setting
from loopelastica.studies.bench.markdown import markdown_table

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
    """Ratios of run times, a line per set of targets."""
    lines = []
    for targets, rows in inverse.items():
        by_name = {row["method"]: row for row in rows}
        peer = by_name[inverse_ways.PEER]["time_median_ms"]
        ours, large = by_name[inverse_ways.OURS], by_name[inverse_ways.LARGE]
        lines.append(
            f"- {targets}: median of `solve_bvp` over mean of our batch"
            f" {peer / ours['time_mean_ms']:.0f} × on the same {ours['sample']} targets,"
            f" {peer / large['time_mean_ms']:.0f} × by our mean of {large['sample']:,d}"
        )
    return lines


def _markdown(forward: list[Row], inverse: dict[str, list[Row]]) -> str:
    parts = [
        "# Error against run time", "", f"{setting()}; processor time of the working thread.",
        "", "## Forward", "", markdown_table(forward, forward_ways.COLUMNS),
        "", "## Inverse", "", _INVERSE_NOTE, "", *_ratios(inverse),
    ]  # fmt: skip
    for targets, rows in inverse.items():
        parts += ["", f"### {targets}", "", markdown_table(rows, inverse_ways.COLUMNS)]
    return "\n".join(parts) + "\n"


def run(out: Path, full: bool = False, seed: int = _SEED, progress: bool = True) -> list[Row]:
    """Measure error and run time of all methods on the same targets.

    Parameters
    ----------
    out : Path
        Folder for ``forward.csv``, ``inverse.csv``, ``accuracy.md`` and ``accuracy.png``.
    full : bool
        Large samples, up to forty minutes; otherwise two or three minutes.
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
    from loopelastica._progress import progress_bar

    out = Path(out)
    sizes = {targets: both[full] for targets, both in _TARGETS.items()}
    inverse = {}
    with progress_bar(
        total=_RODS[full] + sum(sizes.values()), shown=progress, unit="target"
    ) as bar:
        bar.set_description("forward")
        forward = forward_ways.measure(_RODS[full], np.random.default_rng(seed), bar.update)
        for targets, sample in sizes.items():
            bar.set_description(targets)
            # the same targets in whatever order the sets come
            rng = np.random.default_rng([seed, *targets.encode()])
            inverse[targets] = inverse_ways.measure(targets, sample, _LARGE[full], rng, bar.update)
    rows = [row for part in inverse.values() for row in part]
    write_csv(out / "forward.csv", forward)
    write_csv(out / "inverse.csv", rows)
    write_text(out / "accuracy.md", _markdown(forward, inverse))
    accuracy_plots.draw(forward, inverse, out / "accuracy.png", setting())
    return rows
