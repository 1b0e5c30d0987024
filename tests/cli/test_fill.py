"""The command `fill`, as a user meets it."""

import csv
import gzip
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import damage
import gapped
import numpy as np
import pytest
from typer.testing import CliRunner

from loopelastica.cli.app import app

pytest.importorskip("rdkit")
ROOT = Path(__file__).resolve().parents[2]


def run(*arguments):
    result = CliRunner().invoke(app, ["fill", *(str(a) for a in arguments)])
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    return result


def table(path):
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def results(out):
    """What is in the folder of a run, tables aside."""
    names = {p.relative_to(out).as_posix() for p in out.rglob("*") if p.is_file()}
    return {n for n in names if not n.startswith(("summary.", "failures.csv", ".summary"))}


def sentence(result):
    lines = [line for line in result.stderr.splitlines() if line.strip() and "%|" not in line]
    assert len(lines) == 1, lines
    return lines[0]


@pytest.fixture
def out(tmp_path):
    return tmp_path / "out"


@pytest.mark.parametrize("kind", ["pdb", "cif"])
def test_a_file_gets_a_folder_with_the_structure_and_its_record(tmp_path, out, kind):
    file = tmp_path / f"a.{kind}"
    (gapped.gapped if kind == "pdb" else gapped.gapped_cif)(file, {6, 7})
    result = run(file, "-o", out)
    assert result.exit_code == 0, result.output
    assert result.stderr == ""
    assert results(out) == {"a/fill.json", f"a/filled.{kind}"}
    gapped.added_rows(file, out / "a" / f"filled.{kind}")
    gapped.check_chain(gapped.read(out / "a" / f"filled.{kind}"))
    (row,) = table(out / "summary.csv")
    assert (row["file"], row["status"], row["folder"]) == (str(file), "filled", "a")
    assert table(out / "failures.csv") == []
    for text in ("A.6-7", "UU", "yes"):
        assert text in result.stdout


def test_compressed_input_is_written_plainly(tmp_path, out):
    plain = gapped.gapped_cif(tmp_path / "a.cif", {7})
    (tmp_path / "b.cif.gz").write_bytes(gzip.compress(plain.read_bytes()))
    assert run(tmp_path / "b.cif.gz", "-o", out).exit_code == 0
    assert results(out) == {"b/fill.json", "b/filled.cif"}
    gapped.check_chain(gapped.read(out / "b" / "filled.cif"))


def test_a_strand_is_named_with_its_sequence(tmp_path, out):
    file = gapped.pdb(tmp_path / "a.pdb", gapped.chain({4, 6, 7, 8, 9}))
    result = run(file, "--strand", "A.6-9=UUCG", "--strand", "A.4=A", "-o", out)
    assert result.exit_code == 0, result.output
    content = json.loads((out / "a" / "fill.json").read_text())
    assert [(s["first"], s["sequence"]) for s in content["strands"]] == [("6", "UUCG"), ("4", "A")]
    gapped.check_chain(gapped.read(out / "a" / "filled.pdb"))


def test_further_candidates_are_files_of_their_own(tmp_path, out):
    file = gapped.gapped(tmp_path / "a.pdb", {4, 5, 6, 7, 8, 9, 10})
    assert run(file, "--candidates", 3, "-o", out).exit_code == 0
    (strand,) = json.loads((out / "a" / "fill.json").read_text())["strands"]
    n = len(strand["candidates"])
    assert 1 < n <= 3
    more = {f"a/filled_{k}.pdb" for k in range(2, n + 1)}
    assert results(out) == {"a/fill.json", "a/filled.pdb", *more}
    assert len(table(out / "summary.csv")) == 1


