"""Colours of the page: Okabe and Ito's, which colour-blind people tell apart, and two more."""

from typing import Final

PALETTE: Final = (
    *("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00"),
    *("#56b4e9", "#7a5195", "#a6761d", "#666666", "#b2b200"),
)
"""Of candidates by rank; the eleventh begins anew."""

NATIVE: Final = "#222222"
STEM: Final = "#8a8f98"
NEIGHBOUR: Final = "#c3c8cf"
