"""Hydrogens against those of NMR entries, against rdkit, and in OpenMM."""

import json
from dataclasses import replace

import numpy as np
import pytest
from nucleotides import ends, of_file, pdb_text, strand, topology
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from loopelastica._files import data_path
from loopelastica.atoms.hydrogens import add_hydrogens, carriers, hydrogen_rules
from loopelastica.atoms.terminals import chain_bonds
from loopelastica.molecule.components import METHYLATED
from loopelastica.molecule.polymer import Monomer

NOTHING = np.zeros((0, 3))
TURNING = {"HO2'", "HO3'", "HO5'", "H71", "H72", "H73"}
RIBOSE = "H5' H5'' H4' H3' H2' HO2' H1'"
DEOXYRIBOSE = "H5' H5'' H4' H3' H2' H2'' H1'"
PARENTS = {"5MU": "U", "5MC": "C", "2MG": "G", "M2G": "G", "6MZ": "A"}
PARENTS |= {"OMC": "C", "OMG": "G", "OMU": "U", "A2M": "A"}
BASES = {
    "A": "H8 H61 H62 H2",
    "C": "H41 H42 H5 H6",
    "G": "H8 H1 H21 H22",
    "U": "H3 H5 H6",
    "T": "H3 H71 H72 H73 H6",
}


def all_atoms(monomers):
    return np.array([at for one in monomers for at in one.atoms_A.values()])


@pytest.mark.parametrize("is_dna", [False, True])
@pytest.mark.parametrize("letter", "ACGUT")
def test_a_nucleotide_in_a_chain_has_the_names_of_the_wwpdb_in_their_order(letter, is_dna):
    one = strand("A" + letter, is_dna)[1]
    (found,) = add_hydrogens([one], [(True, True)], NOTHING)
    sugar = DEOXYRIBOSE if is_dna else RIBOSE
    assert " ".join(found) == f"{sugar} {BASES[letter]}"


def test_ends_of_a_chain_have_hydrogens_on_their_oxygens():
    monomers = strand("GAC", is_dna=False)
    first, middle, last = add_hydrogens(monomers, ends(3), NOTHING)
    assert list(first)[-1] == "HO5'"
    assert "HO3'" not in first
    assert not {"HO5'", "HO3'"} & set(middle)
    assert list(last)[4] == "HO3'"
    assert "HO5'" not in last
    (alone,) = add_hydrogens(monomers[:1], [(False, False)], NOTHING)
    assert {"HO5'", "HO3'"} <= set(alone)


def test_a_5_phosphate_takes_the_place_of_a_hydrogen():
    one = strand("GA", is_dna=False)[1]
    (found,) = add_hydrogens([one], [(False, True)], NOTHING)
    assert "HO5'" not in found


@pytest.mark.parametrize("oxygen", ["O2'", "O3'", "O5'"])
def test_an_oxygen_that_is_bonded_to_something_else_has_no_hydrogen(oxygen):
    (one,) = strand("G", is_dna=False)
    (free,) = add_hydrogens([one], [(False, False)], NOTHING)
    name = f"H{oxygen}"
    # such as the phosphorus of a cyclic phosphate
    at = one.atoms_A[oxygen]
    phosphorus = at + 1.6 * (free[name] - at) / 0.96
    (found,) = add_hydrogens([one], [(False, False)], phosphorus[None])
    assert set(free) - set(found) == {name}


def assert_as_in(path):
    """What is fixed lies where the file has it; of an amino group either name will do."""
    monomers, own = of_file(path)
    found = add_hydrogens(monomers, chain_bonds(monomers), NOTHING)
    assert found.remarks == ()
    compared = 0
    for one, new, old in zip(monomers, found, own, strict=True):
        for name in set(new) & set(old) - TURNING:
            others = [name]
            if name in ("H21", "H22", "H41", "H42", "H61", "H62"):
                # entries name them by either convention
                others = [f"{name[:2]}1", f"{name[:2]}2"]
            away = min(np.linalg.norm(new[name] - old[x]) for x in others)
            assert away < 0.25, f"{one.label} {name} {away:.2f}"
            compared += 1
    assert compared > 9 * len(monomers)


