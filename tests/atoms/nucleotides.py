"""Nucleotides for tests of hydrogens: ideal strands, and those of files."""

import io

import numpy as np

from loopelastica.atoms.conventions import conventional
from loopelastica.atoms.fibre import fibre_nucleotide
from loopelastica.molecule.chains import chains_of
from loopelastica.molecule.entry import read_entry
from loopelastica.molecule.polymer import Monomer
from loopelastica.molecule.strands import ideal_strand


def strand(sequence, is_dna):
    """An ideal strand that begins with O5'."""
    fibre = ideal_strand(is_dna)
    out = []
    for k, letter in enumerate(sequence):
        angle = np.deg2rad(k * fibre.turn_deg)
        turn = np.array(
            [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1.0]]
        )
        atoms = {
            name: turn @ at + [0.0, 0.0, k * fibre.rise_A]
            for name, at in fibre_nucleotide(letter, is_dna).items()
            if k or name not in ("P", "OP1", "OP2")
        }
        resname = f"D{letter}" if is_dna else letter
        out.append(Monomer("A", k + 1, "", resname, letter, is_dna, atoms_A=atoms))
    return out


def ends(n):
    """Bonds along a strand."""
    return [(k > 0, k < n - 1) for k in range(n)]


def of_file(path):
    """Nucleotides of the first model of a file, and their own hydrogens."""
    entry = read_entry(path)
    monomers = [m for chain in chains_of(entry) for m in chain.slots if m.atoms_A]
    found = {}
    for chain in entry.model(0):
        for residue in chain:
            key = chain.name, residue.seqid.num, residue.seqid.icode.strip()
            own = {a.name: np.array(a.pos.tolist()) for a in residue if a.is_hydrogen()}
            found.setdefault(key, {}).update(own)
    return monomers, [found[m.chain, m.number, m.icode] for m in monomers]


def pdb_text(monomers, hydrogens, bonded, convention="pdb"):
    """A PDB file of nucleotides with hydrogens."""
    lines = []
    for one, own, (before, after) in zip(monomers, hydrogens, bonded, strict=True):
        places = {**one.atoms_A, **own}
        resname, names = conventional(
            one, one.is_dna, places, first=not before, last=not after, convention=convention
        )
        for wwpdb, name, (x, y, z) in zip(places, names, places.values(), strict=True):
            shown = name if len(name) == 4 else f" {name}"
            lines.append(
                f"ATOM  {len(lines) + 1:5d} {shown:4s} {resname:>3s} A{one.number:4d}    "
                f"{x:8.3f}{y:8.3f}{z:8.3f}  1.00  0.00          {wwpdb[0]:>2s}"
            )
    return "\n".join([*lines, "TER", "END", ""])


def topology(text):
    """What OpenMM reads."""
    from openmm.app import PDBFile

    return PDBFile(io.StringIO(text))
