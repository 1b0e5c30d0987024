"""Files of a loop with atoms: atoms.pdb, atoms.cif, loop.sdf, atoms.json.

The full structure is written with one MODEL per candidate, in their order. A candidate whose atoms
are not sound (a wrong hand, a broken chain, a contact below 2.2 Å) is left out and reported in
atoms.json. All atoms but the loop's keep number, name and coordinates. Hydrogens of the file's own
loop are gone with it: a model has heavy atoms. Waters within 3 Å of any model are left out, for
they were placed around the file's own loop. Names are today's wwPDB names; a modified nucleotide
that cannot be built is written as its parent.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica.atoms.model import AtomModel
from loopelastica.atoms.site import elements, waters
from loopelastica.folding.fold import LoopFold
from loopelastica.molecule.nucleotides import Structure
from loopelastica.molecule.reading import quiet

_WATER_A: Final = 3.0
_LAST_SERIAL: Final = 99_999


@dataclass(frozen=True, slots=True, eq=False)
class LoopAtoms:
    """All that the files need.

    Attributes
    ----------
    structure : Structure
    fold : LoopFold
    models : tuple of AtomModel
    positions : (n_atoms, 3) array
        Of all atoms of the structure, Å; those of the loop may be anything.
    """

    structure: Structure
    fold: LoopFold
    models: tuple[AtomModel, ...]
    positions: Array

    @property
    def written(self) -> tuple[AtomModel, ...]:
        """The sound models; the others are only reported."""
        return tuple(model for model in self.models if model.checks.sound)

    def columns(self, rank: int) -> dict[str, Any]:
        """What a row of ranking.csv says about the atoms of one candidate; empty cells if none."""
        found = next((m for m in self.models if m.rank == rank), None)
        if found is None:
            return dict.fromkeys(_COLUMNS)
        c = found.checks
        values = (
            found.relaxed.message,
            c.sound,
            found.rmsd_A,
            c.bonds_within,
            c.angles_within,
            c.chain_worst_A,
            c.closest_A,
            c.clashes_per_1000,
            c.line_after_A,
        )
        return dict(zip(_COLUMNS, values, strict=True))

    def sticks(self, rank: int) -> Array | None:
        """Bonds (m, 2, 3) of one candidate's atoms in the coordinates of the file, Å."""
        found = next((m for m in self.models if m.rank == rank), None)
        return None if found is None else found.positions_A[np.array(found.molecule.bonds)]


_COLUMNS: Final = (
    "atoms_status",
    "atoms_sound",
    "atoms_rmsd_A",
    "atoms_bonds_within",
    "atoms_angles_within",
    "atoms_chain_worst_A",
    "atoms_closest_A",
    "atoms_clashes_per_1000",
    "atoms_line_A",
)


def write_atoms(folder: Path, atoms: LoopAtoms) -> None:
    """Write the files of one loop into a folder.

    atoms.cif only where gemmi is installed; where no model is sound, atoms.json alone says so.
    """
    content = report(atoms)
    (folder / "atoms.json").write_text(
        json.dumps(content, indent=1, allow_nan=False, ensure_ascii=False) + "\n", encoding="utf-8"
    )
    if not atoms.written:
        return
    write_pdb(folder / "atoms.pdb", atoms)
    write_sdf(folder / "loop.sdf", atoms.written)
    try:
        import gemmi
    except ImportError:
        return
    structure = gemmi.read_pdb(str(folder / "atoms.pdb"))
    structure.setup_entities()
    structure.make_mmcif_document().write_file(str(folder / "atoms.cif"))


