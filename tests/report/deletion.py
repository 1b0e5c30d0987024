"""Nucleotides taken out of a file, and the changes that put the very same atoms back."""

import io

import gemmi
from gemmi import cif

from loopelastica.report.compose import AddedResidue, Changes

_BACKBONE = {"P", "C4'", "C4*"}


def structure_of(text, kind):
    if kind == "mmcif":
        return gemmi.make_structure_from_block(cif.read_string(text).sole_block())
    return gemmi.read_pdb_string(text)


def draw_strands(structure, rng, n_strands=3, longest=4):
    """Inner stretches of nucleotides of one location each: (chain, [(number, icode)])."""
    chains = []
    for chain in structure[0]:
        inner = [r for r in chain if _is_nucleotide(r) and all(a.altloc == "\0" for a in r)]
        numbers = [_number(r) for r in inner]
        every = [_number(r) for r in chain]
        # where a protein has the same numbers, these do not say what to take out
        if len(set(every)) == len(every) and len(numbers) > 2:
            chains.append((chain.name, numbers))
    strands = []
    for _ in range(n_strands if chains else 0):
        chain, numbers = rng.choice(chains)
        first = rng.randrange(1, len(numbers) - 1)
        last = min(first + rng.randrange(1, longest + 1), len(numbers) - 1)
        strands.append((chain, numbers[first:last]))
    return strands


def put_back(structure, strands, **more):
    """The changes that add these residues to every model."""
    gone = {(chain, *number) for chain, numbers in strands for number in numbers}
    added = []
    for index, model in enumerate(structure):
        for chain in model:
            before = None
            for residue in chain:
                place = (chain.name, *_number(residue))
                if place in gone:
                    added.append(_added(index, place, residue, before))
                if _is_nucleotide(residue):
                    before = place
    return Changes(added=tuple(added), **more)


def _added(model, place, residue, before):
    return AddedResidue(
        model,
        *place,
        residue.name,
        before,
        tuple(a.name for a in residue),
        tuple(a.element.name for a in residue),
        [a.pos.tolist() for a in residue],
        [a.occ for a in residue],
        [a.b_iso for a in residue],
    )


def without_pdb(text, strands):
    """PDB text without these residues; CONECT records that name their atoms go too."""
    gone = {(chain, *number) for chain, numbers in strands for number in numbers}
    out, serials = [], set()
    for line in io.StringIO(text, newline=""):
        is_atom = line.startswith(("ATOM", "HETATM", "ANISOU"))
        if is_atom and (line[21].strip(), int(line[22:26]), line[26].strip()) in gone:
            serials.add(line[6:11].strip())
            continue
        fields = {line[k : k + 5].strip() for k in range(6, 31, 5)} - {""}
        if not (line.startswith("CONECT") and fields & serials):
            out.append(line)
    return "".join(out)


def without_cif(text, strands):
    """mmCIF text without these residues in the tables of atoms."""
    gone = {(chain, str(n), icode or "?") for chain, numbers in strands for n, icode in numbers}
    document = cif.read_string(text)
    block = document.sole_block()
    names = ["id", "auth_asym_id", "auth_seq_id", "pdbx_PDB_ins_code"]
    lost = {row[0] for row in block.find("_atom_site.", names) if tuple(row)[1:] in gone}
    for category in ("_atom_site.", "_atom_site_anisotrop."):
        table = block.find(category, ["id"])
        for k in reversed([k for k, row in enumerate(table) if row[0] in lost]):
            table.remove_row(k)
    return document.as_string()


def _number(residue):
    return residue.seqid.num, residue.seqid.icode.strip()


def _is_nucleotide(residue):
    return any(a.name in _BACKBONE for a in residue)
