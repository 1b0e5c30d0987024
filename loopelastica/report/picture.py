"""The figure of a picture; it imports matplotlib and is itself imported when one is drawn."""

import io
import warnings
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure


class Picture(Figure):  # type: ignore[misc]
    """A figure that no backend has to be chosen for, and that shows itself in a notebook."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        FigureCanvasAgg(self)

    def savefig(self, *arguments: Any, **options: Any) -> None:
        """Save it; letters of a name that the font lacks are drawn as boxes."""
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", message="Glyph .* missing from font")
            super().savefig(*arguments, **options)

    def _repr_png_(self) -> bytes:
        stream = io.BytesIO()
        self.savefig(stream, format="png")
        return stream.getvalue()
