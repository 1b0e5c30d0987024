"""Pictures of folded loops; matplotlib is loaded when the first one is drawn.

Two views at a right angle show the stem, the candidates and the file's own loop to one scale; a
third panel the curvature along the loop, and beside it stands what each line is.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from loopelastica._arrays import Array
from loopelastica._names import printable
from loopelastica.folding.expected import expected_text
from loopelastica.folding.rank import Candidate
from loopelastica.folding.result import LoopFold
from loopelastica.molecule.setting import NEAR_A, Setting
from loopelastica.molecule.trace import smoothed_curvature, smoothed_phases
from loopelastica.report.palette import NATIVE, NEIGHBOUR, STEM, colour
from loopelastica.report.panel import DASHES, TEXT, Panel, Shown
from loopelastica.report.records import LINE_POINTS
from loopelastica.report.scene import short_shape, view_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SIZE_IN: Final = (12.6, 5.0)
# lower left corner, width and height of the panels, in parts of the picture
_FRONT: Final = (0.005, 0.02, 0.325, 0.86)
_SIDE: Final = (0.335, 0.02, 0.325, 0.86)
_CURVATURE: Final = (0.715, 0.60, 0.268, 0.28)
_KEY: Final = (0.67, 0.0, 0.325, 0.49)
# the key: height of a row in points (1/72 in), where its columns begin, rows, letters of a shape
_ROW: Final = 10.6
_COLUMNS: Final = (0.075, 0.64, 0.89)
_MOST_ROWS: Final = 10
_LONGEST_SHAPE: Final = 34
_MOST_TICKS: Final = 10


def plot_fold(
    fold: LoopFold,
    path: Path,
    title: str = "",
    sticks: Array | None = None,
    setting: Setting | None = None,
) -> None:
    """Save the picture of a folded loop.

    Parameters
    ----------
    fold, title, sticks, setting
        As for :func:`draw_fold`.
    path : Path
        The picture; its suffix decides the format.
    """
    draw_fold(fold, setting, title, sticks).savefig(path)


def draw_fold(
    fold: LoopFold,
    setting: Setting | None = None,
    title: str = "",
    sticks: Array | None = None,
) -> Figure:
    """Draw the candidates over stem and native line from two sides, and the curvature.

    Parameters
    ----------
    fold : LoopFold
        With at least one candidate.
    setting : Setting, optional
        Stem and neighbours, which are left out without it.
    title : str
        What stands over it, before what the loop is.
    sticks : (m, 2, 3) array, optional
        Bonds of the first candidate's atoms, Å.

    Returns
    -------
    matplotlib.figure.Figure
        It shows itself in a notebook; ``savefig`` saves it.

    Raises
    ------
    ValueError
        If `fold` has no candidates.
    """
    if not fold.candidates:
        raise ValueError(f"`fold` has no candidates to draw: {fold.failure}")
    from loopelastica.report.picture import Picture

    figure = Picture(figsize=_SIZE_IN, dpi=120)
    shown = Shown(fold, setting, sticks)
    view = view_of(fold, setting)
    sides = (
        (_FRONT, "front: the closing pair across", view.across, view.towards),
        (_SIDE, "side: turned by 90°", -view.towards, view.across),
    )
    panels = [
        Panel(figure.add_axes(place), name, view, across, towards)
        for place, name, across, towards in sides
    ]
    scale = min(panel.scale(shown) for panel in panels)
    for panel in panels:
        panel.draw(shown, scale)
    _draw_curvature(figure.add_axes(_CURVATURE), shown)
    _draw_key(figure.add_axes(_KEY), shown)
    hairpin = fold.hairpin
    about = f"{hairpin.name}  {hairpin.sequence}  closing pair {hairpin.label}"
    heading = printable(f"{title}   {about}" if title else about)
    _plain(figure.text(0.012, 0.95, _cut(heading, 140), fontsize=10))
    return figure


def _plain(text: Any) -> None:
    """Names are no formulae, whatever dollars are in them."""
    text.set_parse_math(False)


def _cut(text: str, most: int) -> str:
    return text if len(text) <= most else f"{text[: most - 1]}…"


def _draw_curvature(axes: Any, shown: Shown) -> None:
    fold, n = shown.fold, len(shown.fold.hairpin)
    highest = 0.0
    for candidate in reversed(fold.candidates):
        phases = candidate.line.phases(LINE_POINTS)
        inside = (phases > 0.499) & (phases < n + 0.501)
        curvature = candidate.line.curvature_per_A(LINE_POINTS)[inside]
        first = candidate.rank == 1
        axes.plot(phases[inside], curvature, color=colour(candidate.rank), lw=2.4 if first else 0.9)
        # a rod that no backbone can follow may bend as sharply as it will
        if first or not candidate.contacts.touching:
            highest = max(highest, float(curvature.max()))
    if fold.backbone_A is not None:
        curvature = smoothed_curvature(fold.backbone_A, LINE_POINTS)
        axes.plot(smoothed_phases(n, LINE_POINTS), curvature, color=NATIVE, lw=1.3, ls=DASHES)
        highest = max(highest, float(curvature.max()))
    step = -(-(n + 2) // _MOST_TICKS)
    ticks = range(0, n + 2, step)
    labels = axes.set_xticks(list(ticks), [shown.names[k] for k in ticks])
    for label in labels:
        _plain(label.label1)
    axes.tick_params(labelsize=TEXT)
    axes.set_xlim(-0.2, n + 1.2)
    axes.set_ylim(0.0, 1.06 * highest)
    axes.set_title("curvature along the loop (1/Å)", fontsize=8, color="0.3", loc="left")
    axes.spines[["top", "right"]].set_visible(False)


def _draw_key(axes: Any, shown: Shown) -> None:
    """What each line is: a table of the candidates, and the rest below."""
    fold = shown.fold
    height = axes.get_position().height * _SIZE_IN[1] * 72.0
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(-height, 0.0)
    axes.set_axis_off()

    def write(x: float, row: float, text: str, **options: Any) -> None:
        _plain(axes.text(x, -_ROW * (row + 0.5), text, fontsize=TEXT, va="center", **options))

    known = any(candidate.rmsd_A is not None for candidate in fold.candidates)
    heads = ("candidate", "expected error (Å)", "RMSD (Å)" if known else "")
    for x, text in zip(_COLUMNS, heads, strict=True):
        write(x, 0, text, color="0.3")
    for row, candidate in enumerate(fold.candidates[:_MOST_ROWS], start=1):
        y, first = -_ROW * (row + 0.5), candidate.rank == 1
        axes.plot([0.0, 0.06], [y, y], color=colour(candidate.rank), lw=2.6 if first else 1.0)
        weight = "bold" if first else "normal"
        write(_COLUMNS[0], row, f"{candidate.rank}  {_described(candidate)}", weight=weight)
        write(_COLUMNS[1], row, expected_text(candidate.expected_rmsd_A), weight=weight)
        if candidate.rmsd_A is not None:
            write(_COLUMNS[2], row, f"{candidate.rmsd_A:.2f}", weight=weight)
    below = min(len(fold.candidates), _MOST_ROWS) + 1.4
    if (more := len(fold.candidates) - _MOST_ROWS) > 0:
        write(_COLUMNS[0], below - 0.4, f"and {more} more")
        below += 1.0
    for k, (text, style) in enumerate(_others(shown)):
        x, line = 0.56 * (k % 2), below + k // 2
        axes.plot([x, x + 0.06], [-_ROW * (line + 0.5)] * 2, **style)
        write(x + _COLUMNS[0], line, text)


def _described(candidate: Candidate) -> str:
    if candidate.contacts.touching:
        touches = f", touches {candidate.contacts.touched}"
        return short_shape(candidate, _LONGEST_SHAPE - len(touches)) + touches
    return short_shape(candidate, _LONGEST_SHAPE)


def _others(shown: Shown) -> list[tuple[str, dict[str, Any]]]:
    """What is drawn beside the candidates, and how."""
    error = shown.fold.candidates[0].expected_rmsd_A[1]
    band = {"color": colour(1), "alpha": 0.14, "lw": 7.0, "solid_capstyle": "butt"}
    others = [(f"expected error of 1: {error:.1f} Å (50 %)", band)]
    if shown.native is not None:
        others.append(("file's loop, smoothed", {"color": NATIVE, "lw": 1.3, "ls": DASHES}))
    if shown.setting is not None:
        others.append(("closing pair", {"color": NATIVE, "lw": 2.2}))
        others.append(("stem", {"color": STEM, "lw": 3.2}))
        if shown.setting.neighbours:
            others.append((f"others within {NEAR_A:.0f} Å", {"color": NEIGHBOUR, "lw": 1.0}))
    if shown.sticks is not None:
        others.append(("atoms of 1", {"color": colour(1), "alpha": 0.6, "lw": 0.8}))
    return others
