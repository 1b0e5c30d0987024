"""Which way bases look: from the backbone site to the base, and the axes that follow.

A nucleotide is laid as its backbone site, the direction from there to its base, and the tangent of
its strand. The normal a3 is against the tangent, as far as the direction allows.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from loopelastica._arrays import Array
from loopelastica._vectors import unit
from loopelastica.nanostructures.laying.ends import across
from loopelastica.nanostructures.oxdna.model import BACKBONE_A1, BACKBONE_A2, BASE_A1, centre_of
from loopelastica.nanostructures.oxdna.periodic import nearest_image

_ALONG: Final = BASE_A1 - BACKBONE_A1
REACH: Final = float(np.hypot(_ALONG, BACKBONE_A2))
"""Distance of the base site from the backbone site, oxDNA's units."""
_COS: Final = _ALONG / REACH
_SIN: Final = BACKBONE_A2 / REACH
# directions about the strand that are looked at
_WAYS: Final = 24
MIDDLE: Final = float(-BACKBONE_A1 * _COS + BACKBONE_A2 * _SIN) / REACH
"""Where the centre is beside the line from backbone to base, as a share of it."""


def base_directions(a1: Array, a3: Array) -> Array:
    """Unit vectors (m, 3) from backbone sites to base sites, of axes (m, 3)."""
    return np.asarray(_COS * a1 - _SIN * np.cross(a3, a1))


def axes_of(direction: Array, tangent: Array) -> tuple[Array, Array]:
    """Axes of nucleotides.

    Parameters
    ----------
    direction : (m, 3) array
        Unit vectors from backbone sites to base sites.
    tangent : (m, 3) array
        Of the strand from 5' to 3', of any length.

    Returns
    -------
    a1, a3 : (m, 3) array
        Perpendicular unit vectors, from which :func:`base_directions` gives `direction` back.
    """
    direction = unit(direction)
    a3 = across(-tangent, direction)
    a1 = across(_COS * direction + _SIN * np.cross(a3, direction), a3)
    return a1, a3


def turned_apart(site: Array, direction: Array, tangent: Array, others: Array, box: Array) -> Array:
    """Direction (3,) about a strand in which a centre is furthest from others.

    Parameters
    ----------
    site, direction, tangent : (3,) array
        Of the nucleotide, as for :func:`axes_of`.
    others : (m, 3) array
        Centres to keep away from.
    box : (3,) array
        Sides of the periodic box; 0 where there is none.
    """
    normal = unit(tangent)
    first = across(direction[None], normal[None])[0]
    angle = 2 * np.pi * np.arange(_WAYS)[:, None] / _WAYS
    ways = np.cos(angle) * first + np.sin(angle) * np.cross(normal, first)
    centres = centre_of(site, *axes_of(ways, np.tile(tangent, (_WAYS, 1))))
    apart = nearest_image(others[None] - centres[:, None], box)
    room = np.linalg.norm(apart, axis=2).min(axis=1)
    return np.asarray(ways[int(np.argmax(room))])
