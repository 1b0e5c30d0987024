"""A nanostructure for viewers: an atom per nucleotide, a chain per strand, colours of the design.

PDB and mmCIF by gemmi; a PyMOL script; and the format of oxView (file-format.md of
sulcgroup/oxdna-viewer), which holds colours and base pairs too.
"""

from __future__ import annotations

import json
import string
from collections import defaultdict
from collections.abc import Iterator
from typing import Any, Final

import gemmi
import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica._version import __version__
from loopelastica.errors import StructureError
from loopelastica.nanostructures.nanostructure import Nanostructure
from loopelastica.nanostructures.oxdna.files import box_of
from loopelastica.nanostructures.oxdna.model import UNIT_NM, backbone_sites
from loopelastica.nanostructures.oxdna.topology import written_order
from loopelastica.nanostructures.system import System

_SIGNS: Final = string.ascii_uppercase + string.ascii_lowercase + string.digits
_MOST_RESIDUES: Final = 9_999
_MOST_ATOMS: Final = 99_999
# what fits into eight columns with three decimals
_LEAST_A, _MOST_A = -999.0, 9_999.0
LAID_B: Final = 100.0
"""B factor of nucleotides that were laid; of all others it is 0."""
_LAID_COLOUR: Final = "D55E00"


def chain_name(index: int) -> str:
    """Name of a strand's chain: one sign for the first 62, then two and more.

    >>> [chain_name(i) for i in (0, 61, 62, 3905, 3906)]
    ['A', '9', 'AA', '99', 'AAA']
    """
    name = ""
    index += 1
    while index:
        index, sign = divmod(index - 1, len(_SIGNS))
        name = _SIGNS[sign] + name
    return name


def trace(found: Nanostructure) -> gemmi.Structure:
    """The backbone sites as atoms P, strand by strand from 5' to 3'.

    Parameters
    ----------
    found : Nanostructure
        All nucleotides have a place.

    Returns
    -------
    gemmi.Structure
        In Å; B factors are :data:`LAID_B` where a single strand was laid, else 0.
    """
    system = found.system
    points = backbone_sites(system.centre, system.a1, system.a3) * (10 * UNIT_NM)
    laid = _laid(found)
    names = _residues(system)
    structure = gemmi.Structure()
    structure.name = "trace"
    structure.info["_struct.title"] = (
        "Coarse trace of a nanostructure: backbone sites of oxDNA as atoms P, B factor"
        f" {LAID_B:g} where a single strand was laid"
    )
    structure.info["_software.name"] = f"loopelastica {__version__}"
    chains = [gemmi.Chain(chain_name(k)) for k in range(len(system.strand_name))]
    order, strand = _order(system), system.strand.tolist()
    for i in order:
        chain = chains[strand[i]]
        residue = gemmi.Residue()
        residue.name = names[i]
        residue.seqid = gemmi.SeqId(len(chain) + 1, " ")
        residue.entity_type = gemmi.EntityType.Polymer
        residue.add_atom(_atom(points[i], LAID_B if laid[i] else 0.0))
        chain.add_residue(residue)
    model = gemmi.Model(1)
    for chain in chains:
        model.add_chain(chain)
    structure.add_model(model)
    structure.setup_entities()
    structure.assign_label_seq_id()
    return structure


def _atom(point: Array, b_iso: float) -> gemmi.Atom:
    atom = gemmi.Atom()
    atom.name = "P"
    atom.element = gemmi.Element("P")
    atom.pos = gemmi.Position(*point)
    atom.b_iso = b_iso
    return atom


def _laid(found: Nanostructure) -> Any:
    laid = np.zeros(len(found.system), dtype=bool)
    for strand in found.strands:
        if strand.status == "laid":
            laid[strand.nucleotides] = True
    return laid


def _residues(system: System) -> list[str]:
    """Names of residues; a base that is none of four is one of no name."""
    rna = system.rna[system.strand].tolist()
    return [
        ("" if is_rna else "D") + (base if base in "ACGTU" else "N")
        for base, is_rna in zip(system.base.tolist(), rna, strict=True)
    ]


def _order(system: System) -> list[int]:
    try:
        order = written_order(system, "new")
    except StructureError:  # a strand in pieces is in the order of its file
        order = np.arange(len(system))
    return list(map(int, order))