def test_fixed_hydrogens_lie_where_2koc_has_them():
    assert_as_in(data_path("hairpins/2koc.pdb"))


def test_hydrogens_of_sugars_make_equal_angles():
    monomers, _ = of_file(data_path("hairpins/2koc.pdb"))
    found = add_hydrogens(monomers, chain_bonds(monomers), NOTHING)
    for one, new in zip(monomers, found, strict=True):
        bonds = [new["H4'"], *(one.atoms_A[x] for x in ("C3'", "C5'", "O4'"))] - one.atoms_A["C4'"]
        bonds /= np.linalg.norm(bonds, axis=1, keepdims=True)
        np.testing.assert_allclose(bonds[1:] @ bonds[0], bonds[1] @ bonds[0], atol=1e-9)


@pytest.mark.parametrize(
    "name", ["1anr", "1hlx", "1szy", "1k2g", "1aqo", "1k5i", "1ac7", "1bjh", "1jve", "2l5k"]
)
def test_fixed_hydrogens_lie_where_nmr_entries_have_them(hairpin_folder, name):
    assert_as_in(hairpin_folder / f"{name}.pdb.gz")


def test_of_an_amino_group_the_first_is_on_the_side_of_the_watson_crick_edge():
    monomers = strand("AGC", is_dna=True)
    found = add_hydrogens(monomers, ends(3), NOTHING)
    for k, (first, second, edge) in enumerate(
        [("H61", "H62", "N1"), ("H21", "H22", "N1"), ("H41", "H42", "N3")]
    ):
        at = monomers[k].atoms_A[edge]
        assert np.linalg.norm(found[k][first] - at) < np.linalg.norm(found[k][second] - at) - 0.5


@pytest.mark.parametrize(("is_dna", "centre"), [(False, "C5'"), (True, "C5'"), (True, "C2'")])
def test_of_two_at_one_carbon_the_first_is_pro_s(is_dna, centre):
    from rdkit import Chem

    from loopelastica.atoms.chemistry import Residue, strand_molecule

    kind = Residue("G", is_dna, "DG" if is_dna else "G")
    molecule = strand_molecule({0: (kind, None)}, 1)
    one = strand("AG", is_dna)[1]
    (hydrogens,) = add_hydrogens([one], [(True, True)], NOTHING)
    first, second = f"H{centre[1:]}", f"H{centre[1:]}'"
    for heavy, code in ((first, "S"), (second, "R")):
        mol = Chem.RWMol(molecule.mol)
        places = {row: one.atoms_A[name] for row, name in enumerate(molecule.names)}
        carrier = molecule.index(0, centre)
        for name in (first, second):
            row = mol.AddAtom(Chem.Atom("H"))
            mol.AddBond(carrier, row, Chem.BondType.SINGLE)
            mol.GetAtomWithIdx(row).SetIsotope(2 if name == heavy else 0)
            places[row] = hydrogens[name]
        conformer = Chem.Conformer(mol.GetNumAtoms())
        for row, at in places.items():
            conformer.SetAtomPosition(row, at.tolist())
        mol.GetAtomWithIdx(carrier).SetNoImplicit(True)
        mol.AddConformer(conformer)
        Chem.SanitizeMol(mol)
        Chem.AssignStereochemistryFrom3D(mol)
        assert mol.GetAtomWithIdx(carrier).GetProp("_CIPCode") == code


