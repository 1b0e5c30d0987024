import pytest
from strand import NAMES, added, pdb_lines

from loopelastica.report.compose import Changes, Removed
from loopelastica.report.compose_pdb import compose_pdb

N = len(NAMES)
GAP = Changes(added=(added(3, 2), added(4, 3)))
HEAD_465 = """\
REMARK 465
REMARK 465 MISSING RESIDUES
REMARK 465 THE FOLLOWING RESIDUES WERE NOT LOCATED IN THE
REMARK 465 EXPERIMENT. (M=MODEL NUMBER; RES=RESIDUE NAME; C=CHAIN
REMARK 465 IDENTIFIER; SSSEQ=SEQUENCE NUMBER; I=INSERTION CODE.)
REMARK 465
REMARK 465   M RES C SSSEQI""".splitlines()
HEAD_470 = """\
REMARK 470
REMARK 470 MISSING ATOM
REMARK 470 THE FOLLOWING RESIDUES HAVE MISSING ATOMS (M=MODEL NUMBER;
REMARK 470 RES=RESIDUE NAME; C=CHAIN IDENTIFIER; SSEQ=SEQUENCE NUMBER;
REMARK 470 I=INSERTION CODE):
REMARK 470   M RES CSSEQI  ATOMS""".splitlines()


def _filled(*lines, changes=GAP):
    text = compose_pdb("\n".join([*lines, ""]), changes)
    assert text is not None
    return text.splitlines()


def _remarks(lines, number):
    return [line for line in lines if line.startswith(f"REMARK {number:3d}")]


def _row(number, *, model=" ", chain="A", icode=" ", resname="U"):
    return f"REMARK 465   {model} {resname:>3} {chain} {number:5d}{icode}"


# --- residues and atoms that are missing no longer ------------------------------------------------


def test_filled_nucleotides_leave_remark_465_and_others_stay():
    rows = [_row(3), _row(4), _row(4, icode="A"), _row(3, chain="B"), _row(7)]
    out = _filled(*HEAD_465, *rows, *pdb_lines([1, 2, 5]))
    assert _remarks(out, 465) == [*HEAD_465, *rows[2:]]


@pytest.mark.parametrize("model", [" ", "1"])
def test_remark_465_goes_when_it_is_empty(model):
    rows = [_row(3, model=model), _row(4, model=model)]
    out = _filled("REMARK 400 BEFORE", *HEAD_465, *rows, "REMARK 500 AFTER", *pdb_lines([1, 2, 5]))
    assert [x for x in out if x.startswith("REMARK")] == ["REMARK 400 BEFORE", "REMARK 500 AFTER"]


def test_rows_without_chain_are_those_of_a_file_without_chains():
    lines = [f"{x[:21]} {x[22:]}" for x in pdb_lines([1, 2, 15])]
    rows = [_row(13, chain=" "), _row(14, chain=" "), _row(16, chain=" ")]
    gap = Changes(added=(added(13, 2, chain=""), added(14, 13, chain="")))
    assert _remarks(_filled(*HEAD_465, *rows, *lines, changes=gap), 465) == [*HEAD_465, rows[2]]


def test_a_nucleotide_that_some_models_lack_still_stays_in_remark_465():
    models = [
        line
        for k in (0, 1)
        for line in (f"MODEL     {k + 1:4d}", *pdb_lines([1, 2, 5], model=k), "ENDMDL")
    ]
    head = [*HEAD_465[:-1], "REMARK 465   MODELS 1-2", "REMARK 465     RES C SSSEQI"]
    rows = [_row(3), _row(4)]
    changes = Changes(added=(*(added(3, 2, model=m) for m in (0, 1)), added(4, 3, model=1)))
    out = _filled(*head, *rows, *models, changes=changes)
    assert _remarks(out, 465) == [*head, rows[1]]
    per_model = [_row(3, model="1"), _row(4, model="1"), _row(3, model="2"), _row(4, model="2")]
    out = _filled(*HEAD_465, *per_model, *models, changes=changes)
    assert _remarks(out, 465) == [*HEAD_465, per_model[1]]


def test_completed_atoms_leave_remark_470():
    lines = [*pdb_lines([1]), *pdb_lines([2], serial=N + 1, names=NAMES[:4])]
    row = "REMARK 470       U A   2    C4'  C3'  O3'  C1'  N1   C6"
    other = "REMARK 470       U A   1    C6"
    changes = Changes(added=(added(2, 1, names=NAMES[4:7]),))
    out = _filled(*HEAD_470, row, other, *lines, changes=changes)
    left = "REMARK 470       U A   2    C1'  N1   C6"
    assert _remarks(out, 470) == [*HEAD_470, left, other]
    changes = Changes(added=(added(2, 1, names=NAMES[4:]),))
    out = _filled(*HEAD_470, "REMARK 470       U A   2    C4'  C3'  N1", *lines, changes=changes)
    assert _remarks(out, 470) == []