def write_pdb(path: Path, atoms: LoopAtoms) -> None:
    """The full structure with one MODEL per candidate."""
    import MDAnalysis as mda

    universe, loop, kept = _universe(atoms)
    bonds = "all" if len(universe.atoms) <= _LAST_SERIAL else None
    with (
        quiet(),
        mda.Writer(str(path), n_atoms=len(universe.atoms), multiframe=True, bonds=bonds) as writer,
    ):
        for model in atoms.written:
            positions = np.empty((len(universe.atoms), 3))
            positions[loop] = model.positions_A[model.molecule.loop_atoms]
            positions[~loop] = atoms.positions[kept]
            universe.atoms.positions = positions
            writer.write(universe.atoms)


def write_sdf(path: Path, models: Sequence[AtomModel]) -> None:
    """The loop and the atoms of the stem it is bonded to, with bond orders and charges."""
    from rdkit import Chem
    from rdkit.Geometry import Point3D

    with Chem.SDWriter(str(path)) as writer:
        for model in models:
            mol = Chem.Mol(model.molecule.mol)
            conformer = Chem.Conformer(mol.GetNumAtoms())
            for row, at in enumerate(model.positions_A.tolist()):
                conformer.SetAtomPosition(row, Point3D(*at))
            mol.AddConformer(conformer)
            mol.SetProp("_Name", f"candidate {model.rank}")
            mol.SetProp("sequence", "".join(r.letter for r in model.molecule.residues))
            mol.SetProp("status", model.relaxed.message)
            names = (
                f"{residue}:{name}"
                for residue, name in zip(model.molecule.residue, model.molecule.names, strict=True)
            )
            mol.SetProp("atoms", " ".join(names))
            writer.write(mol)


def report(atoms: LoopAtoms) -> dict[str, Any]:
    """The content of atoms.json."""
    table, hairpin = atoms.structure.nucleotides, atoms.fold.hairpin
    built = atoms.models[0].molecule.residues if atoms.models else ()
    return {
        "nucleotides": [
            {"file": table.label(int(row)), "built": residue.standard}
            for row, residue in zip(hairpin.loop, built, strict=False)
        ],
        # ranks of the MODELs of atoms.pdb, in their order
        "models": [model.rank for model in atoms.written],
        "candidates": [
            {
                "rank": model.rank,
                "status": model.relaxed.message,
                "steps": model.relaxed.steps,
                "cost": model.relaxed.cost,
                "rmsd_A": model.rmsd_A,
                "omega_deg": model.turns.omega_deg,
                "chi_change_deg": model.turns.chi_change_deg,
                "score": model.turns.score,
                "alternatives": [
                    {
                        "omega_deg": other.omega_deg,
                        "chi_change_deg": other.chi_change_deg,
                        "score": other.score,
                    }
                    for other in model.alternatives
                ],
                "checks": model.checks.to_dict(),
            }
            for model in atoms.models
        ],
    }


