"""Where single strands leave their helices: the line of backbone sites of the ideal helix there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array, Record
from loopelastica._vectors import perpendicular, unit
from loopelastica.nanostructures.oxdna.energies import separation
from loopelastica.nanostructures.oxdna.model import HELIX_RISE, HELIX_TWIST, backbone_sites
from loopelastica.nanostructures.system import System


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class HelixEnds(Record):
    """Points and frames of the backbone line at paired nucleotides; oxDNA's units.

    Attributes
    ----------
    point : (m, 3) array
        Their backbone sites.
    frame : (m, 3, 3) array
        Columns d1 (towards the helix axis), d2, d3 (tangent from 5' to 3').
    """

    point: Array
    frame: Array


def helix_ends(system: System, index: NDArray[np.int64]) -> HelixEnds:
    """The line of backbone sites at paired nucleotides, in the ideal helix of the model.

    The axis goes through the middle of the pair, along the normals of both bases; the line climbs
    and turns about it as the model's helix does.

    Parameters
    ----------
    system : System
        The nucleotides.
    index : (m,) array of int
        Paired nucleotides.

    Returns
    -------
    HelixEnds
    """
    partner = system.pair[index]
    point = backbone_sites(system.centre[index], system.a1[index], system.a3[index])
    axis = system.a3[partner] - system.a3[index]
    # bases that both look one way have no common axis: their own has to do
    lost = np.linalg.norm(axis, axis=1) < 0.5
    axis[lost] = -2 * system.a3[index[lost]]
    axis = unit(axis)
    middle = 0.5 * separation(system, system.centre[index], system.centre[partner])
    outward = point - system.centre[index] - middle
    outward = perpendicular(outward, axis)
    tangent = unit(HELIX_RISE * axis + HELIX_TWIST * np.cross(axis, outward))
    # outward is perpendicular to the axis and to the turn, so to the tangent as well
    inward = across(-outward, tangent)
    return HelixEnds(point, np.stack([inward, np.cross(tangent, inward), tangent], axis=-1))


def across(vector: Array, normal: Array) -> Array:
    """Unit vectors (m, 3) perpendicular to unit vectors (m, 3), as near to a vector as can be."""
    found = perpendicular(vector, normal)
    short = np.linalg.norm(found, axis=1) < 1e-6 * np.maximum(np.linalg.norm(vector, axis=1), 1e-9)
    if short.any():
        other = np.eye(3)[np.argmin(np.abs(normal[short]), axis=1)]
        found[short] = perpendicular(other, normal[short])
    found = unit(found)
    # once more, or what cancelled would show
    return unit(perpendicular(found, normal))
