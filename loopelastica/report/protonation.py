"""Hydrogens and 5' phosphates of the nucleotides in the files.

Hydrogens of the input stay where they are, and what a nucleotide lacks is added. Where some lack
and others have names that are not today's, the nucleotide gets all of them anew. Those near the
loop are placed for each model, the others once.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica.atoms.hydrogens import Hydrogens, add_hydrogens
from loopelastica.atoms.terminals import PHOSPHATE_5, phosphate_remark, phosphates_at_5
from loopelastica.molecule.nucleotides import enumerated
from loopelastica.molecule.polymer import Monomer
from loopelastica.report.assembly import HYDROGEN, Assembly, Atom, Residue

if TYPE_CHECKING:
    from loopelastica.atoms.model import AtomModel
    from loopelastica.report.atoms import LoopAtoms

_NEAR_A: Final = 8.0
"""Hydrogens of nucleotides this near to the loop are placed for each model."""


def position(atom: Atom, atoms: LoopAtoms, model: AtomModel) -> Array:
    """Where an atom of the file or of the loop is in a model, Å, single precision."""
    if atom.in_loop is not None:
        return np.asarray(model.positions_A[atom.in_loop])
    return np.asarray(atoms.positions[atom.in_file])


def with_5_phosphates(assembly: Assembly, atoms: LoopAtoms) -> None:
    """Name the phosphates at 5' ends, which force fields refuse, or take them off.

    Parameters
    ----------
    assembly : Assembly
        It is changed.
    atoms : LoopAtoms
    """
    nucleotides = assembly.nucleotides
    residues = list(nucleotides.values())
    monomers = [_monomer(residue, atoms, atoms.written[0]) for residue in residues]
    bonded = [(bool(five), bool(three)) for five, three in assembly.bonded[list(nucleotides)]]
    found = phosphates_at_5(monomers, bonded)
    if found and atoms.no_5_phosphate:
        for k in found:
            # a file may call the acid's own hydrogen HO5'
            gone = {*PHOSPHATE_5, "HO5'"}
            residues[k].atoms = [atom for atom in residues[k].atoms if atom.name not in gone]
        named = enumerated([monomers[k].label for k in found])
        assembly.remarks.append(f"the 5' phosphate was taken off at {named}")
    else:
        assembly.remarks += [phosphate_remark(monomers[k]) for k in found]


def protonate(assembly: Assembly, atoms: LoopAtoms) -> None:
    """Give every nucleotide its hydrogens.

    Parameters
    ----------
    assembly : Assembly
        It is changed.
    atoms : LoopAtoms
        With at least one sound model.
    """
    first = atoms.written[0]
    nucleotides = assembly.nucleotides
    rows = list(nucleotides)
    others_A = _others(assembly, atoms)
    loop_A = np.concatenate([m.positions_A[m.molecule.loop_atoms] for m in atoms.written])
    near: list[int] = []
    far: list[int] = []
    for row in rows:
        residue = nucleotides[row]
        is_near = residue.built is not None or _is_near(residue, atoms, loop_A)
        (near if is_near else far).append(row)

    def added(which: Sequence[int], model: AtomModel) -> Hydrogens:
        monomers = [_monomer(nucleotides[row], atoms, model) for row in which]
        bonded = [(bool(five), bool(three)) for five, three in assembly.bonded[which]]
        rest = [_heavy_A(nucleotides[row], atoms, model) for row in set(rows).difference(which)]
        return add_hydrogens(monomers, bonded, np.concatenate([others_A, *rest]))

    fixed = added(far, first)
    of_models = [added(near, model) for model in atoms.written]
    new_of = {
        row: new
        for which, hydrogens in ((far, fixed), (near, of_models[0]))
        for row, new in zip(which, hydrogens, strict=True)
    }
    completed: list[str] = []
    replaced: list[str] = []
    for row in rows:
        residue, new = nucleotides[row], list(new_of[row])
        odd, lacking = residue.hydrogens.difference(new), set(new) - residue.hydrogens
        if residue.hydrogens and lacking:
            (replaced if odd else completed).append(residue.label)
        if odd and lacking:
            residue.atoms = [atom for atom in residue.atoms if atom.element not in HYDROGEN]
        _give(residue, [name for name in new if name not in residue.hydrogens])
    assembly.hydrogens_A = [
        {
            (row, name): at
            for which, hydrogens in ((far, fixed), (near, of_model))
            for row, new in zip(which, hydrogens, strict=True)
            for name, at in new.items()
        }
        for of_model in of_models
    ]
    assembly.remarks += [*fixed.remarks, *of_models[0].remarks]
    if completed:
        assembly.remarks.append(
            f"hydrogens that the file lacks are added at {enumerated(completed)}"
        )
    if replaced:
        assembly.remarks.append(
            "the file's own hydrogens are not complete and have other names at"
            f" {enumerated(replaced)}; they are placed anew"
        )


def _give(residue: Residue, names: Sequence[str]) -> None:
    """Hydrogens that a nucleotide lacks."""
    heavy = [atom for atom in residue.atoms if atom.element not in HYDROGEN]
    for atom in heavy:
        if f"H{atom.name}" in names:
            # it is no anion with a hydrogen
            atom.charge = 0
    b_factor = round(sum(atom.b_factor for atom in heavy) / max(len(heavy), 1), 2)
    residue.atoms += [Atom(name, "H", b_factor=b_factor) for name in names]


def _heavy_A(residue: Residue, atoms: LoopAtoms, model: AtomModel) -> Array:
    places = [position(a, atoms, model) for a in residue.atoms if a.element not in HYDROGEN]
    return np.array(places).reshape(-1, 3)


def _monomer(residue: Residue, atoms: LoopAtoms, model: AtomModel) -> Monomer:
    heavy = [atom for atom in residue.atoms if atom.element not in HYDROGEN]
    return residue.monomer({atom.name: position(atom, atoms, model) for atom in heavy})


def _others(assembly: Assembly, atoms: LoopAtoms) -> Array:
    """Heavy atoms of all that is no nucleotide, Å."""
    rows: list[int] = [
        atom.in_file
        for residue, atom in assembly.atoms()
        if residue.nucleotide is None and atom.element not in HYDROGEN
        if atom.in_file is not None
    ]
    return atoms.positions[np.array(rows, dtype=np.int64)]


def _is_near(residue: Residue, atoms: LoopAtoms, loop_A: Array) -> bool:
    rows: NDArray[np.int64] = np.array([a.in_file for a in residue.atoms], dtype=np.int64)
    places = atoms.positions[rows]
    low, high = loop_A.min(axis=0) - _NEAR_A, loop_A.max(axis=0) + _NEAR_A
    return bool(((places > low) & (places < high)).all(axis=1).any())
