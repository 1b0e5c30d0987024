"""What else is there: the heavy atoms of a model, and those of its mates in the crystal."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any, Final

import gemmi
import numpy as np
from numpy.typing import ArrayLike

from loopelastica._arrays import Array, read_only
from loopelastica.molecule.conformers import taken
from loopelastica.molecule.polymer import HeavyAtoms

if TYPE_CHECKING:
    from loopelastica.molecule.entry import Entry

# what gemmi does not take for water: force fields
_WATERS: Final = {"SOL", "TIP", "TIP3", "TIP4", "TIP5", "TP3", "TP4", "TP5", "SPC", "T3P", "T4P"}
_NO_CRYSTAL: Final = re.compile("NMR|ELECTRON MICROSCOPY|THEORETICAL|SOLUTION", re.IGNORECASE)
_SAME_A: Final = 0.01
"""Nearer than this, an image of an atom is the atom itself on its axis of symmetry."""


def heavy_atoms(entry: Entry, model: int = 0) -> HeavyAtoms:
    """All heavy atoms of one model, of alternative locations one.

    Parameters
    ----------
    entry : Entry
        What was read.
    model : int
        Which model, from 0.

    Returns
    -------
    HeavyAtoms

    Raises
    ------
    ValueError
        If there is no such model.
    """
    positions: list[list[float]] = []
    elements: list[str] = []
    names: list[str] = []
    labels: list[str] = []
    places: list[tuple[str, int, str, str]] = []
    residue: list[int] = []
    water: list[bool] = []
    metal: list[bool] = []
    for chain in entry.model(model):
        for one in taken(chain):
            number, code = one.place
            icode = f"^{code}" if code else ""
            prefix = f"{chain.name}." if chain.name else ""
            is_water = one.residue.is_water() or one.residue.name in _WATERS
            for atom in one.atoms:
                positions.append(atom.pos.tolist())
                element = _element(atom, one.residue.name)
                elements.append(element.name.upper())
                names.append(atom.name)
                residue.append(len(labels))
                water.append(is_water)
                metal.append(element.is_metal)
            labels.append(f"{prefix}{one.residue.name}{number}{icode}")
            places.append((chain.name, number, code, one.residue.name))
    return HeavyAtoms(
        positions_A=read_only(np.array(positions).reshape(-1, 3)),
        element=np.array(elements, dtype=np.str_),
        name=np.array(names, dtype=np.str_),
        residue=np.array(residue, dtype=np.int64),
        labels=tuple(labels),
        water=np.array(water, dtype=np.bool_),
        metal=np.array(metal, dtype=np.bool_),
        places=tuple(places),
    )


def _element(atom: Any, resname: str) -> Any:
    """Element by the type symbol, else by the name: an ion has that of its residue."""
    if atom.element.name != "X":
        return atom.element
    name = atom.name.lstrip("0123456789")
    letters = re.match("[A-Za-z]*", name)
    whole = letters[0] if letters else ""
    return gemmi.Element(whole if name == resname else whole[:1])


def symmetry_mates(
    entry: Entry, around_points: ArrayLike, radius: float, atoms: HeavyAtoms | None = None
) -> Array:
    """Heavy atoms of crystal mates near some points, for reports.

    Parameters
    ----------
    entry : Entry
        What was read.
    around_points : (m, 3) array
        Å.
    radius : float
        How near, Å.
    atoms : HeavyAtoms, optional
        Those of the model; by default the first one's.

    Returns
    -------
    (N, 3) array
        Å; waters are left out. Empty where there is no crystal: NMR, electron microscopy, a
        predicted structure, no cell.
    """
    points = np.asarray(around_points, dtype=np.float64).reshape(-1, 3)
    structure = entry.structure
    if not structure.cell.is_crystal() or _NO_CRYSTAL.search(_method(structure)) or not len(points):
        return read_only(np.zeros((0, 3)))
    atoms = heavy_atoms(entry) if atoms is None else atoms
    own = atoms.positions_A[~atoms.water]
    cell = structure.cell
    to_fractional = np.array(cell.frac.mat.tolist())
    to_A = np.array(cell.orth.mat.tolist())
    fractional = own @ to_fractional.T + np.array(cell.frac.vec.tolist())
    low, high = points.min(axis=0) - radius, points.max(axis=0) + radius
    corners = np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, -1).T @ to_fractional.T
    first, last = corners.min(axis=0), corners.max(axis=0)
    found = []
    for image in range(len(cell.images) + 1):
        moved = fractional
        if image:
            operation = cell.images[image - 1]
            rotation, shift = np.array(operation.mat.tolist()), np.array(operation.vec.tolist())
            moved = fractional @ rotation.T + shift
        # every translation that brings an atom into the box around the points
        begin, end = np.floor(first - moved.max(axis=0)), np.ceil(last - moved.min(axis=0))
        for cells in np.ndindex(*(end - begin + 1).astype(int)):
            translation = begin + cells
            if not image and not translation.any():
                continue
            inside = moved + translation
            kept = ((inside >= first) & (inside <= last)).all(axis=1)
            found.append(_near(inside[kept] @ to_A.T, points, radius))
    mates = np.concatenate(found) if found else np.zeros((0, 3))
    return read_only(mates[~_on(mates, _near(own, points, radius + 1.0))])


def _method(structure: Any) -> str:
    info = structure.info
    return str(info["_exptl.method"]) if "_exptl.method" in info else ""


def _near(positions: Array, points: Array, radius: float) -> Array:
    if not len(positions):
        return positions
    distance = np.linalg.norm(positions[:, None] - points, axis=2).min(axis=1)
    return np.asarray(positions[distance <= radius])


def _on(positions: Array, others: Array) -> Any:
    if not len(positions) or not len(others):
        return np.zeros(len(positions), dtype=np.bool_)
    distance = np.linalg.norm(positions[:, None] - others, axis=2).min(axis=1)
    return distance < _SAME_A
