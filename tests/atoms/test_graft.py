"""A nucleotide of a template becomes the one that is to be built."""

import numpy as np
import pytest

from loopelastica.atoms.chemistry import Residue, atom_names
from loopelastica.atoms.fibre import fibre_nucleotide
from loopelastica.atoms.graft import grafted
from loopelastica.atoms.measures import chi_torsion, torsion_deg
from loopelastica.molecule.nucleotides import BACKBONE
from loopelastica.molecule.polymer import Monomer
from loopelastica.molecule.templates import monomer_of

GLYCOSIDIC = {"A": "N9", "G": "N9", "C": "N1", "U": "N1", "T": "N1"}


@pytest.fixture
def syn_g(koc):
    """G9 of 2KOC, which is syn."""
    return monomer_of(koc.nucleotides, 8, koc.positions(0))


@pytest.fixture
def u(koc):
    return monomer_of(koc.nucleotides, 6, koc.positions(0))


def ideal(letter, is_dna):
    return Monomer("A", 1, "", letter, letter, is_dna, atoms_A=fibre_nucleotide(letter, is_dna))


def chi(letter, atoms):
    return torsion_deg(*(atoms[name] for name in chi_torsion(letter)))


def normal(atoms):
    ring = np.array([atoms[name] for name in ("N1", "C2", "N3", "C4", "C5", "C6")])
    return np.linalg.svd(ring - ring.mean(axis=0))[2][2]


def test_the_same_nucleotide_keeps_all_its_atoms(syn_g):
    found = grafted(syn_g, Residue("G", False, "G"))
    assert set(found) == set(atom_names(Residue("G", False, "G")))
    for name, at in found.items():
        np.testing.assert_array_equal(at, syn_g.atoms_A[name])


@pytest.mark.parametrize("is_dna", [False, True])
@pytest.mark.parametrize("letter", "ACGUT")
def test_another_base_lies_on_the_same_bond_in_the_same_plane(syn_g, u, letter, is_dna):
    for template in (syn_g, u):
        kind = Residue(letter, is_dna, letter)
        found = grafted(template, kind)
        assert set(found) == set(atom_names(kind)) - {name for name, _ in kind.methyls}
        for name in BACKBONE:
            np.testing.assert_array_equal(found[name], template.atoms_A[name])
        own, other = GLYCOSIDIC[letter], GLYCOSIDIC[template.letter]
        axis, wanted = (at[x] - at["C1'"] for at, x in
                        ((found, own), (template.atoms_A, other)))  # fmt: skip
        cosine = axis @ wanted / np.linalg.norm(axis) / np.linalg.norm(wanted)
        assert cosine > 0.999
        assert abs(normal(found) @ normal(template.atoms_A)) > 0.98
        turn = chi(letter, found) - chi(template.letter, template.atoms_A)
        assert abs((turn + 180) % 360 - 180) < 6


def test_the_sugar_gets_what_it_lacks_and_loses_what_it_must_not_have(syn_g):
    assert "O2'" not in grafted(syn_g, Residue("G", True, "DG"))
    dna = ideal("G", True)
    found = grafted(dna, Residue("G", False, "G"))
    assert np.linalg.norm(found["O2'"] - found["C2'"]) == pytest.approx(1.41, abs=0.06)
    for far in ("C1'", "C3'"):
        assert np.linalg.norm(found["O2'"] - found[far]) > 2.1


def test_pseudouridine_is_a_uridine_on_its_own_bond(u):
    """C5 of pseudouridine stands where N1 of uridine does."""
    renamed = {"N1": "C5", "C5": "N1", "C2": "C4", "C4": "C2", "O2": "O4", "O4": "O2"}
    atoms = {renamed.get(name, name): at for name, at in u.atoms_A.items()}
    psu = Monomer("A", 7, "", "PSU", "U", False, atoms_A=atoms)
    found = grafted(psu, Residue("U", False, "U"))
    assert np.linalg.norm(found["N1"] - found["C1'"]) == pytest.approx(1.47, abs=0.04)
    for name in ("N1", "N3", "C6"):
        assert np.linalg.norm(found[name] - u.atoms_A[name]) < 0.3


def test_without_a_base_the_sugar_is_left(u):
    bare = {name: at for name, at in u.atoms_A.items() if "'" in name or "P" in name}
    found = grafted(Monomer("A", 7, "", "U", "N", False, atoms_A=bare), Residue("A", False, "A"))
    assert set(found) == set(bare)


def test_a_base_that_is_a_heap_places_none(u):
    heap = {name: at if "'" in name or "P" in name else u.atoms_A["C1'"]
            for name, at in u.atoms_A.items()}  # fmt: skip
    found = grafted(Monomer("A", 7, "", "U", "U", False, atoms_A=heap), Residue("A", False, "A"))
    assert "N9" not in found
    assert all(np.isfinite(at).all() for at in found.values())