def test_hydrogens_come_and_5_phosphates_go_by_their_options(tmp_path, out):
    file = gapped.gapped(tmp_path / "a.pdb", {6, 7})
    result = run(file, "--hydrogens", "-o", out)
    assert result.exit_code == 0, result.output
    assert "A.G1: its 5' phosphate is refused by Amber's and CHARMM's" in result.output
    filled = out / "a" / "filled.pdb"
    assert sum(line[76:78] == " H" for line in filled.read_text().splitlines()) == 152
    gapped.check_chain(gapped.read(filled))
    result = run(file, "--hydrogens", "--no-5-phosphate", "-o", out)
    assert result.exit_code == 0, result.output
    assert "phosphate" not in result.output
    names = [line[12:16] for line in filled.read_text().splitlines() if line[22:26] == "   1"]
    assert "HO5'" in names
    assert " P  " not in names
    parameters = json.loads((out / "a" / "fill.json").read_text())["parameters"]
    assert parameters["hydrogens"] is parameters["no_5_phosphate"] is True


def test_a_file_without_gaps_is_written_where_it_gets_hydrogens(tmp_path, out):
    file = gapped.gapped(tmp_path / "a.pdb", ())
    assert run(file, "-o", out).exit_code == 0
    assert results(out) == {"a/fill.json"}
    assert run(file, "--hydrogens", "-o", out).exit_code == 0
    assert results(out) == {"a/fill.json", "a/filled.pdb"}


def test_a_gap_without_a_sequence_is_refused_and_the_sentence_shows_the_way(tmp_path, out):
    file = gapped.pdb(tmp_path / "a.pdb", gapped.chain({6, 7}))
    result = run(file, "-o", out)
    assert result.exit_code == 1
    said = sentence(result)
    assert said.startswith(f"{file}: A.6-7: ")
    assert said.endswith("give the sequence as a strand, A.6-7=NN")
    assert results(out) == {"a/fill.json"}
    assert table(out / "failures.csv") == [{"file": str(file), "failure": said}]


@pytest.mark.parametrize(
    ("arguments", "fragment"),
    [
        (("--strand", "A.6-7=XX"), "no base that can be built"),
        (("--strand", "A.6-7="), "it must be like A.6-9 or A.6-9=UUCG"),
        (("--strand", "hello"), "it must be like A.6-9 or A.6-9=UUCG"),
        (("--strand", "A.7-6=UU"), "from 5' to 3'"),
        (("--strand", "A.6-7=UU", "--strand", "A.7=U"), "overlap"),
        (("--candidates", "0"), "--candidates"),
        (("--candidates", "many"), "--candidates"),
        (("--jobs", "0"), "--jobs"),
        (("--jobs", "2", "--scheduler", "tcp://a:1"), "--jobs"),
        (("--nonsense",), "--nonsense"),
        (("--max-atoms", "0"), "--max-atoms"),
    ],
)
def test_an_option_that_is_wrong_is_one_of_usage_and_nothing_is_written(
    tmp_path, out, arguments, fragment
):
    file = gapped.gapped(tmp_path / "a.pdb", {6, 7})
    result = run(file, *arguments, "-o", out)
    assert result.exit_code == 2
    # in a frame that wraps lines
    said = " ".join(result.stderr.replace("│", " ").split())
    assert fragment in said
    assert "`" not in said
    assert not out.exists()


def test_no_file_at_all_is_one_of_usage(out):
    assert run("-o", out).exit_code == 2
    assert not out.exists()


@pytest.mark.parametrize(
    ("strand", "fragment"),
    [
        ("A.6-7=UUU", "the numbers say 2 nt, and the sequence has 3"),
        ("B.6-7=UU", "there is no chain B of nucleotides; there is A"),
        ("A.6=U", "A.7 beside it is not in the file"),
        ("A.90-91=UU", "chain A runs from A.G1 to A.C14"),
    ],
)
def test_a_strand_that_contradicts_the_file_is_a_sentence_and_no_folder(
    tmp_path, out, strand, fragment
):
    file = gapped.pdb(tmp_path / "a.pdb", gapped.chain({6, 7}))
    result = run(file, "--strand", strand, "-o", out)
    assert result.exit_code == 1
    said = sentence(result)
    assert said.startswith(f"{file}: --strand {strand}: ")
    assert fragment in said
    assert results(out) == set()


