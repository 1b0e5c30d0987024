"""Many elastic chains deformed at once: plain arrays in and out, a failed row is a status.

The chain is in ``kernels.chain``, how it is deformed in ``kernels.chain_minimization``. For one
chain, and what follows from it, see :mod:`.deformed`.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from loopelastica._arrays import Array, Record
from loopelastica._checks import array
from loopelastica.rod._arguments import check_torsion_ratio
from loopelastica.rod.kernels.chain_minimization import deform_rows, new_rows
from loopelastica.rod.kernels.records import Status


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class ChainBatch(Record):
    """Deformed chains of m segments, k of them.

    Attributes
    ----------
    nodes : (k, m + 1, 3) ndarray
        In the start frame and the unit of the steps; zeros where a row failed.
    rotations : (k, m, 3, 3) ndarray
        How each segment is turned against its rest; 1 where a row failed.
    energy : (k,) ndarray
        In K0/L; inf where a row failed.
    residual : (k,) ndarray
        Largest error of what is given back, by formulas that the solver does not use: of the end's
        place, in lengths, and of the balance of moments and the energy, relative to the largest
        load and to the energy; inf where a row failed.
    index : (k,) ndarray of int
        Morse index: independent ways downhill with the ends clamped; -1 where a row failed.
    status : (k,) ndarray of int
        `Status` of each row.
    """

    nodes: Array
    rotations: Array
    energy: Array
    residual: Array
    index: NDArray[np.int64]
    status: NDArray[np.int64]

    @property
    def converged(self) -> NDArray[np.bool_]:
        """(k,) which rows are solutions."""
        return np.asarray(self.status == Status.CONVERGED)

    @property
    def stable(self) -> NDArray[np.bool_]:
        """(k,) which rows are local minima of the energy with the ends clamped."""
        return np.asarray(self.index == 0)

    def __len__(self) -> int:
        return len(self.status)

    def __repr__(self) -> str:
        return f"<ChainBatch: {int(self.converged.sum())} of {len(self)} chains deformed>"


def deform_batch(
    steps: ArrayLike,
    end_frames: ArrayLike,
    positions: ArrayLike,
    rotations: ArrayLike,
    stiffness: ArrayLike | None = None,
    torsion_ratio: float = 1.0,
) -> ChainBatch:
    """Deform elastic chains of equally many segments to clamped ends.

    k shapes go with k ends; one shape goes with all ends, and one end with all shapes.

    Parameters
    ----------
    steps : (k, m, 3) or (m, 3) array_like
        The segments at rest in the start frame, in any unit.
    end_frames : (k, 3, 3) or (3, 3) array_like
        End frames at rest in the start frame.
    positions : (k, 3) or (3,) array_like
        Where the end is clamped, in the start frame and the unit of the steps.
    rotations : (k, 3, 3) or (3, 3) array_like
        End frames there.
    stiffness : (k, m + 1) or (m + 1,) array_like, optional
        Factors of the hinges' stiffness, 1 for that of an ideal rod, which is K0 over half the
        length of either neighbouring segment.
    torsion_ratio : float
        Stiffness of the hinges against torsion over that against bending.

    Returns
    -------
    ChainBatch
        A row that cannot be, such as an end out of reach or numbers that are not finite, has a
        status; the others are solved.

    Raises
    ------
    ValueError
        If shapes of arrays do not fit each other or `torsion_ratio` is not positive.

    Examples
    --------
    A quarter of a circle, its end moved by a tenth of its radius.

    >>> angles = (np.arange(6) + 0.5) * np.pi / 12
    >>> steps = np.stack([np.sin(angles), 0 * angles, np.cos(angles)], axis=1)
    >>> end_frame = [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]
    >>> batch = deform_batch(steps, end_frame, steps.sum(axis=0) + [0, 0.4, 0], end_frame)
    >>> print(batch.converged, batch.energy.round(4))
    [ True] [0.0284]
    """
    shapes = _rows("steps", steps, 3)
    m = shapes.shape[1]
    if m < 2 or shapes.shape[2] != 3:
        raise ValueError(f"`steps` has shape {shapes.shape}; it must be (k, m, 3) with m ≥ 2")
    ends = _rows("end_frames", end_frames, 3, (3, 3))
    places = _rows("positions", positions, 2, (3,))
    frames = _rows("rotations", rotations, 3, (3, 3))
    factors = _rows("stiffness", np.ones(m + 1) if stiffness is None else stiffness, 2, (m + 1,))
    ratio = check_torsion_ratio(torsion_ratio)
    given = {
        "steps": shapes, "end_frames": ends, "positions": places, "rotations": frames,
        "stiffness": factors,
    }  # fmt: skip
    k = _common(given)
    rows = new_rows(k, m)
    deform_rows(
        *(given[name] for name in ("steps", "end_frames", "stiffness", "positions", "rotations")),
        ratio, False, np.zeros((1, 0, 4)), True, rows,
    )  # fmt: skip
    return ChainBatch(
        rows.nodes, rows.rotations[:, :m], rows.energy, rows.residual, rows.morse_index, rows.status
    )


def _rows(name: str, values: ArrayLike, dimensions: int, shape: tuple[int, ...] = ()) -> Array:
    """Rows of an array, of which one may be given without its first dimension."""
    found = array(name, values)
    if found.ndim == dimensions - 1:
        found = found[None]
    if found.ndim != dimensions or (shape and found.shape[1:] != shape):
        wanted = ", ".join(["k", *map(str, shape or ("m", "3"))])
        raise ValueError(f"`{name}` has shape {np.shape(values)}; it must be ({wanted})")
    return found


def _common(given: dict[str, Array]) -> int:
    """How many rows there are; ValueError if an array has neither one nor as many as the others."""
    counts = [len(values) for values in given.values()]
    k = 0 if 0 in counts else max(counts)
    if any(count not in (1, k) for count in counts):
        names = ", ".join(f"`{name}` has {len(values)}" for name, values in given.items())
        raise ValueError(f"rows do not go together: {names}; each must have 1 or as many as others")
    return k
