"""From a clamping to one equilibrium: standard starts, each result judged independently.

The lowest of their results was the lowest of all known ones wherever this was compared with random
starts; it is not proven to be. Where no start arrives, the clamping is approached from others
nearby (``continuation``).
"""

from loopelastica.rod._starts import check_torsion_ratio, from_standard_starts, straight
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.continuation import detours
from loopelastica.rod.equilibrium import Equilibrium


def solve(clamping: Clamping, torsion_ratio: float = 1.0, lowest: bool = True) -> Equilibrium:
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

    Returns
    -------
    Equilibrium
        Its ``converged`` says whether it is a solution: a numerical failure is a status, not an
        exception.

    Raises
    ------
    ValueError
        If no rod can fit (`clamping` out of reach) or `torsion_ratio` is not positive.

    Examples
    --------
    >>> q = Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])
    >>> rod = solve(q)
    >>> print(rod.converged, round(rod.energy, 6), rod.residual < 1e-9)
    True 7.057888 True
    """
    torsion_ratio = check_torsion_ratio(torsion_ratio)
    stretched = straight(clamping, torsion_ratio)
    if stretched is not None:
        return stretched
    rod = from_standard_starts(clamping, torsion_ratio, lowest)
    return rod if rod.converged else by_detour(rod, lowest)


def by_detour(rod: Equilibrium, lowest: bool) -> Equilibrium:
    """By continuation from clampings nearby, where no start arrives; else ``rod`` as it is.

    About one in 200 of those poses needs it whose tangents are both within 1e-6 of the line of a
    nearly straight chord, where solutions are a circle in all but name.
    """
    found = []
    for end in detours(rod.clamping, rod.torsion_ratio):
        found.append(end)
        if not lowest:
            break
    return min(found, key=lambda end: end.energy, default=rod)
