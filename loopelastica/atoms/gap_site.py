"""The site of a gap: its molecule with the flanks, what is fixed, what is around."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from loopelastica._arrays import Array
from loopelastica.atoms.carry import Curve
from loopelastica.atoms.chemistry import (
    JUNCTION_3,
    JUNCTION_5,
    LoopMolecule,
    Residue,
    atom_names,
    strand_molecule,
)
from loopelastica.atoms.geometry import sorts
from loopelastica.atoms.site import GRID_A, NEIGHBOURHOOD_A, NOBODY, Around, Site, placed
from loopelastica.errors import StructureError
from loopelastica.molecule.nucleotides import BACKBONE, RING
from loopelastica.molecule.polymer import Gap, HeavyAtoms, Monomer

PHOSPHATE: Final = ("P", "OP1", "OP2")
_SAME_A: Final = 1e-3
_NAMED: Final = "ACGUT"
_SUGAR: Final = ("OP1", "OP2", "C1'", "C2'", "O4'")


@dataclass(frozen=True, slots=True, eq=False)
class LocalCurve:
    """A curve of the file's coordinates in the frame of a site."""

    curve: Curve
    origin: Array
    frame: Array

    def at(self, phases: ArrayLike) -> tuple[Array, Array]:
        """Points (m, 3) and frames (m, 3, 3) at the phases (m,)."""
        points, frames = self.curve.at(phases)
        return (
            np.round((points - self.origin) @ self.frame, GRID_A),
            np.round(self.frame.T @ frames, GRID_A),
        )


def numbered(gap: Gap) -> dict[int, Monomer]:
    """Nucleotides by their number in the molecule, 5' to 3', from those beyond the flanks."""
    n = len(gap.monomers)
    found = {-2: gap.beyond_5, -1: gap.before, n: gap.after, n + 1: gap.beyond_3}
    found |= dict(enumerate(gap.monomers))
    return {k: found[k] for k in sorted(found) if found[k] is not None}  # type: ignore[misc]


def gap_site(gap: Gap, line: Curve, atoms: HeavyAtoms) -> Site:
    """The site of a gap.

    Parameters
    ----------
    gap : Gap
    line : Curve
        In the coordinates of the file.
    atoms : HeavyAtoms
        Of the whole model.

    Returns
    -------
    Site

    Raises
    ------
    StructureError
        If a base is unknown, or a flank cannot be joined.
    """
    monomers = numbered(gap)
    n = len(gap.monomers)
    there = {k: _there(monomer) for k, monomer in monomers.items()}
    molecule = strand_molecule(
        {k: part for k, part in _parts(monomers, there, n).items() if part[1] != ()}, n
    )
    file_A = np.full((len(molecule.names), 3), np.nan)
    for (k, name), row in molecule.rows.items():
        file_A[row] = there[k].get(name, np.nan)
    if np.isfinite(file_A).all():
        raise StructureError(f"{gap.name}: no atom is missing; there is nothing to build")
    origin, frame = _local_frame(gap, there)
    around, rings = _around(molecule, file_A, there, line, atoms, origin, frame)
    labels = {k: monomer.label for k, monomer in monomers.items()}
    return placed(molecule, file_A, around, rings, origin, frame, labels)


def _there(monomer: Monomer) -> dict[str, Array]:
    return {
        name: np.asarray(at, dtype=np.float64)
        for name, at in monomer.atoms_A.items()
        if np.isfinite(at).all()
    }


def _parts(
    monomers: Mapping[int, Monomer], there: Mapping[int, Mapping[str, Array]], n: int
) -> dict[int, tuple[Residue, Collection[str] | None]]:
    """What each nucleotide is and which of its atoms belong to the molecule."""
    parts: dict[int, tuple[Residue, Collection[str] | None]] = {}
    for k, monomer in monomers.items():
        if 0 <= k < n and monomer.letter not in _NAMED:
            raise StructureError(f"{monomer.label}: its base is unknown; the strand gets no atoms")
        known = monomer.letter in _NAMED
        kind = Residue(monomer.letter if known else "U", monomer.is_dna, monomer.resname)
        whole = atom_names(kind)
        if k in (-2, n + 1):
            # only for the bond outwards
            names = tuple(x for x in (JUNCTION_5 if k < 0 else JUNCTION_3) if x in there[k])
            bonded = ("O3'" if k < 0 else "P") in names
            parts[k] = kind, names if bonded else ()
            continue
        names = whole
        if not 0 <= k < n and (kind.renamed or not known):
            # what the base of a modified flank lacks is not known, nor what its sugar carries
            names = tuple(x for x in whole if x in there[k] or x in (*BACKBONE, *_SUGAR))
            if not known:
                names = tuple(x for x in names if x in PHOSPHATE or "'" in x)
        if "P" not in there[k] and not _bonded_5(k, monomers, there, n):
            # no phosphate is invented at a 5' end
            names = tuple(x for x in names if x not in PHOSPHATE)
        parts[k] = kind, names
    return parts


