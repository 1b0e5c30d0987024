"""One view of a folded loop in a picture: stem, lines, names, nothing on anything else."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np

from loopelastica._arrays import Array
from loopelastica.folding.result import LoopFold
from loopelastica.molecule.setting import Setting
from loopelastica.molecule.trace import smoothed_line
from loopelastica.report.labels import label_places
from loopelastica.report.palette import NATIVE, NEIGHBOUR, STEM, colour
from loopelastica.report.records import LINE_POINTS
from loopelastica.report.scene import View, names_of, smooth_strand, tube

# points (1/72 in): text of labels, width and height of a letter of it, room for labels at the sides
TEXT: Final = 7.0
DASHES: Final = (0, (4, 2))
_LETTER: Final = (0.62 * TEXT, 1.1 * TEXT)
_MARGIN: Final = np.array([38.0, 20.0])
# points of lines that labels keep off: a third are near enough to each other
_SPARSE: Final = 3
_SCALE_BAR_A: Final = 10.0


@dataclass(frozen=True, eq=False)
class Shown:
    """What all panels of a picture draw, Å.

    Attributes
    ----------
    fold : LoopFold
        With at least one candidate.
    setting : Setting or None
        Stem and neighbours.
    sticks : (m, 2, 3) array or None
        Bonds of the first candidate's atoms.
    """

    fold: LoopFold
    setting: Setting | None
    sticks: Array | None

    @cached_property
    def tubes(self) -> list[Array]:
        """The candidates' lines, joined to the stem."""
        return [tube(self.fold, c, self.setting, LINE_POINTS) for c in self.fold.candidates]

    @cached_property
    def native(self) -> Array | None:
        """The file's own line from closing to closing nucleotide."""
        backbone = self.fold.backbone_A
        if backbone is None:
            return None
        inner = smoothed_line(backbone, LINE_POINTS)
        return np.concatenate([backbone[:1], inner, backbone[-1:]])

    @cached_property
    def names(self) -> list[str]:
        """Closing nucleotide, nucleotides of the loop, closing nucleotide."""
        return names_of(self.fold, self.setting)

    @cached_property
    def closing_A(self) -> Array:
        """Where the closing nucleotides are, (2, 3)."""
        if self.setting is not None:
            return np.stack([self.setting.strand_5_A[-1], self.setting.strand_3_A[0]])
        return self.tubes[0][[0, -1]]

    @cached_property
    def strands(self) -> list[Array]:
        """Both strands of the stem, 5' to 3'."""
        if self.setting is None:
            return []
        return [smooth_strand(self.setting.strand_5_A), smooth_strand(self.setting.strand_3_A)]

    @cached_property
    def rungs(self) -> list[Array]:
        """Pairs of the stem, the closing one first, (2, 3) each."""
        if self.setting is None:
            return []
        pairs = zip(self.setting.strand_5_A[::-1], self.setting.strand_3_A, strict=True)
        return [np.stack(pair) for pair in pairs]

    @cached_property
    def extent(self) -> Array:
        """Points (m, 3) that must be in the picture."""
        parts = [*self.tubes, *self.strands, self.closing_A]
        if self.native is not None:
            parts.append(self.native)
        if self.sticks is not None:
            parts.append(self.sticks.reshape(-1, 3))
        points = np.concatenate(parts)
        return points[np.isfinite(points).all(axis=1)]


