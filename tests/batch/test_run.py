"""Runs that are killed and taken up again give the table of an undisturbed run."""

import csv
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from loopelastica._files import data_path
from loopelastica.batch.folds import FOLDS
from loopelastica.batch.run import run, tasks_of
from loopelastica.folding.options import FoldOptions

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
    monkeypatch.setattr(sys.modules["loopelastica.batch.run"], "__version__", "0.0.0")
    assert tasks[0].key != before


@pytest.mark.slow
def test_a_run_killed_three_times_gives_the_undisturbed_table(files, undisturbed, tmp_path, rng):
    pytest.importorskip("distributed")
    out = tmp_path / "out"
    command = [
        *(sys.executable, "-m", "loopelastica.cli.app", "fold", *map(str, files), "-o", str(out)),
        *("--jobs", "2", "--first-model", "--no-plot"),
    ]
    kills = 0
    journal = out / ".summary.journal"
    for _ in range(3):
        process = subprocess.Popen(
            command, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            start_new_session=True,
        )  # fmt: skip
        before = journal.stat().st_size if journal.exists() else 0
        while process.poll() is None:
            time.sleep(0.02)
            # at a random moment after at least one more file was done
            if journal.exists() and journal.stat().st_size > before:
                time.sleep(rng.uniform(0.0, 0.3))
                break
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            kills += 1
        process.wait()
    assert kills
    done = run(FOLDS, tasks_of(files, OPTIONS, out), out)
    assert done.n_resumed
    assert results(out) == results(undisturbed)
    assert {p.name for p in out.iterdir() if p.is_dir() and not p.name.startswith(".")} == {
        p.name for p in undisturbed.iterdir() if p.is_dir()
    }


def test_the_table_is_there_as_parquet_too(undisturbed):
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    table = pandas.read_parquet(undisturbed / "summary.parquet")
    assert len(table) == len(pandas.read_csv(undisturbed / "summary.csv"))
