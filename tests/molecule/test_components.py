"""Names of nucleotides and of their atoms."""

from __future__ import annotations

import pytest

from loopelastica.atoms.chemistry import METHYLATED, Residue, loop_molecule
from loopelastica.molecule.components import (
    component,
    expected_atoms,
    is_nucleotide,
    is_standard,
    letter_of,
    sugar_of,
)


@pytest.mark.parametrize(
    ("name", "letter", "is_dna"),
    [
        *[("A", "A", False), ("DA", "A", True), ("DU", "U", True), ("T", "T", True)],
        *[("ADE", "A", None), ("THY", "T", True), ("RC5", "C", False), ("DG3", "G", True)],
        *[("5MU", "U", False), ("PSU", "U", False), ("H2U", "U", False), ("1MA", "A", False)],
        *[("N", "N", False), ("DN", "N", True), ("I", "G", False), ("A2M", "A", None)],
    ],
)
def test_what_names_mean(name, letter, is_dna):
    assert component(name) == (letter, is_dna)
    assert component(f" {name.lower()} ") == (letter, is_dna)


@pytest.mark.parametrize("name", ["ALA", "GLY", "HOH", "MG", "NA", "SO4", "", "UNK", "CYS"])
def test_what_is_no_nucleotide(name):
    assert component(name) is None
    assert not is_nucleotide(name, ["C1'", "N"])


@pytest.mark.parametrize("name", ["A", "C", "G", "U", "DA", "DC", "DG", "DT", "DU"])
def test_expected_atoms_are_those_that_are_built(name):
    residue = Residue(name[-1], len(name) > 1, name)
    molecule = loop_molecule([residue])
    built = {molecule.names[row] for row in molecule.loop_atoms}
    assert set(expected_atoms(name, residue.letter, residue.is_dna)) == built


def test_what_can_be_built_as_it_is():
    assert all(is_standard(name) for name in (*METHYLATED, "A", "DT", "DU", "GUA", "RA5"))
    assert not any(is_standard(name) for name in ("PSU", "N", "I", "GTP", "X1Y"))


def test_the_sugar_by_its_atoms():
    sugar = ["C1'", "C2'", "C3'"]
    assert sugar_of([*sugar, "O2*"]) is False
    assert sugar_of([*sugar, "F2'"]) is False
    assert sugar_of(sugar) is True
    assert sugar_of(["C1'"]) is None


def test_the_base_by_its_atoms():
    ring = ["N1", "C2", "N3", "C4", "C5", "C6"]
    assert letter_of([*ring, "N4"], is_dna=False) == "C"
    assert letter_of([*ring, "N9", "C8", "O6"], is_dna=False) == "G"
    assert letter_of([*ring, "O4", "C7"], is_dna=True) == "T"
    assert letter_of(ring[:-1], is_dna=True) == "N"


def test_every_methylated_nucleotide_is_known_by_its_name():
    for name, methyls in METHYLATED.items():
        known = component(name)
        assert known is not None, name
        # a carrier that the parent has
        names = expected_atoms(known.letter, known.letter, is_dna=False)
        assert {carrier for _, carrier in methyls} <= set(names)
    assert component("5MC").letter == "C"
