"""Figures without a window, and writing them; matplotlib is loaded when the first one is made."""

from pathlib import Path
from typing import Any

from loopelastica._files import whole_file


def new_figure(width: float, height: float) -> Any:
    """An empty matplotlib figure.

    Parameters
    ----------
    width, height : float
        In inches.

    Returns
    -------
    matplotlib.figure.Figure
        On a canvas that draws into files only.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def save_figure(figure: Any, path: Path, dpi: int = 150) -> None:
    """Write a figure, whole or not at all.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
    path : Path
        Its suffix chooses the format.
    dpi : int
        Dots per inch.
    """
    with whole_file(path) as part:
        figure.savefig(part, dpi=dpi)
