"""One alternative location of everything."""

from __future__ import annotations

import gemmi
import pytest

from loopelastica.molecule.conformers import is_hydrogen, taken


def residue(number, *atoms, name="G", flag="A"):
    """Atoms are (name, alternative location, occupancy)."""
    made = gemmi.Residue()
    made.name, made.seqid, made.het_flag = name, gemmi.SeqId(number, " "), flag
    for atom_name, altloc, occupancy in atoms:
        atom = gemmi.Atom()
        atom.name, atom.altloc, atom.occ = atom_name, altloc or "\0", occupancy
        atom.element = gemmi.Element("C")
        made.add_atom(atom)
    return made


def chosen(*residues):
    chain = gemmi.Chain("A")
    for one in residues:
        chain.add_residue(one)
    return [(one.residue.name, one.altloc, [a.altloc for a in one.atoms]) for one in taken(chain)]


def both(number, a, b, **kwargs):
    return residue(number, ("P", "A", a), ("P", "B", b), ("C1'", "", 1.0), **kwargs)


def test_the_highest_occupancy_is_taken_and_the_first_letter_of_equals():
    assert chosen(both(1, 0.3, 0.7)) == [("G", "B", ["B", "\0"])]
    assert chosen(both(1, 0.5, 0.5)) == [("G", "A", ["A", "\0"])]


def test_neighbours_take_the_same_location():
    found = chosen(both(1, 0.1, 0.9), both(2, 0.6, 0.4), both(9, 0.6, 0.4))
    assert [altloc for _, altloc, _ in found] == ["B", "B", "B"]


def test_what_is_apart_chooses_by_itself():
    plain = residue(2, ("P", "", 1.0))
    found = chosen(both(1, 0.1, 0.9), plain, both(3, 0.6, 0.4))
    assert [altloc for _, altloc, _ in found] == ["B", "", "A"]
    waters = chosen(
        both(1, 0.1, 0.9, name="HOH", flag="H"), both(2, 0.6, 0.4, name="HOH", flag="H")
    )
    assert [altloc for _, altloc, _ in waters] == ["B", "A"]


def test_an_atom_that_the_location_lacks_comes_from_another():
    one = residue(1, ("P", "A", 0.7), ("P", "B", 0.3), ("C1'", "B", 0.3))
    assert chosen(one) == [("G", "A", ["A", "B"])]


def test_of_two_residues_at_one_place_the_higher_one():
    first = residue(1, ("P", "A", 0.4), name="A")
    second = residue(1, ("P", "B", 0.6), name="G")
    chain = gemmi.Chain("A")
    chain.add_residue(first)
    chain.add_residue(second)
    (one,) = taken(chain)
    assert (one.residue.name, one.rivals) == ("G", ("A",))


@pytest.mark.parametrize(
    ("name", "element", "hydrogen"),
    [
        ("H5'", "H", True),
        ("H5'", "X", True),
        ("1H5'", "X", True),
        ("D2", "D", True),
        ("C1'", "X", False),
        ("HG", "Hg", False),
    ],
)
def test_hydrogens_by_element_or_name(name, element, hydrogen):
    atom = gemmi.Atom()
    atom.name, atom.element = name, gemmi.Element(element)
    assert is_hydrogen(atom) == hydrogen
