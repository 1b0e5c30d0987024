"""Which atoms a structure with a built loop has, and what they are called."""

import numpy as np
import pytest
from atom_lines import LOOP, is_hydrogen, line, number

FAR = np.array([60.0, 60.0, 60.0])


def found(atoms):
    return [(r.name, r.number, a.name, a.element) for r, a in atoms.assembly.atoms()]


def test_without_hydrogens_nothing_has_any(of_lines, koc_lines):
    others = [
        line(900, "N", "GLY", "B", 1, FAR),
        line(901, "H", "GLY", "B", 1, FAR + 1),
        line(902, "O", "HOH", "W", 1, FAR + 9, kind="HETATM"),
        line(903, "H1", "HOH", "W", 1, FAR + 10, kind="HETATM"),
    ]
    atoms = of_lines([*koc_lines, *others])
    assert any(map(is_hydrogen, koc_lines))
    assert {element for *_, element in found(atoms)} == {"C", "N", "O", "P"}
    kept = of_lines([*koc_lines, *others], hydrogens=True)
    assert ("GLY", 1, "H", "H") in found(kept)
    assert ("HOH", 1, "H1", "H") in found(kept)


def test_atoms_of_the_file_stay_in_their_order_and_those_of_the_loop_are_the_built_ones(atoms):
    names = [(r.number, a.name) for r, a in atoms.assembly.atoms()]
    molecule = atoms.models[0].molecule
    loop = [(6 + molecule.residue[k], molecule.names[k]) for k in molecule.loop_atoms]
    assert [item for item in names if item[0] in LOOP] == loop
    source = atoms.structure.universe.select_atoms("not element H and not resid 6:9")
    stem = list(zip(source.resids.tolist(), source.names.tolist(), strict=True))
    assert [item for item in names if item[0] not in LOOP] == stem


@pytest.mark.parametrize(("first", "second"), [("A", "B"), ("B", "C"), ("1", "2")])
def test_of_alternative_locations_one_is_left_in_each_residue(of_lines, koc_lines, first, second):
    others = [
        line(900, "C1", "LIG", "L", 1, FAR, altloc=first, occupancy=0.4, kind="HETATM"),
        line(901, "C1", "LIG", "L", 1, FAR + 1, altloc=second, occupancy=0.6, kind="HETATM"),
        line(902, "C2", "LIG", "L", 1, FAR + 2, kind="HETATM"),
    ]
    atoms = of_lines([*koc_lines, *others])
    left = [(a.name, a.in_file) for r, a in atoms.assembly.atoms() if r.name == "LIG"]
    assert left == [("C1", len(koc_lines) + 1), ("C2", len(koc_lines) + 2)]


def test_of_two_residues_in_one_place_one_is_left(of_lines, koc_lines):
    others = [
        line(900 + k, name, resname, "P", 7, FAR + k, altloc=altloc, occupancy=occupancy)
        for k, (name, resname, altloc, occupancy) in enumerate(
            [("N", "SER", "A", 0.3), ("CA", "SER", "A", 0.3),
             ("N", "ALA", "B", 0.7), ("CA", "ALA", "B", 0.7)]
        )
    ]  # fmt: skip
    atoms = of_lines([*koc_lines, *others])
    assert [name for name, n, *_ in found(atoms) if n == 7 and name not in "ACGU"] == ["ALA"] * 2


def test_old_names_become_todays_throughout(of_lines, koc_lines):
    def old(text):
        name = text[12:16].strip()
        name = {"OP1": "O1P", "OP2": "O2P"}.get(name, name).replace("'", "*")
        return f"{text[:12]} {name:<3s}{text[16:17]} R{text[19]}{text[20:]}"

    heavy = [one for one in koc_lines if not is_hydrogen(one)]
    modern, ancient = of_lines(heavy), of_lines(list(map(old, heavy)), "old.pdb")
    assert found(ancient) == found(modern)


def test_numbers_are_those_of_the_file_where_they_start_anew(of_lines, koc_lines):
    others = [
        line(900 + k, "O", "HOH", "W", n, FAR + k, kind="HETATM")
        for k, n in enumerate([9990, 9991, 1, 2])
    ]
    atoms = of_lines([*koc_lines, *others])
    assert [n for name, n, *_ in found(atoms) if name == "HOH"] == [9990, 9991, 1, 2]


def test_an_ion_has_its_own_element_where_the_file_names_none(of_lines, koc_lines):
    ions = [("MG", "MG"), ("NA", "NA"), ("CLA", "CLA"), ("ZN", "ZN"), ("I", "IOD")]
    others = [
        line(900 + k, name, resname, "I", k, FAR + 5 * k, kind="HETATM", element="")
        for k, (name, resname) in enumerate(ions)
    ]
    bare = [one[:76] for one in koc_lines if not is_hydrogen(one)]
    elements = [e for name, _, _, e in found(of_lines([*bare, *others])) if len(name) > 1]
    assert [e.upper() for e in elements] == ["MG", "NA", "CL", "ZN", "I"]


def begins(atoms):
    return [r.number for r in atoms.assembly.residues if r.begins]


def test_chains_begin_where_the_file_has_ended_one(of_lines, koc_lines):
    heavy = [one for one in koc_lines if not is_hydrogen(one)]
    twelfth = next(k for k, one in enumerate(heavy) if number(one) == 12)
    assert begins(of_lines(heavy)) == [1]
    assert begins(of_lines([*heavy[:twelfth], "TER", *heavy[twelfth:], "TER"], "t.pdb")) == [1, 12]


def test_without_names_and_records_a_strand_begins_where_no_bond_leads(of_lines, koc_lines):
    def unnamed(one, shift=0.0, first=0):
        x = float(one[30:38]) + shift
        return f"{one[:21]} {number(one) + first:4d}{one[26:30]}{x:8.3f}{one[38:]}"

    heavy = [one for one in koc_lines if not is_hydrogen(one)]
    peptide = [line(900 + k, n, "GLY", "", 29, FAR + k) for k, n in enumerate(["N", "CA", "C"])]
    second = [unnamed(one, 40.0, 14) for one in heavy if number(one) < 6]
    atoms = of_lines([*map(unnamed, heavy), *second, *peptide])
    assert begins(atoms) == [1, 15, 29]
    # where numbers leave room nucleotides are missing, and the chain goes on
    later = [unnamed(one, 40.0, 20) for one in heavy if number(one) < 6]
    assert begins(of_lines([*map(unnamed, heavy), *later], "gap.pdb")) == [1]


def test_a_nucleotide_knows_whether_it_is_bonded_to_its_neighbours(atoms):
    bonded = atoms.assembly.bonded
    assert bonded.shape == (14, 2)
    assert not bonded[0, 0]
    assert not bonded[-1, 1]
    assert bonded[1:, 0].all()
    assert bonded[:-1, 1].all()