def _universe(atoms: LoopAtoms) -> tuple[Any, NDArray[np.bool_], NDArray[np.int64]]:
    """Universe of the output, which of its atoms are the loop's, and the file rows of the rest."""
    import MDAnalysis as mda

    source, molecule = atoms.structure.universe, atoms.models[0].molecule
    table, hairpin = atoms.structure.nucleotides, atoms.fold.hairpin
    c1 = table.columns(["C1'"])[hairpin.loop, 0]
    loop_residues = source.atoms.resindices[c1].tolist()
    keep = ~np.isin(source.atoms.resindices, loop_residues) & ~_displaced(atoms)
    kept = np.flatnonzero(keep)
    rows: list[tuple[int, int]] = [(int(source.atoms.resindices[i]), int(i)) for i in kept]
    # −1 − r stands for row r of the molecule
    rows += [(loop_residues[molecule.residue[r]], -1 - r) for r in molecule.loop_atoms]
    rows.sort(key=lambda row: row[0])
    residues, resindex = np.unique([r for r, _ in rows], return_inverse=True)
    origin = np.array([i for _, i in rows])
    loop = origin < 0
    old = np.where(loop, 0, origin)
    names = np.array(molecule.names, dtype=object)
    symbols = np.array([a.GetSymbol() for a in molecule.mol.GetAtoms()], dtype=object)
    own = np.where(loop, -1 - origin, 0)

    def atom(attribute: str, default: Any, of_loop: Any) -> Any:
        values = getattr(source.atoms, attribute, np.full(len(source.atoms), default, dtype=object))
        return np.where(loop, of_loop, np.asarray(values, dtype=object)[old])

    def residue(attribute: str, default: Any) -> Any:
        values = getattr(source.residues, attribute, None)
        return (
            np.full(len(residues), default, dtype=object)
            if values is None
            else np.asarray(values, dtype=object)[residues]
        )

    resname = residue("resnames", "UNK")
    for place, built in zip(loop_residues, molecule.residues, strict=True):
        if built.renamed:
            resname[np.flatnonzero(residues == place)[0]] = built.standard
    segments, segindex = np.unique(source.residues.segindices[residues], return_inverse=True)
    with quiet():
        universe = mda.Universe.empty(
            len(rows),
            n_residues=len(residues),
            n_segments=len(segments),
            atom_resindex=resindex,
            residue_segindex=segindex,
            trajectory=True,
        )
        symbol = np.where(loop, symbols[own], np.char.capitalize(elements(atoms.structure))[old])
        for name, values in {
            "name": np.where(loop, names[own], np.asarray(source.atoms.names, dtype=object)[old]),
            "element": atom("elements", "", symbol)
            if hasattr(source.atoms, "elements")
            else symbol,
            "type": symbol,
            "record_type": atom("record_types", "ATOM", "ATOM"),
            "altLoc": atom("altLocs", "", ""),
            "occupancy": atom("occupancies", 1.0, 1.0).astype(float),
            "tempfactor": atom("tempfactors", 0.0, 0.0).astype(float),
            "chainID": atom("chainIDs", "", hairpin.chain[:1]),
            "resname": resname,
            "resid": residue("resids", 1).astype(int),
            "icode": residue("icodes", ""),
            "segid": source.segments.segids[segments],
            "bonds": _bonds(atoms, loop, own, old),
        }.items():
            universe.add_TopologyAttr(name, list(values))
    return universe, loop, origin[~loop]


def _bonds(
    atoms: LoopAtoms, loop: NDArray[np.bool_], own: NDArray[np.int64], old: NDArray[np.int64]
) -> list[tuple[int, int]]:
    """Bonds with a loop atom in them, in rows of the output."""
    molecule, table = atoms.models[0].molecule, atoms.structure.nucleotides
    place = {int(own[row]): int(row) for row in np.flatnonzero(loop)}
    where = {int(old[row]): int(row) for row in np.flatnonzero(~loop)}
    closing = {-1: int(atoms.fold.hairpin.stem_5[0])}
    closing[len(molecule.residues)] = int(atoms.fold.hairpin.stem_3[0])
    for row, (residue, name) in enumerate(zip(molecule.residue, molecule.names, strict=True)):
        if residue in closing:
            place[row] = where[int(table.columns([name])[closing[residue], 0])]
    mine = set(molecule.loop_atoms)
    return [(place[i], place[j]) for i, j in molecule.bonds if i in mine or j in mine]


def _displaced(atoms: LoopAtoms) -> NDArray[np.bool_]:
    """Waters in the way of any model; the whole molecule goes."""
    from scipy.spatial import cKDTree

    water = np.flatnonzero(waters(atoms.structure))
    out = np.zeros(len(atoms.positions), dtype=np.bool_)
    if len(water) == 0:
        return out
    loop = np.concatenate([m.positions_A[m.molecule.loop_atoms] for m in atoms.written])
    near = cKDTree(loop).query(atoms.positions[water], distance_upper_bound=_WATER_A)[0]
    resindices = atoms.structure.universe.atoms.resindices
    gone = np.unique(resindices[water[np.isfinite(near)]])
    out[water] = np.isin(resindices[water], gone)
    return out