@pytest.mark.parametrize("name", ["A", "C", "G", "U", "DA", "DC", "DG", "DT", "DU", *METHYLATED])
def test_there_are_as_many_hydrogens_as_rdkit_counts(name):
    from rdkit import Chem

    from loopelastica.atoms.chemistry import Residue, loop_molecule

    letter = PARENTS.get(name) or name[-1]
    kind = Residue(letter, name.startswith("D"), name)
    molecule = loop_molecule([kind])
    here = [row for row, residue in enumerate(molecule.residue) if residue == 0]
    count = sum(molecule.mol.GetAtomWithIdx(row).GetTotalNumHs() for row in here)
    mol = Chem.AddHs(molecule.mol, addCoords=False)
    assert mol.GetNumAtoms() > molecule.mol.GetNumAtoms()
    atoms = dict.fromkeys((molecule.names[row] for row in here), np.zeros(3))
    one = Monomer("A", 1, "", name, letter, kind.is_dna, atoms_A=atoms)
    rules = [rule for rule in hydrogen_rules(one) if rule.carrier != "O3'"]
    assert {x for rule in rules for x in (rule.carrier, *rule.neighbours)} <= set(atoms)
    assert sum(len(rule.hydrogens) for rule in rules) == count


def test_lengths_and_angles_are_ideal():
    monomers = strand("AUGC", is_dna=False)
    for one, hydrogens in zip(monomers, add_hydrogens(monomers, ends(4), NOTHING), strict=True):
        carried = carriers(one)
        for name, at in hydrogens.items():
            length = np.linalg.norm(at - one.atoms_A[carried[name]])
            assert length == pytest.approx(
                {"O": 0.96, "N": 1.01, "C": 1.085}[carried[name][0]], abs=6e-3
            )
        to = [hydrogens[x] - one.atoms_A["C5'"] for x in ("H5'", "H5''")]
        cosine = np.dot(*to) / np.prod([np.linalg.norm(v) for v in to])
        assert np.rad2deg(np.arccos(cosine)) == pytest.approx(109.5)


def test_a_rigid_motion_moves_hydrogens_along(rng):
    monomers, _ = of_file(data_path("hairpins/2koc.pdb"))
    bonded = chain_bonds(monomers)
    found = add_hydrogens(monomers, bonded, NOTHING)
    turn, shift = Rotation.random(random_state=rng).as_matrix(), rng.normal(size=3) * 50
    moved = [
        replace(one, atoms_A={x: turn @ at + shift for x, at in one.atoms_A.items()})
        for one in monomers
    ]
    for old, new in zip(found, add_hydrogens(moved, bonded, NOTHING), strict=True):
        assert list(old) == list(new)
        for name, at in old.items():
            np.testing.assert_allclose(new[name], turn @ at + shift, atol=1e-9)


@pytest.mark.parametrize("is_dna", [False, True])
def test_no_hydrogen_of_an_ideal_strand_comes_near_another_atom(is_dna):
    monomers = strand("GATCAG" if is_dna else "GAUCAG", is_dna)
    found = add_hydrogens(monomers, ends(6), NOTHING)
    hydrogens = np.array([at for one in found for at in one.values()])
    everything = np.concatenate([all_atoms(monomers), hydrogens])
    # itself, its carrier, and the next
    nearest = cKDTree(everything).query(hydrogens, k=3)[0]
    assert nearest[:, 2].min() > 1.5


def test_hydrogens_of_sound_heavy_atoms_that_would_clash_are_bent_aside():
    first, second = (strand("G", is_dna=False)[0] for _ in range(2))
    (hydrogens,) = add_hydrogens([first], [(False, False)], NOTHING)
    # another nucleotide whose C8 faces this one's C8, 3.0 Å away
    c8 = first.atoms_A["C8"]
    along = (hydrogens["H8"] - c8) / 1.08
    half_turn = Rotation.from_rotvec(np.pi * np.array(perpendicular(along))).as_matrix()
    moved = {x: half_turn @ (at - c8) + c8 + 3.0 * along for x, at in second.atoms_A.items()}
    second = replace(second, number=2, atoms_A=moved)
    found = add_hydrogens([first, second], [(False, False)] * 2, NOTHING)
    apart = np.linalg.norm(found[0]["H8"] - found[1]["H8"])
    assert apart > 1.25
    assert np.linalg.norm(found[0]["H8"] - c8) == pytest.approx(1.08)


