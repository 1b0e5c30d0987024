"""PDB files of models."""

import re

import numpy as np
import pytest
from atom_lines import LOOP, is_hydrogen, line, number, records

from loopelastica.errors import StructureError
from loopelastica.report.model_pdb import no_room, pdb_text

FAR = np.array([60.0, 60.0, 60.0])


def text_of(atoms, **options):
    return pdb_text(atoms.held, atoms.written, None, **options)


def kinds(text):
    return [one[:6].strip() for one in text.splitlines()]


def test_there_is_a_model_for_each_sound_candidate_with_ter_after_the_strand(atoms):
    text = text_of(atoms)
    assert kinds(text).count("MODEL") == kinds(text).count("ENDMDL") == len(atoms.written) == 2
    for part in text.split("ENDMDL")[:2]:
        body = [one for one in part.splitlines() if one.startswith(("ATOM", "HETATM", "TER"))]
        assert body[-1].startswith("TER")
        assert body[-1][17:26] == body[-2][17:26]
        serials = [int(one[6:11]) for one in body]
        assert serials == list(range(1, len(body) + 1))


def test_one_candidate_by_itself_is_a_plain_structure(atoms):
    text = pdb_text(atoms.held, atoms.written[1:], None, single=True)
    assert not {"MODEL", "ENDMDL"} & set(kinds(text))
    assert records(text) == records(text_of(atoms), 2)


def test_residue_names_end_in_their_columns_and_lines_are_not_too_long(atoms):
    text = text_of(atoms)
    assert {one[17:21] for one in records(text)} == {f"  {letter} " for letter in "ACGU"}
    assert max(map(len, text.splitlines())) <= 80
    assert text.isascii()


def test_no_unit_cell_is_invented_and_a_real_one_is_kept(of_lines, koc_lines):
    cell = "CRYST1   54.981   33.389   61.921  90.00  90.20  90.00 P 1 21 1      4"
    fake = "CRYST1    1.000    1.000    1.000  90.00  90.00  90.00 P 1           1"
    assert "CRYST1" not in text_of(of_lines(koc_lines))
    assert "CRYST1" not in text_of(of_lines([fake, *koc_lines], "fake.pdb"))
    (kept,) = (one for one in text_of(of_lines([cell, *koc_lines], "cell.pdb")).splitlines()
               if one.startswith("CRYST1"))  # fmt: skip
    assert kept.split() == cell.split()[:-1]


@pytest.mark.parametrize("hydrogens", [False, True])
def test_conect_records_are_all_bonds_of_the_built_nucleotides(of_lines, koc_lines, hydrogens):
    atoms = of_lines(koc_lines, hydrogens=hydrogens)
    text = text_of(atoms)
    of = {int(one[6:11]): one for one in records(text)}
    bonds = {
        (int(one[6:11]), int(other))
        for one in text.splitlines()
        if one.startswith("CONECT")
        for other in one[11:].split()
    }
    assert {(j, i) for i, j in bonds} == bonds
    places = {k: np.array([float(one[c : c + 8]) for c in (30, 38, 46)]) for k, one in of.items()}
    mine = [k for k, one in of.items() if number(one) in LOOP]
    # by distance: hydrogens have one neighbour, others all within 1.75 Å
    reach = {k: 1.2 if is_hydrogen(one) else 1.75 for k, one in of.items()}
    near = {
        (k, j)
        for k in mine
        for j in of
        if j != k and np.linalg.norm(places[k] - places[j]) < min(reach[k], reach[j])
    }
    assert {(i, j) for i, j in bonds if i in mine} == near


def test_a_hydroxyl_at_the_5_end_is_bonded_too(of_lines, koc_lines):
    atoms = of_lines(koc_lines, hydrogens=True, no_5_phosphate=True)
    text = text_of(atoms)
    serial = {one[12:16].strip(): int(one[6:11]) for one in records(text) if number(one) == 1}
    hydrogen, oxygen = serial["HO5'"], serial["O5'"]
    assert f"CONECT{hydrogen:5d}{oxygen:5d}" in text.splitlines()


def test_insertion_codes_chains_and_segments_stay(of_lines, koc_lines):
    def other(one):
        code = "B" if number(one) > 10 else " "
        return f"{one[:26]}{code}{one[27:72]}RNA1{one[76:]}"

    atoms = of_lines(list(map(other, koc_lines)))
    lines = records(text_of(atoms))
    assert {one[26] for one in lines if number(one) > 10} == {"B"}
    assert {one[21] for one in lines} == {"A"}
    assert {one[72:76] for one in lines} == {"RNA1"}


def test_a_residue_name_of_four_letters_keeps_them_and_their_columns(of_lines, koc_lines):
    water = line(900, "OH2", "TIP", " ", 1, FAR, kind="HETATM")
    long = f"{water[:20]}3{water[21:]}"
    (found,) = (one for one in records(text_of(of_lines([*koc_lines, long]))) if "TIP" in one)
    assert found[17:21] == "TIP3"
    assert found[22:54] == long[22:54]


def test_what_the_format_cannot_hold_is_refused_with_the_reason(of_lines, koc_lines, monkeypatch):
    atoms = of_lines(koc_lines)
    assert no_room(atoms.held) == ""
    monkeypatch.setattr("loopelastica.report.model_pdb.LAST_SERIAL", 298)
    assert re.fullmatch(r"it needs 299 serial numbers, and there are 298", no_room(atoms.held))
    with pytest.raises(StructureError, match="mmCIF can"):
        text_of(atoms)
    assert any("atoms.pdb is not written, since it needs" in one for one in atoms.remarks)


def test_many_chains_and_long_numbers_have_no_room(of_lines, koc_lines):
    atoms = of_lines(koc_lines)
    atoms.assembly.residues[0].number = 10_000
    assert "the number of A.G10000 is not from -999 to 9999" in no_room(atoms.held)
    atoms = of_lines(koc_lines, "again.pdb")
    atoms.held.parts = [[type(r)(**{**as_dict(r), "chain": f"A{k}"})] for k in range(63)
                        for r in atoms.assembly.residues[:1]]  # fmt: skip
    assert "there are 63 chains, and letters for 62" in no_room(atoms.held)


def as_dict(residue):
    return {name: getattr(residue, name) for name in type(residue).__slots__}
