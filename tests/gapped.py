"""Structures with gaps, cut from 2KOC, and what must hold of filled ones, by other programs."""

import warnings
from itertools import pairwise

import gemmi
import numpy as np
from gemmi import cif
from scipy.spatial import cKDTree

from loopelastica._files import data_path

SEQUENCE = "GGCACUUCGGUGCC"
TEXT = data_path("hairpins/2koc.pdb").read_text()
PLACES = [(number, "") for number in range(1, 15)]


def chain(gone=(), name="A", places=PLACES, dna=False, moved=0.0, hydrogens=False, model=1):
    """Atom records of a model of 2KOC without some of its nucleotides.

    Parameters
    ----------
    gone : sequence of int or of (int, str)
        Nucleotides from 1 to 14, or one atom of a nucleotide.
    name : str
        Of the chain.
    places : sequence of (int, str)
        Number and insertion code of each nucleotide.
    dna : bool
        Whether the 2' oxygen goes and the names are those of DNA.
    moved : float
        Along all three axes, Å.
    """
    out = []
    for line in TEXT.split("ENDMDL")[model - 1].splitlines():
        if not line.startswith("ATOM"):
            continue
        k, atom, element = int(line[22:26]), line[12:16].strip(), line[76:78].strip()
        hidden = (element == "H" and not hydrogens) or (dna and atom in ("O2'", "HO2'"))
        if k in gone or (k, atom) in gone or hidden:
            continue
        number, icode = places[k - 1]
        place = "".join(f"{float(line[i : i + 8]) + moved:8.3f}" for i in (30, 38, 46))
        resname = f"{'D' if dna else ' '}{line[19]}"
        out.append(
            f"{line[:17]} {resname} {name or ' '}{number:4d}{icode or ' '}   {place}{line[54:]}"
        )
    return out


def seqres(sequence=SEQUENCE, name="A", dna=False):
    """SEQRES records."""
    names = [f"D{letter}" if dna else letter for letter in sequence]
    lines = []
    for k in range(0, len(names), 13):
        row = " ".join(f"{one:>3}" for one in names[k : k + 13])
        lines.append(f"SEQRES {k // 13 + 1:3d} {name or ' '} {len(names):4d}  {row}")
    return lines


def pdb(path, *models, head=()):
    """Write a PDB file; a model is a list of atom records."""
    lines = list(head)
    for k, atoms in enumerate(models, start=1):
        lines += [f"MODEL     {k:4d}", *atoms, "ENDMDL"] if len(models) > 1 else [*atoms]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join([*lines, "END", ""]))
    return path


def gapped(path, gone, **how):
    """Write 2KOC without some nucleotides, with SEQRES."""
    record = {key: value for key, value in how.items() if key in ("name", "dna")}
    return pdb(path, chain(gone, **how), head=seqres(**record))


def gapped_cif(path, gone):
    """Write it as mmCIF with all categories that speak of the sequence."""
    structure = gemmi.read_pdb_string("\n".join([*seqres(), *chain(), "END", ""]))
    structure.setup_entities()
    structure.assign_label_seq_id()
    groups = gemmi.MmcifOutputGroups(True)
    groups.auth_all = True
    document = structure.make_mmcif_document(groups)
    block = document.sole_block()
    block.name = "X"
    _table(
        block,
        "_pdbx_poly_seq_scheme.",
        *("asym_id", "entity_id", "seq_id", "mon_id", "ndb_seq_num", "pdb_seq_num"),
        *("auth_seq_num", "pdb_mon_id", "auth_mon_id", "pdb_strand_id", "pdb_ins_code", "hetero"),
        rows=[
            [
                *("Axp", "1", str(k), base, str(k), str(k)),
                *(("?", base, "?") if k in gone else (str(k), base, base)),
                *("A", ".", "n"),
            ]
            for k, base in enumerate(SEQUENCE, start=1)
        ],
    )
    _table(
        block,
        "_pdbx_unobs_or_zero_occ_residues.",
        *("id", "PDB_model_num", "polymer_flag", "occupancy_flag", "auth_asym_id"),
        *("auth_comp_id", "auth_seq_id", "PDB_ins_code", "label_asym_id"),
        *("label_comp_id", "label_seq_id"),
        rows=[
            [
                *(str(i), "1", "Y", "1", "A", SEQUENCE[k - 1], str(k), "?"),
                *("Axp", SEQUENCE[k - 1], str(k)),
            ]
            for i, k in enumerate(sorted(gone), start=1)
        ],
    )  # fmt: skip
    column = block.find(["_atom_site.auth_seq_id"])
    for row in reversed(range(len(column))):
        if int(column[row][0]) in gone:
            column.remove_row(row)
    path.write_text(document.as_string())
    return path


