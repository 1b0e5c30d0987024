"""Compute ``hydrogens.json``, the hydrogens of nucleotides by their wwPDB names, anew: a minute.

    python -m pip install biotite rdkit
    python data/make_hydrogens.py

What hydrogens there are, their names and their order come from the wwPDB's Chemical Component
Dictionary, in the copy that biotite carries; what kind each one is follows from the bonds. Which of
two at one carbon or nitrogen has which name is the recommendation of IUPAC where it has one, for
the dictionary differs from nucleotide to nucleotide (Markley et al., Pure Appl. Chem. 70 (1998)
117, doi:10.1351/pac199870010117; real entries agree), and follows from the dictionary's ideal
coordinates elsewhere.

A rule is ``kind hydrogen[,hydrogen…] carrier neighbour…``:

    opposite  away from all of the carrier's one to three neighbours
    side      one of two places at a carrier with two neighbours: on the side of their cross product
    cis       in the plane of carrier, neighbour and its neighbour, on the side of the latter
    trans     the same, on the other side
    turning   one to three that turn about the bond: carrier, neighbour, its neighbour

Acids have no hydrogen (phosphates, carboxylates): they are charged in water. HO3' is in every
nucleotide that can have it; whether it does is for its place in the chain to say. HO5' is in none.
"""

import json
import warnings
from pathlib import Path

import biotite
import biotite.structure.info as info
import numpy as np
from biotite.interface.rdkit import to_mol
from rdkit import Chem

PLACE = Path(__file__).with_name("hydrogens.json")
ELEMENTS = {"C", "N", "O", "P", "S", "H", "F", "CL", "BR", "I"}
SUGAR = ("O5'", "C5'", "C4'", "O4'", "C3'", "O3'", "C2'", "C1'")
KINDS = ("RNA LINKING", "DNA LINKING", "RNA OH", "DNA OH")
# not of a chain by their type, but found in chains
CAPS = ("GTP", "GDP", "ATP", "CTP", "UTP", "CCC")
# of two at one atom: neighbours whose cross product the first one is on the side of (H5' and, of
# DNA, H2' are pro-S), and the atom that the first one of an amino group is cis to
SIDES = {"C5'": ["O5'", "C4'"], "C2'": ["C1'", "C3'"]}
AMINO = {("N6", "C6"): "N1", ("N4", "C4"): "N3", ("N2", "C2"): "N1"}
# their base is anything
UNKNOWN = ("N", "DN")
# what the dictionary draws otherwise than it is found in nucleic acids: hydrogens too many
WRONG = {"7MG": ("H82",)}


def components():
    """Names of all nucleotides of the dictionary that have the usual sugar."""
    table = info.ccd.get_ccd()["chem_comp"]
    columns = (table[name].as_array() for name in ("id", "type", "pdbx_release_status"))
    for name, kind, status in zip(*columns, strict=True):
        if (
            name not in UNKNOWN
            and status == "REL"
            and (kind.upper().startswith(KINDS) or name in CAPS)
        ):
            yield str(name)


def rules_of(name):
    """Rules of one component, in its order; None where its sugar is another one."""
    try:
        atoms = info.residue(name)
    except ValueError:
        return None
    if not {*SUGAR} <= {*atoms.atom_name} or not {*atoms.element} <= ELEMENTS:
        return None
    try:
        mol = to_mol(atoms)
        Chem.SanitizeMol(mol)
    except (ValueError, Chem.MolSanitizeException):
        return None
    wrong = {k for k, atom in enumerate(atoms.atom_name) if atom in WRONG.get(name, ())}
    rules, seen = [], {*wrong, *np.flatnonzero(atoms.atom_name == "HO5'").tolist()}
    for atom in mol.GetAtoms():
        if atom.GetSymbol() == "H" and atom.GetIdx() not in seen:
            (carrier,) = atom.GetNeighbors()
            if is_acid(carrier):
                continue
            own = [n.GetIdx() for n in carrier.GetNeighbors() if n.GetSymbol() == "H"]
            found = rules_at(atoms, carrier, atom.GetIdx(), [k for k in own if k not in wrong])
            if found is None:
                return None
            rule, done = found
            seen |= {*done}
            rules.append(rule)
    return rules


def is_acid(carrier):
    """Whether a hydrogen here is that of a phosphate or of a carboxylic acid."""
    if carrier.GetSymbol() != "O":
        return False
    (other,) = (n for n in carrier.GetNeighbors() if n.GetSymbol() != "H")
    doubly = (b for b in other.GetBonds() if b.GetBondType() == Chem.BondType.DOUBLE)
    oxo = any(b.GetOtherAtom(other).GetSymbol() in "OS" for b in doubly)
    return other.GetSymbol() == "P" or oxo


