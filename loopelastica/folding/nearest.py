"""Which shapes of a large table are worth deforming onto a stem, by an estimate of their energy.

The energy of the elastic chain to second order about its shape at rest. Let the end miss its target
by p in position, in units of the length L = Σ ℓ, and by the rotation vector θ. A hinge that turns
by ω moves the end by (ω × r, ω), r from the hinge to the end, and costs ½ |ω|²/ℓ, ℓ the half of
both neighbouring segments. The least cost is ½ cᵀ (J K⁻¹ Jᵀ)⁻¹ c with c = (p, θ). Referred to the
*elastic centre*, the mean of the hinges weighted by ℓ (Müller-Breslau), both parts separate:

    E = ½ |θ|² + ½ qᵀ S⁻¹ q,    q = p − θ × r̄,    S = Σ ℓ (|r − r̄|² 1 − (r − r̄)(r − r̄)ᵀ)

S is the hinges' tensor of inertia about that centre. So a shape costs one solution of 3×3.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica.folding.shape_table import Mask, ShapeTable
from loopelastica.molecule.ends import ClosingPoses

MOST_SAME: Final = 200
"""Shapes of the same loop sequence that are taken on top."""
CHUNK: Final = 20_000
"""Shapes that are estimated at a time, for memory."""

# of a chain that is straight at rest S is singular: along it nothing yields to second order
_LEAST: Final = 1e-6


def nearest(
    table: ShapeTable,
    poses: ClosingPoses,
    sequence: str,
    most: int = 1000,
    without: Mask | None = None,
) -> NDArray[np.int64]:
    """The shapes that probably cost least on a stem, and those of the same loop sequence.

    Parameters
    ----------
    table : ShapeTable
        k shapes.
    poses : ClosingPoses
        The stem.
    sequence : str
        Of the loop, with its closing pair; T is U.
    most : int
        How many by the estimate; `MOST_SAME` of the same loop sequence come on
        top of it.
    without : (k,) array of bool, optional
        Shapes that are not asked for, such as relatives.

    Returns
    -------
    (≤ k,) array of int
        In ascending order. All that are asked for where these are no more than `most`.
    """
    allowed = np.ones(len(table), dtype=np.bool_) if without is None else ~without
    asked = np.flatnonzero(allowed)
    if len(asked) <= most:
        return asked
    energy = estimated_energy(table.take(asked), poses.position_A, poses.rotation)
    order = np.argsort(energy, kind="stable")
    # of a loop that many entries have, some hundreds tell what all do
    same = table.same_loop(sequence)[asked[order]]
    return np.union1d(asked[order[:most]], asked[order[same][:MOST_SAME]])


def estimated_energy(table: ShapeTable, position_A: Array, rotation: Array) -> Array:
    """Energy E·L/K0 (k,) of shapes on a stem, to second order about their rest.

    Parameters
    ----------
    table : ShapeTable
        k shapes.
    position_A : (3,) array
        End of the chain in the frame of its start, Å.
    rotation : (3, 3) array
        Its frame there.

    Returns
    -------
    (k,) array
    """
    parts = [
        _energies(
            table.steps_A[i : i + CHUNK], table.end_frames[i : i + CHUNK], position_A, rotation
        )
        for i in range(0, len(table), CHUNK)
    ]
    return np.concatenate([np.zeros(0), *parts])


def _energies(steps: Array, end_frames: Array, position: Array, rotation: Array) -> Array:
    from scipy.spatial.transform import Rotation

    lengths = np.linalg.norm(steps, axis=2)
    total = lengths.sum(axis=1)
    steps, lengths = steps / total[:, None, None], lengths / total[:, None]
    yields = np.zeros((len(steps), steps.shape[1] + 1))
    yields[:, :-1] += 0.5 * lengths
    yields[:, 1:] += 0.5 * lengths
    # from each hinge to the end
    to_end = np.zeros((*yields.shape, 3))
    to_end[:, :-1] = np.cumsum(steps[:, ::-1], axis=1)[:, ::-1]
    miss = position / total[:, None] - to_end[:, 0]
    turn = Rotation.from_matrix(rotation @ end_frames.swapaxes(1, 2)).as_rotvec()
    center = np.einsum("kh,khi->ki", yields, to_end)
    arms = to_end - center[:, None]
    second = np.einsum("kh,khi,khj->kij", yields, arms, arms)
    inertia = np.trace(second, axis1=1, axis2=2)[:, None, None] * np.eye(3) - second
    left = miss - np.cross(turn, center)
    pull = np.linalg.solve(inertia + _LEAST * np.eye(3), left[..., None])[..., 0]
    return np.asarray(0.5 * ((turn**2).sum(axis=1) + (left * pull).sum(axis=1)))