def test_every_bad_file_is_one_sentence_and_the_good_ones_are_filled(tmp_path, out):
    good = [gapped.gapped(tmp_path / name, {7}) for name in ("a.pdb", "z.pdb")]
    contents = {
        "empty.pdb": b"",
        "empty.cif": b"",
        "noise.pdb": bytes(range(256)) * 10,
        "cut.cif.gz": gzip.compress(gapped.TEXT.encode())[:2000],
        "protein.pdb": b"ATOM      1  CA  ALA A   1      11.104   6.134  -6.504  1.00  0.00\nEND\n",
        "other.xyz": b"1\n\nC 0 0 0\n",
    }
    for name, content in contents.items():
        (tmp_path / name).write_bytes(content)
    (tmp_path / "folder.pdb").mkdir()
    bad = [tmp_path / name for name in (*contents, "folder.pdb", "absent.pdb")]
    result = run(good[0], *bad, good[1], "-o", out)
    assert result.exit_code == 1
    assert "Traceback" not in result.output
    failures = table(out / "failures.csv")
    assert [row["file"] for row in failures] == [str(path) for path in bad]
    assert all(row["failure"].startswith(f"{row['file']}: ") for row in failures)
    assert results(out) == {f"{k}/{n}" for k in "az" for n in ("fill.json", "filled.pdb")}
    assert [row["file"] for row in table(out / "summary.csv")] == [str(path) for path in good]


def test_missing_ends_alone_are_named_and_no_failure(tmp_path, out):
    result = run(gapped.gapped(tmp_path / "a.pdb", {1, 2, 14}), "-o", out)
    assert result.exit_code == 0
    assert result.stdout.count("note: ") == 3
    notes = [line for line in result.stdout.splitlines() if line.startswith("note: ")]
    assert "A.1-2 (GG)" in notes[0]
    assert "A.14 (C)" in notes[1]
    assert "nothing to fill" in notes[2]
    assert "─" not in result.stdout
    assert results(out) == {"a/fill.json"}


def test_what_was_completed_is_told(tmp_path, out):
    result = run(gapped.gapped(tmp_path / "a.pdb", {(11, "N3"), (11, "C4")}), "-o", out)
    assert result.exit_code == 0
    assert "missing atoms were added to A.U11" in result.stdout
    assert results(out) == {"a/fill.json", "a/filled.pdb"}


def test_a_broken_bond_is_left_unless_repair_is_wanted(tmp_path, out):
    file = tmp_path / "a.pdb"
    file.write_text("\n".join(damage.broken(damage.first_model(), 10, [1.5, 1.5, 0.0])) + "\n")
    left = run(file, "-o", out)
    assert left.exit_code == 0, left.output
    assert "broken" in left.stdout
    assert results(out) == {"a/fill.json"}
    mended = run(file, "-o", out, "--repair")
    assert mended.exit_code == 0, mended.output
    content = json.loads((out / "a" / "fill.json").read_text())
    assert len(content["repaired"]) == 1
    assert content["not_repaired"] == []
    before, after = (
        damage.heavy(path.read_text().splitlines()) for path in (file, out / "a" / "filled.pdb")
    )
    assert set(before) == set(after)
    moved = {
        number for number, name in before if (before[number, name] != after[number, name]).any()
    }
    assert moved
    assert moved <= {9, 10, 11}
    for k in range(1, 14):
        assert abs(np.linalg.norm(after[k, "O3'"] - after[k + 1, "P"]) - 1.607) < 0.06


