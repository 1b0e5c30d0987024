"""The structure that comes back: the text of a file with atoms added, moved and left out.

All other coordinates, names, author numbers and their order stay as they are, to the character.
Serial numbers may change, and whatever refers to them follows.
"""

from __future__ import annotations

from itertools import groupby
from typing import Any, Literal, NamedTuple

from loopelastica.report.changes import AddedResidue, Changes, Removed
from loopelastica.report.compose_cif import compose_cif
from loopelastica.report.compose_pdb import compose_pdb, fits_pdb

__all__ = ["AddedResidue", "Changes", "Composed", "Kind", "Removed", "compose", "fits_pdb"]

Kind = Literal["pdb", "mmcif"]


class Composed(NamedTuple):
    """The text of a structure file, and its format."""

    text: str
    kind: Kind


def compose(content: bytes | str, kind: Kind, changes: Changes) -> Composed:
    r"""The text of a structure file with changes.

    Parameters
    ----------
    content : bytes or str
        The file, decompressed.
    kind : {"pdb", "mmcif"}
        Its format.
    changes : Changes
        Without any the text comes back as it is.

    Returns
    -------
    Composed
        In the format of the input; mmCIF where the PDB format cannot hold the result (more than
        99,999 atoms, a number above 9999, a name of four letters).

    Raises
    ------
    StructureError
        If the changes do not fit the file: they follow a residue, or move an atom, that it has not.

    Examples
    --------
    >>> from loopelastica.report.compose import Changes, compose
    >>> line = "ATOM      1  P     G A   2       1.000   2.000   3.000  1.00  9.00           P\n"
    >>> changes = Changes(moved={(0, "A", 2, "", "P"): (1.5, 2.0, 3.0)})
    >>> print(compose(line, "pdb", changes).text[30:54])
       1.500   2.000   3.000
    """
    text = content if isinstance(content, str) else _decoded(content)
    if not changes:
        return Composed(text, kind)
    # a mark of the byte order is no sign of either format
    text = text.removeprefix("\ufeff")
    if kind == "mmcif":
        return Composed(compose_cif(text, changes), "mmcif")
    composed = compose_pdb(text, changes)
    if composed is not None:
        return Composed(composed, "pdb")
    return Composed(compose_cif(_as_mmcif(text, changes), changes), "mmcif")


def _decoded(content: bytes) -> str:
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:
        return content.decode("latin-1")


def _as_mmcif(text: str, changes: Changes) -> str:
    """A PDB file as mmCIF, with what gemmi keeps of its header."""
    import gemmi

    structure = gemmi.read_pdb_string(text)
    structure.name = dict(structure.info.items()).get("_entry.id", "filled")
    _name_by_segments(structure, {residue.chain for residue in changes.added} - {""})
    structure.setup_entities()
    structure.assign_label_seq_id()
    structure.assign_serial_numbers()
    groups = gemmi.MmcifOutputGroups(True)
    groups.auth_all = True
    # gemmi writes a cell of 1 Å where the file has none
    groups.cell = groups.symmetry = structure.cell.is_crystal()
    document: str = structure.make_mmcif_document(groups).as_string()
    return document


def _name_by_segments(structure: Any, names: set[str]) -> None:
    """Give chains without a name that of their segments, where the changes use it."""
    import gemmi

    for model in structure:
        # copies: gemmi frees those of a chain that goes
        residues = [(chain.name, residue.clone()) for chain in model for residue in chain]
        if not names.intersection(r.segment for name, r in residues if not name):
            continue
        while len(model):
            del model[0]
        for name, of_chain in groupby(residues, key=lambda pair: pair[0] or pair[1].segment):
            chain = gemmi.Chain(name)
            for _, residue in of_chain:
                chain.add_residue(residue)
            model.add_chain(chain)