class Panel:
    """One view.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Where it is drawn.
    name : str
        What stands above it.
    view : View
        Of the loop.
    across, towards : (3,) array
        Directions to the right and out of this view.
    """

    def __init__(self, axes: Any, name: str, view: View, across: Array, towards: Array) -> None:
        self._axes, self._name, self._view = axes, name, view
        self._turned = np.column_stack([across, view.up])
        self._towards = towards
        figure = axes.figure
        self._room = axes.get_position().size * figure.get_size_inches() * 72.0

    def scale(self, shown: Shown) -> float:
        """Points per Å that fill the panel."""
        flat = self._flat(shown.extent)
        return float(((self._room - 2.0 * _MARGIN) / np.maximum(np.ptp(flat, axis=0), 1.0)).min())

    def draw(self, shown: Shown, scale: float) -> None:
        """Draw everything.

        Parameters
        ----------
        shown : Shown
            What there is.
        scale : float
            Points per Å.
        """
        axes, flat = self._axes, self._flat(shown.extent)
        middle = 0.5 * (flat.min(axis=0) + flat.max(axis=0))
        self._low, self._high = (middle + sign * 0.5 * self._room / scale for sign in (-1, 1))
        axes.set_xlim(self._low[0], self._high[0])
        axes.set_ylim(self._low[1], self._high[1])
        axes.set_axis_off()
        axes.text(0.03, 1.0, self._name, transform=axes.transAxes, fontsize=8, color="0.3")
        self._draw_neighbours(shown)
        self._draw_stem(shown)
        self._draw_lines(shown, scale)
        self._draw_labels(shown, scale)
        x, y = self._low + np.array([10.0, 8.0]) / scale
        axes.plot([x, x + _SCALE_BAR_A], [y, y], color="0.3", lw=1.5, solid_capstyle="butt")
        text = f"{_SCALE_BAR_A:.0f} Å"
        axes.text(x, y + 3.0 / scale, text, fontsize=TEXT, color="0.3", va="bottom")

    def _flat(self, points: Array) -> Array:
        return np.asarray((points - self._view.middle_A) @ self._turned)

    def _draw_neighbours(self, shown: Shown) -> None:
        for chain in () if shown.setting is None else shown.setting.neighbours:
            one = len(chain.points_A) == 1
            self._axes.plot(
                *self._flat(chain.points_A).T,
                color=NEIGHBOUR, lw=1.0, marker="." if one else None, ms=2.0, zorder=0,
            )  # fmt: skip

    def _draw_stem(self, shown: Shown) -> None:
        if shown.setting is None:
            return
        self._draw_bonds(shown.setting.stem_bonds_A, STEM, 0.6, 0.5)
        for strand in shown.strands:
            self._axes.plot(
                *self._flat(strand).T, color=STEM, lw=3.2, solid_capstyle="round", zorder=1.2
            )
        for k, pair in enumerate(shown.rungs):
            style = {"color": STEM, "lw": 1.0} if k else {"color": NATIVE, "lw": 2.2}
            self._axes.plot(*self._flat(pair).T, **style, zorder=1)

    def _draw_bonds(self, bonds: Array, colour: str, width: float, zorder: float) -> None:
        from matplotlib.collections import LineCollection

        if len(bonds):
            # what is behind is paler
            depth = bonds.mean(axis=1) @ self._towards
            near = (depth - depth.min()) / max(float(np.ptp(depth)), 1e-6)
            self._axes.add_collection(
                LineCollection(
                    self._flat(bonds), colors=colour, linewidths=width, alpha=0.25 + 0.5 * near,
                    zorder=zorder,
                ),
                autolim=False,
            )  # fmt: skip

    def _draw_lines(self, shown: Shown, scale: float) -> None:
        axes, first = self._axes, shown.fold.candidates[0]
        if shown.sticks is not None:
            self._draw_bonds(shown.sticks, colour(1), 0.8, 3.5)
        # the band is a line as wide as the error: the outline of a tube of that radius
        width = 2.0 * float(first.expected_rmsd_A[1]) * scale
        axes.plot(
            *self._flat(first.line.points(LINE_POINTS)).T, color=colour(1), alpha=0.14, lw=width,
            solid_capstyle="round", solid_joinstyle="round", zorder=0.2,
        )  # fmt: skip
        for candidate, points in zip(shown.fold.candidates, shown.tubes, strict=True):
            leads = candidate is first
            axes.plot(
                *self._flat(points).T, color=colour(candidate.rank), lw=2.6 if leads else 1.0,
                solid_capstyle="round", zorder=4.0 - 0.01 * candidate.rank + leads,
            )  # fmt: skip
        axes.plot(*self._flat(first.trace).T, "o", color=colour(1), mec="white", mew=0.6, ms=5,
                  zorder=6)  # fmt: skip
        if shown.native is not None and shown.fold.backbone_A is not None:
            axes.plot(*self._flat(shown.native).T, color=NATIVE, lw=1.3, ls=DASHES, zorder=5.5)
            inner = self._flat(shown.fold.backbone_A[1:-1])
            axes.plot(*inner.T, "s", color=NATIVE, mec="white", mew=0.4, ms=3.2, zorder=5.6)

    def _draw_labels(self, shown: Shown, scale: float) -> None:
        names = shown.names
        where = [shown.closing_A[:1], shown.fold.candidates[0].trace, shown.closing_A[1:]]
        if shown.strands:
            names = ["5′", *names, "3′"]
            where = [shown.strands[0][:1], *where, shown.strands[1][-1:]]
        points = self._flat(np.concatenate(where))
        known = np.asarray(np.isfinite(points).all(axis=1))
        points, names = points[known], [n for n, k in zip(names, known, strict=True) if k]
        sizes = np.array([[len(name) * _LETTER[0], _LETTER[1]] for name in names]) / scale
        loop = self._flat(np.concatenate([shown.tubes[0], shown.closing_A]))
        out = points - loop[np.isfinite(loop).all(axis=1)].mean(axis=0)
        # the strands' ends are named below the stem
        out[[name in "5′3′" for name in names]] = 0.0, -1.0
        out /= np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-9)
        rungs = [np.linspace(pair[0], pair[1], 30) for pair in shown.rungs]
        tubes = [line[::_SPARSE] for line in shown.tubes]
        lines = [self._flat(line) for line in [*tubes, *shown.strands, *rungs]]
        # the first line and the file's count twice
        lines += [lines[0]] + (
            [self._flat(shown.native[::_SPARSE])] * 2 if shown.native is not None else []
        )
        # above the scale bar
        room = (self._low + np.array([2.0, 20.0]) / scale, self._high - 2.0 / scale)
        places = label_places(points, sizes, out, np.concatenate(lines), room)
        for name, point, place, size in zip(names, points, places, sizes, strict=True):
            of_loop = name in shown.names[1:-1]
            self._axes.text(
                *place, name, fontsize=TEXT, ha="center", va="center", zorder=8,
                color=NATIVE, weight="normal" if of_loop else "bold",
            ).set_parse_math(False)  # fmt: skip
            gap = place - point
            edge = 0.5 * size / np.maximum(np.abs(gap), 1e-9)
            if np.linalg.norm(gap) * (1.0 - edge.min()) > 1.2 * size[1]:
                end = point + gap * (1.0 - edge.min())
                self._axes.plot(*np.array([point, end]).T, color="0.6", lw=0.4, zorder=3)
