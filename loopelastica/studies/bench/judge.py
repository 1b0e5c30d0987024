"""An equilibrium judged by an evaluation that shares nothing with the solver.

SciPy's integrator carries frames as matrices from node to node, the nodes following the rod's own
rate of turning. Where the rod is two boundary layers with a straight middle, the moment is taken
from the curvature of the layer itself, not from M0 + F × r, whose rounding grows with F.
"""

import math

import numpy as np
from scipy.spatial.transform import Rotation

from loopelastica._arrays import Array
from loopelastica.rod.equilibrium import Equilibrium

# decay lengths after which a boundary layer is straight to rounding
_LAYER = 32.0
# radians that the rod turns between two nodes of the check, and the most intervals
_TURN, _INTERVALS = 0.75, 4000
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(8)


def _layers(rod: Equilibrium) -> tuple[Array, float]:
    """Nodes (n,) of the check, and the length of each boundary layer; 0 where there are none."""
    force = float(np.linalg.norm(rod.loads[:3]))
    decay = math.sqrt(max(force - 0.25 * rod.loads[5] ** 2, 0.0))
    twist = abs(rod.loads[5]) / rod.torsion_ratio
    if len(rod.layers) and decay > 2.0 * _LAYER:
        layer = _LAYER / decay
        n = min(int(layer * (2.0 * math.sqrt(force) + twist) / _TURN) + 8, _INTERVALS)
        near = np.linspace(0.0, layer, n + 1)
        return np.concatenate([near, 1.0 - near[::-1]]), layer
    hamiltonian = float(rod.loads[3:] @ rod.loads[3:]) + 2.0 * abs(rod.loads[2])
    rate = max(math.sqrt(max(hamiltonian, 2.0 * force)), twist, 1.0)
    return np.linspace(0.0, 1.0, min(int(rate / _TURN) + 16, _INTERVALS) + 1), 0.0


def _march(
    frames: Array, moment: Array, h: Array, force: Array, torsion_ratio: float
) -> tuple[Array, Array]:
    """All intervals at once, by SciPy: displacements (n, 3), and frames (n, 3, 3) at their ends.

    From frames (n, 3, 3) and moments (n, 3) at their starts, over lengths ``h`` (n,).
    """
    from scipy.integrate import solve_ivp

    n, step = len(h), h[:, None]

    def slope(_: float, y: Array) -> Array:
        state = y.reshape(n, 12)
        frame = state[:, 3:].reshape(n, 3, 3)
        t = frame[:, :, 2]
        m = moment + np.cross(force, step * state[:, :3])
        omega = step * (m + (1.0 / torsion_ratio - 1.0) * (m * t).sum(1)[:, None] * t)
        turned = np.cross(omega[:, None, :], frame.transpose(0, 2, 1)).transpose(0, 2, 1)
        return np.asarray(np.hstack([t, turned.reshape(n, 9)])).ravel()

    start = np.hstack([np.zeros((n, 3)), frames.reshape(n, 9)]).ravel()
    end = solve_ivp(slope, (0.0, 1.0), start, "DOP853", rtol=3e-12, atol=1e-13).y[:, -1]
    state = end.reshape(n, 12)
    return state[:, :3] * step, state[:, 3:].reshape(n, 3, 3)


def _layer_moments(rod: Equilibrium, at: int, moved: Array) -> Array:
    """Moments (n, 3) at the nodes of both layers, without bending where these end.

    ``moved`` (n − 1, 3) are the displacements from node to node, ``at`` the straight interval.
    """
    force = rod.loads[:3]
    twist = rod.loads[5] * force / np.linalg.norm(force)
    near, far = moved[:at], moved[at + 1 :]
    back = np.vstack([-np.cumsum(near[::-1], axis=0)[::-1], np.zeros(3)])
    ahead = np.vstack([np.zeros(3), np.cumsum(far, axis=0)])
    return np.asarray(twist + np.cross(force, np.vstack([back, ahead])))


def independent(rod: Equilibrium) -> tuple[float, float]:
    """The largest of the `misfits`, and the relative error of the energy."""
    misfit, energy_error = misfits(rod)
    return float(misfit.max()), energy_error


def misfits(rod: Equilibrium) -> tuple[Array, float]:
    """Misfits of center line and frames, and the relative error of the energy.

    The misfits (nodes + 1,) are the largest components of position (L) or frame that are missing at
    the start, at the end, and from each node to the next. Their sum bounds, but for how the rod
    itself magnifies it, what is missing at the end.
    """
    s, layer = _layers(rod)
    h, force = np.diff(s), np.asarray(rod.loads[:3])
    line, frames = rod.centerline(s), rod.frames(s)
    inner = (s[:-1, None] + 0.5 * h[:, None] * (1.0 + _POINTS)).ravel()
    tangents = rod.frames(inner)[:, :, 2].reshape(len(h), -1, 3)
    keep = np.ones(len(h), dtype=np.bool_)
    first = max(np.abs(line[0]).max(), np.abs(frames[0] - np.eye(3)).max())
    last = np.abs(line[-1] - rod.clamping.position).max()
    last = max(last, np.abs(frames[-1] - rod.clamping.rotation).max())
    jumps = np.zeros(len(h))
    twist = 0.5 * rod.loads[5] ** 2 / rod.torsion_ratio
    if layer:
        at = len(s) // 2 - 1
        keep[at] = False
        size = float(np.linalg.norm(force))
        moved = 0.5 * h[:, None] * (_WEIGHTS[:, None] * tangents).sum(axis=1)
        for _ in range(2):
            moment = _layer_moments(rod, at, moved)[:-1]
            moved[keep], turned = _march(
                frames[:-1][keep], moment[keep], h[keep], force, rod.torsion_ratio
            )
        spun = Rotation.from_rotvec([0, 0, rod.loads[5] / rod.torsion_ratio * h[at]])
        jumps[at] = np.abs(frames[at] @ spun.as_matrix() - frames[at + 1]).max()
        jumps[at] = max(jumps[at], np.abs(line[at] + h[at] * force / size - line[at + 1]).max())
        # the first integral, free of the rounding of F × r
        bending = 0.5 * size * ((tangents - force / size) ** 2).sum(axis=2)
        bending[at] = 0.0
    else:
        moment = rod.moment(s)[:-1]
        moved, turned = _march(frames[:-1], moment, h, force, rod.torsion_ratio)
        bending = 0.5 * rod.curvature(inner).reshape(len(h), -1) ** 2
    jumps[keep] = np.abs((line[:-1] + moved - line[1:])[keep]).max(axis=1)
    jumps[keep] = np.maximum(jumps[keep], np.abs(turned - frames[1:][keep]).max(axis=(1, 2)))
    energy = float((0.5 * h) @ (bending @ _WEIGHTS)) + twist
    energy_error = abs(energy - rod.energy) / max(abs(rod.energy), 1e-12)
    return np.array([first, last, *jumps]), energy_error
