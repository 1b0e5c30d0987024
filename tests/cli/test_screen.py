"""What commands say: on eighty columns, nothing but failures, or as JSON."""

import csv
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import gapped
import pytest
import typer
from rich.cells import cell_len
from typer.testing import CliRunner

from loopelastica._files import data_path
from loopelastica._version import __version__
from loopelastica.cli.app import app
from loopelastica.cli.screen import Screen, fail

ROOT = Path(__file__).resolve().parents[2]
HAIRPIN = data_path("hairpins/2koc.pdb")
FAST = ("--no-plot", "--first-model")


def run(*arguments, **options):
    result = CliRunner().invoke(app, [str(a) for a in arguments], **options)
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    return result


def words(text):
    return " ".join(text.split())


def strict(text):
    """The one document in a text, which may have no NaN."""

    def refuse(name):
        raise AssertionError(f"{name} is no JSON")

    return json.loads(text, parse_constant=refuse)


def table(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


# --- failures -------------------------------------------------------------------------------------


@pytest.mark.parametrize(("n", "last"), [(20, "number 19"), (21, "1 more in out/failures.csv")])
def test_a_screenful_of_failures_is_shown_and_the_rest_counted(capsys, n, last):
    with pytest.raises(typer.Exit):
        fail([f"number {k}" for k in range(n)], "in out/failures.csv")
    lines = capsys.readouterr().err.splitlines()
    assert lines[:20] == [f"number {k}" for k in range(20)]
    assert lines[-1] == last
    assert len(lines) == n


def test_no_failure_ends_no_program(capsys):
    fail([])
    assert capsys.readouterr().err == ""


def test_failures_of_many_models_are_one_line(capsys):
    with pytest.raises(typer.Exit):
        fail([f"a.pdb: model {k}: no P atom" for k in range(2, 21)], "elsewhere")
    assert capsys.readouterr().err == "a.pdb: models 2-20: no P atom\n"


@pytest.mark.parametrize("jobs", [(), ("--jobs", "1")])
def test_models_that_cannot_be_folded_are_one_line_on_the_screen_and_rows_in_the_table(
    tmp_path, jobs
):
    short = ("--length-per-nucleotide", 3.634, "--shapes", "rod", "--no-plot")
    result = run("fold", HAIRPIN, "-o", tmp_path, *short, *jobs)
    failures = [row["failure"] for row in table(tmp_path / "failures.csv")]
    assert len(failures) > 5
    assert all(": model " in failure for failure in failures)
    (said,) = result.stderr.splitlines()
    assert said == f"{failures[0]} (and {len(failures) - 1} more models)"


# --- notes ----------------------------------------------------------------------------------------


def test_notes_are_a_screenful_and_the_rest_is_counted(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    Screen("fold", "loops").note((f"n{k}.pdb: sentence {k}" for k in range(100)), "in the files")
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "note: n0.pdb: sentence 0"
    assert lines[-1] == "note: 80 more notes are in the files"
    assert len(lines) == 21


def test_a_note_is_broken_between_words(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    Screen("fold", "loops").note(["a.pdb: " + "some words " * 30], "elsewhere", ["a.pdb"])
    text = capsys.readouterr().out
    assert max(map(len, text.splitlines())) <= 80
    assert words(text) == words("note: " + "some words " * 30)


@pytest.mark.parametrize("jobs", [(), ("--jobs", "1")])
def test_what_was_odd_in_reading_is_told_however_files_are_folded(tmp_path, jobs):
    lines = HAIRPIN.read_text().split("ENDMDL")[0].splitlines()
    path = tmp_path / "absent.pdb"
    path.write_text("\n".join(s for s in lines if s[22:26].strip() not in {"6", "7", "8", "9"}))
    result = run("fold", path, HAIRPIN, "-o", tmp_path / "out", *FAST, *jobs)
    assert "--loop A.6-9 folds it" in words(result.stdout)


# --- quiet ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "arguments",
    [
        ("fold", *FAST, "-o", "out"),
        ("fold", *FAST, "--jobs", "1", "-o", "out"),
        ("fill", "-o", "out"),
        ("hairpins",),
        ("scan", "--extend-5", "0", "--extend-3", "0"),
    ],
)
def test_a_quiet_command_prints_failures_alone_and_keeps_its_status(
    tmp_path, monkeypatch, arguments
):
    monkeypatch.chdir(tmp_path)
    result = run(*arguments, HAIRPIN, "--quiet")
    assert (result.exit_code, result.output) == (0, "")
    result = run(*arguments, HAIRPIN, "absent.pdb", "-q")
    assert result.exit_code == 1
    assert result.stdout == ""
    assert result.stderr == "absent.pdb: there is no such file\n"


def test_a_quiet_build_prints_nothing(tmp_path):
    result = run("build", "GGC(UUU)GCC", "--candidates", 1, "--no-plot", "-q", "-o", tmp_path)
    assert (result.exit_code, result.output) == (0, "")
    assert len(table(tmp_path / "summary.csv")) == 1


# --- json -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("jobs", [(), ("--jobs", "1")])
def test_the_document_of_a_fold_has_loops_candidates_and_failures(tmp_path, jobs):
    out = tmp_path / "out"
    result = run("fold", HAIRPIN, "absent.pdb", "-o", out, *FAST, *jobs, "--json")
    assert result.exit_code == 1
    content = strict(result.stdout)
    assert (content["version"], content["command"]) == (__version__, "fold")
    assert content["folder"] == str(out)
    assert content["failures"] == [
        {"file": "absent.pdb", "failure": "absent.pdb: there is no such file"}
    ]
    assert content["notes"] == []
    (loop,) = content["loops"]
    assert (loop["file"], loop["folder"]) == (str(HAIRPIN), "2koc_A6-9")
    ranking = json.loads((out / loop["folder"] / "ranking.json").read_text())
    assert loop["hairpin"] == ranking["hairpin"]
    for shown, stored in zip(loop["candidates"], ranking["candidates"], strict=True):
        assert shown == {name: stored[name] for name in shown}
        assert len(shown["trace_A"]) == 4
        assert shown["expected_rmsd_A"][0] < shown["expected_rmsd_A"][1]


def test_the_document_of_a_fold_with_atoms_says_whether_they_are_sound(tmp_path):
    result = run("fold", HAIRPIN, *FAST, "--atoms", "--candidates", 1, "--json", "-o", tmp_path)
    (loop,) = strict(result.stdout)["loops"]
    (candidate,) = loop["candidates"]
    (row,) = table(tmp_path / "summary.csv")
    assert candidate["atoms_sound"] is True
    assert candidate["atoms_closest_A"] == float(row["atoms_closest_A"])
    assert any("5' phosphate" in note for note in strict(result.stdout)["notes"])


def test_the_document_of_a_filling_has_what_fill_json_has(tmp_path):
    pytest.importorskip("rdkit")
    file, out = gapped.gapped(tmp_path / "a.pdb", {6, 7}), tmp_path / "out"
    result = run("fill", file, "absent.pdb", "--json", "-o", out)
    assert result.exit_code == 1
    content = strict(result.stdout)
    assert content["command"] == "fill"
    assert [failure["file"] for failure in content["failures"]] == ["absent.pdb"]
    (filled,) = content["files"]
    record = json.loads((out / "a" / "fill.json").read_text())
    assert filled == {"file": str(file), "folder": "a", **record}
    again = strict(run("fill", file, "absent.pdb", "--json", "-o", out).stdout)
    assert again == content


def test_the_document_of_a_build_has_a_loop_without_rmsd(tmp_path):
    result = run("build", "GGC(UUU)GCC", "--candidates", 1, "--no-plot", "--json", "-o", tmp_path)
    assert result.exit_code == 0, result.stderr
    (loop,) = strict(result.stdout)["loops"]
    assert loop["file"] == "GGCUUUGCC"
    assert loop["candidates"][0]["rmsd_A"] is None
    assert loop["candidates"][0]["atoms_sound"] is True


def test_the_documents_of_the_other_commands(tmp_path):
    (scanned,) = strict(run("scan", HAIRPIN, "--json", "--extend-5", 0).stdout)["loops"]
    assert scanned["hairpin"]["sequence"] == "CUUCGG"
    assert scanned["candidates"][0]["rank"] == 1
    (listed,) = strict(run("hairpins", HAIRPIN, "--json").stdout)["files"]
    assert listed["hairpins"][0]["name"] == "A6-9"
    kinds = strict(run("library", "list", data_path("loops.lib"), "--json").stdout)["kinds"]
    assert {row["kind"] for row in kinds} == {"RNA", "DNA"}
    made = run("library", "build", HAIRPIN, "-o", tmp_path / "a.lib", "--json")
    assert strict(made.stdout)["kinds"][0]["most_frequent"] == "UUCG"
    rods = strict(run("solve", "--clamping", "-0.4 -0.1 0.5 4.8 1.4 2.2", "--json").stdout)
    assert rods["command"] == "solve"
    assert rods["equilibria"][0]["energy"] == pytest.approx(7.058, abs=1e-3)
    assert rods["failures"] == rods["notes"] == []


@pytest.mark.parametrize("command", ["fold", "fill", "hairpins", "scan"])
def test_what_cannot_be_read_is_a_document_too(tmp_path, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    result = run(command, "absent.pdb", "--json")
    assert result.exit_code == 1
    content = strict(result.stdout)
    assert content["failures"] == [
        {"file": "absent.pdb", "failure": "absent.pdb: there is no such file"}
    ]
    assert content["files" if command in ("fill", "hairpins") else "loops"] == []
    assert result.stderr == "absent.pdb: there is no such file\n"


def test_what_ends_a_run_is_in_its_document(tmp_path):
    (tmp_path / "summary.csv").write_text("mine\n")
    result = run("fold", HAIRPIN, "-o", tmp_path, *FAST, "--json")
    assert result.exit_code == 1
    content = strict(result.stdout)
    assert content["loops"] == []
    (failure,) = content["failures"]
    assert failure["file"] is None
    assert "not written by this program" in failure["failure"]


def test_a_mistake_of_usage_leaves_the_standard_output_empty(tmp_path):
    result = run("fold", HAIRPIN, "-o", tmp_path / "out", "--json", "--rank", "best")
    assert (result.exit_code, result.stdout) == (2, "")


# --- folders and entries as input -----------------------------------------------------------------


@pytest.fixture
def folder(tmp_path):
    """Two copies of a model, and what is no structure."""
    place = tmp_path / "in"
    (place / "deeper").mkdir(parents=True)
    text = HAIRPIN.read_text().split("ENDMDL")[0] + "ENDMDL\nEND\n"
    for name in ("a.pdb", "b.ent", "deeper/c.pdb"):
        (place / name).write_text(text)
    (place / "notes.txt").write_text("mine")
    return place


@pytest.mark.parametrize("jobs", [(), ("--jobs", "1")])
def test_a_folder_stands_for_the_structures_in_it(tmp_path, folder, jobs):
    out = tmp_path / "out"
    assert run("fold", folder, "-o", out, *FAST, *jobs).exit_code == 0
    names = {Path(row["file"]).name for row in table(out / "summary.csv")}
    assert names == {"a.pdb", "b.ent"}


@pytest.mark.parametrize("command", ["fold", "fill"])
def test_an_empty_folder_and_an_entry_are_rows_and_the_others_go_on(
    tmp_path, folder, monkeypatch, command
):
    monkeypatch.chdir(tmp_path)
    Path("empty").mkdir()
    result = run(command, "empty", "2KOC", folder, "-o", "out")
    assert result.exit_code == 1
    failures = {row["file"]: row["failure"] for row in table(tmp_path / "out" / "failures.csv")}
    assert list(failures) == ["empty", "2KOC"]
    assert failures["empty"] == "empty: this is a folder, not a structure file, and holds none"
    assert "nothing is downloaded" in failures["2KOC"]
    assert "https://files.rcsb.org/download/2KOC.cif" in failures["2KOC"]
    assert "a.pdb" in result.stdout or command == "fill"


# --- eighty columns -------------------------------------------------------------------------------


@pytest.fixture
def piped(monkeypatch):
    """A command with its output in a pipe, begun in some folder."""

    def of(*arguments, cwd, columns=None):
        monkeypatch.chdir(cwd)
        monkeypatch.delenv("COLUMNS", raising=False)
        return run(*arguments, env=columns and {"COLUMNS": str(columns)}).stdout

    return of


def check_width(text, columns=80):
    """No line is wider, nothing is cut, every number is whole."""
    for line in text.splitlines():
        assert cell_len(line) <= columns, line
        assert line == line.rstrip()
    assert "…" not in text
    # an interval has both ends in one line
    assert all(line.count("(") == line.count(")") for line in text.splitlines() if "–" in line
               and re.search(r"\d\.\d \(", line))  # fmt: skip


@pytest.fixture
def ten(tmp_path, hairpin_folder):
    """Ten files under short names, and the folder they are in."""
    names = ("17ra", "1aqo", "1atv", "1bjh", "1hlx", "1jur", "1msy", "1y26", "2g1g", "430d")
    (tmp_path / "in").mkdir()
    for name in names:
        (tmp_path / "in" / f"{name}.pdb.gz").symlink_to(hairpin_folder / f"{name}.pdb.gz")
    return tmp_path


def test_a_fold_of_ten_files_fits_eighty_columns(ten, piped):
    shown = piped("fold", "in", *FAST, "-o", "out", cwd=ten)
    check_width(shown)
    rows = [row for row in table(ten / "out" / "summary.csv") if row["rank"] == "1"]
    assert len(rows) >= 10
    text = words(shown)
    for row in rows[:12]:
        low, middle, high = (
            float(row[name]) for name in ("expected_10_A", "expected_rmsd_A", "expected_90_A")
        )
        for cell in (
            f"{Path(row['file']).name} {row['closing_pair']} {row['sequence']}",
            f"{middle:.1f} ({low:.1f}–{high:.1f}) {float(row['energy_per_A']):.4f}",
            row["folder"],
        ):
            assert cell in text
    assert "Written to out" in text


def test_a_fold_with_atoms_fits_eighty_columns(ten, piped):
    pytest.importorskip("rdkit")
    for file in ("17ra", "1msy"):
        shown = piped(
            *("fold", f"in/{file}.pdb.gz", *FAST, "--atoms", "--candidates", 3, "-o", file), cwd=ten
        )
        check_width(shown)
        rows = table(ten / file / "summary.csv")
        assert shown.count("sound") >= len(rows) > 0
        for row in rows:
            assert f"{float(row['energy_per_A']):.4f}" in shown
            assert f"{float(row['atoms_rmsd_A'] or 0):.2f}" in shown


def test_a_wider_screen_is_used(ten, piped):
    wide = piped("fold", "in/1aqo.pdb.gz", *FAST, "-o", "out", cwd=ten, columns=140)
    check_width(wide, 140)
    lines = wide.splitlines()
    assert any("library " in line and line.split()[-1].count(".") == 1 for line in lines)
    assert max(map(cell_len, lines)) > 80


def test_a_filling_of_real_gaps_fits_eighty_columns(tmp_path, piped):
    pytest.importorskip("rdkit")
    folder = ROOT.parent / "shared" / "gaps"
    if not folder.is_dir():
        pytest.skip("the structures with gaps are not beside this checkout (../shared/gaps)")
    (tmp_path / "in").mkdir()
    for name in ("3npq", "4gxy", "1u9s", "1l9a", "2il9", "3f2x"):
        (tmp_path / "in" / f"{name}.cif.gz").symlink_to(folder / f"{name}.cif.gz")
    shown = piped("fill", "in", "-o", "out", cwd=tmp_path)
    check_width(shown)
    text = words(shown)
    rows = table(tmp_path / "out" / "summary.csv")
    for row in rows:
        name = row["first"] if row["first"] == row["last"] else f"{row['first']}-{row['last']}"
        assert f"{row['chain']}.{name}" in text
        if row["expected_rmsd_A"]:
            assert f"{float(row['energy_per_A']):.4f}" in text


# --- help -----------------------------------------------------------------------------------------

COMMANDS = (
    *((name,) for name in ("fold", "fill", "build", "evaluate", "scan", "hairpins", "solve")),
    *(("warm",), ("library",), ("library", "build"), ("library", "list"), ("bench",), ("studies",)),
    *(("bench", name) for name in ("paper", "atoms", "strands", "stability", "scaling")),
    ("bench", "nanostructures"),
    (),
)


@pytest.mark.parametrize("command", COMMANDS, ids=" ".join)
def test_every_command_has_a_short_help_of_eighty_columns(command):
    result = run(*command, "-h", env={"COLUMNS": "80"})
    assert result.exit_code == 0
    assert result.output == run(*command, "--help", env={"COLUMNS": "80"}).output
    assert max(map(len, result.output.splitlines())) <= 80
    assert "-h, --help" in result.output
    assert "..." not in result.output.partition("Commands:")[2]


def test_options_of_a_fold_have_headings():
    text = run("fold", "--help").output
    headings = ("Results", "Which loops", "Shapes and their order", "Atoms", "Rod", "Screen")
    places = [text.index(f"\n{heading}:\n") for heading in headings]
    assert places == sorted(places)
    assert text.index("\nAtoms:") < text.index("--hydrogens") < text.index("\nRod:")


def test_the_version_has_a_short_name():
    assert run("-V").output == run("--version").output == f"loopelastica {__version__}\n"


def test_completion_can_be_installed_and_shown():
    text = run("--help").output
    assert "--install-completion" in text
    assert "--show-completion" in text
    env = {**os.environ, "_LOOPELASTICA_COMPLETE": "complete_bash", "COMP_WORDS": "loopelastica fo",
           "COMP_CWORD": "1", "PYTHONPATH": str(ROOT)}  # fmt: skip
    code = "import sys; sys.argv = ['loopelastica']; from loopelastica.cli.app import app; app()"
    done = subprocess.run([sys.executable, "-c", code], env=env, capture_output=True, text=True)
    assert done.stdout.split() == ["fold"]
