"""Other ways for lines that cannot give way: bowed to one side, where there is most room."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from loopelastica.nanostructures.laying.chains import Chains
from loopelastica.nanostructures.laying.ends import across

# sideways bows that are looked at: directions, and heights in oxDNA's units
_WAYS: Final = 12
_HEIGHTS: Final = (0.7, 1.4, 2.1, 2.8)
# distance of sites below which a bow is crowded
_ROOM: Final = 0.9
# bonds longer than this count against it
_LONG: Final = 0.85


def bow(chains: Chains, lines: list[NDArray[np.int64]], attempt: int) -> None:
    """Bow lines to the side.

    Parameters
    ----------
    chains : Chains
        All nucleotides; those of the lines are changed in place.
    lines : list of (n,) array of int
        Nucleotides of each from 5' to 3'.
    attempt : int
        0 for the side with most room, 1 for the second best, and so on.
    """
    from scipy.spatial import cKDTree

    moving = np.concatenate(lines)
    still = chains.placed.copy()
    still[moving] = False
    tree = cKDTree(np.concatenate([chains.sites[still], chains.sites[still]
                                   + 0.8 * chains.direction[still]]))  # fmt: skip
    for rows in lines:
        before, after = chains.n5[rows[0]], chains.n3[rows[-1]]
        ends = [rows[0] if before < 0 else before, rows[-1] if after < 0 else after]
        chord = chains.sites[ends[1]] - chains.sites[ends[0]]
        axis = (chord / max(float(np.linalg.norm(chord)), 1e-9))[None]
        clamp = chains.tangent[ends[0]] + chains.tangent[ends[1]]
        side = across(clamp[None], axis)[0]
        other = np.cross(axis[0], side)
        s = np.arange(1, len(rows) + 1) / (len(rows) + 1)
        angle = 2 * np.pi * np.arange(_WAYS) / _WAYS
        ways = np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * other
        bows = (np.sin(np.pi * s)[:, None] * ways[:, None]).reshape(_WAYS, len(rows), 3)
        tried = np.concatenate([chains.sites[rows] + height * bows for height in _HEIGHTS])
        distance, _ = tree.query(tried, distance_upper_bound=_ROOM)
        crowded = (np.maximum(_ROOM - distance, 0.0) ** 2).sum(axis=1)
        whole = np.concatenate(
            [
                np.broadcast_to(chains.sites[ends[0]], (len(tried), 1, 3)),
                tried,
                np.broadcast_to(chains.sites[ends[1]], (len(tried), 1, 3)),
            ],
            axis=1,
        )
        bond = np.linalg.norm(np.diff(whole, axis=1), axis=2).mean(axis=1)
        cost = crowded + (len(rows) + 1) * np.maximum(bond - _LONG, 0.0) ** 2
        best = np.argsort(cost, kind="stable")[min(attempt, len(cost) - 1)]
        chains.sites[rows] = tried[best]
