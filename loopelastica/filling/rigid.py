"""A stretch that was shifted as a whole, put back between its neighbours as a rigid body."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Final

import numpy as np

from loopelastica._arrays import Array
from loopelastica.molecule.faults import JUNCTION, junction_errors
from loopelastica.molecule.polymer import Monomer

JUNCTION_SD_A: Final = 0.05
SHIFT_SD_A: Final = 10.0
TURN_SD: Final = 1.0
"""How far a stretch is expected to have moved, Å and rad; the two junctions decide."""
MOST_STEPS: Final = 60
FITS_A: Final = 0.4
"""Largest misfit of the junctions of a stretch that was moved as a whole."""


def moved_back(
    before: Monomer | None, after: Monomer | None, stretch: Sequence[Monomer]
) -> Mapping[str, Mapping[str, Array]] | None:
    """Where the atoms of a stretch are after the least motion that joins it to both sides.

    Parameters
    ----------
    before, after : Monomer or None
        Its neighbours; None at an end of the chain.
    stretch : sequence of Monomer
        5' to 3'.

    Returns
    -------
    mapping of str to mapping of str to (3,) array, or None
        By labels and names, Å; None where it fits in no place as it is.
    """
    from scipy.optimize import least_squares
    from scipy.spatial.transform import Rotation

    everything = np.array([at for one in stretch for at in one.atoms_A.values()])
    middle = everything.mean(axis=0)

    def placed(one: Monomer, motion: Array, names: Collection[str] = ()) -> dict[str, Array]:
        names = [name for name in names or one.atoms_A if name in one.atoms_A]
        turn = Rotation.from_rotvec(motion[3:])
        at = turn.apply(np.array([one.atoms_A[name] for name in names]) - middle)
        return dict(zip(names, at + middle + motion[:3], strict=True))

    def misfits(motion: Array) -> Array:
        found = []
        if before is not None:
            found.append(junction_errors(before.atoms_A, placed(stretch[0], motion, _LATER)))
        if after is not None:
            found.append(junction_errors(placed(stretch[-1], motion, _EARLIER), after.atoms_A))
        return np.concatenate(found)

    def residuals(motion: Array) -> Array:
        prior = motion / np.repeat([SHIFT_SD_A, TURN_SD], 3)
        return np.concatenate([misfits(motion) / JUNCTION_SD_A, prior])

    found = []
    # the two ends pull a stretch to its place; more starts for where they pull it onto a wrong side
    for start in _STARTS:
        motion = least_squares(residuals, start, x_scale=_SCALE, max_nfev=MOST_STEPS).x
        misfit = np.abs(misfits(motion))
        if len(misfit) and misfit.max() <= FITS_A:
            found.append(motion)
    if not found:
        return None
    best = min(found, key=lambda motion: float((residuals(motion) ** 2).sum()))
    return {one.label: placed(one, best) for one in stretch}


_EARLIER: Final = tuple(dict.fromkeys(name for name, _, _ in JUNCTION))
_LATER: Final = tuple(name for _, name, _ in JUNCTION[2:]) + ("P",)
_SCALE: Final = np.repeat([1.0, 0.2], 3)
_STARTS: Final = tuple(
    np.array([*(4.0 * side), 0.0, 0.0, 0.0]) for side in (np.zeros(3), *np.eye(3), *-np.eye(3))
)
