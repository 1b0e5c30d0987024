import pytest
from gemmi import cif
from strand import NAMES, added, cif_text

from loopelastica.report.compose import Changes
from loopelastica.report.compose_cif import compose_cif

SCHEME = (
    "loop_",
    *(
        f"_pdbx_poly_seq_scheme.{name}"
        for name in (
            *("asym_id", "entity_id", "seq_id", "mon_id", "ndb_seq_num", "pdb_seq_num"),
            *("auth_seq_num", "pdb_mon_id", "auth_mon_id", "pdb_strand_id", "pdb_ins_code"),
        )
    ),
    "A 1 2 U 2 102 102 U URI X .",
    "A 1 3 U 3 103 ? ? ? X .",
    "A 1 4 U 4 104 ? ? ? X .",
    "B 1 3 U 3 103 ? ? ? Y .",
)
_PLACE = ("PDB_model_num", "polymer_flag", "occupancy_flag", "auth_asym_id", "auth_comp_id")
RESIDUES = (
    "loop_",
    *(
        f"_pdbx_unobs_or_zero_occ_residues.{name}"
        for name in ("id", *_PLACE, "auth_seq_id", "PDB_ins_code")
    ),
)


def _gap(*numbers, **more):
    chain = more.pop("chain", "X")
    return tuple(added(n, (chain, n - 1, ""), chain=chain, **more) for n in numbers)


def _block(text, **changes):
    return cif.read_string(compose_cif(text, Changes(**changes))).sole_block()


def test_the_scheme_has_the_number_and_name_of_what_was_filled():
    block = _block(cif_text([1, 2, 5], *SCHEME), added=_gap(103))
    rows = [list(row) for row in block.find_mmcif_category("_pdbx_poly_seq_scheme.")]
    assert [" ".join(row) for row in rows] == [
        "A 1 2 U 2 102 102 U URI X .",
        "A 1 3 U 3 103 103 U U X .",
        "A 1 4 U 4 104 ? ? ? X .",
        "B 1 3 U 3 103 ? ? ? Y .",
    ]


def test_of_two_names_of_one_place_the_scheme_gets_the_one_that_was_built():
    rows = [*SCHEME[:-3], "A 1 3 C 3 103 ? ? ? X .", *SCHEME[-3:]]
    block = _block(cif_text([1, 2, 5], *rows), added=_gap(103, record=3))
    names = block.get_mmcif_category("_pdbx_poly_seq_scheme.")["pdb_mon_id"]
    assert names == ["U", None, "U", None, None]


def test_filled_nucleotides_leave_those_that_were_not_observed():
    rows = ("1 1 Y 1 X U 103 ?", "2 1 Y 1 X U 104 ?", "3 1 Y 1 Y U 103 ?", "4 1 Y 0 X U 103 ?")
    block = _block(cif_text([1, 2, 5], *RESIDUES, *rows), added=_gap(103))
    ids = block.get_mmcif_category("_pdbx_unobs_or_zero_occ_residues.")["id"]
    assert ids == ["2", "3", "4"]


@pytest.mark.parametrize("is_loop", [True, False])
def test_an_emptied_table_goes(is_loop):
    row = "1 1 Y 1 X U 103 ?"
    names = [line for line in RESIDUES if line != "loop_"]
    pairs = [f"{n} {v}" for n, v in zip(names, row.split(), strict=True)]
    block = _block(cif_text([1, 2, 5], *([*RESIDUES, row] if is_loop else pairs)), added=_gap(103))
    assert "_pdbx_unobs_or_zero_occ_residues." not in block.get_mmcif_category_names()


def test_a_nucleotide_is_unobserved_in_the_models_that_lack_it():
    rows = ("1 1 Y 1 X U 103 ?", "2 2 Y 1 X U 103 ?", "3 ? Y 1 X U 103 ?")
    text = cif_text([1, 2, 5], *RESIDUES, *rows, models=2)
    block = _block(text, added=_gap(103, model=1))
    assert block.get_mmcif_category("_pdbx_unobs_or_zero_occ_residues.")["id"] == ["1", "3"]
    both = _gap(103, model=1) + _gap(103)
    names = _block(text, added=both).get_mmcif_category_names()
    assert "_pdbx_unobs_or_zero_occ_residues." not in names