def rules_at(atoms, carrier, hydrogen, own):
    """The rule of one hydrogen, or of all that turn together; and which these are."""
    x, names = carrier.GetIdx(), atoms.atom_name
    heavy = [n for n in carrier.GetNeighbors() if n.GetSymbol() != "H"]
    refs = [n.GetIdx() for n in heavy]
    flat = carrier.GetHybridization() in (Chem.HybridizationType.SP2, Chem.HybridizationType.SP)
    # one that has lost a hydrogen is flat in truth
    flat |= len(refs) + len(own) < carrier.GetDegree()
    flat &= carrier.GetSymbol() != "O"

    def rule(kind, hydrogens, *places):
        return " ".join([kind, ",".join(names[h] for h in hydrogens), *names[[x, *places]]])

    if len(own) == 1 and len(refs) in ((2, 3) if flat else (3,)):
        return rule("opposite", own, *sorted(refs, key=lambda k: names[k])), own
    if len(refs) == 1 and carrier.GetHybridization() == Chem.HybridizationType.SP:
        return rule("opposite", own, *refs), own
    if len(refs) == 2:
        a, b, h = (atoms.coord[k] - atoms.coord[x] for k in (*refs, hydrogen))
        order = refs if np.dot(np.cross(a, b), h) > 0 else refs[::-1]
        if sorted(names[order]) == sorted(SIDES.get(names[x], ())):
            order = sorted(refs, key=lambda k: SIDES[names[x]].index(names[k]))
            order = order if hydrogen == own[0] else order[::-1]
        return rule("side", [hydrogen], *order), [hydrogen]
    if len(refs) != 1:
        return None
    beyond = [n.GetIdx() for n in heavy[0].GetNeighbors() if n.GetIdx() != x]
    beyond = [k for k in beyond if atoms.element[k] != "H"]
    if not beyond:
        return None
    # of a double bond and a single one the hydrogens of a methyl group eclipse the double one
    orders = Chem.Mol(carrier.GetOwningMol())
    Chem.Kekulize(orders, clearAromaticFlags=True)
    bonds = {n: orders.GetBondBetweenAtoms(refs[0], n) for n in beyond}
    beyond.sort(key=lambda k: (bonds[k].GetBondTypeAsDouble(), names[k]))
    fixed = AMINO.get((names[x], names[refs[0]]))
    if flat and fixed in names[beyond] and len(own) == 2:
        kind = "cis" if hydrogen == own[0] else "trans"
        (place,) = (k for k in beyond if names[k] == fixed)
        return rule(kind, [hydrogen], refs[0], place), [hydrogen]
    if flat:
        out = atoms.coord[hydrogen] - atoms.coord[x], atoms.coord[beyond[0]] - atoms.coord[refs[0]]
        axis = atoms.coord[refs[0]] - atoms.coord[x]
        perp = [v - axis * np.dot(v, axis) / np.dot(axis, axis) for v in out]
        kind = "cis" if np.dot(*perp) > 0 else "trans"
        return rule(kind, [hydrogen], refs[0], beyond[0]), [hydrogen]
    return rule("turning", own, refs[0], beyond[0]), own


def main():
    """Write the table; what most of them share is written once."""
    # coordinates of the experiment where there are no ideal ones
    warnings.filterwarnings("ignore", message="The coordinates are missing")
    table = {name: rules for name in sorted(components()) if (rules := rules_of(name))}
    shared = {"rna": "G", "dna": "DG"}
    sugars = {
        key: [rule for rule in table[name] if "'" in rule.split()[1]]
        for key, name in shared.items()
    }
    for rules in sugars.values():
        # the sugar's own: what the base is called depends on the base
        rules[:] = [rule for rule in rules if rule.split()[1] != "H1'"]
    out = {}
    for name, rules in table.items():
        sugar = next((key for key, common in sugars.items() if {*common} <= {*rules}), None)
        common = sugars.get(sugar, [])
        out[name] = {"sugar": sugar, "rules": [rule for rule in rules if rule not in common]}
    lines = [f"  {json.dumps(name)}: {json.dumps(one)}" for name, one in out.items()]
    source = f"Chemical Component Dictionary of the wwPDB, as biotite {biotite.__version__} has it"
    head = (
        f'{{\n"source": {json.dumps(source)},\n"sugars": {json.dumps(sugars)},\n"components": {{\n'
    )
    PLACE.write_text(head + ",\n".join(lines) + "\n}\n}\n", encoding="utf-8")
    print(f"{len(out)} components, {PLACE.stat().st_size} bytes")


if __name__ == "__main__":
    main()
