import numpy as np
import pytest

from loopelastica._files import data_path
from loopelastica.errors import StructureError
from loopelastica.studies.simulation.cases import (
    BUILT,
    Case,
    built_cases,
    file_cases,
    nucleotides,
    write_nucleotides,
)


def test_the_built_hairpins_are_twenty_of_both_kinds_with_all_lengths_and_wobbles():
    texts = [text for of_kind in BUILT.values() for text in of_kind]
    assert len(set(texts)) == 20
    loops = {
        kind: {len(text.split("(")[1].split(")")[0]) for text in own} for kind, own in BUILT.items()
    }
    assert loops["RNA"] == loops["DNA"] - {10} | {10} == set(range(3, 11))
    for kind, wobbles in (("RNA", {"GU", "UG"}), ("DNA", {"GT", "TG"})):
        pairs = set()
        for text in BUILT[kind]:
            five, rest = text.split("(")
            pairs |= {a + b for a, b in zip(five, reversed(rest.split(")")[1]), strict=True)}
        assert wobbles <= pairs


def test_a_file_gives_each_simple_loop_as_it_is_folded_and_as_it_is(tmp_path):
    folded, native = file_cases(tmp_path, data_path("hairpins/2koc.pdb"))
    assert (folded.source, native.source) == ("folded", "native")
    for case in (folded, native):
        assert case.failure is None
        assert case.kind == "RNA"
        assert case.sequence == "CUUCGG"
        assert case.loop == {("A", str(number)) for number in range(6, 10)}
        text = case.path.read_text()
        assert "HO2'" in text
        assert "CRYST1" not in text
        # 2KOC has a phosphate at its 5' end
        assert "P" in nucleotides(case.path)[0].atoms_A
        assert "HO5'" in case.bare.read_text()
        assert "P" not in nucleotides(case.bare)[0].atoms_A
    for one, own in zip(
        nucleotides(native.path), nucleotides(data_path("hairpins/2koc.pdb")), strict=True
    ):
        assert sorted(one.atoms_A) == sorted(own.atoms_A)


@pytest.mark.parametrize("chain", ["", "RNA1"])
def test_a_chain_without_a_letter_is_found_in_the_files_that_are_written(
    tmp_path, koc_lines, write_cif, chain
):
    if chain:
        file = write_cif(tmp_path / "koc.cif", chain)
    else:
        file = tmp_path / "koc.pdb"
        lines = [f"{line[:21]} {line[22:]}" for line in koc_lines]
        file.write_text("\n".join([*lines, "END", ""]))
    for case in file_cases(tmp_path, file):
        written = {(one.chain, str(one.number)) for one in nucleotides(case.path)}
        assert case.loop < written


def test_a_file_that_cannot_be_used_is_a_case_with_its_reason(tmp_path):
    path = tmp_path / "none.pdb"
    path.write_text("nothing\n")
    (case,) = file_cases(tmp_path, path)
    assert case.path is None
    assert "this is not a PDB structure" in case.failure


def test_a_sequence_that_cannot_be_folded_is_a_case_with_its_reason(tmp_path, monkeypatch):
    def fold_sequence(*_, **__):
        raise StructureError("the stem is none")

    monkeypatch.setattr("loopelastica.studies.simulation.cases.fold_sequence", fold_sequence)
    (case,) = built_cases(tmp_path, {"RNA": ("GGC(GAAA)GCC",)})
    assert (case.path, case.failure) == (None, "the stem is none")


def test_a_file_without_5_phosphate_gives_one_file(tmp_path, koc_lines):
    phosphate = ("P", "OP1", "OP2", "OP3")
    path = tmp_path / "hydroxyl.pdb"
    own = [
        line for line in koc_lines if int(line[22:26]) > 1 or line[12:16].strip() not in phosphate
    ]
    path.write_text("\n".join([*own, "END", ""]))
    for case in file_cases(tmp_path, path):
        assert case.bare is None
        assert "HO5'" in case.path.read_text()


def test_modified_nucleotides_keep_their_names(tmp_path):
    found = nucleotides(data_path("hairpins/2koc.pdb"))[:2]
    changed = [type(m)(m.chain, m.number, "", "PSU", "U", False, atoms_A=m.atoms_A) for m in found]
    write_nucleotides(tmp_path / "psu.pdb", changed)
    assert [one.resname for one in nucleotides(tmp_path / "psu.pdb")] == ["PSU", "PSU"]


def test_a_case_has_a_path_of_harmless_letters(tmp_path):
    case = Case("built", "GG(A/..)CC", "RNA", "")
    assert case.place(tmp_path).parent == tmp_path


@pytest.mark.parametrize("kind", ["RNA", "DNA"])
def test_built_models_come_with_hydrogens(tmp_path, kind):
    (case,) = built_cases(tmp_path, {kind: BUILT[kind][:1]})
    assert case.failure is None
    names = {line[12:16].strip() for line in case.path.read_text().splitlines() if "ATOM" in line}
    assert {"HO5'", "HO3'", "H5''"} <= names
    assert np.isin("HO2'", list(names)) == (kind == "RNA")
