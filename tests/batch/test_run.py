"""Runs that are killed and taken up again give the table of an undisturbed run."""

import csv
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner

from loopelastica._files import data_path
from loopelastica.batch.folds import FOLDS
from loopelastica.batch.run import _Book, run
from loopelastica.batch.tasks import tasks_of
from loopelastica.cli.app import app
from loopelastica.folding.options import FoldOptions
from loopelastica.molecule.folders import distinct

ROOT = Path(__file__).resolve().parents[2]
OPTIONS = {**FoldOptions(all_models=False).to_dict(), "plot": False}


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Copies of the first model of 2KOC, one of them broken, two of one name."""
    folder = tmp_path_factory.mktemp("files")
    text = data_path("hairpins/2koc.pdb").read_text().split("ENDMDL")[0] + "ENDMDL\nEND\n"
    paths = [folder / f"copy{k}.pdb" for k in range(6)] + [folder / "other" / "copy0.pdb"]
    for path in paths:
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
    paths[3].write_text("no structure\n")
    return paths


@pytest.fixture(scope="module")
def undisturbed(files, tmp_path_factory):
    out = tmp_path_factory.mktemp("undisturbed")
    done = run(FOLDS, tasks_of(files, OPTIONS, out), out)
    assert (done.n_files, done.n_resumed) == (7, 0)
    assert len(done.failures) == 1
    assert "copy3.pdb" in done.failures[0]
    return out


def results(out):
    return {
        path.relative_to(out).as_posix(): path.read_bytes() for path in sorted(out.rglob("*.csv"))
    }


def test_the_table_has_a_line_per_candidate_in_the_order_of_the_input(files, undisturbed):
    with (undisturbed / "summary.csv").open() as file:
        table = list(csv.DictReader(file))
    names = [row["file"] for row in table if row["rank"] == "1"]
    assert names == [str(f) for f in files if f != files[3]]
    folders = {row["folder"] for row in table}
    assert folders == {*(f"copy{k}_A6-9" for k in (0, 1, 2, 4, 5)), "copy0_A6-9_2"}
    assert all((undisturbed / folder / "ranking.json").is_file() for folder in folders)


def test_a_run_that_is_repeated_does_nothing_and_redoes_what_is_gone(files, undisturbed):
    before = results(undisturbed)
    removed = undisturbed / "copy1_A6-9"
    for path in removed.iterdir():
        path.unlink()
    removed.rmdir()
    again = run(FOLDS, tasks_of(files, OPTIONS, undisturbed), undisturbed)
    assert again.n_resumed == 6
    assert results(undisturbed) == before


def test_other_options_are_other_work(files, undisturbed, tmp_path, monkeypatch):
    tasks = tasks_of(files[:1], OPTIONS, undisturbed)
    other = tasks_of(files[:1], {**OPTIONS, "taper": 0.0}, undisturbed)
    assert tasks[0].key != other[0].key
    assert (before := tasks[0].key) == tasks_of(files[:1], OPTIONS, tmp_path)[0].key
    # and so is another version's
    monkeypatch.setattr(sys.modules["loopelastica.batch.tasks"], "__version__", "0.0.0")
    assert tasks[0].key != before


def test_a_damaged_journal_costs_only_the_files_of_its_damaged_lines(files, undisturbed, tmp_path):
    out = tmp_path / "out"
    run(FOLDS, tasks_of(files, OPTIONS, out), out)
    before = results(out)
    journal = out / ".summary.journal"
    lines = journal.read_bytes().splitlines(keepends=True)
    lines[0], lines[4] = b"damaged\n", lines[4].replace(b'"rows": [', b'"rows": [5, ')
    journal.write_bytes(b"".join(lines))
    again = run(FOLDS, tasks_of(files, OPTIONS, out), out)
    assert (again.n_resumed, again.n_done) == (5, 7)
    assert again.notes == (f"{journal}: 2 lines are damaged; what stood there is done again",)
    assert results(out) == before


def test_what_was_done_with_other_options_is_kept(files, tmp_path):
    other = {**OPTIONS, "taper": 0.0}
    resumed = [
        run(FOLDS, tasks_of(files[:2], options, tmp_path), tmp_path).n_resumed
        for options in (OPTIONS, other, OPTIONS, other)
    ]
    journal = (tmp_path / ".summary.journal").read_text()
    assert resumed[:2] == [0, 0]
    assert all(task.key in journal for task in tasks_of(files[:2], OPTIONS, tmp_path))
    assert all(task.key in journal for task in tasks_of(files[:2], other, tmp_path))


def test_each_file_counts_once_by_whatever_path_it_is_given(files, tmp_path, monkeypatch):
    monkeypatch.chdir(files[0].parent)
    link = tmp_path / "link.pdb"
    link.symlink_to(files[1])
    given = ["copy0.pdb", "./copy0.pdb", files[0], files[1], link, "copy0.pdb", "absent.pdb"]
    found, notes = distinct([*given, "other/../absent.pdb"])
    assert found == ["copy0.pdb", str(files[1]), "absent.pdb"]
    assert notes == [
        "./copy0.pdb is the same file as copy0.pdb; it counts once",
        f"{files[0]} is the same file as copy0.pdb; it counts once",
        f"{link} is the same file as {files[1]}; it counts once",
        "copy0.pdb was given before; it counts once",
        "other/../absent.pdb is the same file as absent.pdb; it counts once",
    ]


def table(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def cli(*arguments):
    result = CliRunner().invoke(app, [str(a) for a in arguments])
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    return result


def test_the_tables_of_a_run_are_the_same_with_and_without_jobs(files, tmp_path, monkeypatch):
    monkeypatch.chdir(files[0].parent)
    given = ["./copy0.pdb", "copy3.pdb", "other/copy0.pdb", files[1], "absent.pdb", "copy0.pdb"]
    for name, jobs in (("one", ()), ("many", ("--jobs", 1))):
        result = cli("fold", *given, "--first-model", "--no-plot", "-o", tmp_path / name, *jobs)
        assert result.exit_code == 1
        assert "note: copy0.pdb is the same file as ./copy0.pdb; it counts once" in result.output
    for name in ("summary.csv", "failures.csv"):
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "many" / name).read_bytes()
    rows = table(tmp_path / "one" / "summary.csv")
    folded = ["./copy0.pdb", "other/copy0.pdb", str(files[1])]
    assert [row["file"] for row in rows if row["rank"] == "1"] == folded
    assert [row["folder"] for row in rows if row["rank"] == "1"][1] == "copy0_A6-9_2"
    failures = table(tmp_path / "one" / "failures.csv")
    assert [f["file"] for f in failures] == ["copy3.pdb", "absent.pdb"]
    assert failures[1]["failure"] == "absent.pdb: there is no such file"


def test_a_fold_without_failures_writes_an_empty_table_of_them(files, tmp_path):
    result = cli("fold", files[0], "--first-model", "--no-plot", "--no-report", "-o", tmp_path)
    assert result.exit_code == 0
    assert (tmp_path / "failures.csv").read_text() == "file,failure\n"
    assert {p.name for p in tmp_path.iterdir()} == {"copy0_A6-9", "summary.csv", "failures.csv"}


@pytest.mark.parametrize("jobs", [(), ("--jobs", 1)])
def test_results_of_inputs_that_are_gone_are_named_and_stay(files, tmp_path, jobs):
    fast = ("--first-model", "--no-plot", "-o", tmp_path, *jobs)
    assert "earlier" not in cli("fold", *files[:2], *fast).output
    for k in range(25):  # of yet other runs
        shutil.copytree(tmp_path / "copy0_A6-9", tmp_path / f"zz{k:02d}_A6-9")
    # neither of which is the result of a fold of a file
    (tmp_path / "mine").mkdir()
    (tmp_path / "built").mkdir()
    (tmp_path / "built" / "ranking.json").write_text('{"input": {"sequence": "GGC(UUUU)GCC"}}')
    result = cli("fold", files[1], files[2], *fast)
    (_, note) = " ".join(result.output.split()).split("note: ")
    assert "holds results of earlier runs that are not in summary.csv: copy0_A6-9, zz00" in note
    assert "zz06_A6-9 and 18 more" in note
    assert "mine" not in note
    assert "built" not in note
    assert (tmp_path / "copy0_A6-9" / "ranking.json").is_file()


def moved(text, rng, path):
    """The atoms of a file in another place."""
    rotation, shift = Rotation.random(rng=rng), rng.uniform(-20.0, 20.0, 3)
    lines = []
    for line in text.splitlines():
        if line.startswith(("ATOM", "HETATM")):
            place = rotation.apply([float(line[k : k + 8]) for k in (30, 38, 46)]) + shift
            line = line[:30] + "".join(f"{x:8.3f}" for x in place) + line[54:]
        lines.append(line)
    path.write_text("\n".join(lines) + "\n")


def children(pid):
    """Processes that a process has started."""
    found = subprocess.run(["pgrep", "-P", str(pid)], capture_output=True, text=True).stdout
    return [int(line) for line in found.split()]


@pytest.mark.slow
def test_files_whose_processes_are_killed_give_the_undisturbed_tables(tmp_path, rng):
    """Main process, single workers and all of them, with SIGKILL, at random moments."""
    pytest.importorskip("distributed")
    text = data_path("hairpins/2koc.pdb").read_text().split("ENDMDL")[0] + "ENDMDL\nEND"
    files = [tmp_path / f"{k % 7}" / f"copy{k // 2}.pdb" for k in range(60)]
    for file in files:
        file.parent.mkdir(exist_ok=True)
        moved(text, rng, file)
    files[17].write_text("no structure\n")
    files[43].write_bytes(b"")
    calm, out = tmp_path / "calm", tmp_path / "out"
    # rods alone: the journal is what is tried, not the folding
    options = {**OPTIONS, "shapes": "rod"}
    assert len(run(FOLDS, tasks_of(files, options, calm), calm).failures) == 2
    command = [
        *(sys.executable, "-m", "loopelastica", "fold", *map(str, files), "-o", str(out)),
        *("--jobs", "2", "--first-model", "--no-plot", "--shapes", "rod"),
    ]
    journal = out / ".summary.journal"
    kills = {"main": 0, "worker": 0, "all": 0}
    # each attempt costs the start of three processes
    for attempt in range(20):
        process = subprocess.Popen(
            command, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            start_new_session=True,
        )  # fmt: skip
        done = journal.stat().st_size if journal.exists() else 0
        whom = ("all", "worker", "main", "all", "worker", "nobody")[min(attempt, 5)]
        while process.poll() is None:
            time.sleep(0.02)
            if whom == "nobody" or not journal.exists() or journal.stat().st_size == done:
                continue
            time.sleep(rng.uniform(0.0, 0.3))  # at a random moment after one more file was done
            if process.poll() is not None:
                break
            kills[whom] += 1
            if whom == "all":
                os.killpg(process.pid, signal.SIGKILL)
            elif whom == "main":
                process.kill()
            else:
                os.kill(rng.choice(children(process.pid)), signal.SIGKILL)
                whom, done = "main", journal.stat().st_size
        process.wait()
        failures = out / "failures.csv"
        if process.returncode == 1 and failures.read_text().count("\n") == 3:
            break
    print(f"{attempt + 1} runs, kills: {kills}")
    assert min(kills.values()) >= 1
    for name in ("summary.csv", "failures.csv"):
        assert (out / name).read_bytes() == (calm / name).read_bytes()
    assert {p.name for p in out.iterdir() if p.is_dir()} == {
        p.name for p in calm.iterdir() if p.is_dir()
    }
    assert results(out) == results(calm)


def test_the_table_is_there_as_parquet_too(undisturbed):
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    table = pandas.read_parquet(undisturbed / "summary.parquet")
    assert len(table) == len(pandas.read_csv(undisturbed / "summary.csv"))


def test_only_tables_that_a_killed_run_began_are_cleared_away(tmp_path):
    theirs = tmp_path / ".summary.mine.csv"
    begun = [tmp_path / ".loopelastica-x1.csv", tmp_path / ".loopelastica-x2.parquet"]
    for path in (theirs, *begun):
        path.write_text("file\n")
    _Book(FOLDS, [], tmp_path, str)
    assert theirs.exists()
    assert not any(path.exists() for path in begun)


def test_a_further_file_that_the_result_depends_on_is_part_of_the_key(tmp_path):
    source, beside = tmp_path / "a.pdb", tmp_path / "template.pdb"
    for path in (source, beside):
        path.write_text("one")
    (alone,) = tasks_of([source], OPTIONS, tmp_path)
    (none,) = tasks_of([source], OPTIONS, tmp_path, [None])
    (task,) = tasks_of([source], OPTIONS, tmp_path, [None, str(beside)])
    assert alone.key == none.key != task.key
    before = task.key
    beside.write_text("two")
    assert task.key != before


def test_a_folder_that_the_result_depends_on_is_part_of_the_key_with_what_is_in_it(tmp_path):
    source, folder = tmp_path / "a.pdb", tmp_path / "loops"
    source.write_text("one")
    (folder / "deep").mkdir(parents=True)
    (task,) = tasks_of([source], OPTIONS, tmp_path, [str(folder)])
    keys = [task.key, task.key]
    for name, text in (("deep/b.pdb", "one"), ("deep/b.pdb", "other"), ("c.cif", "one")):
        (folder / name).write_text(text)
        keys.append(task.key)
    assert keys[0] == keys[1]
    assert len(set(keys)) == 4
    (folder / "notes.txt").write_text("no structure")
    assert task.key == keys[-1]