def mmcif_text(structure: gemmi.Structure) -> str:
    """The trace as mmCIF."""
    return str(structure.make_mmcif_document().as_string())


def pdb_text(structure: gemmi.Structure) -> str | None:
    """The trace as PDB; None where that format does not hold it."""
    chains = list(structure[0])
    box = structure.calculate_box()
    fits = (
        len(chains) <= len(_SIGNS)
        and all(len(chain) <= _MOST_RESIDUES for chain in chains)
        # with a TER for each chain
        and sum(len(chain) + 1 for chain in chains) <= _MOST_ATOMS
        and all(x > _LEAST_A for x in box.minimum.tolist())
        and all(x < _MOST_A for x in box.maximum.tolist())
    )
    # there is no cell, and its placeholder warns
    options = gemmi.PdbWriteOptions(cryst1_record=False)
    return str(structure.make_pdb_string(options)) if fits else None


def pymol_text(found: Nanostructure, trace_file: str) -> str:
    """A PyMOL script: tubes along the strands, in the colours of the design where it has any.

    Parameters
    ----------
    found : Nanostructure
    trace_file : str
        Name of the trace in the folder of the script; of harmless signs.

    Returns
    -------
    str
    """
    chains = defaultdict(list)
    for k, colour in enumerate(found.system.colour):
        chains[colour.removeprefix("#")].append(chain_name(k))
    lines = [
        f"# loopelastica {__version__}: single strands between the helices of a nanostructure.",
        "# Run it in this folder.",
        "set ignore_case_chain, 0",
        f"load {trace_file}, trace",
        "hide everything",
        "bg_color white",
        "set cartoon_trace_atoms, 1",
        "set cartoon_tube_radius, 1.5",
        "cartoon tube",
        "show cartoon",
        "color grey70",
    ]
    for colour, names in chains.items():
        if colour:
            lines.append(f"color 0x{colour}, chain {'+'.join(names)}")
    if not any(chains.keys()):
        lines.append(f"color 0x{_LAID_COLOUR}, b > {LAID_B / 2:g}")
    lines += [f"select laid, b > {LAID_B / 2:g}", "deselect", "orient"]
    return "\n".join([*lines, ""])


def oxview_text(found: Nanostructure, line: NDArray[np.int64]) -> str:
    """The nanostructure in the format of oxView, with base pairs and colours.

    Parameters
    ----------
    found : Nanostructure
    line : (n,) array of int
        Line of each nucleotide in the configuration, which is its number in oxView too, so that a
        trajectory fits.

    Returns
    -------
    str
    """
    system = found.system
    # of each nucleotide, and −1 for none
    number = np.append(line, -1)
    box = system.box if (system.box > 0).all() else box_of(system)
    monomers: list[list[dict[str, Any]]] = [[] for _ in system.strand_name]
    strand = system.strand.tolist()
    columns = zip(
        system.base.tolist(),
        *(np.round(x, 9).tolist() for x in (system.centre, system.a1, system.a3)),
        *(number[x].tolist() for x in (system.n3, system.n5, system.pair)),
        strict=True,
    )
    rows = list(columns)
    for i in _order(system):
        base, p, a1, a3, n3, n5, pair = rows[i]
        neighbours = {"n3": n3, "n5": n5, "bp": pair}
        monomer = {
            "id": int(line[i]),
            "type": base,
            "class": "RNA" if system.rna[strand[i]] else "DNA",
            "p": p,
            "a1": a1,
            "a3": a3,
            **{name: other for name, other in neighbours.items() if other >= 0},
            "cluster": 1,
        }
        colour = system.colour[strand[i]]
        if colour:
            monomer["color"] = int(colour.removeprefix("#"), 16)
        monomers[strand[i]].append(monomer)
    content = {
        "box": box.tolist(),
        "systems": [{"id": 0, "strands": list(_oxview_strands(monomers))}],
    }
    return json.dumps(content, allow_nan=False, separators=(",", ":")) + "\n"


def _oxview_strands(monomers: list[list[dict[str, Any]]]) -> Iterator[dict[str, Any]]:
    for k, own in enumerate(monomers):
        ends = {"end5": own[0]["id"], "end3": own[-1]["id"]}
        yield {"id": k, "class": "NucleicAcidStrand", **ends, "monomers": own}