def test_completed_atoms_leave_those_that_were_not_observed():
    head = [line.replace("residues", "atoms") for line in RESIDUES]
    head.append("_pdbx_unobs_or_zero_occ_atoms.auth_atom_id")
    rows = ('1 1 Y 1 X U 102 ? "C1\'"', "2 1 Y 1 X U 102 ? N1", "3 1 Y 1 X U 101 ? N1")
    text = cif_text([1, 2], *head, *rows)
    partial = [r for r in text.split("\n") if not (" 102 U X" in r and '"C1\'"' in r)]
    new = _gap(102, names=("C1'",))
    block = _block("\n".join(partial), added=new)
    assert block.get_mmcif_category("_pdbx_unobs_or_zero_occ_atoms.")["id"] == ["2", "3"]


@pytest.mark.parametrize(
    ("software", "expected"),
    [
        ((), {"pdbx_ordinal": ["1"], "name": ["le"], "version": ["2"]}),
        (
            ("_software.name CNS", "_software.citation_id ?", "_software.pdbx_ordinal 4"),
            {
                "name": ["CNS", "le"],
                "citation_id": [None] * 2,
                "pdbx_ordinal": ["4", "5"],
                "version": [None, "2"],
            },
        ),
        (
            (
                "loop_",
                "_software.name",
                "_software.version",
                "_software.pdbx_ordinal",
                "A 1 1",
                "B 2 7",
            ),
            {"name": ["A", "B", "le"], "version": ["1", "2", "2"], "pdbx_ordinal": ["1", "7", "8"]},
        ),
    ],
)
def test_the_software_says_what_it_did(software, expected):
    block = _block(cif_text([1, 2, 5], *software), added=_gap(103), software=("le", "2"))
    found = block.get_mmcif_category("_software.")
    assert found.pop("classification")[-1] == "model building"
    assert found == expected
    again = compose_cif(
        cif.Document.as_string(_document(block)), Changes(added=_gap(104), software=("le", "2"))
    )
    found = cif.read_string(again).sole_block().get_mmcif_category("_software.")
    assert found["name"] == expected["name"]


def _document(block):
    document = cif.Document()
    document.add_copied_block(block)
    return document


def test_notes_are_remark_99():
    remark = ("_database_PDB_remark.id 3", "_database_PDB_remark.text 'REFINEMENT.'")
    notes = ("Nucleotides X.103-104 (UU) were modelled, 2.0 Å apart; " * 3, ";odd 'quotes\"")
    for more in ((), remark):
        block = _block(cif_text([1, 2, 5], *more), added=_gap(103), notes=notes)
        found = block.get_mmcif_category("_database_PDB_remark.")
        assert found["id"] == [*(["3"] if more else []), "99"]
        text = found["text"][-1]
        assert "2.0 A apart" in text
        assert text.endswith("\n ;odd 'quotes\"")
        assert max(map(len, text.split("\n"))) <= 80


def test_a_remark_99_that_is_there_goes_on():
    remark = ("_database_PDB_remark.id 99", "_database_PDB_remark.text 'An earlier one.'")
    block = _block(cif_text([1, 2, 5], *remark), added=_gap(103), notes=("Modelled.",))
    found = block.get_mmcif_category("_database_PDB_remark.")
    assert found == {"id": ["99"], "text": ["An earlier one.\nModelled."]}


def test_single_values_and_text_fields_stay_as_they_are():
    more = (
        "_entry.id test",
        "_struct.title\n;two\nlines\n;",
        "_cell.length_a 10.00",
        "_exptl.method 'X-RAY DIFFRACTION'",
        "_odd.value ?",
        "_odd.other .",
    )
    block = _block(cif_text([1, 2, 5], *more), added=_gap(103))
    old = cif.read_string(cif_text([1, 2, 5], *more)).sole_block()
    names = [name for name in old.get_mmcif_category_names() if name != "_atom_site."]
    assert block.get_mmcif_category_names() == old.get_mmcif_category_names()
    for name in names:
        new, was = (list(b.find_mmcif_category(name)[0]) for b in (block, old))
        assert new == was
    assert len(block.find("_atom_site.", ["id"])) == 4 * len(NAMES)
