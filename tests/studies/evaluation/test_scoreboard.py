"""The scoreboard over a few real files."""

import csv
import shutil

import pytest
from typer.testing import CliRunner

import loopelastica as le
from loopelastica.cli.app import app
from loopelastica.studies.evaluation import loops, refit
from loopelastica.studies.evaluation.scoreboard import (
    _median_90,
    add_comparisons,
    evaluate,
    groups,
    scoreboard,
)

ENTRIES = ("1bjh", "1kr8", "2l5k", "1szy", "1k2g")


@pytest.fixture(scope="module", autouse=True)
def few_tapers():
    """Two of the seven tapers among which the constants are refitted."""
    with pytest.MonkeyPatch.context() as patch:
        for module in (loops, refit):
            patch.setattr(module, "TAPERS", (0.0, 0.2))
        yield


@pytest.fixture(scope="module")
def folder(hairpin_folder, tmp_path_factory):
    folder = tmp_path_factory.mktemp("structures")
    for entry in ENTRIES:
        shutil.copy(hairpin_folder / f"{entry}.pdb.gz", folder)
    (folder / "broken.pdb").write_text("nothing\n")
    (folder / "notes.txt").write_text("no structure")
    return folder


@pytest.fixture(scope="module")
def done(folder, tmp_path_factory):
    out = tmp_path_factory.mktemp("out")
    result = CliRunner().invoke(app, ["evaluate", str(folder), "-o", str(out)])
    assert result.exit_code == 1
    assert "broken.pdb" in result.stderr
    with (out / "scoreboard.csv").open() as file:
        return out, list(csv.DictReader(file))


def test_every_loop_has_a_row_with_the_numbers_of_fold(folder, done):
    rows = {(row["file"], row["loop"]): row for row in done[1]}
    assert len(rows) == 6
    (loop,) = le.fold(folder / "1bjh.pdb.gz", exclude_relatives=True)
    row = rows["1bjh.pdb.gz", "A5-7"]
    assert float(row["rmsd_first_A"]) == loop.candidates[0].rmsd_A
    assert row["shape"] == loop.candidates[0].shape == "straight rod"
    assert float(row["models_first_A"]) == pytest.approx(loop.candidates[0].rmsd_models_A.mean())
    assert row["n_models"] == "16"
    assert (row["type"], row["closing_type"], row["set"]) == ("triloop", "C-G", "DNA")
    for row in rows.values():
        assert float(row["rmsd_best_A"]) <= float(row["rmsd_best5_A"]) <= float(row["rmsd_first_A"])
        assert float(row["hermite_A"]) < float(row["chord_A"])
    at_the_pair = {"stem_extend_5": 0, "stem_extend_3": 0, "taper": 0, "shapes": "rod"}
    plain = le.fold(folder / "1szy.pdb.gz", all_models=False, **at_the_pair)
    assert float(rows["1szy.pdb.gz", "A8-14"]["plain_rod_A"]) == plain[0].candidates[0].rmsd_A


def test_nothing_related_to_a_loop_is_known_of_it(folder, done):
    rows = {(row["file"], row["loop"]): row for row in done[1]}
    (loop,) = le.fold(folder / "1szy.pdb.gz", exclude_relatives=True)
    row = rows["1szy.pdb.gz", loop.hairpin.name]
    assert (row["shape"], row["shape_source"]) == (loop.candidates[0].shape, "mean of its length")
    assert not any("same sequence" in row["shape"] for row in rows.values())
    assert "none was taken from a related loop" in (done[0] / "scoreboard.md").read_text()


def test_every_row_says_what_error_was_expected_and_whether_it_held(folder, done):
    for row in done[1]:
        low, middle, high = (float(row[f"expected_{q}_A"]) for q in (10, 50, 90))
        assert 0.0 <= low < middle < high
        assert row["inside"] == str(low <= float(row["rmsd_first_A"]) <= high)
    (loop,) = le.fold(folder / "1bjh.pdb.gz", exclude_relatives=True)
    (row,) = (row for row in done[1] if row["file"] == "1bjh.pdb.gz")
    assert float(row["expected_50_A"]) == loop.candidates[0].expected_rmsd_A[1]
    text = (done[0] / "scoreboard.md").read_text()
    section = text.split("## Expected errors")[1].split("## What failed")[0]
    for part in ("### All loops", "### Simple loops", "| all (6) |", "| all (5) |", "| DNA (3) |"):
        assert part in section
    assert "mean of its length" in section


