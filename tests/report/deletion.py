"""Nucleotides taken out of a file, and the changes that put the very same atoms back."""

from __future__ import annotations

import io
import random

import gemmi
from gemmi import cif

from loopelastica.report.compose import AddedResidue, Changes

SUGAR = {"C4'", "C4*"}


def structure_of(text, kind):
    if kind == "mmcif":
        return gemmi.make_structure_from_block(cif.read_string(text).sole_block())
    return gemmi.read_pdb_string(text)


def runs_to_delete(structure, rng, n_strands=3, longest=4):
    """Inner stretches of nucleotides without alternate locations: (chain, [(number, icode)])."""
    out = []
    for chain in structure[0]:
        inner = [
            residue
            for residue in chain
            if any(a.name in SUGAR for a in residue) and all(a.altloc == "\0" for a in residue)
        ]
        numbers = [(r.seqid.num, r.seqid.icode.strip()) for r in inner]
        if len(set(numbers)) == len(numbers) > 2:
            out.append((chain.name, numbers))
    strands = []
    for _ in range(n_strands):
        chain, numbers = rng.choice(out)
        first = rng.randrange(1, len(numbers) - 1)
        last = min(first + rng.randrange(1, longest + 1), len(numbers) - 1)
        strands.append((chain, numbers[first:last]))
    return strands


def put_back(structure, strands, *, asym=False):
    """The changes that add these residues, model by model, in random-free file order."""
    gone = {(chain, *number) for chain, numbers in strands for number in numbers}
    added = []
    for model_index, model in enumerate(structure):
        for chain in model:
            before = None
            for residue in chain:
                number = (residue.seqid.num, residue.seqid.icode.strip())
                if (chain.name, *number) in gone:
                    added.append(
                        AddedResidue(
                            model=model_index,
                            chain=chain.name,
                            number=number[0],
                            icode=number[1],
                            resname=residue.name,
                            after=before,
                            names=tuple(a.name for a in residue),
                            elements=tuple(a.element.name for a in residue),
                            positions_A=[a.pos.tolist() for a in residue],
                            occupancy=[a.occ for a in residue],
                            b_factor_A2=[a.b_iso for a in residue],
                            asym=residue.subchain if asym else None,
                        )
                    )
                if any(a.name in SUGAR for a in residue):
                    before = (chain.name, *number)
    return added


def without_pdb(text, strands):
    """PDB text without these residues; CONECT records that name them go too."""
    gone = {(chain, *number) for chain, numbers in strands for number in numbers}
    out, serials = [], set()
    for line in io.StringIO(text, newline=""):
        if line.startswith(("ATOM", "HETATM", "ANISOU")):
            key = (line[21].strip(), int(line[22:26]), line[26].strip())
            if key in gone:
                serials.add(line[6:11].strip())
                continue
        fields = {line[k : k + 5].strip() for k in range(6, 31, 5)} - {""}
        if line.startswith("CONECT") and fields & serials:
            continue
        out.append(line)
    return "".join(out)


def without_cif(text, strands):
    """mmCIF text without these residues in the table of atoms."""
    gone = {(chain, str(num), icode or "?") for chain, ns in strands for num, icode in ns}
    document = cif.read_string(text)
    block = document.sole_block()
    loop = block.find_loop("_atom_site.id").get_loop()
    values, width = loop.values, loop.width()
    tags = [tag.split(".")[1] for tag in loop.tags]
    columns = {tag: values[k::width] for k, tag in enumerate(tags)}
    names = ("auth_asym_id", "auth_seq_id", "pdbx_PDB_ins_code")
    keys = list(zip(*(columns[name] for name in names), strict=True))
    keep = [key not in gone for key in keys]
    lost = {i for i, kept in zip(columns["id"], keep, strict=True) if not kept}
    loop.set_all_values([[v for v, k in zip(c, keep, strict=True) if k] for c in columns.values()])
    aniso = block.find("_atom_site_anisotrop.", ["id"])
    for k in reversed(range(len(aniso))):
        if aniso[k][0] in lost:
            aniso.remove_row(k)
    return document.as_string()


def changes_for(structure, strands, rng=None, **more):
    added = put_back(structure, strands, asym=more.pop("asym", False))
    if rng is not None:
        random.Random(rng.random()).shuffle(added)
    return Changes(added=tuple(added), **more)
