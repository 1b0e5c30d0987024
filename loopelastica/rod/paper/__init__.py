"""The method of the 2018 paper as printed: the reference that the package's solver is measured by.

Ameline, Haliyo, Huang, Cognet, J. Comput. Phys. 373 (2018) 736, doi:10.1016/j.jcp.2018.07.021. The
way from a clamping to loads is :mod:`.solver`; :mod:`.grid` holds the guesses, :mod:`.errors`,
:mod:`.derivatives`, :mod:`.newton` and :mod:`.path` the printed algorithms in compiled code,
:mod:`.bulirsch_stoer` the printed integrator. Nothing of the product depends on this room.
"""

from loopelastica.rod.paper.continuation import Continuation, continue_angle
from loopelastica.rod.paper.solutions import PaperSolution
from loopelastica.rod.paper.solver import ERRORS, FORWARD, PaperSolver, solve_paper

__all__ = [
    "ERRORS",
    "FORWARD",
    "Continuation",
    "PaperSolution",
    "PaperSolver",
    "continue_angle",
    "solve_paper",
]