def test_the_rod_by_the_rule_is_beside_the_first_answer(folder, done):
    rows = {(row["file"], row["loop"]): row for row in done[1]}
    for file in ("1bjh", "1szy"):
        (loop,) = le.fold(folder / f"{file}.pdb.gz", all_models=False, shapes="rod")
        row = rows[f"{file}.pdb.gz", loop.hairpin.name]
        assert float(row["rod_A"]) == pytest.approx(loop.candidates[0].rmsd_A, abs=1e-9)
        # there is nothing but the hairpin in these files
        assert row["surrounded_A"] == ""


def test_what_is_no_evidence_is_shown_apart(done):
    (row,) = (row for row in done[1] if row["file"] == "2l5k.pdb.gz")
    assert (row["set"], row["simple"]) == ("not evidence", "False")
    text = (done[0] / "scoreboard.md").read_text()
    assert "apart: 2l5k.pdb.gz A11-13" in text
    assert "all simple loops (5)" in text
    for name in (
        "rmsd_by_length.png",
        "energy_and_rmsd.png",
        "rank_of_best.png",
        "expected_and_true_error.png",
    ):
        assert (done[0] / name).stat().st_size > 5000


def test_a_second_run_measures_nothing_again_and_writes_the_same(folder, done):
    before = (done[0] / "scoreboard.csv").read_bytes()
    again = evaluate(folder, done[0])
    assert again.n_resumed == again.n_files == 6
    assert (done[0] / "scoreboard.csv").read_bytes() == before


def test_where_a_simple_curve_wins_the_table_says_so():
    row = {
        "simple": True, "set": "RNA, small files", "type": "triloop", "nucleotides": 3,
        "kind": "RNA", "family": "a", "file": "x", "loop": "y", "sequence": "CAAAG",
        "expected_10_A": 1.0, "expected_50_A": 1.5, "expected_90_A": 3.0, "inside": True,
        "shape_source": "mean of its length",
    }  # fmt: skip
    numbers = dict.fromkeys(
        (
            *("rmsd_first_A", "rmsd_best5_A", "rmsd_best_A", "models_first_A", "plain_rod_A"),
            *("rod_A", "surrounded_A"),
            *("refit_taper_A", "refit_all_A", "hermite_A", "chord_A", "plain_hermite_A"),
            *("plain_arc_A", "plain_chord_A", "mean_loop_A"),
        ),
        2.0,
    )
    text = scoreboard([row | numbers | {"arc_A": 1.25}])
    assert "all simple loops: circular arc, same ends (1.25 against 2.00 Å)" in text
    assert "Nowhere" in scoreboard([row | numbers | {"arc_A": 3.0}])
    nearer = [row | numbers | {"arc_A": 3.0, "rod_A": value} for value in (1.0, 1.5, 3.0, None)]
    assert "| all simple loops (4) | 67 % of 3: 1.50 against 2.00 |" in scoreboard(nearer)
    assert list(groups([row])) == [
        "all simple loops", "RNA, small files", "triloop", "3 nucleotides",
    ]  # fmt: skip


def test_a_folder_without_structures_is_refused(tmp_path):
    with pytest.raises(ValueError, match="holds no PDB or mmCIF"):
        evaluate(tmp_path, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_the_mean_loop_is_that_of_other_families_of_the_same_kind_and_length():
    grid = [[1.0] * len(loops.EXTENSIONS)] * len(loops.TAPERS)
    rows = [
        {
            "simple": True, "kind": kind, "family": family, "nucleotides": n, "loop": str(k),
            "native": [[x, 0.0, 0.0]] * n, "grid": grid,
        }
        for k, (kind, family, n, x) in enumerate(
            [
                ("RNA", "a", 4, 0.0), ("RNA", "a", 4, 50.0), ("RNA", "b", 4, 2.0),
                ("RNA", "c", 4, 6.0), ("DNA", "d", 4, 80.0), ("RNA", "e", 5, 90.0),
            ]
        )
    ]  # fmt: skip
    add_comparisons(rows)
    found = [row["mean_loop_A"] for row in rows]
    # of b and c: 4; of a, a and c: 56/3; of a, a and b: 52/3
    assert found[:4] == pytest.approx([4.0, 46.0, 56 / 3 - 2, 52 / 3 - 6])
    assert found[4:] == [None, None]


def test_a_cell_holds_median_and_ninetieth_percentile_of_what_there_is():
    assert _median_90(list(range(11))) == "5.00 / 9.00"
    assert _median_90([2.0, None]) == "2.00 / 2.00 (1)"
    assert _median_90([None]) == "–"


def test_no_sentence_is_taken_for_markdown():
    text = scoreboard([], ("a|b<i>[x](y)*`.pdb: bad", "two\nlines.pdb: bad"))
    assert r"- a\|b\<i\>\[x\](y)\*\`.pdb: bad" in text.splitlines()
    assert "- two\\\\nlines.pdb: bad" in text.splitlines()