def test_the_second_run_resumes(tmp_path, out):
    files = [gapped.gapped(tmp_path / f"{k}.pdb", {7}) for k in "ab"]
    first = run(*files, "-o", out)
    tables = [(out / name).read_bytes() for name in ("summary.csv", "failures.csv")]
    again = run(*files, "-o", out)
    assert "2 files (0 were done before)" in first.stdout
    assert "2 files (2 were done before)" in again.stdout
    assert [(out / name).read_bytes() for name in ("summary.csv", "failures.csv")] == tables


def test_a_file_where_the_folder_should_be_is_one_sentence(tmp_path):
    file = gapped.gapped(tmp_path / "a.pdb", {7})
    (tmp_path / "taken").write_text("mine")
    for place in (tmp_path / "taken", tmp_path / "taken" / "out"):
        result = run(file, "-o", place)
        assert result.exit_code == 1
        assert str(place) in sentence(result)
    assert (tmp_path / "taken").read_text() == "mine"


def test_a_folder_that_takes_nothing_is_one_sentence(tmp_path):
    result = run(gapped.gapped(tmp_path / "a.pdb", {7}), "-o", "/proc/nothing")
    assert result.exit_code == 1
    assert "/proc/nothing" in sentence(result)


def test_a_users_own_files_stay(tmp_path, out):
    file = gapped.gapped(tmp_path / "a.pdb", {7})
    (out / "a").mkdir(parents=True)
    for name in ("notes.txt", "a/notes.txt"):
        (out / name).write_text("mine")
    assert run(file, "-o", out).exit_code == 0
    assert run(file, "--candidates", 2, "-o", out).exit_code == 0
    for name in ("notes.txt", "a/notes.txt"):
        assert (out / name).read_text() == "mine"


def test_a_table_of_somebody_else_is_left_alone(tmp_path, out):
    out.mkdir()
    (out / "summary.csv").write_text("mine\n")
    result = run(gapped.gapped(tmp_path / "a.pdb", {7}), "-o", out)
    assert result.exit_code == 1
    assert str(out / "summary.csv") in sentence(result)
    assert {p.name for p in out.iterdir()} == {"summary.csv"}


def test_results_beside_the_input_touch_no_input(tmp_path, monkeypatch):
    file = gapped.gapped(tmp_path / "filled.pdb", {7})
    before = file.read_bytes()
    monkeypatch.chdir(tmp_path)
    assert run("filled.pdb", "-o", ".").exit_code == 0
    assert file.read_bytes() == before
    assert table(tmp_path / "summary.csv")[0]["file"] == "filled.pdb"
    assert (tmp_path / "filled" / "filled.pdb").is_file()


def test_the_table_has_filled_and_refused_strands_in_eighty_columns(tmp_path, out):
    atoms = [*gapped.chain({6, 7}), "TER", *gapped.chain({9}, name="B", moved=40.0)]
    result = run(gapped.pdb(tmp_path / "a.pdb", atoms, head=gapped.seqres()), "-o", out)
    assert "a.pdb, in a" in result.stdout
    lines = result.stdout.splitlines()
    assert any("A.6-7  UU" in line and line.endswith("yes") for line in lines)
    assert any("B.9" in line and line.endswith("refused") for line in lines)


def test_the_help_says_what_it_does():
    result = CliRunner().invoke(app, ["fill", "--help"])
    assert result.exit_code == 0
    for text in ("internal gap", "--strand", "--candidates", "--jobs", "A.6-9=UUCG"):
        assert text in " ".join(result.stdout.split())


# --- runs that are stopped ------------------------------------------------------------------------


def started(*arguments):
    return subprocess.Popen(
        [sys.executable, "-m", "loopelastica", "fill", "--no-report", *map(str, arguments)],
        cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True,
    )  # fmt: skip


def wait_for(process, journal, lines):
    deadline = time.monotonic() + 240
    while process.poll() is None and time.monotonic() < deadline:
        if journal.exists() and journal.read_bytes().count(b"\n") > lines:
            return
        time.sleep(0.01)


