"""Candidates of a loop in a notebook, in 3D, by nglview."""

from __future__ import annotations

import importlib
from itertools import pairwise
from typing import Any

from loopelastica.errors import MissingDependencyError
from loopelastica.folding.result import LoopFold
from loopelastica.molecule.setting import Setting
from loopelastica.report.records import LINE_POINTS

_STEM = (0.6, 0.6, 0.6)
_FIRST, _OTHERS = (0.0, 0.45, 0.7), (0.35, 0.7, 0.9)


def view_fold(fold: LoopFold, setting: Setting | None = None) -> Any:
    """Show the lines of a loop, and its stem.

    Parameters
    ----------
    fold : LoopFold
        With at least one candidate.
    setting : Setting, optional
        What the loop is seen in.

    Returns
    -------
    nglview.NGLWidget

    Raises
    ------
    MissingDependencyError
        If nglview is not installed.
    """
    try:
        nglview = importlib.import_module("nglview")
    except ImportError:
        raise MissingDependencyError(
            "a loop is shown in a notebook by nglview; install it with"
            " `pip install loopelastica[notebook]`"
        ) from None
    widget = nglview.NGLWidget()
    for start, end in () if setting is None else setting.stem_bonds_A.tolist():
        widget.shape.add_cylinder(start, end, _STEM, 0.15)
    for candidate in fold.candidates:
        colour, radius = (_FIRST, 0.5) if candidate.rank == 1 else (_OTHERS, 0.2)
        points = candidate.line.points(LINE_POINTS).tolist()
        for start, end in pairwise(points):
            widget.shape.add_cylinder(start, end, colour, radius)
    widget.center()
    return widget
