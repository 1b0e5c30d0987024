"""Clampings drawn at random: the ordinary ones.

A draw takes a generator and a number n and returns positions (n, 3) and rotations (n, 3, 3): the
end's pose in the start frame, lengths in units of the rod's. Each function here that returns poses
or rods takes these two first; ``cases`` has the extreme poses.
"""

import math
from collections.abc import Callable
from functools import partial

import numpy as np
from scipy.spatial.transform import Rotation

from loopelastica._arrays import Array
from loopelastica.rod.parameters import PhysicalParameters, a_min

Poses = tuple[Array, Array]
Draw = Callable[[np.random.Generator, int], Poses]

# largest force and moment of load-drawn rods (K0/L², K0/L), those of the guess library
_FORCE, _MOMENT = 60.0, 12.0


def directions(rng: np.random.Generator, n: int) -> Array:
    """Unit vectors, uniform.

    Parameters
    ----------
    rng : numpy.random.Generator
    n : int

    Returns
    -------
    (n, 3) ndarray
    """
    v = rng.normal(size=(n, 3))
    return np.asarray(v / np.linalg.norm(v, axis=1, keepdims=True))


def random_loads(rng: np.random.Generator, n: int) -> Array:
    """Loads with |F| and |M| uniform and uniform directions.

    Parameters
    ----------
    rng, n
        As for `directions`.

    Returns
    -------
    (n, 6) ndarray
        |F| below 60 K0/L², |M| below 12 K0/L.
    """
    force = directions(rng, n) * rng.uniform(0.0, _FORCE, (n, 1))
    moment = directions(rng, n) * rng.uniform(0.0, _MOMENT, (n, 1))
    return np.hstack([force, moment])


def load_drawn(rng: np.random.Generator, n: int) -> Poses:
    """Ends of rods (K30 = 1) with `random_loads`.

    Parameters
    ----------
    rng, n
        As for `directions`.

    Returns
    -------
    positions, rotations : (n, 3) and (n, 3, 3) ndarray
    """
    from loopelastica.rod.kernels.shooting import ends

    positions, quaternions = ends(random_loads(rng, n), 1.0, 4.0)
    return positions, Rotation.from_quat(quaternions, scalar_first=True).as_matrix()


def shell(rng: np.random.Generator, n: int, low: float, high: float) -> Poses:
    """Positions uniform in a shell, rotations uniform.

    Parameters
    ----------
    rng, n
        As for `directions`.
    low, high : float
        Bounds of |η|.

    Returns
    -------
    positions : (n, 3) ndarray
    rotations : (n, 3, 3) ndarray
    """
    radius = np.cbrt(rng.uniform(low**3, high**3, (n, 1)))
    return directions(rng, n) * radius, random_rotations(rng, n)


def random_rotations(rng: np.random.Generator, n: int) -> Array:
    """Rotation matrices, uniform.

    Parameters
    ----------
    rng, n
        As for `directions`.

    Returns
    -------
    (n, 3, 3) ndarray
    """
    return np.asarray(Rotation.random(n, random_state=rng).as_matrix())


def at_shell(low: float, high: float) -> Draw:
    """`shell` of given bounds, as a draw.

    Parameters
    ----------
    low, high : float
        Bounds of |η|.

    Returns
    -------
    callable
    """
    return partial(shell, low=low, high=high)


def ends_of(rods: list[PhysicalParameters]) -> Poses:
    """Positions (n, 3) and rotations (n, 3, 3) of the ends of rods, K30 = 1."""
    clampings = [rod.clamping() for rod in rods]
    return np.array([c.position for c in clampings]), np.array([c.rotation for c in clampings])


def cut(
    rng: np.random.Generator, lam: float, t_p: float, a: float, length: float
) -> PhysicalParameters:
    """A piece of an infinite rod that starts anywhere in its period, with any φ0.

    Parameters
    ----------
    rng : numpy.random.Generator
    lam, t_p, a : float
        λ, t_P and a (eq. 9–11 of doi:10.1016/j.jcp.2018.07.021), dimensionless.
    length : float
        L/μ.

    Returns
    -------
    PhysicalParameters
    """
    rod = PhysicalParameters(lam, t_p, a, rng.uniform(0.0, math.tau), 0.0, length)
    window = rod.period if math.isfinite(rod.period) else length
    return PhysicalParameters(lam, t_p, a, rod.phi0, rng.uniform(0.0, window), length)


def of_length(
    rng: np.random.Generator, n: int, shortest: float, longest: float
) -> list[PhysicalParameters]:
    """Random rods with L/μ between two bounds, log-uniform.

    Parameters
    ----------
    rng, n
        As for `directions`.
    shortest, longest : float
        Bounds of L/μ.

    Returns
    -------
    list of PhysicalParameters
    """
    rods = []
    for _ in range(n):
        lam, t_p = rng.uniform(-2.0, 2.0, 2)
        a = a_min(lam, t_p) + 10.0 ** rng.uniform(-3.0, 0.5)
        length = 10.0 ** rng.uniform(math.log10(shortest), math.log10(longest))
        rods.append(cut(rng, lam, t_p, a, length))
    return rods
