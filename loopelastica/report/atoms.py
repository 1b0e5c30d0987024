"""Files of a loop with atoms: atoms.pdb, atoms.cif, loop.sdf, atoms.json.

The full structure is written with one MODEL per candidate, in their order. A candidate whose atoms
are not sound (a wrong hand, a bond off by 0.05 Å, an angle off by 10°, a contact below 2.2 Å, no
convergence) is left out and reported in atoms.json. All atoms but the loop's keep number, name and
coordinates; those of the loop have the error to expect as B factor. Hydrogens of the file's own
loop are gone with it: a model has heavy atoms. Waters within 3 Å of any model are left out, for
they were placed around the file's own loop. Names are today's wwPDB names; a modified nucleotide
that cannot be built is written as its parent.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica._files import write_json, write_text
from loopelastica.atoms.model import AtomModel
from loopelastica.folding.result import LoopFold
from loopelastica.molecule.neighbours import elements, waters
from loopelastica.molecule.nucleotides import Structure
from loopelastica.molecule.reading import quiet
from loopelastica.report.pdb import b_factor, expected_notes, pdb_name

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
    contact : str or None
        The pair that was sought, as in :func:`build_atoms`.
    """

    structure: Structure
    fold: LoopFold
    models: tuple[AtomModel, ...]
    positions: Array
    contact: str | None = None

    @property
    def written(self) -> tuple[AtomModel, ...]:
        """The sound models; the others are only reported."""
        return tuple(model for model in self.models if model.checks.sound)

    def columns(self, rank: int) -> dict[str, Any]:
        """The columns of ranking.csv on the atoms of one candidate; empty cells if it has none."""
        found = next((m for m in self.models if m.rank == rank), None)
        return {n: None if found is None else value(found) for n, value in _COLUMNS.items()}

    def sticks(self, rank: int) -> Array | None:
        """Bonds (m, 2, 3) of one candidate's atoms in the coordinates of the file, Å."""
        found = next((m for m in self.models if m.rank == rank), None)
        return None if found is None else found.positions_A[np.array(found.molecule.bonds)]


_COLUMNS: Final[dict[str, Callable[[AtomModel], Any]]] = {
    "atoms_status": lambda model: model.relaxed.message,
    "atoms_sound": lambda model: model.checks.sound,
    "atoms_rmsd_A": lambda model: model.rmsd_A,
    "atoms_bonds_within": lambda model: model.checks.bonds_within,
    "atoms_angles_within": lambda model: model.checks.angles_within,
    "atoms_chain_worst_A": lambda model: model.checks.chain_worst_A,
    "atoms_closest_A": lambda model: model.checks.closest_A,
    "atoms_clashes_per_1000": lambda model: model.checks.clashes_per_1000,
    "atoms_line_A": lambda model: model.checks.line_after_A,
}


def write_atoms(folder: Path, atoms: LoopAtoms) -> None:
    """Write the files of one loop into a folder.

    atoms.cif only where gemmi is installed; where no model is sound, atoms.json alone says so.

    Parameters
    ----------
    folder : Path
        Where they go.
    atoms : LoopAtoms
        What they show.
    """
    write_json(folder / "atoms.json", content(atoms))
    if not atoms.written:
        return
    write_pdb(folder / "atoms.pdb", atoms)
    write_sdf(folder / "loop.sdf", atoms.written)
    try:
        import gemmi
    except ImportError:
        return
    structure = gemmi.read_pdb_string((folder / "atoms.pdb").read_text(encoding="ascii"))
    structure.name = "atoms"
    structure.setup_entities()
    write_text(folder / "atoms.cif", structure.make_mmcif_document().as_string())


def write_pdb(path: Path, atoms: LoopAtoms) -> None:
    """Write the full structure with one MODEL per candidate.

    Parameters
    ----------
    path : Path
        The file.
    atoms : LoopAtoms
        With at least one sound model.
    """
    import MDAnalysis as mda

    rows = _rows(atoms)
    universe = _universe(atoms, rows)
    bonds = "all" if len(universe.atoms) <= _LAST_SERIAL else None
    with (
        quiet(),
        mda.Writer(str(path), n_atoms=len(universe.atoms), multiframe=True, bonds=bonds) as writer,
    ):
        chosen = {candidate.rank: candidate for candidate in atoms.fold.candidates}
        candidates = [chosen[model.rank] for model in atoms.written]
        universe.trajectory.remarks = expected_notes(candidates)
        b_factors = universe.atoms.tempfactors
        for model, candidate in zip(atoms.written, candidates, strict=True):
            expected = b_factor(float(candidate.expected_rmsd_A[1]))
            universe.atoms.tempfactors = np.where(rows.is_loop, expected, b_factors)
            universe.atoms.positions = np.where(
                rows.is_loop[:, None],
                model.positions_A[rows.in_loop],
                atoms.positions[rows.in_file],
            )
            writer.write(universe.atoms)


def write_sdf(path: Path, models: Sequence[AtomModel]) -> None:
    """Write the loop and the atoms of the stem it is bonded to, with bond orders and charges.

    Parameters
    ----------
    path : Path
        The file.
    models : sequence of AtomModel
        A record each.
    """
    from rdkit import Chem
    from rdkit.Geometry import Point3D

    stream = io.StringIO()
    with Chem.SDWriter(stream) as writer:
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
    write_text(path, stream.getvalue())


