"""Rods of one clamping on the curve that a rod follows while its end is turned.

After each whole turn of the end the clamping is the first one again. Between folds the rods along
the curve mostly keep their Morse index, so that from a pass with a tight loop in it come the passes
with the same loop and other twist, which the search of ``equilibria`` may miss: its shots from the
middle end where a rod is too tense.
"""

import math
from collections.abc import Iterator

from loopelastica.rod._discrete import discrete_copy, segments
from loopelastica.rod._starts import problem_of
from loopelastica.rod.continuation import twist_end
from loopelastica.rod.descent import HINGE, refined
from loopelastica.rod.equilibrium import Equilibrium

# turns of the end either way, and most steps
_TURNS, _STEPS = 2.0, 100


def turned(rod: Equilibrium, tolerance: float) -> Iterator[Equilibrium]:
    """Equilibria of the same clamping on the curve of a rod whose end is turned both ways.

    Parameters
    ----------
    rod : Equilibrium
        One that converged, with a fixed end spin.
    tolerance : float
        Largest residual of what is found.

    Yields
    ------
    Equilibrium
        Without its index; the rod itself may be among them.
    """
    problem = problem_of(rod.clamping, rod.torsion_ratio, tolerance)
    for turns in (_TURNS, -_TURNS):
        path = twist_end(rod, turns, steps=_STEPS, stability=False)
        for k in range(1, len(path.rods)):
            before, after = sorted((path.parameter[k - 1], path.parameter[k]))
            whole = math.ceil(before)
            if not before < whole <= after:
                continue
            there = twist_end(path.rods[k], whole - path.parameter[k], stability=False).end
            if there is None:
                continue
            copy = discrete_copy(there, segments(there, HINGE))
            # turned back, the clamping is off by rounding
            found = refined(rod, problem, copy, there.loads.copy())
            if found.converged:
                yield found
