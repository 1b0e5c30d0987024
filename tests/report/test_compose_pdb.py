import numpy as np
import pytest
from strand import NAMES, added, pdb_lines

from loopelastica.report.compose import Changes, Removed, compose
from loopelastica.report.compose_pdb import compose_pdb

GAP = Changes(added=(added(3, 2), added(4, 3)))
N = len(NAMES)


def _text(*lines, end="\n"):
    return end.join([*lines, ""])


def _filled(*lines, changes=GAP, end="\n"):
    text = compose_pdb(_text(*lines, end=end), changes)
    assert text is not None
    assert text.endswith(end)
    return text.split(end)[:-1]


def _kinds(lines):
    """Runs of records: kind and how many."""
    out = []
    for line in lines:
        kind = line[:6].strip()
        if out and out[-1][0] == kind:
            out[-1][1] += 1
        else:
            out.append([kind, 1])
    return [tuple(run) for run in out]


def _serials(lines):
    return [int(x[6:11]) for x in lines if x.startswith(("ATOM", "HETATM", "TER"))]


def _numbers(lines):
    seen = [x[22:27].strip() for x in lines if x.startswith(("ATOM", "HETATM"))]
    return list(dict.fromkeys(seen))


def _water(serial, number, chain="A"):
    return (
        f"HETATM{serial:5d}  O   HOH {chain}{number:4d}    {number:8.3f}  50.000   0.000"
        "  1.00 20.00           O  "
    )


# --- where new atoms stand, and how ---------------------------------------------------------------


def test_a_strand_comes_between_its_neighbours_in_the_columns_of_the_format():
    lines = _filled(*pdb_lines([1, 2, 5]))
    assert lines == pdb_lines([1, 2, 3, 4, 5])[: 2 * N] + [
        # modelled atoms have the numbers that they are given
        f"{line[:60]}  0.00{line[66:]}"
        if "   3   " in line[20:30] or "   4   " in line[20:30]
        else line
        for line in pdb_lines([1, 2, 3, 4, 5])[2 * N :]
    ]


def test_occupancy_and_b_factor_mark_what_was_modelled():
    changes = Changes(added=(added(3, 2, occupancy=0.5, b_factor_A2=np.arange(N) * 150.0),))
    new = [x for x in _filled(*pdb_lines([1, 2, 5]), changes=changes) if x[22:26] == "   3"]
    assert [x[54:60] for x in new] == ["  0.50"] * N
    assert [x[60:66] for x in new[:2]] == ["  0.00", "150.00"]
    assert new[-1][60:66] == "1200.0"


def test_serial_numbers_rise_only_where_room_is_needed():
    gap = pdb_lines([1, 2], serial=1) + pdb_lines([5], serial=2 * N + 5)
    serials = _serials(_filled(*gap, *pdb_lines([1], chain="B", serial=500)))
    assert serials == [*range(1, 4 * N + 1), *range(4 * N + 1, 5 * N + 1), *range(500, 500 + N)]


def test_a_gap_that_has_room_for_them_changes_no_other_serial_number():
    gap = pdb_lines([1, 2]) + pdb_lines([5], serial=4 * N + 1)
    assert [x for x in _filled(*gap) if x[22:26] not in ("   3", "   4")] == gap


def test_anisou_records_stay_with_their_atoms_and_follow_their_numbers():
    lines = []
    for line in pdb_lines([1, 2, 5]):
        lines += [line, f"ANISOU{line[6:28]}   1000   1000   1000      0      0      0{line[70:]}"]
    out = _filled(*lines)
    assert len(out) == 3 * 2 * N + 2 * N
    for k, line in enumerate(out):
        if line.startswith("ANISOU"):
            assert out[k - 1][6:27] == line[6:27]
    assert out[: 4 * N] == lines[: 4 * N]
    assert _kinds(out[4 * N : 6 * N]) == [("ATOM", 2 * N)]


