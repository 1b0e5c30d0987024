"""From a clamping to one equilibrium: standard starts, each result judged independently.

The lowest of their results was the lowest of all that random starts found wherever the two were
compared; it is not proven to be. Where no start arrives, the clamping is approached from others
nearby (``continuation``).
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from loopelastica._checks import array, instance
from loopelastica.rod._arguments import check_flag, check_torsion_ratio
from loopelastica.rod._starts import (
    TOLERANCE,
    Deadline,
    check_tolerance,
    from_loads,
    from_standard_starts,
    straight,
)
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.continuation import continue_clamping
from loopelastica.rod.equilibrium import Equilibrium
from loopelastica.rod.kernels.records import Method, Status

# Newton steps from a given guess
_PATIENCE = 40
# how far, and where to, the clamping is moved for a detour
_DETOURS = tuple((size, seed) for seed in range(3) for size in (0.1, 0.3, 0.2, 0.03))


def solve(
    clamping: Clamping,
    torsion_ratio: float = 1.0,
    lowest: bool = True,
    *,
    guess: Equilibrium | ArrayLike | None = None,
    tolerance: float = TOLERANCE,
    time_limit_s: float | None = None,
) -> Equilibrium:
    """Find an equilibrium of an ideal rod with both ends clamped.

    Parameters
    ----------
    clamping : Clamping
        The end's pose in the start frame, lengths in units of the rod's.
    torsion_ratio : float
        K30 = K3/K0 (eq. 5 of doi:10.1016/j.jcp.2018.07.021).
    lowest : bool
        Return the equilibrium of least energy that the standard starts lead to (not proven to be
        the lowest of all); otherwise the first one found.
    guess : Equilibrium or (6,) array_like, optional
        A warm start: a rod of a clamping nearby, or loads. The equilibrium that Newton's method
        reaches from it is returned, whatever its energy; the standard starts follow if there is
        none.
    tolerance : float
        Largest residual of a solution.
    time_limit_s : float, optional
        Seconds after which no further way is tried. The standard starts, some milliseconds, are
        made whole.

    Returns
    -------
    Equilibrium
        Its ``converged`` says whether it is a solution: a numerical failure is a status, not an
        exception.

    Raises
    ------
    ValueError
        If no rod can fit (`clamping` out of reach) or another argument is out of range.

    Examples
    --------
    >>> q = Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])
    >>> rod = solve(q)
    >>> print(rod.converged, round(rod.energy, 6), rod.residual < 1e-9)
    True 7.057888 True
    """
    clamping, lowest = instance("clamping", clamping, Clamping), check_flag("lowest", lowest)
    torsion_ratio, tolerance = check_torsion_ratio(torsion_ratio), check_tolerance(tolerance)
    deadline = Deadline(time_limit_s)
    stretched = straight(clamping, torsion_ratio)
    if stretched is not None:
        return stretched
    if guess is not None:
        rod = _from_guess(clamping, torsion_ratio, guess, tolerance)
        if rod is not None:
            return rod
    rod = from_standard_starts(clamping, torsion_ratio, lowest, tolerance)
    return rod if rod.converged else by_detour(rod, lowest, tolerance, deadline)


def _from_guess(
    clamping: Clamping, torsion_ratio: float, guess: Equilibrium | ArrayLike, tolerance: float
) -> Equilibrium | None:
    """What Newton's method reaches from a guess, or None."""
    if isinstance(guess, Equilibrium):
        if guess.clamping.free_spin == clamping.free_spin and guess.torsion_ratio == torsion_ratio:
            # the one step is for boundary layers too tense for nodes
            path = continue_clamping(guess, clamping, natural=True, steps=1, stability=False)
            if path.end is not None and path.end.residual < tolerance:
                return replace(path.end, method=Method.GUESS)
        loads = guess.loads
    else:
        loads = array("guess", guess)
        if loads.shape != (6,) or not np.isfinite(loads).all():
            raise ValueError("`guess` must be an Equilibrium or six finite loads F1 F2 F3 M1 M2 M3")
    rod = from_loads(clamping, torsion_ratio, loads, _PATIENCE, tolerance)
    return replace(rod, method=Method.GUESS) if rod.converged else None


def by_detour(
    rod: Equilibrium, lowest: bool, tolerance: float = TOLERANCE, deadline: Deadline | None = None
) -> Equilibrium:
    """By continuation from clampings nearby, where no start arrives; else ``rod`` as it is.

    About one in 200 of those poses needs it whose tangents are both within 1e-6 of the line of a
    nearly straight chord, where solutions are a circle in all but name.

    Parameters
    ----------
    rod : Equilibrium
        What the standard starts came to, unsolved.
    lowest : bool
        Try all ways and return the lowest; otherwise the first one found.
    tolerance : float
        Largest residual of a solution.
    deadline : Deadline, optional
        When to stop trying.

    Returns
    -------
    Equilibrium
        ``rod`` itself if nothing was found, with the status of a time limit if that was why.
    """
    found = []
    for end in detours(rod.clamping, rod.torsion_ratio):
        if end is not None and end.residual < tolerance:
            found.append(end)
            if not lowest:
                break
        if deadline is not None and deadline.passed:
            if not found:
                return replace(rod, status=Status.OUT_OF_TIME)
            break
    return min(found, key=lambda end: end.energy, default=rod)


def detours(clamping: Clamping, torsion_ratio: float) -> Iterator[Equilibrium | None]:
    """Equilibria of a clamping reached from others nearby.

    Where solutions lie on a circle, or nearly, Newton's method has a direction in which
    nothing stops it. A clamping a few degrees away has isolated solutions, and along the way
    back the path stays on one of them.

    Parameters
    ----------
    clamping : Clamping
        The goal, with its ends less than the rod's length apart.
    torsion_ratio : float
        K30.

    Yields
    ------
    Equilibrium or None
        Verified as any other; None where a way led nowhere. The displacements are fixed, so two
        runs agree.
    """
    from scipy.spatial.transform import Rotation

    for size, seed in _DETOURS:
        rng = np.random.default_rng(seed)
        turn = Rotation.from_rotvec(size * rng.normal(size=3)).as_matrix()
        shifted = (1.0 - 0.3 * size) * clamping.position + 0.1 * size * rng.normal(size=3)
        near = Clamping(shifted, clamping.rotation @ turn, clamping.free_spin)
        rod = from_standard_starts(near, torsion_ratio)
        path = continue_clamping(rod, clamping, steps=200, stability=False)
        yield None if path.end is None else replace(path.end, method=Method.NEARBY)
