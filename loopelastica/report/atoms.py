"""Files of a loop with atoms: atoms.pdb, atoms.cif, loop.sdf, atoms.json.

The full structure is written with one MODEL per candidate, in their order. A candidate whose atoms
are not sound is left out and reported in atoms.json. All atoms but the loop's keep number, name and
coordinates; those of the loop have the error to expect as B factor. Names are today's wwPDB names,
or those of a force field; a modified nucleotide that cannot be built is written as its parent.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Final

import numpy as np

from loopelastica._arrays import Array
from loopelastica._files import write_json, write_text
from loopelastica.atoms.conventions import check_names, conventional
from loopelastica.atoms.model import AtomModel
from loopelastica.folding.result import LoopFold
from loopelastica.molecule.nucleotides import Structure
from loopelastica.report.assembly import Assembly, Residue, assemble
from loopelastica.report.model_cif import cif_text
from loopelastica.report.model_notes import Source, because, sentences
from loopelastica.report.model_pdb import no_room, pdb_text
from loopelastica.report.model_structure import ModelStructure
from loopelastica.report.pdb import pdb_name
from loopelastica.report.protonation import protonate, with_5_phosphates
from loopelastica.report.records import ATOMS_COLUMNS
from loopelastica.report.sdf import write_sdf


@dataclass(frozen=True, eq=False)
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
    hydrogens : bool
        Whether nucleotides have hydrogens; otherwise nothing in the files has.
    names : {"pdb", "amber", "charmm"}
        Whose names nucleotides and their atoms have.
    no_5_phosphate : bool
        Whether phosphates at 5' ends are taken off.
    separate : bool
        Whether each candidate has files of its own too.
    """

    structure: Structure
    fold: LoopFold
    models: tuple[AtomModel, ...]
    positions: Array
    contact: str | None = None
    hydrogens: bool = False
    names: str = "pdb"
    no_5_phosphate: bool = False
    separate: bool = False

    def __post_init__(self) -> None:
        check_names("names", self.names)

    @property
    def written(self) -> tuple[AtomModel, ...]:
        """The sound models; the others are only reported."""
        return tuple(model for model in self.models if model.checks.sound)

    @cached_property
    def assembly(self) -> Assembly:
        """The atoms of the files; ValueError where no model is sound."""
        if not self.written:
            raise ValueError("`models` has no sound one; there is nothing to write")
        assembly = assemble(self)
        with_5_phosphates(assembly, self)
        if self.hydrogens:
            protonate(assembly, self)
        return assembly

    @cached_property
    def held(self) -> ModelStructure:
        """The same as gemmi holds them."""
        return ModelStructure(self)

    @cached_property
    def remarks(self) -> tuple[str, ...]:
        """One sentence for each thing that a user should be aware of."""
        found = [*sentences(self)]
        if self.written:
            found += self.assembly.remarks
            if why := no_room(self.held):
                found.append(f"atoms.pdb is not written, since {why}; atoms.cif has the models")
        return tuple(found)

    def names_of(self, residue: Residue) -> tuple[str, list[str]]:
        """Name of a residue in the files, and of its atoms.

        Parameters
        ----------
        residue : Residue
            One of the assembly's.

        Returns
        -------
        str, list of str
        """
        names = [atom.name for atom in residue.atoms]
        if residue.nucleotide is None or self.names == "pdb":
            return pdb_name(residue.name), [pdb_name(name) for name in names]
        five, three = self.assembly.bonded[residue.nucleotide].tolist()
        own, of_atoms = conventional(
            residue.monomer(), residue.is_dna, names, not five, not three, self.names
        )
        return pdb_name(own), [pdb_name(name) for name in of_atoms]

    def options(self) -> dict[str, Any]:
        """What determines the files beside the fold, JSON-ready."""
        names = ("contact", "hydrogens", "names", "no_5_phosphate", "separate")
        return {name: getattr(self, name) for name in names}

    def columns(self, rank: int) -> dict[str, Any]:
        """The columns of ranking.csv on the atoms of one candidate; empty cells if it has none."""
        found = next((m for m in self.models if m.rank == rank), None)
        return {n: None if found is None else value(found) for n, value in _COLUMNS.items()}

    def figures(self, rank: int) -> dict[str, Any]:
        """Of these columns the few that the table of a run has, and why a model is not sound."""
        columns = self.columns(rank)
        return {name: columns[name] for name in (*ATOMS_COLUMNS, "atoms_not_sound_because")}

    def sticks(self, rank: int) -> Array | None:
        """Bonds (m, 2, 3) of one candidate's atoms in the coordinates of the file, Å."""
        found = next((m for m in self.models if m.rank == rank), None)
        return None if found is None else found.positions_A[np.array(found.molecule.bonds)]


