"""What kernels pass on by name: problems, starts, solutions, and how a solve ended.

Plain tuples and structured arrays, which Python and compiled code read alike.
"""

from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np

from loopelastica._arrays import Array

# segments of a discrete rod, and with them the nodes that a solution has room for
SEGMENTS = 64


class Status(IntEnum):
    """How a solve ended; only ``CONVERGED`` (0) is a solution.

    Examples
    --------
    >>> import loopelastica as le
    >>> rod = le.solve(le.Clamping([0.0, 0.0, 0.5], [[1, 0, 0], [0, 1, 0], [0, 0, 1]]))
    >>> rod.status == le.Status.CONVERGED, [status.name for status in le.Status][:2]
    (True, ['CONVERGED', 'STALLED'])
    """

    CONVERGED = 0
    STALLED = 1
    TOO_MANY_ITERATIONS = 2
    TOO_STIFF = 3
    CHECK_FAILED = 4
    UNREACHABLE = 5
    BAD_INPUT = 6
    OUT_OF_TIME = 7


class Method(IntEnum):
    """Which step of the solver delivered an equilibrium; :attr:`label` says it in words."""

    NONE = 0
    SHOOTING = 1
    BOUNDARY_LAYERS = 2
    REFINED_LAYERS = 3
    DISCRETE_ROD = 4
    DISCRETE_ROD_LAYERS = 5
    DISCRETE_ROD_SHOOTING = 6
    CONTINUATION = 7
    NEARBY = 8
    GUESS = 9
    STRAIGHT = 10
    NEARLY_STRAIGHT = 11
    MIDDLE = 12

    @property
    def label(self) -> str:
        """The method in words."""
        return _LABELS[self]

    def __str__(self) -> str:
        return self.label


_LABELS = {
    Method.NONE: "none",
    Method.SHOOTING: "shooting from a stored rod",
    Method.BOUNDARY_LAYERS: "boundary layers",
    Method.REFINED_LAYERS: "boundary layers + multiple shooting",
    Method.DISCRETE_ROD: "discrete rod + multiple shooting",
    Method.DISCRETE_ROD_LAYERS: "discrete rod + boundary layers",
    Method.DISCRETE_ROD_SHOOTING: "discrete rod + shooting",
    Method.CONTINUATION: "continuation",
    Method.NEARBY: "continuation from a near clamping",
    Method.GUESS: "shooting from a given guess",
    Method.STRAIGHT: "straight",
    Method.NEARLY_STRAIGHT: "nearly straight rod + multiple shooting",
    Method.MIDDLE: "shooting from the middle + multiple shooting",
}


class Problem(NamedTuple):
    """A clamping to be solved, in compiled code's terms."""

    position: Array
    """r(L) in the start frame, (3,)."""
    quaternion: Array
    """End frame in the start frame, (4,)."""
    shortening: float
    """1 − |r(L)|, known better than one minus its rounded length."""
    torsion_ratio: float
    """K30."""
    free_spin: bool
    tolerance: float
    """Largest residual of a solution."""


class Nodes(NamedTuple):
    """Nodes of multiple shooting: arc lengths (m + 1,) and poses (m + 1, 7) as if K30 were 1."""

    s: Array
    pose: Array


class Outcome(NamedTuple):
    """How a start ended; with 0 segments the boundary layers, or one shot, hold the rod."""

    method: int
    residual: float
    energy: float
    segments: int


# one start of the standard ones: whole turns added to the end-to-end twist, whether an end's
# boundary layer goes over the other side, a bow (radian) that leaves a symmetric start, half waves
# of a buckled start, and whether the discrete rod is minimized (else it is refined as it stands,
# which leads to saddles as readily as to minima)
START = np.dtype(
    (
        np.record,
        [
            ("turns", "f8"),
            ("bow", "f8"),
            ("half_waves", "f8"),
            ("over_0", "?"),
            ("over_1", "?"),
            ("minimized", "?"),
        ],
    )
)


class Start(NamedTuple):
    """A row of an array of `START`."""

    turns: float = 0.0
    bow: float = 0.0
    half_waves: float = 0.0
    over_0: bool = False
    over_1: bool = False
    minimized: bool = True


def starts_array(starts: tuple[Start, ...]) -> Any:
    """Starts as an array (n,) of `START`."""
    return np.array([tuple(start) for start in starts], dtype=START)


# two boundary layers in closed form (``boundary_layers``): the quaternion of the axis, √F, β; for
# either end azimuth φ, X at the clamp x, side δ, sin(α/2) and the angle χ of the clamp (K30 = 1,
# counted on from the start); r(L); and what the layers miss where they meet
_LAYERS = """
    axis_w axis_x axis_y axis_z root beta phi_0 x_0 delta_0 phi_1 x_1 delta_1
    end_x end_y end_z half_sine_0 half_sine_1 meeting chi_0 chi_1
"""
LAYERS = np.dtype((np.record, [(name, "f8") for name in _LAYERS.split()]))


class Solution(NamedTuple):
    """Room for a solution: its loads and its nodes, or its boundary layers."""

    loads: Array
    """F and M at s = 0, (6,)."""
    nodes: Nodes
    layers: Any
    """(1,) of `LAYERS`."""