def _bonded_5(
    k: int, monomers: Mapping[int, Monomer], there: Mapping[int, Mapping[str, Array]], n: int
) -> bool:
    """Whether a nucleotide before k is there, or will be, for its phosphate to be bonded to."""
    if k - 1 not in monomers:
        return False
    return k - 1 >= -1 or "O3'" in there[k - 1]


def _local_frame(gap: Gap, there: Mapping[int, Mapping[str, Array]]) -> tuple[Array, Array]:
    """A frame that moves with the structure: of a flank's backbone."""
    for k in (-1, len(gap.monomers), *range(len(gap.monomers))):
        atoms = there.get(k, {})
        places = [atoms[name] for name in ("C4'", "C3'", "C5'", *BACKBONE) if name in atoms]
        if len(places) < 3:
            continue
        x = places[1] - places[0]
        z = np.cross(x, places[2] - places[0])
        if np.linalg.norm(z) > 0.1:
            x, z = x / np.linalg.norm(x), z / np.linalg.norm(z)
            return places[0], np.stack([x, np.cross(z, x), z], axis=1)
    raise StructureError(
        f"{gap.name}: no nucleotide of the strand or beside it has three atoms of its backbone; the"
        " strand gets no atoms"
    )


def _around(
    molecule: LoopMolecule,
    file_A: Array,
    there: Mapping[int, Mapping[str, Array]],
    line: Curve,
    atoms: HeavyAtoms,
    origin: Array,
    frame: Array,
) -> tuple[Around, Array]:
    """What is near the strand and no part of its molecule; six-membered rings of the flanks."""
    from scipy.spatial import cKDTree

    n = molecule.n
    places = np.concatenate([line.at(np.arange(0.5, n + 0.75, 0.25))[0],
                             file_A[np.isfinite(file_A).all(axis=1)]])  # fmt: skip
    candidates = ~atoms.water & np.isfinite(atoms.positions_A).all(axis=1)
    rows = np.flatnonzero(candidates)
    near = cKDTree(places).query(atoms.positions_A[rows], distance_upper_bound=NEIGHBOURHOOD_A)[0]
    rows = rows[np.isfinite(near)]
    # an atom is one of ours if it stands in the same place: labels need not be unique
    owners = [k for k in there for _ in there[k]]
    ours = cKDTree(np.array([at for k in there for at in there[k].values()]).reshape(-1, 3))
    apart, which = ours.query(atoms.positions_A[rows], distance_upper_bound=_SAME_A)
    owner_of: dict[int, int] = {}
    for row, place in zip(rows[np.isfinite(apart)], which[np.isfinite(apart)], strict=True):
        owner_of.setdefault(int(atoms.residue[row]), owners[place])
    fixed = cKDTree(file_A[np.isfinite(file_A).all(axis=1)])
    known = np.isfinite(fixed.query(atoms.positions_A[rows], distance_upper_bound=_SAME_A)[0])
    rows = rows[~known]
    metal = atoms.metal[rows]
    around = Around(
        np.round((atoms.positions_A[rows] - origin) @ frame, GRID_A),
        np.where(
            metal, 0, sorts(np.char.upper(atoms.element[rows]).tolist(), atoms.name[rows].tolist())
        ),
        metal,
        np.array([owner_of.get(int(r), NOBODY) for r in atoms.residue[rows]], dtype=np.int64),
        np.array(
            [f"{atoms.labels[atoms.residue[r]]}:{atoms.name[r]}" for r in rows], dtype=np.str_
        ),
    )
    rings = [
        [there[k].get(name, np.full(3, np.nan)) for name in RING] for k in (-1, n) if k in there
    ]
    local = (np.array(rings).reshape(-1, len(RING), 3) - origin) @ frame
    return around, np.round(local, GRID_A)
