"""`hairpins` and `scan` of one file and of several."""

import csv
import json

import pytest
from typer.testing import CliRunner

from loopelastica._files import data_path
from loopelastica.cli.app import app

HAIRPIN = data_path("hairpins/2koc.pdb")
SMALL = ("--extend-5", 0, "--extend-3", 1)


def run(*arguments):
    result = CliRunner().invoke(app, [str(a) for a in arguments])
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    return result


@pytest.fixture
def files(tmp_path):
    """The first model of 2KOC twice, with a file between them that is none."""
    text = HAIRPIN.read_text().split("ENDMDL")[0] + "ENDMDL\nEND\n"
    for name, content in (("a.pdb", text), ("bad.pdb", "nothing\n"), ("c.pdb", text)):
        (tmp_path / name).write_text(content)
    return [tmp_path / name for name in ("a.pdb", "bad.pdb", "c.pdb")]


@pytest.mark.parametrize("command", [("hairpins",), ("scan", *SMALL)])
def test_a_bad_file_does_not_stop_the_others(files, command):
    for given in (files, [files[0].parent]):
        result = run(*command, *given)
        assert result.exit_code == 1
        (sentence,) = result.stderr.splitlines()
        assert sentence.startswith(f"{files[1]}: ")
        assert result.stdout.count("A.C5–A.G10") == 2
        assert "c.pdb" in result.stdout


def test_hairpins_of_several_files_are_written_into_one_file(files, tmp_path):
    path = tmp_path / "all.json"
    run("hairpins", *files, "-o", path)
    content = json.loads(path.read_text())
    assert [one["file"] for one in content["files"]] == [str(files[0]), str(files[2])]
    run("hairpins", files[0], "-o", path)
    assert json.loads(path.read_text())["hairpins"] == content["files"][0]["hairpins"]


def test_a_file_behind_json_is_written_as_it_was(files, tmp_path):
    path = tmp_path / "one.json"
    result = run("hairpins", files[0], "--json", path)
    assert result.exit_code == 0
    assert "A.C5–A.G10" in result.stdout
    assert json.loads(path.read_text())["input"]["file"] == "a.pdb"


@pytest.mark.parametrize("name", ["scan.csv", "other.csv"])
def test_a_scan_writes_its_table(files, tmp_path, name):
    out = tmp_path / "new" if name == "scan.csv" else tmp_path / "new" / name
    result = run("scan", files[0], files[2], *SMALL, "-o", out)
    assert result.exit_code == 0, result.output
    path = tmp_path / "new" / name
    assert str(path) in "".join(result.stdout.split("\n"))
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert {row["file"] for row in rows} == {str(files[0]), str(files[2])}
    ranks = [int(row["rank"]) for row in rows if row["file"] == str(files[0])]
    assert ranks == list(range(1, len(ranks) + 1))
    assert sum(row["is_rule"] == "True" for row in rows) >= 2
    energies = [float(row["energy_per_A"]) for row in rows if row["touching"] == "False"]
    assert energies[: len(energies) // 2] == sorted(energies[: len(energies) // 2])


def test_a_scan_replaces_no_table_of_others(files, tmp_path):
    (tmp_path / "scan.csv").write_text("name,dose\n")
    result = run("scan", files[0], *SMALL, "-o", tmp_path)
    assert result.exit_code == 1
    assert "not written by this program" in result.stderr
    assert (tmp_path / "scan.csv").read_text() == "name,dose\n"