_COLUMNS: Final[dict[str, Callable[[AtomModel], Any]]] = {
    "atoms_status": lambda model: model.relaxed.message,
    "atoms_sound": lambda model: model.checks.sound,
    "atoms_not_sound_because": because,
    "atoms_rmsd_A": lambda model: model.rmsd_A,
    "atoms_worst_bond_A": lambda model: model.checks.worst_bond_A,
    "atoms_worst_angle_deg": lambda model: model.checks.worst_angle_deg,
    "atoms_closest_A": lambda model: model.checks.closest_A,
    "atoms_contact_A": lambda model: model.checks.contact_A,
    "atoms_bonds_within": lambda model: model.checks.bonds_within,
    "atoms_angles_within": lambda model: model.checks.angles_within,
    "atoms_chain_worst_A": lambda model: model.checks.chain_worst_A,
    "atoms_clashes_per_1000": lambda model: model.checks.clashes_per_1000,
    "atoms_line_A": lambda model: model.checks.line_after_A,
}


def model_row(model: AtomModel) -> dict[str, Any]:
    """The row of a model in tables: ``rank``, ``sound``, and what was measured on its atoms."""
    columns = {name.removeprefix("atoms_"): value(model) for name, value in _COLUMNS.items()}
    return {"rank": model.rank, **columns}


def write_atoms(folder: Path, atoms: LoopAtoms, source: Source = None) -> None:
    """Write the files of one loop into a folder.

    Where no model is sound, atoms.json alone says so; where the PDB format has no room for the
    structure, there is no atoms.pdb.

    Parameters
    ----------
    folder : Path
        Where they go.
    atoms : LoopAtoms
        What they show.
    source : Path or str, optional
        The file, or the sequence, that the structure is from; default: its own file.
    """
    write_json(folder / "atoms.json", content(atoms))
    if not atoms.written:
        return
    source = _source(atoms, source)
    has_pdb = not no_room(atoms.held)
    if has_pdb:
        write_text(folder / "atoms.pdb", pdb_text(atoms.held, atoms.written, source))
    write_text(folder / "atoms.cif", cif_text(atoms.held, atoms.written, source))
    write_sdf(folder / "loop.sdf", atoms.written)
    for model in atoms.written if atoms.separate else ():
        name = f"atoms_{model.rank}"
        if has_pdb:
            text = pdb_text(atoms.held, [model], source, single=True)
            write_text(folder / f"{name}.pdb", text)
        write_text(folder / f"{name}.cif", cif_text(atoms.held, [model], source, name))


def write_pdb(path: Path, atoms: LoopAtoms, source: Source = None) -> None:
    """Write the full structure in PDB format, a MODEL per candidate.

    Parameters
    ----------
    path : Path
        The file.
    atoms : LoopAtoms
        With at least one sound model.
    source : Path or str, optional
        As for :func:`write_atoms`.

    Raises
    ------
    StructureError
        If the format cannot hold the atoms.
    """
    write_text(path, pdb_text(atoms.held, atoms.written, _source(atoms, source)))


def write_cif(path: Path, atoms: LoopAtoms, source: Source = None) -> None:
    """Write the full structure as mmCIF, a model per candidate.

    Parameters
    ----------
    path : Path
        The file.
    atoms : LoopAtoms
        With at least one sound model.
    source : Path or str, optional
        As for :func:`write_atoms`.
    """
    write_text(path, cif_text(atoms.held, atoms.written, _source(atoms, source)))


def _source(atoms: LoopAtoms, source: Source) -> Source:
    own = atoms.structure.source
    return Path(own) if source is None and own is not None else source


def content(atoms: LoopAtoms) -> dict[str, Any]:
    """The content of atoms.json."""
    table, hairpin = atoms.structure.nucleotides, atoms.fold.hairpin
    built = atoms.models[0].molecule.residues if atoms.models else ()
    return {
        "nucleotides": [
            {"file": table.label(int(row)), "built": residue.standard}
            for row, residue in zip(hairpin.loop, built, strict=False)
        ],
        **atoms.options(),
        # ranks of the MODELs of atoms.pdb, in their order
        "models": [model.rank for model in atoms.written],
        "remarks": list(atoms.remarks),
        "candidates": [
            {
                "rank": model.rank,
                "status": model.relaxed.message,
                "sound": model.checks.sound,
                "not_sound_because": list(model.checks.wrong),
                "worst_bond_A": model.checks.worst_bond_A,
                "worst_angle_deg": model.checks.worst_angle_deg,
                "closest_contact_A": model.checks.closest_A,
                "contact_A": model.checks.contact_A,
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
