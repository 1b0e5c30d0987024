"""Colours of pictures, pages and viewers' scripts: a candidate has one and the same everywhere.

Six are of Okabe and Ito (Color Universal Design, 2008), four of Tol's schemes (SRON/EPS/TN/09-002,
2021). Any two of them, and any one and the dark grey, differ by at least 17 in CIELAB for normal
eyes, under protanopia and under deuteranopia (matrices of Machado et al.,
doi:10.1109/TVCG.2009.113).

>>> colour(1), colour(11) == colour(1)
('#d55e00', True)
"""

from typing import Final

PALETTE: Final = (
    *("#d55e00", "#0072b2", "#009e73", "#cc79a7", "#e69f00"),
    *("#56b4e9", "#332288", "#aa3377", "#117733", "#661100"),
)
"""Candidates of rank 1 to 10, from the eleventh on again."""

NATIVE: Final = "#404040"
"""The file's own loop."""

STEM: Final = "#8c8c8c"
"""The stem that holds the loop, and the rest of its structure."""

NEIGHBOUR: Final = "#c8c8c8"
"""Other chains near the loop."""


def colour(rank: int) -> str:
    """The colour of a candidate by its rank, from 1: "#rrggbb"."""
    return PALETTE[(rank - 1) % len(PALETTE)]
