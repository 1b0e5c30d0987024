"""Each kind of fault is found where it was made, and nothing else is."""

from dataclasses import replace

import numpy as np
import pytest

from loopelastica._files import data_path
from loopelastica.molecule.chains import chains_of
from loopelastica.molecule.entry import read_entry
from loopelastica.molecule.faults import (
    bonds_of,
    broken_or_strained,
    find_faults,
    strain_A,
)


@pytest.fixture(scope="module")
def chain():
    (found,) = chains_of(read_entry(data_path("hairpins/2koc.pdb")))
    return found


def changed(chain, place, **atoms):
    """The chain with atoms of one nucleotide elsewhere; C1_ stands for C1'."""
    one = chain.slots[place]
    new = {name.replace("_", "'"): np.asarray(at) for name, at in atoms.items()}
    slots = list(chain.slots)
    slots[place] = replace(one, atoms_A={**one.atoms_A, **new})
    return replace(chain, slots=tuple(slots))


def shifted(chain, place, by):
    atoms = {name.replace("'", "_"): at + by for name, at in chain.slots[place].atoms_A.items()}
    return changed(chain, place, **atoms)


def kinds(chain):
    return {fault.kind for fault in find_faults(chain)}


def test_every_model_of_a_good_structure_is_without_fault():
    entry = read_entry(data_path("hairpins/2koc.pdb"))
    for model in range(entry.n_models):
        assert [find_faults(chain) for chain in chains_of(entry, model)] == [[]]


def test_a_shifted_nucleotide_has_two_broken_bonds(chain):
    faults = find_faults(shifted(chain, 6, np.array([0.0, 0.0, 4.0])))
    bonds = [fault for fault in faults if fault.kind == "bond"]
    assert [fault.places for fault in bonds] == [(5, 6), (6, 7)]
    assert bonds[0].where == "A.U6–A.U7"
    assert bonds[0].what.startswith("O3'–P ")


def test_a_bond_over_two_angstroms_is_a_fault_and_one_under_is_none(chain):
    o3, p = chain.slots[4].atoms_A["O3'"], chain.slots[5].atoms_A["P"]
    along = (p - o3) / np.linalg.norm(p - o3)
    for length, broken in ((1.9, False), (2.1, True)):
        found = find_faults(changed(chain, 4, O3_=p - length * along))
        assert any("O3'–P" in fault.what for fault in found) is broken


def test_a_bond_inside_a_nucleotide_may_be_too_long_or_too_short(chain):
    c4, c5 = (chain.slots[3].atoms_A[name] for name in ("C4'", "C5'"))
    for length in (2.3, 0.7):
        moved = c4 + length * (c5 - c4) / np.linalg.norm(c5 - c4)
        found = [str(f) for f in find_faults(changed(chain, 3, C5_=moved))]
        assert any(s.startswith("A.A4: C5'–C4'") and f"{length:.1f} Å" in s for s in found)


@pytest.mark.parametrize(
    ("centre", "moved", "fixed"),
    [
        ("C1'", "N9", ("C1'", "O4'", "C2'")),
        ("C2'", "O2'", ("C2'", "C1'", "C3'")),
        ("C3'", "O3'", ("C3'", "C4'", "C2'")),
        ("C4'", "C5'", ("C4'", "C3'", "O4'")),
    ],
)
def test_a_mirrored_centre_has_the_wrong_hand(chain, centre, moved, fixed):
    atoms = chain.slots[8].atoms_A
    a, b, c = (atoms[name] for name in fixed)
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal)
    at = atoms[moved] - 2.0 * ((atoms[moved] - a) @ normal) * normal
    found = find_faults(changed(chain, 8, **{moved.replace("'", "_"): at}))
    hands = [fault.what for fault in found if fault.kind == "hand"]
    assert hands == [f"wrong hand at {centre}"]


def test_a_flattened_centre_has_no_hand(chain):
    atoms = chain.slots[8].atoms_A
    a, b, c = (atoms[name] for name in ("O4'", "C2'", "N9"))
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal)
    flat = atoms["C1'"] - ((atoms["C1'"] - a) @ normal) * normal
    assert "wrong hand at C1'" in [f.what for f in find_faults(changed(chain, 8, C1_=flat))]