def test_conect_records_point_to_the_atoms_they_pointed_to():
    lines = pdb_lines([1, 2, 5])
    last = 2 * N + 1
    out = _filled(*lines, f"CONECT{1:5d}{last:5d}", f"CONECT{last:5d}{1:5d}{2:5d}".ljust(80))
    assert out[-2:] == [
        f"CONECT{1:5d}{last + 2 * N:5d}",
        f"CONECT{last + 2 * N:5d}{1:5d}{2:5d}".ljust(80),
    ]


def test_conect_records_of_old_files_keep_their_hydrogen_bonds():
    lines = pdb_lines([1, 2, 5])
    last = 2 * N + 1
    out = _filled(*lines, f"CONECT{last:5d}{1:5d}{'':15}{last + 1:5d}")
    assert out[-1] == f"CONECT{last + 2 * N:5d}{1:5d}{'':15}{last + 1 + 2 * N:5d}"


def test_ter_records_follow_the_last_residue_of_their_chain():
    ter = f"TER   {3 * N + 1:5d}        U A   5"
    other = pdb_lines([1], chain="B", serial=3 * N + 2)
    out = _filled(*pdb_lines([1, 2, 5]), ter, *other, "TER", "END")
    assert _kinds(out) == [("ATOM", 5 * N), ("TER", 1), ("ATOM", N), ("TER", 1), ("END", 1)]
    assert out[5 * N] == f"TER   {5 * N + 1:5d}        U A   5"
    assert out[-2] == "TER"


def test_a_chain_that_was_filled_does_not_end_where_it_was_broken():
    broken = [*pdb_lines([1, 2]), f"TER   {2 * N + 1:5d}        U A   2"]
    out = _filled(*broken, *pdb_lines([5], serial=2 * N + 2), "TER", "END")
    assert _kinds(out) == [("ATOM", 5 * N), ("TER", 1), ("END", 1)]


def test_a_chain_that_grows_ends_with_what_was_added():
    ter = f"TER   {2 * N + 1:5d}        U A   2"
    # number 9 is far from 3: another chain of that name, or a ligand
    out = _filled(
        *pdb_lines([1, 2]),
        ter,
        *pdb_lines([9], serial=2 * N + 2),
        changes=Changes(added=(added(3, 2, resname="G"),)),
    )
    assert _kinds(out) == [("ATOM", 3 * N), ("TER", 1), ("ATOM", N)]
    assert out[3 * N] == f"TER   {3 * N + 1:5d}        G A   3"


@pytest.mark.parametrize("tail", [(), ("TER",), ("TER", "END")])
def test_files_without_ter_or_end_get_none(tail):
    assert _kinds(_filled(*pdb_lines([1, 2, 5]), *tail))[1:] == [(kind, 1) for kind in tail]


def test_lines_end_as_the_others_do():
    lines = pdb_lines([1, 2, 5])
    assert _filled(*lines, end="\r\n") == _filled(*lines)
    assert compose_pdb("\n".join(lines), GAP) == _text(*_filled(*lines))[:-1]


def test_insertion_codes_are_told_apart():
    lines = [
        *pdb_lines([1]),
        *(f"{x[:26]}B{x[27:]}" for x in pdb_lines([1], serial=N + 1)),
        *pdb_lines([2], serial=2 * N + 1),
    ]
    out = _filled(*lines, changes=Changes(added=(added(1, 1, icode="A"),)))
    assert _numbers(out) == ["1", "1A", "1B", "2"]
    out = _filled(*lines, changes=Changes(added=(added(1, ("A", 1, "B"), icode="C"),)))
    assert _numbers(out) == ["1", "1B", "1C", "2"]


def test_a_file_without_chains_gets_none():
    lines = [f"{x[:21]} {x[22:]}" for x in pdb_lines([1, 2, 5])]
    gap = Changes(added=(added(3, 2, chain=""), added(4, 3, chain="")))
    out = _filled(*lines, changes=gap)
    assert _numbers(out) == ["1", "2", "3", "4", "5"]
    assert {x[21] for x in out} == {" "}


def test_a_strand_may_be_named_by_its_segment():
    lines = [f"{x[:21]} {x[22:72]}RNA1{x[76:]}" for x in pdb_lines([1, 2, 5])]
    for chain in ("RNA1", ""):
        gap = Changes(added=(added(3, 2, chain=chain), added(4, 3, chain=chain)))
        out = _filled(*lines, changes=gap)
        assert _numbers(out) == ["1", "2", "3", "4", "5"]
        assert {x[21] + x[72:76] for x in out} == {" RNA1"}


