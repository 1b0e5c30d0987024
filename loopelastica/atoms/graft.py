"""A nucleotide of another structure, carried to its place, becomes the one that is to be built.

Sugar and phosphate are taken as they are. A base of the same letter too; another one is laid on the
glycosidic bond: same C1', same bond, same plane, purine and pyrimidine turned about it alike (χ is
counted to C4 of a purine and C2 of a pyrimidine). What the template lacks, such as the O2' of
ribose on a template of DNA, is laid on the atoms of the sugar next to it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from loopelastica._arrays import Array
from loopelastica.atoms.chemistry import Residue, atom_names
from loopelastica.atoms.fibre import fibre_nucleotide
from loopelastica.atoms.measures import rigid_fit
from loopelastica.atoms.site import Site
from loopelastica.molecule.polymer import Monomer

_PHOSPHATE: Final = ("P", "OP1", "OP2")
_GLYCOSIDIC: Final = {"N9": ("C4", "C8"), "N1": ("C2", "C6"), "C5": ("C4", "C6")}
"""Atom of the base at C1' (C5: pseudouridine), and its neighbours: first the one that χ counts."""
_BOND_A: Final = (1.2, 1.9)
"""Shortest and longest bond of C1' to a base: other atoms there place none."""
_NEXT_TO: Final = {
    "O2'": ("C1'", "C2'", "C3'"),
    "OP1": ("P", "O5'", "C5'"),
    "OP2": ("P", "O5'", "C5'"),
    "O4'": ("C1'", "C4'", "C3'"),
    "C2'": ("C3'", "C4'", "O3'"),
    "C1'": ("C2'", "C3'", "C4'"),
}
"""Atoms that one which is missing is placed by."""


def grafted(template: Monomer, kind: Residue) -> dict[str, Array]:
    """Where the atoms of a nucleotide start.

    Parameters
    ----------
    template : Monomer
        What was carried there, with its atoms.
    kind : Residue
        What is to be built.

    Returns
    -------
    dict of str to (3,) array
        In the coordinates of the template, Å; an atom that nothing places is left out.
    """
    there = template.atoms_A
    ideal = fibre_nucleotide(kind.letter, kind.is_dna)
    names = [name for name in atom_names(kind) if name in ideal]
    at = {x: there[x] for x in names if x in there and (x in _PHOSPHATE or "'" in x)}
    for name, beside in _NEXT_TO.items():
        if name in names and name not in at and all(x in at for x in beside):
            at[name] = _laid(ideal, name, {x: at[x] for x in beside})
    bond = _bond(there)
    own = _bond(ideal)
    if bond is None or own is None:
        return at
    from_frame, from_origin = _frame(ideal, own)
    to_frame, to_origin = _frame(there, bond)
    same = template.letter == kind.letter and bond == own
    for name in names:
        if name not in at and name not in _PHOSPHATE and "'" not in name:
            laid = to_origin + to_frame @ from_frame.T @ (ideal[name] - from_origin)
            at[name] = there.get(name, laid) if same else laid
    return at


def grafts(site: Site, templates: Sequence[Monomer]) -> dict[str, dict[str, Array]]:
    """Where the atoms of all nucleotides of a strand start, by their labels.

    Parameters
    ----------
    site : Site
        Where the strand is built.
    templates : sequence of Monomer
        What was carried there, one for each of its nucleotides.

    Returns
    -------
    dict of str to dict of str to (3,) array
        As :meth:`Site.given` takes it.
    """
    kinds = site.molecule.residues
    return {
        site.labels[k]: grafted(template, kind)
        for k, (template, kind) in enumerate(zip(templates, kinds, strict=True))
    }


def _laid(ideal: Mapping[str, Array], name: str, beside: Mapping[str, Array]) -> Array:
    """An atom of the ideal nucleotide, laid on its neighbours."""
    model = np.array([ideal[x] for x in beside])
    rotation, shift = rigid_fit(model, np.array(list(beside.values())))
    return np.asarray(rotation @ ideal[name] + shift)


def _bond(atoms: Mapping[str, Array]) -> str | None:
    """The atom of the base that C1' is bonded to; None where base or C1' is not there."""
    for name, sides in _GLYCOSIDIC.items():
        if all(x in atoms for x in ("C1'", name, *sides)):
            first, second = (atoms[x] - atoms["C1'"] for x in sides)
            bond_A = np.linalg.norm(atoms[name] - atoms["C1'"])
            # sides that lie on one line span no plane
            if _BOND_A[0] <= bond_A <= _BOND_A[1] and np.linalg.norm(np.cross(first, second)) > 1.0:
                return name
    return None


def _frame(atoms: Mapping[str, Array], bond: str) -> tuple[Array, Array]:
    """Frame (3, 3) along the glycosidic bond and in the plane of the base, from C1' on."""
    first, second = (atoms[name] for name in _GLYCOSIDIC[bond])
    x = atoms[bond] - atoms["C1'"]
    x = x / np.linalg.norm(x)
    z = np.cross(x, first - second)
    z /= np.linalg.norm(z)
    return np.stack([x, np.cross(z, x), z], axis=1), atoms["C1'"]