def content(atoms: LoopAtoms) -> dict[str, Any]:
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
                **asdict(model.turns),
                "alternatives": [asdict(other) for other in model.alternatives],
                "checks": model.checks.to_dict(),
            }
            for model in atoms.models
        ],
    }


@dataclass(frozen=True, slots=True, eq=False)
class _Rows:
    """Atoms of the output: which are the loop's, and where each comes from.

    `residue` (n,) is their residue in the structure; `in_file` (n,) and `in_loop` (n,) are rows of
    the structure's atoms and of the molecule, of which `is_loop` (n,) says which one counts.
    """

    residue: NDArray[np.int64]
    is_loop: NDArray[np.bool_]
    in_file: NDArray[np.int64]
    in_loop: NDArray[np.int64]
    loop_residues: list[int]


def _rows(atoms: LoopAtoms) -> _Rows:
    source, molecule = atoms.structure.universe.atoms, atoms.models[0].molecule
    c1 = atoms.structure.nucleotides.columns(["C1'"])[atoms.fold.hairpin.loop, 0]
    loop_residues = source.resindices[c1].tolist()
    kept = np.flatnonzero(~np.isin(source.resindices, loop_residues) & ~_displaced(atoms))
    # −1 − r stands for row r of the molecule
    rows: list[tuple[int, int]] = [(int(source.resindices[i]), int(i)) for i in kept]
    rows += [(loop_residues[molecule.residue[r]], -1 - r) for r in molecule.loop_atoms]
    rows.sort(key=lambda row: row[0])
    residue, origin = np.array(rows, dtype=np.int64).T
    is_loop = origin < 0
    return _Rows(
        residue,
        is_loop,
        np.where(is_loop, 0, origin),
        np.where(is_loop, -1 - origin, 0),
        loop_residues,
    )


def _universe(atoms: LoopAtoms, rows: _Rows) -> Any:
    """Universe of the output, without coordinates."""
    import MDAnalysis as mda

    source = atoms.structure.universe
    residues, resindex = np.unique(rows.residue, return_inverse=True)
    segments, segindex = np.unique(source.residues.segindices[residues], return_inverse=True)
    with quiet():
        universe = mda.Universe.empty(
            len(rows.residue),
            n_residues=len(residues),
            n_segments=len(segments),
            atom_resindex=resindex,
            residue_segindex=segindex,
            trajectory=True,
        )
        attributes = {
            **_atom_attributes(atoms, rows),
            **_residue_attributes(atoms, rows, residues),
            "segid": source.segments.segids[segments],
            "bonds": _bonds(atoms, rows),
        }
        for name, values in attributes.items():
            universe.add_TopologyAttr(
                name, [pdb_name(v) if isinstance(v, str) else v for v in values]
            )
    return universe


def _atom_attributes(atoms: LoopAtoms, rows: _Rows) -> dict[str, Any]:
    source, molecule = atoms.structure.universe.atoms, atoms.models[0].molecule

    def merged(values: Any, of_loop: Any) -> Any:
        return np.where(rows.is_loop, of_loop, np.asarray(values, dtype=object)[rows.in_file])

    def atom(attribute: str, default: Any) -> Any:
        values = getattr(source, attribute, np.full(len(source), default, dtype=object))
        return merged(values, default)

    names = np.array(molecule.names, dtype=object)[rows.in_loop]
    symbols = np.array([a.GetSymbol() for a in molecule.mol.GetAtoms()], dtype=object)[rows.in_loop]
    symbol = merged(np.char.capitalize(elements(atoms.structure)), symbols)
    own = getattr(source, "elements", None)
    chain = atoms.fold.hairpin.chain[:1]
    return {
        "name": merged(source.names, names),
        "element": symbol if own is None else merged(own, symbol),
        "type": symbol,
        "record_type": atom("record_types", "ATOM"),
        "altLoc": atom("altLocs", ""),
        "occupancy": atom("occupancies", 1.0).astype(float),
        "tempfactor": atom("tempfactors", 0.0).astype(float),
        "chainID": merged(getattr(source, "chainIDs", np.full(len(source), "")), chain),
    }


def _residue_attributes(
    atoms: LoopAtoms, rows: _Rows, residues: NDArray[np.int64]
) -> dict[str, Any]:
    source = atoms.structure.universe.residues

    def residue(attribute: str, default: Any) -> Any:
        values = getattr(source, attribute, np.full(len(source), default, dtype=object))
        return np.asarray(values, dtype=object)[residues]

    resname = residue("resnames", "UNK")
    for place, built in zip(rows.loop_residues, atoms.models[0].molecule.residues, strict=True):
        if built.renamed:
            resname[np.flatnonzero(residues == place)[0]] = built.standard
    resid = residue("resids", 1).astype(int)
    return {"resname": resname, "resid": resid, "icode": residue("icodes", "")}


def _bonds(atoms: LoopAtoms, rows: _Rows) -> list[tuple[int, int]]:
    """Bonds with a loop atom in them, in rows of the output."""
    molecule, table = atoms.models[0].molecule, atoms.structure.nucleotides
    place = {int(rows.in_loop[row]): int(row) for row in np.flatnonzero(rows.is_loop)}
    where = {int(rows.in_file[row]): int(row) for row in np.flatnonzero(~rows.is_loop)}
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