def test_chains_are_told_apart_by_case():
    lines = [*pdb_lines([1, 2, 5]), *pdb_lines([1, 2, 5], chain="a", serial=3 * N + 1)]
    out = _filled(*lines, changes=Changes(added=(added(3, 2, chain="a"),)))
    assert [x[21] for x in out] == ["A"] * 3 * N + ["a"] * 4 * N


def test_elements_are_written_where_the_others_have_them():
    bare = [x[:66] for x in pdb_lines([1, 2, 5])]
    assert {x[66:].strip() for x in _filled(*bare)} == {""}
    named = _filled(*pdb_lines([1, 2, 5]))
    assert [x[76:78].strip() for x in named] == [x[12:16].strip()[0] for x in named]


def test_short_lines_tabs_and_indents_stay():
    lines = pdb_lines([1, 2, 5])
    lines[0] = f"\t {lines[0][:54]}"
    out = _filled("REMARK\tby hand", *lines, "END")
    assert out[:2] == ["REMARK\tby hand", lines[0]]
    assert _numbers(x.strip() for x in out[1:]) == ["1", "2", "3", "4", "5"]


def test_modified_nucleotides_are_hetatm_records_and_others_are_not():
    lines = [*pdb_lines([1, 2]), *pdb_lines([5], resname="5MU", record="HETATM", serial=2 * N + 1)]
    changes = Changes(added=(added(3, 2, resname="5MU"), added(4, 3), added(6, 5)))
    kinds = {x[22:26].strip(): x[:6].strip() for x in _filled(*lines, changes=changes)}
    assert kinds == dict(
        zip("123456", ("ATOM", "ATOM", "HETATM", "ATOM", "HETATM", "ATOM"), strict=True)
    )


def test_names_of_four_letters_and_elements_of_two_begin_in_column_13():
    new = added(3, 2, names=("P", "O5'"))
    object.__setattr__(new, "names", ("H5''", "SE"))
    object.__setattr__(new, "elements", ("H", "SE"))
    out = _filled(*pdb_lines([1, 2]), changes=Changes(added=(new,)))
    assert {x[12:16] + x[76:78] for x in out[2 * N :]} == {"H5'' H", "SE  SE"}


# --- models ---------------------------------------------------------------------------------------


def _models(*numbers, restart=True):
    out, serial = [], 1
    for k, of_model in enumerate(numbers):
        lines = pdb_lines(of_model, serial=1 if restart else serial, model=k)
        serial += len(lines)
        out += [f"MODEL     {k + 1:4d}", *lines, "ENDMDL"]
    return [*out, "END"]


@pytest.mark.parametrize("restart", [True, False])
def test_each_model_is_filled_by_itself(restart):
    changes = Changes(added=tuple(added(k, k - 1, model=m) for m in (1, 0) for k in (4, 3)))
    out = _filled(*_models([1, 2, 5], [1, 2, 5], restart=restart), changes=changes)
    assert _kinds(out) == _kinds(_models([1, 2, 3, 4, 5], [1, 2, 3, 4, 5]))
    serials = _serials(out)
    assert serials == ([*range(1, 5 * N + 1)] * 2 if restart else [*range(1, 10 * N + 1)])
    heights = [float(x[46:54]) for x in out if x.startswith("ATOM")]
    assert heights == [0.0] * 5 * N + [1.0] * 5 * N


def test_an_atom_has_one_number_in_all_models_though_one_of_them_is_not_filled():
    lines = [*_models([1, 2, 5], [1, 2, 5])[:-1], f"CONECT{1:5d}{2 * N + 1:5d}", "END"]
    out = _filled(*lines, changes=Changes(added=(added(3, 2, model=1),)))
    phosphorus = [x for x in out if x[12:16] == " P  " and x[22:26] == "   5"]
    assert [int(x[6:11]) for x in phosphorus] == [3 * N + 1] * 2
    assert out[-2] == f"CONECT{1:5d}{3 * N + 1:5d}"


