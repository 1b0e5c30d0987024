"""Hydrogens and 5' phosphates of the files."""

import numpy as np
from atom_lines import LOOP, identity, is_hydrogen, line, number, records

from loopelastica.report.model_pdb import pdb_text


def written(atoms, model=1):
    return records(pdb_text(atoms.held, atoms.written, None), model)


def hydrogens(lines):
    return {(number(one), one[12:16].strip()): one[30:54] for one in lines if is_hydrogen(one)}


def test_a_stem_with_hydrogens_keeps_its_own_and_the_loop_gets_all(of_lines, koc_lines):
    own = hydrogens(koc_lines)
    now = hydrogens(written(of_lines(koc_lines, hydrogens=True)))
    assert {k: v for k, v in now.items() if k[0] not in LOOP} == {
        k: v for k, v in own.items() if k[0] not in LOOP
    }
    # the file names the same ones in its own loop, which is another one
    assert {k for k in now if k[0] in LOOP} == {k for k in own if k[0] in LOOP}


def test_a_file_without_hydrogens_gets_them_everywhere(of_lines, koc_lines):
    heavy = [one for one in koc_lines if not is_hydrogen(one)]
    now, own = hydrogens(written(of_lines(heavy, hydrogens=True))), hydrogens(koc_lines)
    # a phosphate has none; 2KOC calls it so
    assert set(now) == set(own) - {(1, "HO5'")}
    # what cannot turn is where the spectroscopists have it
    fixed = [key for key in now if key[0] not in LOOP and key[1] in ("H1'", "H6", "H8", "H3'")]
    places = (np.array([float(of[key][k : k + 8]) for k in (0, 8, 16)]) for of in (now, own)
              for key in fixed)  # fmt: skip
    first, second = np.array(list(places)).reshape(2, -1, 3)
    assert np.linalg.norm(first - second, axis=1).max() < 0.1


def test_hydrogens_of_other_names_are_placed_anew_and_that_is_said(of_lines, koc_lines):
    lines = [one.replace(" H8 ", "1H8 ") if number(one) == 2 else one for one in koc_lines]
    atoms = of_lines(lines, hydrogens=True)
    assert set(hydrogens(written(atoms))) == set(hydrogens(koc_lines))
    assert any("at A.G2;" in remark for remark in atoms.remarks)


def test_hydrogens_that_lack_are_added_to_those_of_the_file_and_that_is_said(of_lines, koc_lines):
    lacks = [one for one in koc_lines if (number(one), one[12:16].strip()) != (4, "H2")]
    atoms = of_lines(lacks, hydrogens=True)
    now, own = hydrogens(written(atoms)), hydrogens(koc_lines)
    assert set(now) == set(own)
    assert all(now[key] == own[key] for key in now if key[0] not in LOOP and key != (4, "H2"))
    assert any("added at A.A4" in remark for remark in atoms.remarks)


def test_every_hydrogen_is_bonded_to_one_atom_and_near_no_other(of_lines, koc_lines):
    heavy = [one for one in koc_lines if not is_hydrogen(one)]
    atoms = of_lines(heavy, hydrogens=True)
    for model in range(1, len(atoms.written) + 1):
        lines = written(atoms, model)
        places = np.array([[float(one[k : k + 8]) for k in (30, 38, 46)] for one in lines])
        which = np.array([is_hydrogen(one) for one in lines])
        apart = np.linalg.norm(places[which, None] - places[None, ~which], axis=2)
        assert ((apart < 1.15).sum(axis=1) == 1).all()
        assert ((apart < 1.5).sum(axis=1) == 1).all()


def test_hydrogens_near_the_loop_are_placed_for_each_model(of_lines, koc_lines):
    heavy = [one for one in koc_lines if not is_hydrogen(one)]
    atoms = of_lines(heavy, hydrogens=True)
    first, second = (hydrogens(written(atoms, k)) for k in (1, 2))
    assert set(first) == set(second)
    assert all(first[key] != second[key] for key in first if key[0] in LOOP)


def test_a_5_phosphate_is_named(of_lines, koc_lines, atoms):
    for options in ({}, {"hydrogens": True}):
        remarks = of_lines(koc_lines, **options).remarks
        assert any("A.G1" in one and "--no-5-phosphate" in one for one in remarks)


def test_a_5_phosphate_is_taken_off_on_request(of_lines, koc_lines):
    atoms = of_lines(koc_lines, no_5_phosphate=True, hydrogens=True)
    names = {one[12:16].strip() for one in written(atoms) if number(one) == 1}
    assert not names & {"P", "OP1", "OP2", "OP3", "HOP3", "HOP2"}
    assert "HO5'" in names
    lines = {one[12:16].strip(): one for one in written(atoms) if number(one) == 1}
    o5, ho5 = (
        np.array([float(lines[name][k : k + 8]) for k in (30, 38, 46)]) for name in ("O5'", "HO5'")
    )
    # 2KOC has one of that name on its phosphate
    assert np.linalg.norm(o5 - ho5) < 1.0
    assert any("taken off at A.G1" in remark for remark in atoms.remarks)
    # inside the chain nothing is taken off
    assert {"P", "OP1", "OP2"} <= {one[12:16].strip() for one in written(atoms) if number(one) == 2}


def test_without_hydrogens_it_is_taken_off_too(of_lines, koc_lines):
    lines = written(of_lines(koc_lines, no_5_phosphate=True))
    assert "P" not in {one[12:16].strip() for one in lines if number(one) == 1}
    assert not any(map(is_hydrogen, lines))


def test_an_oxygen_that_gets_a_hydrogen_has_no_charge(of_lines, koc_lines):
    def charged(one):
        ends = number(one) == 14 and one[12:16].strip() == "O3'"
        return f"{one[:78]:<78}1-" if ends else one

    heavy = [charged(one) for one in koc_lines if not is_hydrogen(one)]
    (with_charge,) = (one for one in written(of_lines(heavy)) if one.rstrip().endswith("1-"))
    assert identity(with_charge)[0] == "O3'"
    atoms = of_lines(heavy, "again.pdb", hydrogens=True)
    assert not any(one.rstrip().endswith("1-") for one in written(atoms))


def test_other_molecules_keep_their_hydrogens(of_lines, koc_lines):
    far = np.array([60.0, 0.0, 0.0])
    protein = [line(900, "N", "GLY", "B", 1, far), line(901, "H", "GLY", "B", 1, far + 0.6)]
    lines = written(of_lines([*koc_lines, *protein], hydrogens=True))
    assert [identity(one)[:2] for one in lines[-2:]] == [("N", "GLY"), ("H", "GLY")]