def test_exchanged_names_of_phosphate_oxygens_are_no_fault(chain):
    atoms = chain.slots[5].atoms_A
    assert find_faults(changed(chain, 5, OP1=atoms["OP2"], OP2=atoms["OP1"])) == []


def test_atoms_of_two_nucleotides_may_not_meet(chain):
    other = chain.slots[10].atoms_A["C5"]
    found = find_faults(changed(chain, 3, N6=other + np.array([1.2, 0.0, 0.0])))
    assert any(f.kind == "clash" and f.places == (3, 10) for f in found)


def test_a_clash_is_one_fault_for_each_two_nucleotides(chain):
    step = chain.slots[9].atoms_A["C4'"] - chain.slots[2].atoms_A["C4'"]
    clashes = [f for f in find_faults(shifted(chain, 2, step)) if f.kind == "clash"]
    assert len({fault.places for fault in clashes}) == len(clashes)


def test_what_is_missing_is_no_fault(chain):
    slots = list(chain.slots)
    slots[6] = replace(slots[6], atoms_A={})
    assert find_faults(replace(chain, slots=tuple(slots))) == []


def test_without_a_record_numbers_that_jump_are_no_broken_bond(chain):
    slots = chain.slots[:5] + chain.slots[7:]
    assert find_faults(replace(chain, slots=slots, source="")) == []
    assert kinds(replace(chain, slots=slots, source="SEQRES")) == {"bond"}


def test_groups_of_modified_nucleotides_are_bonded_to_anything(chain):
    slots = list(chain.slots)
    methyl = slots[5].atoms_A["O2'"] + np.array([1.0, 1.0, 0.0])
    slots[5] = replace(slots[5], resname="OMU", atoms_A={**slots[5].atoms_A, "CM2": methyl})
    assert find_faults(replace(chain, slots=tuple(slots))) == []


def test_the_ends_of_a_circular_chain_may_be_bonded(chain):
    p = chain.slots[0].atoms_A["P"]
    closed = changed(chain, 13, O3_=p + np.array([1.6, 0.0, 0.0]))
    pairs = [str(f) for f in find_faults(closed) if f.kind == "clash" and f.places == (0, 13)]
    assert not any("O3' and P" in pair or "P and O3'" in pair for pair in pairs)


def test_a_junction_is_strained_when_an_angle_is_far_off(chain):
    first, second = chain.slots[4:6]
    assert not broken_or_strained(first, second)
    o3, p, c3 = first.atoms_A["O3'"], second.atoms_A["P"], first.atoms_A["C3'"]
    folded = o3 + np.linalg.norm(p - o3) * (c3 - o3) / np.linalg.norm(c3 - o3)
    assert broken_or_strained(first, replace(second, atoms_A={**second.atoms_A, "P": folded}))


def test_strain_is_nothing_in_a_good_nucleotide_and_grows_with_a_bond(chain):
    one = chain.slots[5]
    assert strain_A(one) == 0.0
    longer = replace(one, atoms_A={**one.atoms_A, "P": one.atoms_A["P"] + np.ones(3)})
    assert strain_A(longer) > 0.5


@pytest.mark.parametrize("letter", "ACGUT")
def test_the_table_of_bonds_is_that_of_rdkit(letter):
    Chem = pytest.importorskip("rdkit.Chem")
    mol = Chem.MolFromSequence(letter, flavor=7 if letter == "T" else 3)
    names = [a.GetPDBResidueInfo().GetName().strip() for a in mol.GetAtoms()]
    theirs = {
        frozenset((names[b.GetBeginAtomIdx()], names[b.GetEndAtomIdx()])) for b in mol.GetBonds()
    }
    theirs = {pair for pair in theirs if "OP3" not in pair}
    ours = {frozenset(pair) for pair in bonds_of(letter)}
    assert ours - theirs <= {frozenset(("C2'", "O2'"))}
    assert theirs <= ours