def test_models_that_only_end_are_models():
    lines = [*pdb_lines([1, 2, 5]), "ENDMDL", *pdb_lines([1, 2, 5], model=1), "END"]
    out = _filled(*lines, changes=Changes(added=(added(3, 2, model=1),)))
    assert _kinds(out) == [("ATOM", 3 * N), ("ENDMDL", 1), ("ATOM", 4 * N), ("END", 1)]


# --- serial numbers that are none -----------------------------------------------------------------


@pytest.mark.parametrize("serial", ["*****", "     ", "    1"])
def test_serial_numbers_that_do_not_rise_are_replaced(serial):
    lines = [f"{x[:6]}{serial}{x[11:]}" for x in pdb_lines([1, 2, 5])]
    assert _serials(_filled(*lines)) == [*range(1, 5 * N + 1)]


def test_hybrid_36_goes_on():
    lines = pdb_lines([1, 2, 5], serial=99_990 - 2 * N)
    lines = lines[: 2 * N] + [
        f"{x[:6]}{s}{x[11:]}"
        for x, s in zip(
            lines[2 * N :], ["99998", "99999", *(f"A000{k}" for k in range(N - 2))], strict=True
        )
    ]
    out = _filled(*lines, changes=Changes(added=(added(3, 2),)))
    texts = [x[6:11] for x in out]
    assert texts[2 * N : 2 * N + 3] == ["99990", "99991", "99992"]
    assert texts[-1] == "A0007"
    assert len(set(texts)) == len(texts)


def test_serial_numbers_near_the_end_of_the_columns_begin_anew():
    lines = pdb_lines([1, 2, 5], serial=99_999 - 3 * N + 1)
    out = _filled(*lines, f"CONECT{99_999 - 3 * N + 1:5d}{99_999:5d}")
    assert _serials(out[:-1]) == [*range(1, 5 * N + 1)]
    assert out[-1] == f"CONECT{1:5d}{5 * N:5d}"


# --- completed nucleotides ------------------------------------------------------------------------


def test_missing_atoms_come_into_their_nucleotide_in_the_order_of_the_wwpdb():
    partial = pdb_lines([2], serial=N + 1, names=("P", "O5'", "C4'", "N1"))
    lines = [*pdb_lines([1]), *partial, *pdb_lines([3], serial=N + 5)]
    missing = tuple(name for name in NAMES if name not in ("P", "O5'", "C4'", "N1"))
    out = _filled(*lines, changes=Changes(added=(added(2, 1, names=missing[::-1]),)))
    assert [x[12:16].strip() for x in out] == list(NAMES) * 3
    assert [x[11:] for x in out if x[11:] in {y[11:] for y in lines}] == [x[11:] for x in lines]


def test_a_nucleotide_without_its_first_atoms_gets_them_in_front():
    lines = [*pdb_lines([1]), *pdb_lines([2], serial=N + 1, names=NAMES[2:])]
    out = _filled(*lines, changes=Changes(added=(added(2, 1, names=NAMES[:2]),)))
    assert [x[11:54] for x in out] == [x[11:54] for x in pdb_lines([1, 2])]


def test_missing_atoms_have_the_location_and_spelling_of_their_nucleotide():
    old = [
        f"{x[:16]}B{x[17:]}".replace("'", "*")
        for x in pdb_lines([2], serial=N + 1, names=("P", "C4'", "C3'"))
    ]
    lines = [*pdb_lines([1]), *old]
    new = added(2, 1, names=("O5'", "C5'"))
    out = [x for x in _filled(*lines, changes=Changes(added=(new,))) if x[22:26] == "   2"]
    assert [x[12:17] for x in out] == [" P  B", " O5*B", " C5*B", " C4*B", " C3*B"]


def test_two_locations_stay_and_what_they_share_has_none():
    one = pdb_lines([2], serial=N + 1, names=("P", "O5'", "C4'"))
    both = [f"{x[:16]}{a}{x[17:]}" for x in one for a in "AB"]
    new = added(2, 1, names=("C5'",))
    out = _filled(*pdb_lines([1]), *both, changes=Changes(added=(new,)))[N:]
    assert [x[12:17].strip() for x in out] == (
        ["P  A", "P  B", "O5'A", "O5'B", "C5'", "C4'A", "C4'B"]
    )


