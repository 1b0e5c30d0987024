"""Single strands on other lines than rods: what exporters do, and what a user could write.

Every line has n + 1 bonds for n nucleotides, from the backbone site of the paired nucleotide before
it to that of the one after it. A straight chord is what exporters draw; an arc has bonds of the
model's unstretched length and is not clamped. Tails go straight on along the helix. The fourth way
is the exporter of scadnano itself.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import redirect_stdout
from dataclasses import replace
from io import StringIO
from typing import Any

import numpy as np

from loopelastica._arrays import Array
from loopelastica._vectors import unit
from loopelastica.nanostructures.laying.ends import across, helix_ends
from loopelastica.nanostructures.laying.laid import LaidStrand
from loopelastica.nanostructures.oxdna.model import BOND_LENGTH, centre_of
from loopelastica.nanostructures.system import System

Line = tuple[Array, Array, Array]
Curve = Callable[[Array, Array, Array, int], Line]


def chord(start: Array, end: Array, outward: Array, bonds: int) -> Line:
    """A straight line with equal spacing.

    Parameters
    ----------
    start, end : (3,) array
        Backbone sites of the paired nucleotides.
    outward : (3,) array
        A direction away from the helices; not used.
    bonds : int
        One more than nucleotides.

    Returns
    -------
    sites, directions, tangents : (bonds − 1, 3) array
        Backbone sites; unit vectors from there to the bases, perpendicular to the tangents; unit
        vectors from 5' to 3'.
    """
    along = unit(end - start)
    side = across(outward[None], along[None])[0]
    sites = start + np.linspace(0.0, 1.0, bonds + 1)[1:-1, None] * (end - start)
    return sites, np.tile(side, (bonds - 1, 1)), np.tile(along, (bonds - 1, 1))


def arc(start: Array, end: Array, outward: Array, bonds: int) -> Line:
    """A circular arc with bonds of unstretched length, bowed outwards; its bases look outwards.

    The arguments and what is returned are those of :func:`chord`, which it is where the ends are
    too far apart for an arc.
    """
    from scipy.optimize import brentq

    distance = float(np.linalg.norm(end - start))
    if distance >= 0.9999 * bonds * BOND_LENGTH:
        return chord(start, end, outward, bonds)

    def missing(turn: float) -> float:
        return float(np.sin(bonds * turn / 2) / np.sin(turn / 2)) - distance / BOND_LENGTH

    # each bond turns by this angle
    turn = brentq(missing, 1e-9, 2 * np.pi / bonds)
    radius = BOND_LENGTH / (2 * np.sin(turn / 2))
    along = unit(end - start)
    up = across(outward[None], along[None])[0]
    angle = (turn * (np.arange(bonds + 1) - bonds / 2))[1:-1, None]
    towards = np.sin(angle) * along + np.cos(angle) * up
    middle = (start + end) / 2 - radius * np.cos(bonds * turn / 2) * up
    return middle + radius * towards, towards, np.cos(angle) * along - np.sin(angle) * up


def on_curves(system: System, strands: tuple[LaidStrand, ...], curve: Curve) -> System:
    """Put single strands on curves.

    Parameters
    ----------
    system : System
        With its helices in place.
    strands : tuple of LaidStrand
        Which ones; where they were laid is not used.
    curve : callable
        :func:`chord` or :func:`arc`.

    Returns
    -------
    System
        Of refused strands no nucleotide has a place.
    """
    centre, a1, a3 = system.centre.copy(), system.a1.copy(), system.a3.copy()
    placed = system.placed.copy()
    for one in strands:
        known = np.array([end for end in (one.before, one.after) if end >= 0])
        if one.status == "refused" or not len(known):
            continue
        ends = helix_ends(system, known)
        bonds = len(one) + 1
        if len(known) == 2:
            outward = ends.frame[0, :, 2] - ends.frame[1, :, 2]
            sites, direction, tangent = curve(ends.point[0], ends.point[1], outward, bonds)
        else:
            sites, direction, tangent = _tail(ends.point[0], ends.frame[0], len(one), one.after < 0)
        rows = one.nucleotides
        a1[rows], a3[rows] = direction, -tangent
        centre[rows] = centre_of(sites, a1[rows], a3[rows])
        placed[rows] = True
    return replace(system, centre=centre, a1=a1, a3=a3, placed=placed)


def _tail(start: Array, frame: Array, n: int, three: bool) -> Line:
    """Straight on along the helix, from its end or to its beginning."""
    steps = BOND_LENGTH * (np.arange(1, n + 1) if three else np.arange(-n, 0))
    sites = start + steps[:, None] * frame[:, 2]
    return sites, np.tile(frame[:, 0], (n, 1)), np.tile(frame[:, 2], (n, 1))


def exported(design: Any, system: System, strands: tuple[LaidStrand, ...]) -> System:
    """What scadnano's own exporter makes of a design.

    Parameters
    ----------
    design : scadnano.Design
    system : System
        The same design as this program reads it.
    strands : tuple of LaidStrand
        The refused ones of them get no place.

    Returns
    -------
    System
        With the exporter's helices too.

    Raises
    ------
    Exception
        Whatever the exporter stumbles over, such as ZeroDivisionError at a hairpin.
    """
    # it prints warnings
    with redirect_stdout(StringIO()):
        configuration, _ = design.to_oxdna_format()
    rows = np.array(
        [[float(word) for word in line.split()[:9]] for line in configuration.splitlines()[3:]]
    )
    placed = np.ones(len(system), dtype=bool)
    for one in strands:
        placed[one.nucleotides] = one.status == "laid"
    return replace(system, centre=rows[:, :3], a1=rows[:, 3:6], a3=rows[:, 6:], placed=placed)