def perpendicular(vector):
    """A unit vector across another one."""
    across = np.cross(vector, [0.3, 0.5, 0.81])
    return across / np.linalg.norm(across)


def test_a_hydroxyl_gives_way_to_what_stands_there():
    (one,) = strand("G", is_dna=False)
    (free,) = add_hydrogens([one], [(False, False)], NOTHING)
    for name in ("HO2'", "HO3'", "HO5'"):
        carrier = one.atoms_A[carriers(one)[name]]
        # 2.4 Å away, in the direction of the hydrogen
        there = carrier + 2.4 * (free[name] - carrier) / 0.96
        (found,) = add_hydrogens([one], [(False, False)], there[None])
        assert np.linalg.norm(found[name] - there) > 1.7


def test_the_nucleotides_own_atoms_may_be_among_what_is_around():
    monomers = strand("GAUC", is_dna=False)
    alone = add_hydrogens(monomers, ends(4), NOTHING)
    with_all = add_hydrogens(monomers, ends(4), all_atoms(monomers))
    for one, other in zip(alone, with_all, strict=True):
        assert list(one) == list(other)
        np.testing.assert_allclose(list(one.values()), list(other.values()))


def test_modified_nucleotides_have_the_dictionarys_names():
    (uridine,) = strand("U", is_dna=False)
    pseudo = {"N1": "C5", "C5": "N1", "C2": "C4", "C4": "C2", "O2": "O4", "O4": "O2", "N3": "N3"}
    atoms = {pseudo.get(x, x): at for x, at in uridine.atoms_A.items()}
    one = replace(uridine, resname="PSU", atoms_A=atoms)
    found = add_hydrogens([one], [(True, True)], NOTHING)
    assert set(RIBOSE.split()) | {"HN1", "HN3", "H6", "HO5'"} == set(found[0])
    assert found.remarks == ()


def test_all_modified_nucleotides_of_a_transfer_rna_get_theirs(hairpin_folder):
    monomers, _ = of_file(hairpin_folder / "1ehz.cif.gz")
    assert len({one.resname for one in monomers}) > 12
    found = add_hydrogens(monomers, chain_bonds(monomers), NOTHING)
    assert found.remarks == ()
    assert min(map(len, found)) >= 9


def test_names_of_force_fields_mean_the_standard_nucleotide():
    (one,) = strand("G", is_dna=False)
    expected = list(add_hydrogens([one], [(False, False)], NOTHING)[0])
    for name in ("RG5", "GUA", "G5", "g"):
        (found,) = add_hydrogens([replace(one, resname=name)], [(False, False)], NOTHING)
        assert list(found) == expected


def test_an_unknown_nucleotide_gets_none_and_a_sentence():
    monomers = strand("GAG", is_dna=False)
    monomers[1] = replace(monomers[1], resname="XQZ")
    found = add_hydrogens(monomers, ends(3), NOTHING)
    assert found.remarks == ("A.XQZ2: XQZ is not in the table of hydrogens; it gets none",)
    assert [len(one) > 0 for one in found] == [True, False, True]


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_position_that_is_no_number_costs_its_nucleotide_the_hydrogens(value):
    monomers = strand("GAG", is_dna=False)
    sound = add_hydrogens(monomers, ends(3), NOTHING)
    atoms = {**monomers[1].atoms_A, "C8": np.array([0.0, value, 0.0])}
    monomers[1] = replace(monomers[1], atoms_A=atoms)
    found = add_hydrogens(monomers, ends(3), NOTHING)
    assert found.remarks == ("A.A2: the position of C8 is no number; it gets no hydrogens",)
    assert found[1] == {}
    assert list(found[0]) == list(sound[0])
    assert np.isfinite([at for one in found for at in one.values()]).all()


