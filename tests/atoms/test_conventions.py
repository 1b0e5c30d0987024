"""Names against the templates of OpenMM's force fields and a file that CHARMM wrote."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from nucleotides import ends, of_file, strand

from loopelastica.atoms.conventions import conventional
from loopelastica.atoms.hydrogens import add_hydrogens

NOTHING = np.zeros((0, 3))


def template(file, residue):
    """Names of the atoms of a template of OpenMM."""
    app = pytest.importorskip("openmm.app")
    text = (Path(app.__file__).parent / "data" / file).read_text()
    own = re.search(rf'<Residue name="{residue}".*?</Residue>', text, re.DOTALL)[0]
    return set(re.findall(r'<Atom [^>]*?name="([^"]+)"', own))


def written(sequence, is_dna, convention):
    """Names of residues and atoms of a strand with hydrogens."""
    monomers, bonded = strand(sequence, is_dna), ends(len(sequence))
    found = add_hydrogens(monomers, bonded, NOTHING)
    for one, own, (before, after) in zip(monomers, found, bonded, strict=True):
        names = [*one.atoms_A, *own]
        yield conventional(one, is_dna, names, not before, not after, convention)


@pytest.mark.parametrize(("sequence", "is_dna"), [("ACGUACGUACGU", False), ("ACGTACGTACGT", True)])
def test_ambers_names_are_those_of_its_templates(sequence, is_dna):
    file = "amber14/DNA.OL15.xml" if is_dna else "amber14/RNA.OL3.xml"
    found = list(written(sequence, is_dna, "amber"))
    for resname, names in found:
        assert set(names) == template(file, resname)
    parent = "D" if is_dna else ""
    assert [found[k][0] for k in (0, 1, -1)] == [
        f"{parent}A5", f"{parent}C", f"{parent}{sequence[-1]}3"
    ]  # fmt: skip


def test_ambers_name_of_a_nucleotide_alone():
    ((resname, names),) = written("A", True, "amber")
    assert resname == "DAN"
    assert set(names) == template("amber14/DNA.OL15.xml", "DAN")


@pytest.mark.parametrize("position", range(1, 5))
def test_charmms_names_are_those_of_its_templates(position):
    resname, names = list(written("GACGUA", False, "charmm"))[position]
    assert set(names) == template("charmm36.xml", resname)


def test_charmms_thymidine_has_its_methyl_group_by_other_names():
    resname, names = list(written("GTA", True, "charmm"))[1]
    assert resname == "THY"
    assert set(names) == template("charmm36.xml", "THY") - {"O2'"}


def test_charmms_ends_have_names_of_their_own():
    found = list(written("GA", False, "charmm"))
    assert "H5T" in found[0][1]
    assert "H3T" in found[1][1]


def test_names_are_those_of_a_file_that_charmm_wrote(hairpin_folder):
    monomers, own = of_file(hairpin_folder / "1k5i_c36.pdb.gz")
    found = add_hydrogens(monomers, ends(len(monomers)), NOTHING)
    for one, new, old in zip(monomers[1:-1], found[1:-1], own[1:-1], strict=True):
        resname, names = conventional(one, False, new, False, False, "charmm")
        assert resname == one.resname
        assert set(names) == set(old)


def test_a_modified_nucleotide_keeps_its_names():
    (one,) = strand("U", is_dna=False)
    for name in ("PSU", "5MU", "XQZ"):
        for convention in ("pdb", "amber", "charmm"):
            got = conventional(
                replace(one, resname=name), False, ["P", "HO2'"], True, True, convention
            )
            assert got == (name, ("P", "HO2'"))


def test_a_chain_that_begins_with_a_phosphate_has_no_name_of_a_beginning():
    assert conventional("G", False, ["P", "O5'"], True, False, "amber")[0] == "G"
    assert conventional("G", False, ["P", "O5'"], True, True, "amber")[0] == "G3"


def test_the_files_own_names_are_kept_by_default():
    (one,) = strand("G", is_dna=False)
    assert conventional(replace(one, resname="RG5"), False, ["HO2'"], True, False) == (
        "RG5",
        ("HO2'",),
    )


def test_an_unknown_convention_is_refused():
    with pytest.raises(ValueError, match="`names` is 'gromos'"):
        conventional("G", False, [], True, True, "gromos")