@pytest.fixture
def forty(tmp_path):
    return [gapped.gapped(tmp_path / f"copy{k}.pdb", {7}) for k in range(40)]


@pytest.mark.slow
def test_an_interrupted_run_says_what_is_done_and_goes_on(forty, out):
    process = started(*forty, "-o", out)
    wait_for(process, out / ".summary.journal", 3)
    os.killpg(process.pid, signal.SIGINT)
    _, errors = process.communicate(timeout=120)
    assert process.returncode == 130
    said = errors.decode()
    assert "Traceback" not in said
    assert "of 40 files are done and kept, and the same command goes on from there" in said
    assert {p.name for p in out.iterdir() if p.name.startswith(".copy")} == set()
    done = len(table(out / "summary.csv"))
    assert 2 <= done < 40
    again = run(*forty, "-o", out)
    assert again.exit_code == 0
    assert any(f"({k} were done before)" in again.stdout for k in (done, done + 1))
    assert len(table(out / "summary.csv")) == 40


@pytest.mark.slow
def test_a_killed_run_resumes_to_the_same_tables(forty, out, tmp_path):
    process = started(*forty, "-o", out)
    wait_for(process, out / ".summary.journal", 5)
    process.kill()
    process.communicate(timeout=120)
    assert run(*forty, "-o", out).exit_code == 0
    assert run(*forty, "-o", tmp_path / "calm").exit_code == 0
    for name in ("summary.csv", "failures.csv"):
        assert (out / name).read_bytes() == (tmp_path / "calm" / name).read_bytes()
    assert results(out) == results(tmp_path / "calm")


@pytest.mark.slow
def test_two_jobs_and_their_resumption_write_the_tables_of_one(forty, out, tmp_path):
    pytest.importorskip("distributed")
    assert run(*forty[:4], "-o", tmp_path / "one").exit_code == 0
    assert run(*forty[:2], "--jobs", 2, "-o", out).exit_code == 0
    assert run(*forty[:4], "--jobs", 2, "-o", out).exit_code == 0
    for name in ("summary.csv", "failures.csv"):
        assert (out / name).read_bytes() == (tmp_path / "one" / name).read_bytes()


@pytest.fixture
def eighth(tmp_path):
    """The eighth model of 2KOC as a template."""
    return gapped.pdb(tmp_path / "eighth.pdb", gapped.chain(model=8))


def test_a_strand_like_another_one_says_so_in_the_record_and_on_the_screen(tmp_path, out, eighth):
    file = gapped.gapped(tmp_path / "a.pdb", {6, 7, 8, 9})
    result = run(file, "--like", f"{eighth}:A.5-A.10", "-o", out)
    assert result.exit_code == 0, result.output
    assert "like" in result.stdout
    assert "eighth" in result.stdout
    (strand,) = json.loads((out / "a" / "fill.json").read_text())["strands"]
    assert strand["candidates"][0]["shape"] == "like eighth A.5-A.10"
    (row,) = table(out / "summary.csv")
    assert row["shape"] == "like eighth A.5-A.10"


@pytest.mark.parametrize(
    ("like", "status", "fragment"),
    [
        ("{}:loop", 2, "--like"),
        ("nowhere.pdb", 1, "nowhere.pdb: there is no such file"),
        ("{}:A.5-A.99", 1, "there is no nucleotide A.99"),
    ],
)
def test_a_template_that_is_none_is_one_sentence_and_nothing_is_written(
    tmp_path, out, eighth, like, status, fragment
):
    file = gapped.gapped(tmp_path / "a.pdb", {6, 7, 8, 9})
    result = run(file, "--like", like.format(eighth), "-o", out)
    assert result.exit_code == status
    assert fragment in result.stderr
    assert not out.exists()


