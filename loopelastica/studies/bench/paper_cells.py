"""The settings of the paper's studies (Figs. 3 and 4), and what the paper prints about each.

Ameline et al., J. Comput. Phys. 373 (2018) 736, DOI 10.1016/j.jcp.2018.07.021, section 4.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from loopelastica.rod.paper import ERRORS, grid


@dataclass(frozen=True, slots=True)
class Cell:
    """One setting of the paper's studies, and what the paper prints about it."""

    figure: int
    l: float  # noqa: E741 (the paper's letter)
    delta: float
    error: str
    symmetry: bool
    halved: bool  # α2 = α1/2 instead of α1 (section 4.3)
    paper_rods: int
    paper_success_percent: float | None = None
    paper_time_ms: float | None = None
    scan: str = "eps1"

    @property
    def spacing(self) -> float:
        """α1 or α2 (eq. 41)."""
        return grid.spacing(self.l, self.delta) * (0.5 if self.halved else 1.0)

    @property
    def name(self) -> str:
        """File name of the partial results; figures share a cell that is in both."""
        half = "s" if self.symmetry else "n"
        scan = "" if self.scan == "eps1" else f"-scan-{self.scan}"
        return f"l{self.l:g}-d{self.delta:g}-{self.error}-{half}{scan}"


def cells_of(figures: Sequence[int]) -> list[Cell]:
    """The cells of Fig. 3 and of Fig. 4, in the paper's order."""
    cells = []
    if 3 in figures:
        for delta, halved, rods in (
            (2.0, False, 3622),
            (1.0, False, 2154),
            (0.5, True, 53170),
            (0.25, True, 50946),
        ):
            for error in ERRORS:
                # in words: 99.9 % at δ = 0.5 for each error; 94 % and 263 ms at δ = 2 with ε3
                success = 99.9 if delta == 0.5 else None
                milliseconds = None
                if delta == 2.0 and error == "eps3":
                    success, milliseconds = 94.0, 263.0
                cells.append(Cell(3, 2.0, delta, error, True, halved, rods, success, milliseconds))
        # "one additional test (not in Figure 3)": ε3 to scan the grid as well
        cells.append(Cell(3, 2.0, 2.0, "eps3", True, False, 3622, 94.9, 171.0, "eps3"))
    if 4 in figures:
        for size, rods in ((2, 53170), (3, 82260), (5, 142552), (7, 191004), (10, 328152)):
            for symmetry in (True, False):
                cells.append(Cell(4, float(size), 0.5, "eps2", symmetry, True, rods, 99.9))
    return cells