@pytest.mark.parametrize("shift_A", [-1.51, 4.0])
def test_a_bond_that_is_none_costs_its_nucleotide_the_hydrogens(shift_A):
    monomers = strand("GAG", is_dna=False)
    atoms = dict(monomers[1].atoms_A)
    along = atoms["C5'"] - atoms["C4'"]
    atoms["C5'"] = atoms["C5'"] + shift_A * along / np.linalg.norm(along)
    monomers[1] = replace(monomers[1], atoms_A=atoms)
    found = add_hydrogens(monomers, ends(3), NOTHING)
    (remark,) = found.remarks
    assert remark.startswith("A.A2: C5' and ")
    assert "Å apart; it gets no hydrogens" in remark
    assert [len(one) > 0 for one in found] == [True, False, True]


def test_neighbours_in_a_plane_leave_no_place():
    one = strand("GA", is_dna=False)[1]
    atoms = dict(one.atoms_A)
    x, y = np.array([1.5, 0, 0]), np.array([0, 1.5, 0])
    atoms["C3'"] = atoms["C4'"] + x
    atoms["C5'"] = atoms["C4'"] + (-0.5 * x + 0.866 * y)
    atoms["O4'"] = atoms["C4'"] + (-0.5 * x - 0.866 * y)
    found = add_hydrogens([replace(one, atoms_A=atoms)], [(True, True)], NOTHING)
    assert found[0] == {}
    assert "it gets no hydrogens" in found.remarks[0]


def test_missing_atoms_cost_the_hydrogens_beside_them():
    (one,) = strand("G", is_dna=False)
    atoms = {x: at for x, at in one.atoms_A.items() if x not in ("N2", "C8")}
    found = add_hydrogens([replace(one, atoms_A=atoms)], [(True, True)], NOTHING)
    assert not {"H21", "H22", "H8"} & set(found[0])
    assert {"H1", "H1'", "HO2'"} <= set(found[0])
    assert found.remarks == ("A.G1 lacks C8, N2; it gets no hydrogens there",)


def test_nothing_gives_nothing():
    assert add_hydrogens([], [], NOTHING) == []
    missing = Monomer("A", 1, "", "G", "G", False)
    found = add_hydrogens([missing], [(False, False)], NOTHING)
    assert found == [{}]
    assert found.remarks == ()


def test_every_rule_of_the_table_is_of_a_known_kind():
    table = json.loads(data_path("hydrogens.json").read_text(encoding="utf-8"))
    texts = [text for one in table["components"].values() for text in one["rules"]]
    sizes = {"opposite": (1, 2, 3), "side": (2,), "cis": (2,), "trans": (2,), "turning": (2,)}
    for text in [*texts, *table["sugars"]["rna"], *table["sugars"]["dna"]]:
        kind, hydrogens, _, *neighbours = text.split()
        assert len(neighbours) in sizes[kind]
        assert len(hydrogens.split(",")) <= (3 if kind == "turning" else 1)
    for name, one in table["components"].items():
        rules = [*table["sugars"].get(one["sugar"], []), *one["rules"]]
        names = [hydrogen for rule in rules for hydrogen in rule.split()[1].split(",")]
        assert len(set(names)) == len(names), name


@pytest.mark.parametrize(
    ("sequence", "is_dna", "force_field"),
    [("GAUCAG", False, "amber14/RNA.OL3.xml"), ("GATCAG", True, "amber14/DNA.OL15.xml")],
)
def test_openmm_accepts_a_strand_with_hydrogens(sequence, is_dna, force_field):
    app = pytest.importorskip("openmm.app")
    monomers = strand(sequence, is_dna)
    found = add_hydrogens(monomers, ends(6), NOTHING)
    for convention in ("pdb", "amber"):
        pdb = topology(pdb_text(monomers, found, ends(6), convention))
        system = app.ForceField(force_field).createSystem(pdb.topology)
        assert system.getNumParticles() == sum(map(len, found)) + len(all_atoms(monomers))
