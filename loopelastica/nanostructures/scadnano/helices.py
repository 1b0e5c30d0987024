"""Where a helix of a design is, and where its nucleotides are, in the geometry of oxDNA2.

The design decides the axes, the rise, the bases per turn and where the minor groove looks; the
model decides the rest, because its bonds and its pairs must fit: centres 0.6 from the axis, the two
of a pair opposite to each other. scadnano's own exporter has the same axes, and the same centres
where the design's minor groove has the model's width of 140°. At scadnano's 150° its partners miss
each other by 10°; here each is turned by 5°, so that the middle of the groove stays.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica._checks import shown
from loopelastica.errors import StructureError
from loopelastica.nanostructures.oxdna.model import (
    BOND_LONGEST,
    BOND_SHORTEST,
    HELIX_RADIUS,
    UNIT_NM,
    backbone_sites,
)


@dataclass(frozen=True, slots=True)
class Helices:
    """Geometry of the helices of a design; arrays over helices in the order of their numbers.

    Attributes
    ----------
    index : (n,) array of int
        Their numbers in the design, rising.
    origin : (n, 3) array
        The axis at offset 0; oxDNA's units.
    direction : (n, 3) array
        Unit vectors of rising offsets.
    up : (n, 3) array
        Unit vectors from the axis to where the design draws the backbone of a forward strand at
        offset 0.
    rise, turn, groove : (n,) array
        oxDNA's units and radians per base, and the minor groove's width in radians.
    """

    index: NDArray[np.int64]
    origin: Array
    direction: Array
    up: Array
    rise: Array
    turn: Array
    groove: Array

    def rows(self, index: NDArray[np.int64]) -> NDArray[np.int64]:
        """Places (m,) in these arrays of helices, by their numbers in the design."""
        return np.searchsorted(self.index, index)

    def axis_points(self, row: NDArray[np.int64], steps: Array) -> Array:
        """Points (m, 3) on axes: of which helices, how many bases from offset 0."""
        points: Array = self.origin[row] + (self.rise[row] * steps)[:, None] * self.direction[row]
        return points

    def place(
        self, row: NDArray[np.int64], steps: Array, forward: NDArray[np.bool_]
    ) -> tuple[Array, Array, Array]:
        """Place nucleotides on helices.

        Parameters
        ----------
        row : (m,) array of int
            Of which helix, by its place in these arrays.
        steps : (m,) array
            How many bases from offset 0 along the axis.
        forward : (m,) array of bool
            Whether their strand follows rising offsets.

        Returns
        -------
        centre, a1, a3 : (m, 3) arrays
            As in a :class:`~loopelastica.nanostructures.system.System`.
        """
        # the groove's middle looks between both backbones, and the centres are a quarter of a
        # turn to its two sides
        side = np.where(forward, -1.0, 1.0)
        angle = steps * self.turn[row] + self.groove[row] / 2 + side * np.pi / 2
        axis, up = self.direction[row], self.up[row]
        radial = np.cos(angle)[:, None] * up + np.sin(angle)[:, None] * np.cross(axis, up)
        return self.axis_points(row, steps) + HELIX_RADIUS * radial, -radial, side[:, None] * axis


def helices_of(where: str, design: Any) -> Helices:
    """Geometry of the helices of a design.

    Parameters
    ----------
    where : str
        What sentences call the file.
    design : scadnano.Design

    Raises
    ------
    StructureError
        If a helix has no place, or a geometry in which no strand can be bound.
    """
    rows, checked = [], set()
    for index, helix in sorted(design.helices.items()):
        group = design.groups[helix.group]
        geometry = design.geometry if group.geometry is None else group.geometry
        if id(geometry) not in checked:  # most often one for all
            _check_geometry(f"{where}: the geometry of helix {index}", geometry)
            checked.add(id(geometry))
        _numbers(f"{where}: the grid position of helix {index}", helix.grid_position or ())
        position = helix.calculate_position(group.grid, geometry)
        angles = _numbers(
            f"{where}: yaw, pitch and roll of helix {index}",
            (group.yaw, group.pitch, group.roll, helix.roll),
        )
        places = _numbers(
            f"{where}: the position of helix {index}",
            [getattr(of, axis) for of in (group.position, position) for axis in "xyz"],
        )
        shape = (
            geometry.rise_per_base_pair / UNIT_NM,
            2 * np.pi / geometry.bases_per_turn,
            np.radians(geometry.minor_groove_angle),
        )
        rows.append((index, *places, *angles, *shape))
    table = np.array(rows, dtype=np.float64)
    return _oriented(table[:, 0].astype(np.int64), table[:, 1:7], table[:, 7:11], table[:, 11:])


def _oriented(index: NDArray[np.int64], places: Array, angles: Array, shape: Array) -> Helices:
    from scipy.spatial.transform import Rotation

    yaw, pitch, roll, own_roll = angles.T
    # scadnano turns a group by yaw, pitch and roll, about axes that turn with it
    group = Rotation.from_euler("YXZ", np.column_stack([yaw, -pitch, roll]), degrees=True)
    helix = Rotation.from_euler(
        "YXZ", np.column_stack([yaw, -pitch, roll + own_roll]), degrees=True
    )
    return Helices(
        index=index,
        origin=(places[:, :3] + group.apply(places[:, 3:])) / UNIT_NM,
        direction=group.apply([0.0, 0.0, 1.0]),
        up=helix.apply([0.0, -1.0, 0.0]),
        rise=shape[:, 0],
        turn=shape[:, 1],
        groove=shape[:, 2],
    )


def _numbers(what: str, values: Any) -> list[float]:
    for value in values:
        real = isinstance(value, int | float) and not isinstance(value, bool)
        if not real or not abs(value) < 1e9:
            raise StructureError(f"{what} has {shown(value)}; it must be a number below 10⁹")
    return [float(value) for value in values]


def _check_geometry(what: str, geometry: Any) -> None:
    _numbers(what, geometry.values())
    rise, turn = geometry.rise_per_base_pair, geometry.bases_per_turn
    for name, value in (("rise_per_base_pair", rise), ("bases_per_turn", turn)):
        if value <= 0:
            raise StructureError(f"{what}: {name} is {value:g}; it must be above 0")
    length = helix_bond(rise / UNIT_NM, 2 * np.pi / turn)
    if not BOND_SHORTEST < length < BOND_LONGEST:
        raise StructureError(
            f"{what}: a rise of {rise:g} nm and {turn:g} bases per turn make every bond"
            f" {length:.4f} long; oxDNA's are {BOND_SHORTEST:.4f} to {BOND_LONGEST:.4f}"
        )


def helix_bond(rise: float, turn: float) -> float:
    """Length of the bonds along a helix of the model.

    Parameters
    ----------
    rise, turn : float
        Per base; oxDNA's units and radians.

    Returns
    -------
    float
        oxDNA's units.

    Examples
    --------
    >>> round(helix_bond(0.332 / UNIT_NM, 2 * np.pi / 10.5), 4)
    0.7066
    """
    plain = np.array([[1.0, 0, 0]]), np.array([[0.0, 0, 1]])
    site = backbone_sites(-HELIX_RADIUS * plain[0], *plain)[0]
    chord = 2 * float(np.linalg.norm(site)) * np.sin(turn / 2)
    return float(np.hypot(chord, rise))
