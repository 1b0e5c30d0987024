"""The page that a run ends with, as a user meets it."""

import json
import re

import gapped
import pytest
from typer.testing import CliRunner

from loopelastica._files import data_path
from loopelastica.cli.app import app
from loopelastica.folding.fold import fold_hairpins

pytest.importorskip("plotly")
FEW = ("--first-model", "--candidates", "1", "--shapes", "rod", "--no-plot")
SCRIPT = re.compile(r"<script>window\.report = (.*);</script>\n")


@pytest.fixture(autouse=True)
def _plotly(monkeypatch):
    monkeypatch.setattr("loopelastica.report.page.write.is_available", lambda: True)


@pytest.fixture
def files(tmp_path):
    text = data_path("hairpins/2koc.pdb").read_text().split("ENDMDL")[0] + "ENDMDL\nEND\n"
    paths = [tmp_path / "a.pdb", tmp_path / "b.pdb"]
    for path in paths:
        path.write_text(text)
    return paths


@pytest.fixture
def out(tmp_path):
    return tmp_path / "out"


def run(*arguments):
    return CliRunner().invoke(app, [str(a) for a in arguments])


def page(out):
    return json.loads(SCRIPT.search((out / "report.html").read_text(encoding="utf-8"))[1])


def loops(out):
    return [(row["file"], row["loop"], row["place"]) for row in page(out)["rows"]]


@pytest.mark.parametrize("jobs", [(), ("--jobs", "1")])
def test_a_fold_ends_with_the_page_of_all_its_loops(files, out, jobs):
    result = run("fold", *files, "-o", out, *FEW, *jobs)
    assert result.exit_code == 0, result.output
    assert "report.html shows it all" in " ".join(result.output.split())
    assert loops(out) == [(str(file), "A6-9", 0) for file in files]
    manifest = json.loads((out / "a_A6-9" / "ranking.json").read_text())
    assert "scene.js" in manifest["files"]


def test_a_resumed_fold_makes_the_page_from_the_folders(files, out):
    run("fold", files[0], "-o", out, *FEW, "--jobs", "1")
    (out / "report.html").unlink()
    result = run("fold", *files, "-o", out, *FEW, "--jobs", "1")
    assert "(1 were done before)" in result.output
    assert [loop[0] for loop in loops(out)] == [str(file) for file in files]


def test_a_file_that_failed_stands_on_the_page(files, out):
    files[1].write_text("no structure\n")
    assert run("fold", *files, "-o", out, *FEW).exit_code == 1
    (failure,) = page(out)["failures"]
    assert failure["file"] == str(files[1])
    assert len(loops(out)) == 1


def test_a_fill_ends_with_the_page_of_its_strands(tmp_path, out):
    pytest.importorskip("rdkit")
    result = run("fill", gapped.gapped(tmp_path / "a.pdb", {7}), "-o", out)
    assert result.exit_code == 0, result.output
    (row,) = page(out)["rows"]
    assert (row["loop"], row["status"], row["candidates"]) == ("A.7", "filled", 1)


def test_a_built_hairpin_has_a_page(out):
    pytest.importorskip("rdkit")
    result = run("build", "GGCAC(UUCG)GUGCC", "-o", out, "--candidates", "1", "--no-plot")
    assert result.exit_code == 0, result.output
    ((row),) = page(out)["rows"]
    assert (row["sequence"], row["sound"]) == ("CUUCGG", True)


def test_no_report_leaves_neither_page_nor_scene_nor_those_of_an_earlier_run(files, out):
    run("fold", files[0], "-o", out, *FEW)
    result = run("fold", files[0], "-o", out, *FEW, "--no-report")
    assert result.exit_code == 0
    assert "report.html" not in result.output
    assert not list(out.rglob("report.html"))
    assert not list(out.rglob("scene.js"))


def test_without_plotly_there_is_no_page_and_asking_for_it_is_a_sentence(files, out, monkeypatch):
    monkeypatch.setattr("loopelastica.report.page.write.is_available", lambda: False)
    assert run("fold", files[0], "-o", out, *FEW).exit_code == 0
    assert not (out / "report.html").exists()
    asked = run("fold", files[0], "-o", out / "more", *FEW, "--report")
    assert asked.exit_code == 1
    assert "pip install loopelastica[report]" in asked.output
    assert not (out / "more").exists()


def test_an_interrupted_fold_leaves_the_page_of_what_is_done(files, out, monkeypatch):
    def interrupted(structure, *arguments):
        if "b.pdb" in str(structure.source):
            raise KeyboardInterrupt
        return fold_hairpins(structure, *arguments)

    monkeypatch.setattr("loopelastica.batch.folds.fold_hairpins", interrupted)
    assert run("fold", *files, "-o", out, *FEW).exit_code == 130
    assert [loop[0] for loop in loops(out)] == [str(files[0])]