def test_a_template_that_fits_no_strand_is_one_sentence_and_no_structure(tmp_path, out, eighth):
    file = gapped.gapped(tmp_path / "a.pdb", {6, 7, 8, 9})
    result = run(file, "--like", f"{eighth}:A.1-A.3", "-o", out)
    assert result.exit_code == 1
    assert "its strand has 1 nucleotide, what is to be like it 4" in sentence(result)
    assert results(out) == set()


def test_a_template_that_has_changed_is_other_work(tmp_path, out, eighth):
    files = [gapped.gapped(tmp_path / f"{k}.pdb", {6, 7, 8, 9}) for k in "ab"]
    run(*files, "--like", eighth, "-o", out)
    again = run(*files, "--like", eighth, "-o", out)
    assert "2 files (2 were done before)" in again.stdout
    before = (out / "a" / "filled.pdb").read_bytes()
    gapped.pdb(eighth, gapped.chain(model=3))
    changed = run(*files, "--like", eighth, "-o", out)
    assert "2 files (0 were done before)" in changed.stdout
    assert (out / "a" / "filled.pdb").read_bytes() != before


@pytest.fixture
def library(tmp_path):
    """A library of one loop: that of the eighth model of 2KOC."""
    folder = tmp_path / "structures"
    gapped.pdb(folder / "1abc.pdb", gapped.chain(model=8))
    return folder


def test_a_strand_with_a_shape_of_a_library_says_so_in_the_record_and_on_the_screen(
    tmp_path, out, library
):
    file = gapped.gapped(tmp_path / "a.pdb", {6, 7, 8, 9})
    result = run(file, "--library", library, "--candidates", 2, "-o", out)
    assert result.exit_code == 0, result.output
    assert "motif UNCG" in result.stdout
    content = json.loads((out / "a" / "fill.json").read_text())
    assert content["parameters"]["library"] == str(library)
    (strand,) = content["strands"]
    assert [candidate["shape"] for candidate in strand["candidates"]] == [
        "motif UNCG, same sequence, 1 loop", "rod in its surroundings",
    ]  # fmt: skip
    (row,) = table(out / "summary.csv")
    assert row["shape"] == "motif UNCG, same sequence, 1 loop"


def test_a_library_that_has_no_such_loop_is_a_note(tmp_path, out, library):
    file = gapped.gapped(tmp_path / "a.pdb", {6, 7})
    result = run(file, "--library", library, "-o", out)
    assert result.exit_code == 0, result.output
    assert "A.6-7: the library has no other loop of 2 nucleotides" in result.stdout


def test_a_library_that_is_none_is_one_sentence_and_nothing_is_written(tmp_path, out):
    files = [gapped.gapped(tmp_path / f"{k}.pdb", {6, 7, 8, 9}) for k in "ab"]
    result = run(*files, "--library", tmp_path / "nowhere.lib", "-o", out)
    assert result.exit_code == 1
    assert "nowhere.lib" in sentence(result)
    assert not out.exists()


def test_a_library_that_has_changed_is_other_work(tmp_path, out, library):
    from loopelastica.batch.shapes import build_library

    lib = tmp_path / "some.lib"
    build_library(library, lib)
    files = [gapped.gapped(tmp_path / f"{k}.pdb", {6, 7, 8, 9}) for k in "ab"]
    run(*files, "--library", lib, "-o", out)
    again = run(*files, "--library", lib, "-o", out)
    assert "2 files (2 were done before)" in again.stdout
    gapped.pdb(library / "2abc.pdb", gapped.chain(model=3))
    build_library(library, lib)
    changed = run(*files, "--library", lib, "-o", out)
    assert "2 files (0 were done before)" in changed.stdout
    (row, _) = table(out / "summary.csv")
    assert row["shape"] == "motif UNCG, same sequence, 2 loops"
    run(*files, "--library", library, "-o", out)
    gapped.pdb(library / "3abc.pdb", gapped.chain(model=5))
    changed = run(*files, "--library", library, "-o", out)
    assert "2 files (0 were done before)" in changed.stdout
