"""What a user would write instead: SciPy's collocation and single shooting, some twenty lines each.

Both solve for the loads (F, M0) of a rod with L = K0 = K30 = 1 whose end is clamped; position and
unit quaternion (w, x, y, z) along the rod obey

    r' = t,    q' = ½ (0, M) q,    M' = F × t,    F constant.

They are written as a competent user writes them: analytic right-hand sides, in vectors for
``solve_bvp`` and in plain floats for the integrator; no Jacobians. Collocation starts from a cubic
Hermite line with frames carried along it and the moment that these frames turn with: frames that
are only turned evenly from one end to the other lose half of the targets. Further guesses are rods
of random loads, as many as `guesses` has, and as long as `_PATIENCE` lasts.
"""

import itertools
import time
from collections.abc import Callable, Sequence

import numpy as np

from loopelastica._arrays import Array
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.equilibrium import Equilibrium
from loopelastica.rod.kernels.records import Status

Method = Callable[[Clamping], Equilibrium | None]

_START = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
_MESH = 21
# collocation from the Hermite line, and from a random rod: a guess that is no good shows early
_MAX_NODES, _FEWER_NODES = 5000, 1000
# least_squares: what it may spend on a guess, and the misfit that is a solution
_EVALUATIONS, _REACHED = 30, 1e-6
# seconds after which no further guess is tried
_PATIENCE = 6.0


def _rod(loads: Array, rtol: float, at: Array | None = None) -> Array:
    """Poses (7, m) by SciPy's DOP853: where it stops, or at the arc lengths ``at`` (m,)."""
    from scipy.integrate import solve_ivp

    fx, fy, fz, ax, ay, az = loads.tolist()

    def slope(_: float, pose: Array) -> Sequence[float]:
        rx, ry, rz, w, x, y, z = pose.tolist()
        mx, my, mz = ax + fy * rz - fz * ry, ay + fz * rx - fx * rz, az + fx * ry - fy * rx
        return (
            2.0 * (x * z + w * y),
            2.0 * (y * z - w * x),
            w * w + z * z - x * x - y * y,
            -0.5 * (mx * x + my * y + mz * z),
            0.5 * (mx * w + my * z - mz * y),
            0.5 * (my * w + mz * x - mx * z),
            0.5 * (mz * w + mx * y - my * x),
        )

    return np.asarray(
        solve_ivp(slope, (0.0, 1.0), _START, "DOP853", at, rtol=rtol, atol=0.1 * rtol).y
    )


def end_by_dop853(loads: Array, rtol: float) -> Array:
    """The end of a rod by ``solve_ivp``.

    Parameters
    ----------
    loads : (6,) ndarray
        F and M at s = 0, in K0/L² and K0/L.
    rtol : float
        Relative tolerance; the absolute one is a tenth of it.

    Returns
    -------
    (7,) ndarray
        Position and quaternion.
    """
    return _rod(loads, rtol)[:, -1]


def random_guesses(rng: np.random.Generator, n: int) -> Array:
    """Loads of the size that rods below |η| = 0.95 have.

    Parameters
    ----------
    rng, n
        Generator, and how many.

    Returns
    -------
    (n, 6) ndarray
    """
    return np.hstack([rng.normal(0.0, 20.0, (n, 3)), rng.normal(0.0, 5.0, (n, 3))])


def _quaternion(rotation: Array) -> Array:
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_matrix(rotation.copy()).as_quat(scalar_first=True))


def _turned_away(q: Array, target: Array) -> Array:
    """Vector part of q times the target's inverse: the sine of half the angle between them."""
    (w, x, y, z), (a, b, c, d) = q, target
    return np.array([
        a * x - b * w + c * z - d * y,
        a * y - c * w + d * x - b * z,
        a * z - d * w + b * y - c * x,
    ])  # fmt: skip


def _hermite(clamping: Clamping, s: Array) -> tuple[Array, Array]:
    """Poses (7, m) on the cubic with the given ends, and moments (3, m) that turn them so."""
    from scipy.spatial.transform import Rotation

    start, end = np.array([[0.0], [0.0], [1.0]]), clamping.rotation[:, 2:]
    chord = clamping.position[:, None]
    line = (3 - 2 * s) * s**2 * chord + (1 - s) ** 2 * s * start - (1 - s) * s**2 * end
    slope = 6 * s * (1 - s) * chord + (1 - s) * (1 - 3 * s) * start + (3 * s - 2) * s * end
    t = (slope / np.linalg.norm(slope, axis=0)).T
    frames = [Rotation.identity()]
    for here, there in itertools.pairwise(t):
        axis = np.cross(here, there)
        size = np.linalg.norm(axis)
        angle = np.arctan2(size, here @ there)
        frames.append(Rotation.from_rotvec(axis * angle / max(size, 1e-12)) * frames[-1])
    # what twist is missing at the end is spread evenly
    # a copy: older SciPy takes no read-only arrays
    left = (frames[-1].inv() * Rotation.from_matrix(clamping.rotation.copy())).as_matrix()
    twist = np.arctan2(left[1, 0], left[0, 0])
    turned = Rotation.concatenate(frames) * Rotation.from_rotvec(np.outer(s * twist, [0, 0, 1]))
    q = turned.as_quat(scalar_first=True)
    q[1:] *= np.cumprod(np.sign((q[1:] * q[:-1]).sum(axis=1)))[:, None]
    rate = (turned[1:] * turned[:-1].inv()).as_rotvec() / np.diff(s)[:, None]
    moment = np.vstack([rate[:1], 0.5 * (rate[1:] + rate[:-1]), rate[-1:]])
    return np.vstack([line, q.T]), moment.T


