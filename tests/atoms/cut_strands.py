"""Strands cut out of a structure, and lines to fill them on."""

from dataclasses import replace

import numpy as np

from loopelastica.atoms.carry import IdealCurve
from loopelastica.atoms.measures import rigid_fit
from loopelastica.molecule.nucleotides import BACKBONE
from loopelastica.molecule.polymer import Gap, HeavyAtoms, Monomer
from loopelastica.molecule.strands import ideal_strand, strand_atoms

PHOSPHATE = ("P", "OP1", "OP2")


def monomers(structure):
    """All nucleotides of the first model, heavy atoms only."""
    table, positions = structure.nucleotides, structure.positions(0)
    atoms = structure.universe.atoms
    out = []
    for row in range(len(table.letter)):
        c4 = table.columns(["C4'"])[row, 0]
        rows = [i for i in atoms[c4].residue.atoms.indices if atoms[i].name[0] != "H"]
        residue = atoms[c4].residue
        out.append(
            Monomer(
                "A", int(residue.resid), "", residue.resname, str(table.letter[row]),
                bool(table.is_dna[row]), None, {atoms[i].name: positions[i] for i in rows},
            )
        )  # fmt: skip
    return out


def heavy(nucleotides, *others):
    """What is there: atoms of nucleotides, and single atoms (name, element, place)."""
    places, names, elements, residue, labels = [], [], [], [], []
    for monomer in nucleotides:
        labels.append(monomer.label)
        for name, at in monomer.atoms_A.items():
            places.append(at)
            names.append(name)
            elements.append(name[0])
            residue.append(len(labels) - 1)
    for name, element, at in others:
        labels.append(f"B.{name}{len(labels)}")
        places.append(at)
        names.append(name)
        elements.append(element)
        residue.append(len(labels) - 1)
    return HeavyAtoms(
        np.array(places, dtype=float),
        np.array(elements),
        np.array(names),
        np.array(residue),
        tuple(labels),
        np.array([labels[r].startswith("B.HOH") for r in residue]),
        np.array([labels[r].startswith("B.MG") for r in residue]),
    )


def without(monomer, *names):
    return replace(monomer, atoms_A={k: v for k, v in monomer.atoms_A.items() if k not in names})


def only(monomer, *names):
    return replace(monomer, atoms_A={k: v for k, v in monomer.atoms_A.items() if k in names})


def base(monomer):
    return tuple(name for name in monomer.atoms_A if "'" not in name and name not in PHOSPHATE)


def cut(chain, first, n):
    """The gap of n nucleotides from row `first` on."""
    empty = tuple(replace(monomer, atoms_A={}) for monomer in chain[first : first + n])
    last = first + n
    return Gap(
        empty,
        chain[first - 1],
        chain[last],
        chain[first - 2] if first > 1 else None,
        chain[last + 1] if last + 1 < len(chain) else None,
    )


def left(chain, gap):
    """What is there with a gap."""
    gone = {monomer.number for monomer in gap.monomers}
    rest = [monomer for monomer in chain if monomer.number not in gone]
    changed = {monomer.number: monomer for monomer in (gap.before, gap.after)}
    rest = [changed.get(monomer.number, monomer) for monomer in rest]
    return [*rest, *(monomer for monomer in gap.monomers if monomer.atoms_A)]


def ideal_line(gap):
    """The line of an ideal strand that goes on from the nucleotide before."""
    strand = ideal_strand(gap.before.is_dna)
    table = strand_atoms(strand, 0)
    names = [name for name in BACKBONE if name in gap.before.atoms_A]
    model = np.array([table[BACKBONE.index(name)] for name in names])
    fit = rigid_fit(model, np.array([gap.before.atoms_A[name] for name in names]))

    class Shifted:
        def at(self, phases):
            return IdealCurve(strand, *fit).at(np.asarray(phases) + 1.0)

    return Shifted()
