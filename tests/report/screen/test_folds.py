"""Folded loops on the screen."""

import dataclasses
import os

import pytest

from loopelastica.batch.folds import loop_rows
from loopelastica.report.screen.folds import IN_FULL, SHOWN, fold_screen


def rows_of(fold, file="a.pdb", atoms=None):
    return [
        {**row, **({} if atoms is None else atoms.figures(row["rank"])), "folder": f"{file}_A6-9"}
        for row in loop_rows(file, fold)
    ]


def words(text):
    return " ".join(text.split())


def test_a_loop_is_shown_with_all_that_is_known_of_each_candidate(shown, chains):
    text = shown(*fold_screen(rows_of(chains), "out"))
    head, place, *lines = text.splitlines()
    assert head == "a.pdb  A.C5–A.G10  CUUCGG  4 nt RNA"
    assert place == "in out/a.pdb_A6-9"
    first = next(line for line in lines if line.startswith("1 "))
    candidate = chains.candidates[0]
    for cell in (
        "like 2koc",
        "1.2 (0.5–2.0)",
        f"{candidate.energy_per_A:.4f}",
        f"{candidate.rmsd_A:.2f}",
    ):
        assert cell in first
    assert "straight rod" in text
    assert "measured to be nearest first" in words(text)


def test_the_order_is_told(shown, chains):
    assert "least energy first" in words(shown(*fold_screen(rows_of(chains), "out", "energy")))


def test_an_rmsd_that_nobody_knows_takes_no_room(shown, chains):
    rows = [
        {
            **row,
            **dict.fromkeys(("rmsd_A", "rmsd_models_mean_A", "rmsd_models_sd_A")),
            "n_models": 0,
        }
        for row in rows_of(chains)
    ]
    assert "RMSD" not in shown(*fold_screen(rows, "out"))


def test_the_spread_over_models_and_their_number_are_shown(shown, chains):
    rows = rows_of(chains)
    for row, count in zip(rows, (20, 20, 14), strict=False):
        row.update(rmsd_models_mean_A=1.25, rmsd_models_sd_A=0.5, n_models=count)
    text = shown(*fold_screen(rows[:3], "out"))
    assert "4 nt RNA, 20 models" in text
    assert text.count("1.25 ± 0.50") == 3
    assert text.count("1.25 ± 0.50 (14)") == 1


def test_what_a_line_touches_is_named(shown, chains):
    row = {**rows_of(chains)[0], "stem_contact_A": 0.5, "self_contact_A": 0.5}
    assert "touches stem and itself" in words(shown(*fold_screen([row], "out")))


def test_atoms_that_are_sound_stand_in_the_same_table(shown, fold, atoms):
    text = shown(*fold_screen(rows_of(fold, atoms=atoms), "out"))
    first = next(line for line in text.splitlines() if line.startswith("1 "))
    assert first.endswith(f"sound     {atoms.models[0].rmsd_A:.2f}")
    worst = max(model.checks.worst_bond_A for model in atoms.models)
    assert f"no bond is off by more than {worst:.3f} Å" in words(text)
    assert "2 of 2 are sound" in text


def test_atoms_that_are_not_sound_have_their_reason(shown, fold, atoms):
    first, second = atoms.models
    checks = dataclasses.replace(first.checks, worst_bond_A=0.123, worst_bond="2:O3'–3:P")
    odd = dataclasses.replace(first, checks=checks)
    wrong = dataclasses.replace(atoms, models=(odd, second))
    text = words(shown(*fold_screen(rows_of(fold, atoms=wrong), "out")))
    assert "Atoms of 1 are not sound: bond 2:O3'–3:P off by 0.12 Å" in text
    assert "Atoms of 1 of 2 are sound" in text
    assert "not written" in text


def test_more_loops_have_a_row_each_with_their_folders(shown, chains):
    names = [f"{k}.pdb" for k in range(IN_FULL + 1)]
    rows = [row for name in names for row in rows_of(chains, name)]
    text = shown(*fold_screen(rows, "out"))
    for name in names:
        assert f"{name}  A.C5–A.G10  CUUCGG" in text
        assert f"in {name}_A6-9" in text
    assert text.count("1.2 (0.5–2.0)") == len(names)
    assert "straight rod" not in text


def test_of_hundreds_a_screenful_is_shown_and_the_table_named(shown, chains):
    row = rows_of(chains)[0]
    rows = ({**row, "folder": f"f{k}"} for k in range(300))
    text = shown(*fold_screen(rows, "out"))
    assert f"and {300 - SHOWN} more loops: out/summary.csv has all of them" in text
    # two lines for each, and what they say
    assert len(text.splitlines()) < 2 * SHOWN + 20


def test_nothing_is_shown_of_nothing(shown):
    assert shown(*fold_screen([], "out")) == ""


@pytest.mark.parametrize("count", [1, IN_FULL + 1])
@pytest.mark.parametrize(
    ("name", "escaped"),
    [
        *((name, name) for name in ("[red]x", "[/]", "[bold", ":smile:", "a;b")),
        *(("a\nb", r"a\nb"), ("\x1b[2J", r"\x1b[2J"), (os.fsdecode(b"\xff"), r"\udcff")),
    ],
)
def test_a_name_is_shown_as_it_is_and_breaks_no_line(shown, chains, count, name, escaped):
    row = {**rows_of(chains)[0], "closing_pair": name, "shape": name}
    rows = [{**row, "folder": f"{name}{k}"} for k in range(count)]
    text = shown(*fold_screen(rows, "out"))
    assert text.count(escaped) == 3 * count
    assert text.encode()


def test_a_long_place_leaves_the_name_of_the_folder_whole(shown, chains):
    text = shown(*fold_screen(rows_of(chains), "/some/" + "long/" * 20))
    assert "\nin a.pdb_A6-9\n" in text
