"""What a list of equilibria has of the rods that the independent search has hit.

A rod that was hit is expected in the list if its energy is below the list's bound. Rods are equal
if energies and poses are. Their indices are counted by ``morse``.
"""

import math
import time
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.equilibria import equilibria
from loopelastica.rod.equilibrium import Equilibrium
from loopelastica.rod.kernels.records import Status
from loopelastica.rod.writhe import net_winding
from loopelastica.studies.completeness.morse import index
from loopelastica.studies.completeness.search import PARTS, Rod, mark, same, seen_from_start, traced

Row = dict[str, Any]

# efforts by name: `rounds` of `equilibria`
EFFORTS: dict[str, int | None] = {"default": None, "deepest": 4}
# nodes of each half of a rod: loads alone do not fix a tense one
_NODES = 16
# points of each half that the winding is counted on
_WINDING = 200
# what is this near to the bound, relative to it, need not be listed
_HAIR = 1e-6
# names of Morse indices in tables; the last one stands for all above
INDICES = ("minima", "index 1", "index 2", "index 3+")


def matches(
    rods: Sequence[Rod], found: Sequence[Equilibrium], clamping: Clamping
) -> NDArray[np.bool_]:
    """Which rods of the independent search are which of a list.

    Parameters
    ----------
    rods : sequence of Rod
    found : sequence of Equilibrium
    clamping : Clamping
        Of all of them.

    Returns
    -------
    (rods, found) ndarray of bool
    """
    s = np.linspace(0.0, 1.0, 2 * PARTS + 1)
    equal = np.zeros((len(rods), len(found)), dtype=np.bool_)
    for j, other in enumerate(found):
        its_mark = mark(other.centerline(s), other.frames(s), other.loads, clamping)
        for i, rod in enumerate(rods):
            equal[i, j] = same(rod.energy, rod.mark, other.energy, its_mark)
    return equal


def below(rods: Sequence[Rod], energy_max: float) -> list[Rod]:
    """Rods that a list with this bound should have.

    Parameters
    ----------
    rods : sequence of Rod
    energy_max : float
        In K0/L.

    Returns
    -------
    list of Rod
    """
    return [rod for rod in rods if rod.energy < energy_max - _HAIR * (1.0 + abs(energy_max))]


def as_equilibrium(rod: Rod, clamping: Clamping, torsion_ratio: float) -> Equilibrium:
    """A rod of the independent search with the properties of one of the package.

    Parameters
    ----------
    rod : Rod
    clamping : Clamping
    torsion_ratio : float
        K30 = K3/K0.

    Returns
    -------
    Equilibrium
    """
    line, frames = seen_from_start(rod.middle, torsion_ratio, _NODES)
    return Equilibrium(
        clamping,
        torsion_ratio,
        rod.loads,
        rod.energy,
        rod.residual,
        Status.CONVERGED,
        node_s=np.linspace(0.0, 1.0, 2 * _NODES + 1),
        node_pose=np.hstack([line, frames.as_quat(scalar_first=True)]),
    )


def kind_of(rod: Rod, clamping: Clamping, torsion_ratio: float) -> int:
    """Place of a rod's Morse index in `INDICES`.

    Parameters
    ----------
    rod : Rod
    clamping : Clamping
    torsion_ratio : float
        K30 = K3/K0.

    Returns
    -------
    int
    """
    return min(index(rod.middle, torsion_ratio, clamping.free_spin), len(INDICES) - 1)


def judged(
    rods: Sequence[Rod], clamping: Clamping, torsion_ratio: float, effort: str
) -> tuple[Row, list[Row]]:
    """Make the list of a clamping and look for the rods in it.

    Parameters
    ----------
    rods : sequence of Rod
        What the independent search has hit.
    clamping : Clamping
    torsion_ratio : float
        K30 = K3/K0.
    effort : str
        A key of `EFFORTS`.

    Returns
    -------
    row : dict
        Rods and hits that were expected and that are listed, time and what the list says of itself.
    missed : list of dict
        What is not listed, a row per rod.
    """
    started = time.perf_counter()
    found = equilibria(clamping, torsion_ratio, rounds=EFFORTS[effort])
    seconds = time.perf_counter() - started
    expected = below(rods, found.energy_max)
    there = matches(expected, found, clamping).any(axis=1)
    kinds = np.array([kind_of(rod, clamping, torsion_ratio) for rod in expected], dtype=np.int64)
    hits = np.array([rod.hits for rod in expected], dtype=np.int64)
    row: Row = {
        "effort": effort,
        "listed": len(found),
        "listed_hit": int(matches(rods, found, clamping).any(axis=0).sum()),
        "energy_max": found.energy_max,
        "unseen": found.unseen,
        "seconds": round(seconds, 6),
        "hits": int(hits.sum()),
        "hits_listed": int(hits[there].sum()),
        "rods": len(expected),
        "rods_listed": int(there.sum()),
    }
    for place, name in enumerate(INDICES):
        row[name] = int((kinds == place).sum())
        row[f"{name} listed"] = int((there & (kinds == place)).sum())
    missed = [
        {"effort": effort, **_described(expected[i], int(kinds[i]), clamping, torsion_ratio)}
        for i in np.flatnonzero(~there)
    ]
    return row, missed


def _described(rod: Rod, kind: int, clamping: Clamping, torsion_ratio: float) -> Row:
    its = as_equilibrium(rod, clamping, torsion_ratio)
    force: Array = rod.loads[:3]
    return {
        "energy": rod.energy,
        "index": INDICES[kind],
        "hits": rod.hits,
        "force": float(np.linalg.norm(force)),
        "torsion": float(rod.loads[5]),
        "periods": its.periods,
        "turns": _turns(rod, clamping, torsion_ratio),
        "residual": rod.residual,
        **dict(zip(("F1", "F2", "F3", "M1", "M2", "M3"), rod.loads.tolist(), strict=True)),
    }


def _turns(rod: Rod, clamping: Clamping, torsion_ratio: float) -> int | None:
    """Whole turns of a rod's net winding; None with a free end spin, which fixes none."""
    if clamping.free_spin:
        return None
    line, frames = traced(rod.middle, torsion_ratio, _WINDING)
    twist = rod.loads[5] / torsion_ratio / math.tau
    # half a turn, which rounding would put on either side, counts upwards
    return math.floor(net_winding(line, frames, turns=twist) + 0.5 + 1e-9)