def _table(block, prefix, *tags, rows):
    loop = block.init_loop(prefix, list(tags))
    for row in rows:
        loop.add_row(row)


# --- what must hold -------------------------------------------------------------------------------


def rows_of(path):
    """Every atom as it is written, but for its serial."""
    text = path.read_text()
    if path.suffix == ".cif":
        block = cif.read_string(text).sole_block()
        columns = [
            *("group_PDB", "auth_atom_id", "label_alt_id", "auth_comp_id", "auth_asym_id"),
            *("auth_seq_id", "pdbx_PDB_ins_code", "Cartn_x", "Cartn_y", "Cartn_z", "occupancy"),
            *("B_iso_or_equiv", "label_asym_id", "label_seq_id", "pdbx_PDB_model_num"),
        ]
        table = block.find("_atom_site.", columns)
        assert len(table) > 0
        return [tuple(row) for row in table]
    atoms = (line for line in text.splitlines() if line.startswith(("ATOM", "HETATM")))
    return [line[:6] + line[11:80] for line in atoms]


def added_rows(before, after):
    """What is new; all that was there follows in its order, to the character."""
    old, new = iter(rows_of(before)), []
    waiting = next(old, None)
    for row in rows_of(after):
        if row == waiting:
            waiting = next(old, None)
        else:
            new.append(row)
    assert waiting is None, f"gone, changed or in another place: {waiting}"
    return new


def read(path):
    """The file by gemmi, after MDAnalysis and RDKit have read it too."""
    from rdkit import Chem

    structure = gemmi.read_structure(str(path))
    if path.suffix == ".pdb":
        import MDAnalysis as mda

        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            universe = mda.Universe(str(path))
        n_atoms = structure[0].count_atom_sites()
        assert len(universe.atoms) == n_atoms
        molecule = Chem.MolFromPDBBlock(path.read_text().split("ENDMDL")[0], removeHs=False)
        assert molecule is not None
        assert molecule.GetNumAtoms() == n_atoms
    return structure


def neighbours(structure, name="A", model=0):
    """Nucleotides of a chain in the order of the file."""
    found = [residue for one in structure[model] if one.name == name for residue in one]
    return [residue for residue in found if residue.find_atom("C4'", "*")]


def place(residue, atom):
    found = residue.find_atom(atom, "*")
    assert found, f"{residue} has no {atom}"
    return np.array(found.pos.tolist())


def hands(residue):
    """Signs of the centres of a sugar."""
    base = "N9" if residue.find_atom("N9", "*") else "N1"
    centres = {"C1'": ("O4'", "C2'", base), "C3'": ("C2'", "C4'", "O3'")}
    centres["C4'"] = ("C3'", "C5'", "O4'")
    if residue.find_atom("O2'", "*"):
        centres["C2'"] = ("C1'", "C3'", "O2'")
    signs = {}
    for centre, around in centres.items():
        a, b, c = (place(residue, atom) - place(residue, centre) for atom in around)
        signs[centre] = float(np.sign(a @ np.cross(b, c)))
    return signs


# of D-ribose, where 2KOC has it
HANDS = hands(neighbours(gemmi.read_pdb_string("\n".join(chain())))[2])


def check_chain(structure, n=14, name="A", model=0):
    """A chain is whole, its sugars are right, and nothing of it is too near to anything."""
    residues = neighbours(structure, name, model)
    assert len(residues) == n
    for before, after in pairwise(residues):
        bond = np.linalg.norm(place(before, "O3'") - place(after, "P"))
        assert 1.55 <= bond <= 1.66, f"{before}–{after}: {bond:.2f} Å"
    for residue in residues:
        assert hands(residue).items() <= HANDS.items(), residue
    check_contacts(structure, model)


def check_contacts(structure, model=0, least=2.2):
    """No two atoms of different residues are nearer than 2.2 Å but bonded ones."""
    atoms = [
        (np.array(atom.pos.tolist()), atom.name, residue)
        for one in structure[model]
        for residue in one
        for atom in residue
        if not atom.is_hydrogen()
    ]
    for i, j in cKDTree([a[0] for a in atoms]).query_pairs(least):
        (first, name_1, one), (second, name_2, other) = atoms[i], atoms[j]
        if one is other or {name_1, name_2} == {"O3'", "P"}:
            continue
        apart = np.linalg.norm(first - second)
        raise AssertionError(f"{one} {name_1} and {other} {name_2}: {apart:.2f} Å")
