"""The mmCIF file of a loop's models."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

from loopelastica._files import PROGRAM
from loopelastica._version import __version__
from loopelastica.atoms.model import AtomModel
from loopelastica.report.cif_categories import add_remark, add_software, raw
from loopelastica.report.model_notes import MODEL_COLUMNS, Source, model_values, notes, title
from loopelastica.report.model_structure import ModelStructure

_CATEGORIES: Final = (
    *("entry", "block_name", "title_keywords", "atom_type"),
    *("entity", "entity_poly", "entity_poly_seq", "struct_asym"),
)


def cif_text(
    structure: ModelStructure, models: Sequence[AtomModel], source: Source, name: str = "atoms"
) -> str:
    """Text of an mmCIF file with models.

    Parameters
    ----------
    structure : ModelStructure
    models : sequence of AtomModel
        Some of the sound ones.
    source : Path, str or None
        The file, or the sequence, that the structure is from.
    name : str
        Of the data block.

    Returns
    -------
    str
    """
    import gemmi

    atoms, held = structure.atoms, structure.gemmi
    structure.call_chains(structure.long_names)
    held.name = name
    held.info["_struct.title"] = title(atoms, source)
    groups = gemmi.MmcifOutputGroups(False)
    for category in _CATEGORIES:
        setattr(groups, category, True)
    groups.cell = groups.symmetry = atoms.assembly.origin.cell is not None
    document = held.make_mmcif_document(groups)
    block = document.sole_block()
    add_software(block, PROGRAM, __version__)
    add_remark(block, notes(atoms, models, source))
    table = block.init_mmcif_loop("_loopelastica_model.", list(MODEL_COLUMNS))
    for number, model in enumerate(models, start=1):
        values = model_values(atoms, model, number)
        table.add_row(["?" if value is None else raw(value) for value in values])
    parts = [document.as_string().rstrip(), ""]
    for number, model in enumerate(models, start=1):
        head, rows = _atom_site(structure, model, number)
        parts += [head, rows] if number == 1 else [rows]
    return "\n".join([*parts, ""])


def _atom_site(structure: ModelStructure, model: AtomModel, number: int) -> tuple[str, str]:
    """Head and rows of the table of atoms for one model; ids go on from model to model."""
    import gemmi

    structure.place(model)
    groups = gemmi.MmcifOutputGroups(False, atoms=True, group_pdb=True, auth_all=True)
    document = structure.gemmi.make_mmcif_document(groups)
    loop: Any = document.sole_block().find_loop("_atom_site.id").get_loop()
    n, width = loop.length(), loop.width()
    values = loop.values
    columns = [values[k::width] for k in range(width)]
    columns[loop.tags.index("_atom_site.id")] = [str(n * (number - 1) + k + 1) for k in range(n)]
    columns[loop.tags.index("_atom_site.pdbx_PDB_model_num")] = [str(number)] * n
    loop.set_all_values(columns)
    text: str = document.as_string()
    begin, last = text.index("loop_"), text.rindex("\n_atom_site.")
    end = text.index("\n", last + 1)
    return text[begin:end], text[end:].strip()
