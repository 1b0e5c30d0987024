"""The commands `library build` and `library list`, as a user meets them."""

import csv
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from typer.testing import CliRunner

from loopelastica._files import data_path
from loopelastica.cli.app import app
from loopelastica.folding.library_file import load_library

KOC = data_path("hairpins/2koc.pdb")
ROOT = Path(__file__).resolve().parents[2]


def run(*arguments):
    result = CliRunner().invoke(app, ["library", *(str(a) for a in arguments)])
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    return result


def said(result):
    return [line for line in result.stderr.splitlines() if line.strip() and "%|" not in line]


@pytest.fixture
def out(tmp_path):
    return tmp_path / "loops.lib"


def test_a_library_is_built_listed_and_built_again(out):
    folder = out.parent / "structures"
    folder.mkdir()
    (folder / KOC.name).write_bytes(KOC.read_bytes())
    result = run("build", folder, "-o", out)
    assert (result.exit_code, said(result)) == (0, [])
    assert " ".join(result.stdout.split()) == f"1 file (0 done before), 1 loop in {out}"
    content = out.read_bytes()
    listed = run("list", out)
    assert listed.exit_code == 0
    (row,) = [line for line in listed.stdout.splitlines() if line.startswith("RNA")]
    assert row.split() == ["RNA", "4", "1", "1", "1", "UUCG", "(1)"]
    assert "1 loop shape" in listed.stdout
    result = run("build", folder / KOC.name, "-o", out)
    assert "1 file (1 done before), 1 loop in" in result.stdout
    assert out.read_bytes() == content
    assert len(load_library(out)) == 1


def test_a_bad_file_is_said_and_the_library_is_written(tmp_path, out):
    (tmp_path / "bad.pdb").write_text("nothing\n")
    result = run("build", KOC, tmp_path / "bad.pdb", "-o", out)
    assert result.exit_code == 1
    (sentence,) = said(result)
    assert sentence.startswith(f"{tmp_path / 'bad.pdb'}: ")
    assert "has no loop" not in result.stdout
    assert len(load_library(out)) == 1
    with (tmp_path / "loops.lib.run" / "failures.csv").open(newline="") as file:
        assert [row["file"] for row in csv.DictReader(file)] == [str(tmp_path / "bad.pdb")]


def test_notes_name_the_option_as_it_is_called_here(tmp_path, out, hairpin_folder):
    result = run("build", hairpin_folder / "1ehz.cif.gz", "-o", out)
    assert "; --with-contacts takes such loops" in result.stdout
    assert (
        run("build", hairpin_folder / "1ehz.cif.gz", "-o", out, "--with-contacts").stdout.count(
            "takes such loops"
        )
        == 0
    )


@pytest.mark.parametrize(
    ("arguments", "status", "sentence"),
    [
        (["build", "{tmp}/empty", "-o", "{tmp}/x.lib"], 2, "holds no PDB or mmCIF file"),
        (["build", "{tmp}/absent.pdb", "-o", "{tmp}/x.lib"], 1, "no library is written"),
        (["build", KOC, "-o", "{tmp}/notes.txt"], 1, "this is no library of loop shapes"),
        (["build", KOC, "-o", "{tmp}/empty"], 1, "this is no library of loop shapes"),
        (["build", KOC, "-o", "{tmp}/notes.txt/x.lib"], 1, "cannot be written"),
        (["build", KOC, "-o", "{tmp}/x.lib", "--jobs", "2", "--scheduler", "tcp://x:1"], 2,
         "--jobs goes without --scheduler"),
        (["build", KOC, "-o", "{tmp}/x.lib", "--max-size", "-1"], 2, "--max-size is -1"),
        (["build"], 2, "Missing argument"),
        (["list", "{tmp}/notes.txt"], 1, "this is no library of loop shapes"),
        (["list", "{tmp}/absent.lib"], 1, "there is no such file"),
        (["list", "{tmp}/empty"], 1, "this is no file"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_one_sentence_and_a_status(tmp_path, arguments, status, sentence):
    (tmp_path / "empty").mkdir()
    (tmp_path / "notes.txt").write_text("mine")
    result = run(*(str(a).replace("{tmp}", str(tmp_path)) for a in arguments))
    assert result.exit_code == status, result.output
    # a usage error is broken into lines by the terminal's width
    assert sentence in " ".join(result.stderr.replace("│", " ").split())
    assert not (tmp_path / "x.lib").exists()
    assert (tmp_path / "notes.txt").read_text() == "mine"


def test_help_names_both_commands():
    result = run("--help")
    assert result.exit_code == 0
    assert {"build", "list"} <= set(result.stdout.split())


@pytest.mark.slow
def test_an_interrupted_build_leaves_no_library_and_goes_on(tmp_path, out):
    folder = tmp_path / "in"
    folder.mkdir()
    # without its HEADER each file is an entry of its own
    text = "".join(
        line for line in KOC.read_text().splitlines(True) if not line.startswith("HEADER")
    )
    for k in range(60):
        (folder / f"{k:02d}.pdb").write_text(text)
    command = [sys.executable, "-m", "loopelastica", "library", "build", folder, "-o", out]
    process = subprocess.Popen(
        command, stderr=subprocess.PIPE, cwd=ROOT, env={**os.environ, "COLUMNS": "200"}
    )
    journal = tmp_path / "loops.lib.run" / ".loops.journal"
    while not journal.exists() or journal.stat().st_size < 3000:
        assert process.poll() is None
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130
    assert b"the same command goes on from there" in errors
    assert not out.exists()
    result = run("build", folder, "-o", out)
    assert result.exit_code == 0
    assert "(0 done before)" not in result.stdout
    assert len(load_library(out)) == 60