def _of_loads(f: Array, s: Array) -> tuple[Array, Array]:
    """As `_hermite`, of the rod with the loads ``f`` (6,)."""
    poses = _rod(f, 1e-4, s)
    return poses, f[3:, None] + np.cross(f[:3], poses[:3].T).T


def by_collocation(guesses: Array, tolerance: float = 1e-6) -> Method:
    """``solve_bvp`` from the Hermite line, then from rods of random loads.

    Parameters
    ----------
    guesses : (n, 6) ndarray
        These loads.
    tolerance : float
        Of ``solve_bvp``.

    Returns
    -------
    callable
        From a clamping to a result, or None.
    """
    from scipy.integrate import solve_bvp

    def slope(_: Array, state: Array, f: Array) -> Array:
        w, x, y, z, mx, my, mz = state[3:]
        tx, ty, tz = 2 * (x * z + w * y), 2 * (y * z - w * x), w * w + z * z - x * x - y * y
        return np.array([
            tx, ty, tz,
            -0.5 * (mx * x + my * y + mz * z), 0.5 * (mx * w + my * z - mz * y),
            0.5 * (my * w + mz * x - mx * z), 0.5 * (mz * w + mx * y - my * x),
            f[1] * tz - f[2] * ty, f[2] * tx - f[0] * tz, f[0] * ty - f[1] * tx,
        ])  # fmt: skip

    def solve(clamping: Clamping) -> Equilibrium | None:
        target, s = _quaternion(clamping.rotation), np.linspace(0.0, 1.0, _MESH)

        def ends(a: Array, b: Array, _: Array) -> Array:
            miss = _turned_away(b[3:7], target)
            return np.concatenate([a[:7] - _START, b[:3] - clamping.position, miss])

        began = time.thread_time()
        for number, f in enumerate((np.zeros(6), *guesses)):
            poses, moment = _of_loads(f, s) if number else _hermite(clamping, s)
            # an iteration that runs away overflows before it is given up
            with np.errstate(all="ignore"):
                found = solve_bvp(
                    slope, ends, s, np.vstack([poses, moment]), f[:3],
                    tol=tolerance, max_nodes=_FEWER_NODES if number else _MAX_NODES,
                )  # fmt: skip
            if found.success:
                loads = np.concatenate([found.p, found.y[7:, 0]])
                return from_nodes(clamping, loads, found.x, found.y[:7].T)
            if time.thread_time() - began > _PATIENCE:
                break
        return None

    return solve


def by_shooting(guesses: Array, tolerance: float = 1e-10) -> Method:
    """``least_squares`` over the loads, from none and then from random ones.

    Parameters
    ----------
    guesses : (n, 6) ndarray
        These loads.
    tolerance : float
        Relative tolerance of the integrator.

    Returns
    -------
    callable
        From a clamping to a result, or None.
    """
    from scipy.optimize import least_squares

    def solve(clamping: Clamping) -> Equilibrium | None:
        target = _quaternion(clamping.rotation)

        def misfit(f: Array) -> Array:
            end = end_by_dop853(f, tolerance)
            return np.concatenate([end[:3] - clamping.position, _turned_away(end[3:], target)])

        began = time.thread_time()
        for f in (np.zeros(6), *guesses):
            found = least_squares(misfit, f, xtol=1e-12, ftol=1e-12, max_nfev=_EVALUATIONS)
            if np.abs(found.fun).max() < _REACHED:
                return from_loads(clamping, found.x)
            if time.thread_time() - began > _PATIENCE:
                break
        return None

    return solve


def from_nodes(clamping: Clamping, loads: Array, s: Array, poses: Array) -> Equilibrium:
    """Loads and nodes as the package's own kind of result, to be judged.

    Parameters
    ----------
    clamping : Clamping
    loads : (6,) ndarray
    s : (m,) ndarray
        Arc lengths of the nodes, in units of L.
    poses : (m, 7) ndarray
        Positions and quaternions of the nodes.

    Returns
    -------
    Equilibrium
        Called converged, whatever it is.
    """
    q = poses[:, 3:] / np.linalg.norm(poses[:, 3:], axis=1, keepdims=True)
    return Equilibrium(
        clamping, 1.0, loads, 1.0, 0.0, Status.CONVERGED,
        node_s=s, node_pose=np.hstack([poses[:, :3], q]),
    )  # fmt: skip


def from_loads(clamping: Clamping, loads: Array) -> Equilibrium:
    """Loads alone as the package's own kind of result, to be judged.

    Parameters
    ----------
    clamping : Clamping
    loads : (6,) ndarray

    Returns
    -------
    Equilibrium
        Called converged, whatever it is.
    """
    return from_nodes(clamping, loads, np.zeros(1), _START[None])
