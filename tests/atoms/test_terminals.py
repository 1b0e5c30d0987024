"""Where chains begin and end."""

from dataclasses import replace

import numpy as np
from nucleotides import of_file, strand

from loopelastica._files import data_path
from loopelastica.atoms.terminals import (
    chain_bonds,
    phosphate_remark,
    phosphates_at_5,
    without_phosphate,
)


def test_bonds_along_a_chain_follow_from_where_atoms_are():
    monomers = strand("GAUC", is_dna=False)
    expected = [(False, True), (True, True), (True, True), (True, False)]
    assert chain_bonds(monomers) == expected
    # in any order, and with another chain beside
    away = [
        replace(one, chain="B", atoms_A={x: at + 50 for x, at in one.atoms_A.items()})
        for one in monomers
    ]
    mixed = [monomers[2], *away, monomers[0], monomers[3], monomers[1]]
    assert chain_bonds(mixed) == [
        expected[2], *expected, expected[0], expected[3], expected[1]
    ]  # fmt: skip


def test_a_gap_ends_a_chain():
    monomers = strand("GAUC", is_dna=False)
    del monomers[1]
    assert chain_bonds(monomers) == [(False, False), (False, True), (True, False)]


def test_what_is_no_number_is_no_bond():
    monomers = strand("GAU", is_dna=False)
    atoms = {**monomers[1].atoms_A, "P": np.full(3, np.nan)}
    monomers[1] = replace(monomers[1], atoms_A=atoms)
    assert chain_bonds(monomers) == [(False, False), (False, True), (True, False)]
    assert chain_bonds([]) == []


def test_a_5_phosphate_is_found_named_and_taken_off():
    monomers, _ = of_file(data_path("hairpins/2koc.pdb"))
    assert phosphates_at_5(monomers, chain_bonds(monomers)) == (0,)
    assert phosphate_remark(monomers[0]) == (
        "A.G1: its 5' phosphate is refused by Amber's and CHARMM's templates; --no-5-phosphate"
        " takes it off"
    )
    bare = without_phosphate(monomers[0])
    assert set(monomers[0].atoms_A) - set(bare.atoms_A) == {"P", "OP1", "OP2", "OP3"}
    assert phosphates_at_5([bare, *monomers[1:]], chain_bonds([bare, *monomers[1:]])) == ()


def test_a_chain_that_begins_with_an_oxygen_has_none():
    monomers = strand("GAUC", is_dna=True)
    assert phosphates_at_5(monomers, chain_bonds(monomers)) == ()
