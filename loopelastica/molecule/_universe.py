"""A Universe or an AtomGroup as the text of a file: PDB, or mmCIF where it does not fit."""

from __future__ import annotations

from typing import Any

import gemmi
import numpy as np

from loopelastica.errors import StructureError
from loopelastica.molecule._recognition import chains_of, strings

_MOST_SERIAL = 99_999
_NUMBERS = range(-999, 10_000)
_SMALLEST_A, _LARGEST_A = -999.999, 9999.999


def text_of(source: Any) -> tuple[str, str]:
    """Format ("pdb" or "mmcif") and text of the atoms in the current frame.

    Parameters
    ----------
    source : MDAnalysis.Universe or MDAnalysis.AtomGroup
        Atoms need names; chains, insertion codes, alternative locations, occupancies, B factors,
        elements may be absent.

    Raises
    ------
    StructureError
        If it has no atoms, names or coordinates.
    """
    atoms = source.atoms.unique
    if len(atoms) == 0:
        raise StructureError("universe: it has no atoms")
    if not hasattr(atoms.universe, "trajectory"):
        raise StructureError("universe: it has no coordinates")
    if not hasattr(atoms, "names"):
        raise StructureError("universe: the atoms have no names")
    structure = _structure(atoms)
    if _fits(structure):
        options = gemmi.PdbWriteOptions(minimal=True, ter_records=False)
        return "pdb", structure.make_pdb_string(options)
    structure.setup_entities()
    groups = gemmi.MmcifOutputGroups(False, atoms=True, group_pdb=True, auth_all=True)
    return "mmcif", structure.make_mmcif_document(groups).as_string()


def _structure(atoms: Any) -> Any:
    structure, model = gemmi.Structure(), gemmi.Model(1)
    # single precision has no more decimals than these
    positions = np.round(np.asarray(atoms.positions, dtype=np.float64), 3)
    names, chains = strings(atoms, "names"), chains_of(atoms)
    elements, altlocs = strings(atoms, "elements"), strings(atoms, "altLocs")
    occupancies = np.asarray(getattr(atoms, "occupancies", np.ones(len(atoms))), dtype=float)
    b_factors = np.asarray(getattr(atoms, "tempfactors", np.zeros(len(atoms))), dtype=float)
    records = strings(atoms, "record_types")
    resnames, icodes = strings(atoms, "resnames"), strings(atoms, "icodes")
    resids, resindices = np.asarray(atoms.resids), np.asarray(atoms.resindices)
    chain: Any = None
    residue: Any = None
    last = None
    for k in range(len(atoms)):
        if chain is None or chain.name != chains[k]:
            chain, last = gemmi.Chain(chains[k]), None
            model.add_chain(chain)
            chain = model[-1]
        if last != resindices[k]:
            last = resindices[k]
            residue = gemmi.Residue()
            residue.name = resnames[k] or "UNK"
            residue.seqid = gemmi.SeqId(int(resids[k]), icodes[k] or " ")
            residue.het_flag = "H" if records[k] == "HETATM" else "A"
            chain.add_residue(residue)
            residue = chain[-1]
        atom = gemmi.Atom()
        atom.name = names[k]
        atom.pos = gemmi.Position(*positions[k])
        atom.element = gemmi.Element(elements[k])
        atom.altloc = altlocs[k] or "\0"
        atom.occ, atom.b_iso = occupancies[k], b_factors[k]
        residue.add_atom(atom)
    structure.add_model(model)
    structure.name = "universe"
    return structure


def _fits(structure: Any) -> bool:
    """Whether the columns of the PDB format are wide enough."""
    flat = gemmi.FlatStructure(structure)
    return (
        len(flat.resnums) <= _MOST_SERIAL
        and bool(((flat.pos >= _SMALLEST_A) & (flat.pos <= _LARGEST_A)).all())
        and all(
            len(chain.name) <= 1
            and len(residue.name) <= 3
            and residue.seqid.num in _NUMBERS
            and all(len(atom.name) <= 4 for atom in residue)
            for chain in structure[0]
            for residue in chain
        )
    )