# --- notes ----------------------------------------------------------------------------------------


def test_notes_are_remark_99_in_the_order_of_the_remarks_and_80_columns_wide():
    note = "Nucleotides A.3-4 (UU) were modelled by a program " * 3 + "within 2.0 Å – no more"
    head = ["HEADER    RNA", "REMARK   2", "REMARK   2 RESOLUTION.", "REMARK 100", "SEQRES"]
    out = _filled(*head, *pdb_lines([1, 2, 5]), changes=Changes(notes=(note,)))
    remarks = _remarks(out, 99)
    assert out[: 3 + len(remarks) + 2] == [*head[:3], *remarks, *head[3:]]
    assert {len(line) for line in remarks} == {80}
    text = " ".join(line[10:].strip() for line in remarks).strip()
    assert text == note.replace("Å", "A").replace("–", "-").replace("  ", " ")
    assert all(line.isascii() for line in remarks)


@pytest.mark.parametrize(
    ("head", "place"),
    [
        ((), 0),
        (("HEADER    RNA", "TITLE     X", "SEQRES   1 A"), 2),
        (("CRYST1   10.000   10.000   10.000  90.00  90.00  90.00 P 1",), 0),
        (("REMARK 465 ROWS",), 0),
        (("REMARK   4", "REMARK  99 AN EARLIER ONE", "REMARK 100"), 2),
        (("REMARK by hand",), 1),
    ],
)
def test_notes_stand_behind_the_title_where_there_is_no_remark(head, place):
    out = _filled(*head, *pdb_lines([1, 2]), changes=Changes(notes=("Modelled.",)))
    assert [line.rstrip() for line in out[place : place + 2]] == [
        "REMARK  99",
        "REMARK  99 Modelled.",
    ]
    assert out[:place] + out[place + 2 :] == [*head, *pdb_lines([1, 2])]


def test_a_note_of_one_long_word_is_broken():
    out = _filled(*pdb_lines([1]), changes=Changes(notes=("x" * 200,)))
    assert [len(line.rstrip()) for line in _remarks(out, 99)] == [10, 80, 80, 73]


# --- what names a water ---------------------------------------------------------------------------


def _water(serial, number):
    return f"HETATM{serial:5d}  O   HOH A{number:4d}    {number:8.3f}  50.000   0.000  1.00 20.00"


def test_links_sites_and_counts_follow_a_water_that_went():
    lines = [
        "FORMUL   2  HOH   *12(H2 O)",
        "LINK         O   HOH A 101                MG    MG A 201     1555   1555  2.10",
        "LINK         O   HOH A 102                MG    MG A 201     1555   1555  2.10",
        "SITE     1 AC1  6   U A   1    U A   2  HOH A 101  HOH A 102",
        "SITE     2 AC1  6   U A   3    U A   4",
        "SITE     1 AC2  1 HOH A 101",
        *pdb_lines([1, 2]),
        _water(50, 101),
        _water(51, 102),
        _master(0, 2 * N + 2, 0, 0, sites=3),
    ]
    changes = Changes(removed=(Removed(0, "A", 101, "", "HOH"),))
    out = _filled(*lines, changes=changes)
    assert out == [
        "FORMUL   2  HOH   *11(H2 O)",
        lines[2],
        "SITE     1 AC1  5   U A   1    U A   2  HOH A 102    U A   3",
        "SITE     2 AC1  5   U A   4",
        *pdb_lines([1, 2]),
        _water(51, 102),
        _master(0, 2 * N + 1, 0, 0, sites=2),
    ]


# --- MASTER ---------------------------------------------------------------------------------------


def _master(remarks, atoms, ters, conects, sites=0):
    fields = (remarks, 0, 0, 0, 0, 0, sites, 6, atoms, ters, conects, 2)
    return "MASTER    " + "".join(f"{field:5d}" for field in fields) + "          "


def test_master_counts_what_is_there():
    lines = [*HEAD_465, _row(3), _row(4), *pdb_lines([1, 2, 5]), "TER", f"CONECT{1:5d}{2:5d}"]
    changes = Changes(added=GAP.added, notes=("Modelled.",))
    out = _filled(*lines, _master(9, 3 * N, 1, 1), "END", changes=changes)
    assert out[-2] == _master(2, 5 * N, 1, 1)


@pytest.mark.parametrize("models", [1, 2])
def test_master_counts_all_models_or_the_first_one_as_before(models):
    lines = [
        line
        for k in (0, 1)
        for line in (f"MODEL     {k + 1:4d}", *pdb_lines([1, 2, 5], model=k), "TER", "ENDMDL")
    ]
    changes = Changes(added=tuple(added(3, 2, model=m) for m in (0, 1)))
    out = _filled(*lines, _master(0, 3 * N * models, models, 0), changes=changes)
    assert out[-1] == _master(0, 4 * N * models, models, 0)
