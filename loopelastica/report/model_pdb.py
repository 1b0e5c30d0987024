"""The PDB file of a loop's models.

It holds what the format has room for: serial numbers up to 99,999, since not all programs read
hybrid-36, and chains of one letter. Where there is no room, the mmCIF file alone has the models.
CONECT records give all bonds of the modelled nucleotides, junctions and hydrogens included: OpenMM,
RDKit, gemmi and biotite need them for modified ones only and take no harm from the others.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from typing import Final

from loopelastica.atoms.model import AtomModel
from loopelastica.errors import StructureError
from loopelastica.report.model_notes import Source, notes, title
from loopelastica.report.model_structure import ModelStructure
from loopelastica.report.pdb import cell_record, chain_letters, renamed_records
from loopelastica.report.pdb_lines import LAST_SERIAL, fits_columns

_NUMBERS: Final = range(-999, 10_000)
_MOST_CHAINS: Final = 62
_TITLE: Final = 69


def pdb_text(
    structure: ModelStructure, models: Sequence[AtomModel], source: Source, single: bool = False
) -> str:
    """Text of a PDB file with models.

    Parameters
    ----------
    structure : ModelStructure
    models : sequence of AtomModel
        Some of the sound ones.
    source : Path, str or None
        The file, or the sequence, that the structure is from.
    single : bool
        Whether the one model is written without a MODEL record.

    Returns
    -------
    str

    Raises
    ------
    StructureError
        If the format cannot hold the atoms.
    """
    obstacle = no_room(structure)
    if obstacle:
        raise StructureError(f"the PDB format cannot hold the models: {obstacle}; mmCIF can")
    lines = list(_header(structure, models, source))
    for number, model in enumerate(models, start=1):
        body = _body(structure, model)
        lines += body if single else [f"MODEL     {number:4d}", *body, "ENDMDL"]
    return "\n".join([*lines, *_connections(structure), "END", ""])


def no_room(structure: ModelStructure) -> str:
    """Why the PDB format cannot hold the atoms; "" where it can.

    Parameters
    ----------
    structure : ModelStructure

    Returns
    -------
    str
    """
    atoms = structure.atoms
    serials = len(structure.rows) + len(structure.polymer_ends)
    if serials > LAST_SERIAL:
        return f"it needs {serials:,} serial numbers, and there are {LAST_SERIAL:,}"
    chains = {part[0].chain for part in structure.parts} - {""}
    if len(chains) > _MOST_CHAINS:
        return f"there are {len(chains)} chains, and letters for {_MOST_CHAINS}"
    for residue in atoms.assembly.residues:
        if residue.number not in _NUMBERS:
            return f"the number of {residue.label} is not from -999 to 9999"
        names = atoms.names_of(residue)
        if len(names[0]) > 4 or any(len(name) > 4 for name in names[1]):
            return f"names of {residue.label} have more than four letters"
    kept = [atom.in_file for _, atom in structure.rows if atom.in_file is not None]
    places = [atoms.positions[kept], *(model.positions_A for model in atoms.written)]
    far = next((at for at in places if not fits_columns((at.min(), at.max()))), None)
    return "" if far is None else "coordinates have more than four digits before the point"


def _header(
    structure: ModelStructure, models: Sequence[AtomModel], source: Source
) -> Iterator[str]:
    atoms = structure.atoms
    yield f"HEADER    {atoms.fold.hairpin.kind}"
    for k, line in enumerate(textwrap.wrap(title(atoms, source), _TITLE), start=1):
        yield f"TITLE     {line}" if k == 1 else f"TITLE   {k:2d} {line}"
    for note in notes(atoms, models, source):
        yield f"REMARK  99 {note}"
    letters = _letters(structure)
    yield from renamed_records({part[0].chain: letters[part[0].chain] for part in structure.parts})
    yield from cell_record(atoms.assembly.origin)


def _letters(structure: ModelStructure) -> dict[str, str]:
    # without a name of its own a chain has none, even if its segment has one
    return {**chain_letters(structure.atoms.structure), "": ""}


def _body(structure: ModelStructure, model: AtomModel) -> list[str]:
    """Records of the atoms of one model."""
    import gemmi

    structure.place(model)
    letters = _letters(structure)
    structure.call_chains([letters[part[0].chain] for part in structure.parts])
    options = gemmi.PdbWriteOptions(minimal=True)
    options.cryst1_record = False
    lines: list[str] = structure.gemmi.make_pdb_string(options).splitlines()
    names = [structure.atoms.names_of(residue)[0] for residue in structure.atoms.assembly.residues]
    if all(len(name) <= 3 for name in names):
        return lines
    # gemmi cuts a fourth letter off, which programs write into the column that is left free
    of_atoms = [
        name
        for name, residue in zip(names, structure.atoms.assembly.residues, strict=True)
        for _ in residue.atoms
    ]
    out, k = [], -1
    for line in lines:
        k += line.startswith(("ATOM", "HETATM"))
        out.append(f"{line[:17]}{of_atoms[k]:>3}{line[17 + max(len(of_atoms[k]), 3) :]}")
    return out


def _connections(structure: ModelStructure) -> Iterator[str]:
    """CONECT records of the modelled bonds, from both of their ends."""
    ends = set(structure.polymer_ends)
    serials, last = [], 0
    for k in range(len(structure.rows)):
        last += 1
        serials.append(last)
        # TER has a number too
        last += k in ends
    partners: dict[int, set[int]] = {}
    for i, j in structure.bonds():
        partners.setdefault(serials[i], set()).add(serials[j])
        partners.setdefault(serials[j], set()).add(serials[i])
    for one in sorted(partners):
        others = sorted(partners[one])
        for k in range(0, len(others), 4):
            yield f"CONECT{one:5d}{''.join(f'{other:5d}' for other in others[k : k + 4])}"
