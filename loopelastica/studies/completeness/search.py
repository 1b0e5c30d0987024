"""Equilibria from random loads: what the lists of ``rod.equilibria`` are judged by.

Each start is a force and a moment in the middle of the rod, drawn without a look at the clamping;
``shots`` corrects it. What arrives is refined on a finer mesh and must hold on one finer still.
Hits of one rod are counted together where energies, center lines and frames agree.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from loopelastica._arrays import Array, Record
from loopelastica.rod.clamping import Clamping
from loopelastica.studies.bench.poses import directions
from loopelastica.studies.completeness import shots

# most of the starts: |F|, log-uniform; |M| across the tangent, uniform to this
_FORCES, _BENDING = (3.0, 300.0), 16.0
# the others, about loops: their share, |F|, log-uniform, and how far they are off, relative
_LOOPING, _TENSIONS, _SPREAD = 1 / 3, (10.0, 1000.0), 0.3
# energy of the twist, at most
_TWISTING = 120.0
# radians per step and misfit to reach: while searching, refined, and of the check
_COARSE, _FINE, _CHECK = (1.4, 1e-6), (0.08, 1e-11), (0.04, 1e-9)
# a loop that slides along a tense rod takes long to find its place
_PATIENCE = 400
# 1 − |η| below which a rod is pulled from one with that much, and the logarithm of each step
_LOOSE, _PULL = 0.15, 0.05
# hits are one rod if energies (relative to 1 + E) and poses differ by less
_SAME_ENERGY, _SAME = 1e-6, 1e-5
# each half of the rod is compared in so many points
PARTS = 4


@dataclass(frozen=True, slots=True, eq=False)
class Rod(Record):
    """An equilibrium that the independent search has hit.

    Attributes
    ----------
    loads : (6,) ndarray
        F and M at s = 0 in the start frame, in K0/L² and K0/L.
    energy : float
        In K0/L.
    residual : float
        What it misses its end by on a mesh that was not used to find it.
    hits : int
        How many starts led to it.
    middle : (6,) ndarray
        F and M at s = ½ in the frame there.
    mark : ndarray
        Numbers that two copies of one rod have in common, see `mark`.
    """

    loads: Array
    energy: float
    residual: float
    hits: int
    middle: Array
    mark: Array


def random_middles(
    rng: np.random.Generator, n: int, torsion_ratio: float, free_spin: bool
) -> Array:
    """Loads (n, 6) in the middle of a rod to start from.

    Parameters
    ----------
    rng : numpy.random.Generator
    n : int
    torsion_ratio : float
        K30 = K3/K0.
    free_spin : bool
        No torsion.

    Returns
    -------
    (n, 6) ndarray
    """
    twist = math.sqrt(2.0 * torsion_ratio * _TWISTING) * rng.uniform(-1.0, 1.0, n)
    across, force = _anyhow(rng, n)
    loops = rng.random(n) < _LOOPING
    across[loops], force[loops] = _loops(rng, int(loops.sum()))
    return np.column_stack([force, across, (not free_spin) * twist])


def _log_uniform(rng: np.random.Generator, bounds: tuple[float, float], n: int) -> Array:
    low, high = np.log(bounds)
    return np.exp(rng.uniform(low, high, n))


def _anyhow(rng: np.random.Generator, n: int) -> tuple[Array, Array]:
    """Moments across the tangent (n, 2) and forces (n, 3), in all directions."""
    size = _log_uniform(rng, _FORCES, n)[:, None]
    angle, bending = rng.uniform(0.0, math.tau, n), rng.uniform(0.0, _BENDING, (n, 1))
    return bending * np.column_stack([np.cos(angle), np.sin(angle)]), size * directions(rng, n)


def _loops(rng: np.random.Generator, n: int) -> tuple[Array, Array]:
    """Moments across the tangent (n, 2) and forces (n, 3) near those of a loop in a long rod.

    The angle of the tangent with the force is 4 atan exp(√F s) about a loop at s = 0 (Love 1927,
    art. 262): only with nearly these loads is a rod tense and yet loops.
    """
    size = _log_uniform(rng, _TENSIONS, n)
    root, s = np.sqrt(size), rng.uniform(-0.5, 0.5, n)
    angle = 4.0 * np.arctan(np.exp(root * s))
    bending = 2.0 * root / np.cosh(root * s) * (1.0 + _SPREAD * rng.normal(size=n))
    azimuth, tilt = rng.uniform(0.0, math.tau, n), _SPREAD * rng.normal(size=n)
    side = np.column_stack([np.cos(azimuth), np.sin(azimuth)])
    force = np.column_stack([np.sin(angle)[:, None] * side, np.cos(angle)])
    turned = np.column_stack([np.sin(azimuth + tilt), -np.cos(azimuth + tilt)])
    return bending[:, None] * turned, size[:, None] * force


def search(
    clamping: Clamping, torsion_ratio: float, starts: int, rng: np.random.Generator, span: float
) -> list[Rod]:
    """Equilibria that random loads lead to.

    Parameters
    ----------
    clamping : Clamping
    torsion_ratio : float
        K30 = K3/K0.
    starts : int
        How many random loads.
    rng : numpy.random.Generator
    span : float
        Keep what is at most this much above the lowest one, in K0/L.

    Returns
    -------
    list of Rod
        Lowest energy first.
    """
    near, *path = _pulled(clamping)
    middles = random_middles(rng, starts, torsion_ratio, clamping.free_spin)
    # what is higher may come lower on the way
    found = _refined(middles, near, torsion_ratio, 2.0 * span if path else span)
    for further in path:
        found = _low(_followed(found, further, torsion_ratio), 2.0 * span)
    return _low(found, span)


def _low(rods: list[Rod], span: float) -> list[Rod]:
    """Those at most ``span`` above the lowest, in order."""
    lowest = min((rod.energy for rod in rods), default=0.0)
    return sorted((r for r in rods if r.energy <= lowest + span), key=lambda rod: rod.energy)


def _refined(
    middles: Array, clamping: Clamping, torsion_ratio: float, span: float = math.inf
) -> list[Rod]:
    """The rods that loads (n, 6) lead to, refined and checked."""
    left = _descend(middles, clamping, torsion_ratio, *_COARSE)
    middles = middles[left <= _COARSE[1]]
    energies = np.array([energy_of(x, clamping, torsion_ratio) for x in middles])
    # those far from the lowest are let go before they cost more
    middles = middles[energies <= energies.min(initial=math.inf) + 1.01 * span]
    left = _descend(middles, clamping, torsion_ratio, *_FINE)
    found: list[Rod] = []
    for middle in middles[left <= _FINE[1]]:
        _merge(found, rod_at(middle, clamping, torsion_ratio))
    return [rod for rod in found if rod.residual <= _CHECK[1]]


def _followed(rods: list[Rod], clamping: Clamping, torsion_ratio: float) -> list[Rod]:
    """``rods`` of a clamping nearby, corrected for this one; they keep their hits."""
    found: list[Rod] = []
    for rod in rods:
        for new in _refined(rod.middle[None].copy(), clamping, torsion_ratio):
            _merge(found, replace(new, hits=rod.hits))
    return found


def energy_of(middle: Array, clamping: Clamping, torsion_ratio: float) -> float:
    """Energy of a rod from its loads in the middle.

    ½|M across t|² + F·t is constant along the rod, and F·t integrates to F·(r(1) − r(0)).

    Parameters
    ----------
    middle : (6,) ndarray
        F and M at s = ½ in the frame there.
    clamping : Clamping
    torsion_ratio : float
        K30 = K3/K0.

    Returns
    -------
    float
        In K0/L.
    """
    force = _at_start(middle, torsion_ratio)[0]
    constant = 0.5 * (middle[3] ** 2 + middle[4] ** 2) + middle[2]
    twist = 0.5 * middle[5] ** 2 / torsion_ratio
    return float(constant - force @ clamping.position + twist)


def _pulled(clamping: Clamping) -> list[Clamping]:
    """The clamping after others whose ends are nearer to each other.

    Random loads hardly ever lead to rods that are tense from end to end, because these depend on
    the loads too sharply. They are pulled from rods that are less so.
    """
    gap = 1.0 - float(np.linalg.norm(clamping.position))
    steps = max(0, math.ceil(math.log(_LOOSE / gap) / _PULL)) if gap < _LOOSE else 0
    gaps = gap * (_LOOSE / gap) ** (np.arange(steps, 0, -1) / max(steps, 1))
    scales = [*((1.0 - gaps) / (1.0 - gap)), 1.0]
    return [replace(clamping, position=scale * clamping.position) for scale in scales]


def _descend(
    middles: Array, clamping: Clamping, torsion_ratio: float, radians: float, goal: float
) -> Array:
    """Correct ``middles`` (n, 6) in place; what their ends still miss, (n,)."""
    left = np.empty(len(middles))
    shots.descend_all(
        middles, torsion_ratio, clamping.position.copy(), clamping.rotation.copy(),
        clamping.free_spin, radians, goal, _PATIENCE, left,
    )  # fmt: skip
    return left


def _residual(middle: Array, clamping: Clamping, torsion_ratio: float) -> float:
    left = np.empty(1)
    shots.descend_all(
        middle[None].copy(), torsion_ratio, clamping.position.copy(), clamping.rotation.copy(),
        clamping.free_spin, _CHECK[0], 0.0, 0, left,
    )  # fmt: skip
    return float(left[0])


def traced(middle: Array, torsion_ratio: float, parts: int = PARTS) -> tuple[Array, Array]:
    """Center line and frames as the start frame sees them.

    Parameters
    ----------
    middle : (6,) ndarray
        F and M at s = ½ in the frame there.
    torsion_ratio : float
        K30 = K3/K0.
    parts : int
        Each half of the rod is cut into so many.

    Returns
    -------
    line, frames : (2·parts + 1, 3) and (2·parts + 1, 3, 3) ndarray
    """
    at, turned = seen_from_start(middle, torsion_ratio, parts)
    s = np.linspace(0.0, 1.0, 2 * parts + 1)
    return at, (turned * _spins(torsion_ratio, middle[5] * s)).as_matrix()


def seen_from_start(middle: Array, torsion_ratio: float, parts: int) -> tuple[Array, Rotation]:
    """Center line and frames from the start frame on, turning as if K30 were 1.

    Parameters
    ----------
    middle, torsion_ratio, parts
        As for `traced`.

    Returns
    -------
    line : (2·parts + 1, 3) ndarray
    frames : Rotation
        As many.
    """
    poses = shots.trace(middle.copy(), _FINE[0], parts)
    # the extra spin is nothing in the middle
    turned = Rotation.from_quat(poses[:, 3:], scalar_first=True)
    turned *= _spins(torsion_ratio, np.array([-0.5 * middle[5]]))
    return turned[0].inv().apply(poses[:, :3] - poses[0, :3]), turned[0].inv() * turned


def _spins(torsion_ratio: float, torsions: Array) -> Rotation:
    """Turns about the tangent that K30 adds, for M3·s."""
    return Rotation.from_rotvec(np.outer(torsions, [0.0, 0.0, 1.0 / torsion_ratio - 1.0]))


def _at_start(middle: Array, torsion_ratio: float) -> Array:
    """Force, moment and displacement of the end, (3, 3), in the start frame."""
    line, frames = traced(middle, torsion_ratio, 1)
    # the middle as the start sees it
    force = frames[1] @ middle[:3]
    moment = frames[1] @ middle[3:] + np.cross(force, line[0] - line[1])
    return np.array([force, moment, line[-1]])


def mark(line: Array, frames: Array, loads: Array, clamping: Clamping) -> Array:
    """Numbers that are equal, within 1e-5, for copies of one equilibrium only.

    Where both end tangents lie on one line, rods that turn into each other about it count as one.
    Where the rod is closed it may also start elsewhere on the curve: only its force, its moment
    and the angle between them are left.

    Parameters
    ----------
    line, frames : (n, 3) and (n, 3, 3) ndarray
        At equal distances, in the start frame.
    loads : (6,) ndarray
        F and M at s = 0 in the start frame.
    clamping : Clamping

    Returns
    -------
    ndarray
    """
    if not clamping.on_one_line:
        return np.concatenate([line.ravel(), frames.ravel()])
    force, moment = loads[:3], loads[3:]
    # the moments tell mirror images apart
    unturned = [moment[2], float(force @ moment) / (1.0 + float(force @ force))]
    if clamping.closed:
        return np.array([*unturned, float(np.linalg.norm(force)) / 100.0])
    across = np.hypot(line[:, 0], line[:, 1])
    return np.concatenate([across, line[:, 2], frames[:, 2, 2], unturned])


def same(energy_a: float, mark_a: Array, energy_b: float, mark_b: Array) -> bool:
    """Whether energies and marks are those of one rod.

    Parameters
    ----------
    energy_a, energy_b : float
    mark_a, mark_b : ndarray
        From `mark`.

    Returns
    -------
    bool
    """
    if abs(energy_a - energy_b) > _SAME_ENERGY * (1.0 + abs(energy_a)):
        return False
    return bool(np.abs(mark_a - mark_b).max() < _SAME)


def rod_at(middle: Array, clamping: Clamping, torsion_ratio: float, hits: int = 1) -> Rod:
    """The rod with some loads in the middle, its end checked on the finest mesh.

    Parameters
    ----------
    middle : (6,) ndarray
        F and M at s = ½ in the frame there.
    clamping : Clamping
        What its end should meet.
    torsion_ratio : float
        K30 = K3/K0.
    hits : int
        How many starts led to it.

    Returns
    -------
    Rod
    """
    loads = _at_start(middle, torsion_ratio)[:2].ravel()
    return Rod(
        loads,
        energy_of(middle, clamping, torsion_ratio),
        _residual(middle, clamping, torsion_ratio),
        hits,
        middle.copy(),
        mark(*traced(middle, torsion_ratio), loads, clamping),
    )


def _merge(found: list[Rod], new: Rod) -> None:
    for i, old in enumerate(found):
        if same(old.energy, old.mark, new.energy, new.mark):
            kept = new if new.residual < old.residual else old
            found[i] = replace(kept, hits=old.hits + new.hits)
            return
    found.append(new)