def test_a_water_of_the_same_number_is_no_nucleotide():
    lines = [*pdb_lines([1, 2, 5]), _water(3 * N + 1, 3)]
    out = _filled(*lines)
    assert _numbers(out) == ["1", "2", "3", "4", "5"]
    assert [x[17:20] for x in out][2 * N : 3 * N] == ["  U"] * N
    assert out[-1][17:20] == "HOH"


def test_a_strand_may_run_over_a_nucleotide_of_which_little_is_left():
    lines = [
        *pdb_lines([1, 2]),
        *pdb_lines([4], serial=2 * N + 1, names=("P", "OP1")),
        *pdb_lines([6], serial=2 * N + 3),
    ]
    changes = Changes(added=(added(5, 4), added(4, 3, names=NAMES[2:]), added(3, 2)))
    out = _filled(*lines, changes=changes)
    assert [x[11:54] for x in out] == [x[11:54] for x in pdb_lines([1, 2, 3, 4, 5, 6])]


# --- what moves, and what goes --------------------------------------------------------------------


def test_a_moved_atom_has_one_location_and_no_ellipsoid():
    line = pdb_lines([1])[0]
    lines = [
        f"{line[:16]}A{line[17:]}",
        f"ANISOU{line[6:16]}A{line[17:28]}   1000   1000   1000      0      0      0",
        f"{line[:6]}    2{line[11:16]}B{line[17:]}",
        *pdb_lines([1], serial=3)[1:],
    ]
    changes = Changes(
        moved={(0, "A", 1, "", "P"): (1.0, -2.0, 3.0)}, moved_b_factor_A2=99.0, moved_occupancy=0.25
    )
    out = _filled(*lines, changes=changes)
    assert len(out) == N
    assert out[0] == (f"{line[:16]} {line[17:30]}   1.000  -2.000   3.000  0.25 99.00{line[66:]}")
    assert out[1:] == lines[3:]


def test_waters_go_with_what_names_them():
    lines = [
        *pdb_lines([1, 2]),
        _water(2 * N + 1, 101),
        _water(2 * N + 2, 102),
        f"CONECT{1:5d}{2 * N + 1:5d}{2 * N + 2:5d}",
        f"CONECT{2 * N + 1:5d}{1:5d}",
        "END",
    ]
    changes = Changes(removed=(Removed(0, "A", 101, "", "HOH"),))
    out = _filled(*lines, changes=changes)
    assert out == [*lines[: 2 * N], lines[2 * N + 1], f"CONECT{1:5d}{2 * N + 2:5d}", "END"]


def test_of_waters_of_one_number_the_one_at_a_place_goes():
    lines = [*pdb_lines([1, 2]), _water(2 * N + 1, 7), _water(2 * N + 2, 8), _water(2 * N + 3, 7)]
    lines[-1] = lines[-1].replace("50.000", "60.000")
    one = Removed(0, "A", 7, "", "HOH", at_A=(7.0, 60.0, 0.0))
    assert _filled(*lines, changes=Changes(removed=(one,))) == lines[:-1]


def test_a_water_of_a_number_that_the_columns_do_not_hold_goes_by_its_place():
    far = _water(2 * N + 1, 9).replace("A   9", "AA000")
    lines = [*pdb_lines([1, 2]), far, _water(2 * N + 2, 7)]
    one = Removed(0, "A", 10000, "", "HOH", at_A=(9.0, 50.0, 0.0))
    assert _filled(*lines, changes=Changes(removed=(one,))) == [*lines[: 2 * N], lines[-1]]


def test_a_single_atom_can_go():
    lines = pdb_lines([1, 2])
    one = Removed(0, "A", 2, "", "U", name="N1")
    assert _filled(*lines, changes=Changes(removed=(one,))) == lines[:-1]


def test_compose_gives_what_the_format_holds():
    text = _text(*pdb_lines([1, 2, 5]))
    assert compose(text, "pdb", GAP).text == compose_pdb(text, GAP)
