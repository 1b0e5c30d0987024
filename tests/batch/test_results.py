"""Folds written from Python: the files and rows of the command."""

import csv
import json
import shutil
import warnings
from pathlib import Path

import pytest
from typer.testing import CliRunner

import loopelastica as le
from loopelastica._files import data_path
from loopelastica.cli.app import app

HAIRPIN = data_path("hairpins/2koc.pdb")
RODS = {"all_models": False, "shapes": "rod", "max_candidates": 3}


@pytest.fixture(scope="module")
def folds():
    return le.fold(HAIRPIN, **RODS)


@pytest.fixture(scope="module")
def refused():
    return le.fold(HAIRPIN, length_per_nucleotide_A=2.0, **RODS)


def rows_of(path):
    with path.open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def command(out, *options):
    few = ("--shapes", "rod", "--first-model", "--candidates", "3")
    arguments = ["fold", str(HAIRPIN), "-o", str(out), *few]
    assert CliRunner().invoke(app, [*arguments, *options]).exit_code == 0
    return out


@pytest.mark.parametrize("atoms", [False, True])
def test_a_run_in_python_gives_the_files_and_rows_of_the_command(tmp_path, folds, atoms):
    out = folds.write(tmp_path / "python", **({"atoms": True, "names": "amber"} if atoms else {}))
    other = command(tmp_path / "command", *(["--atoms", "--names", "amber"] if atoms else []))
    assert out == tmp_path / "python"
    # a page is of the command alone
    shared = {"report.html", "2koc_A6-9/scene.js"}
    names = [{str(p.relative_to(root)) for p in root.rglob("*")} for root in (out, other)]
    assert names[0] - shared == names[1] - shared
    for table in ("summary.csv", "failures.csv", "2koc_A6-9/ranking.csv"):
        assert rows_of(out / table) == rows_of(other / table)
    for name in {"2koc_A6-9/traces.pdb", "2koc_A6-9/atoms.pdb", "2koc_A6-9/whole.pdb"} & names[0]:
        assert (out / name).read_text() == (other / name).read_text()
    paths = [json.loads((root / "2koc_A6-9/ranking.json").read_text()) for root in (out, other)]
    assert paths[0]["input"] == paths[1]["input"]
    assert paths[0]["written"]["path"] == paths[1]["written"]["path"]


def test_a_loop_is_written_into_its_own_folder_of_the_one_given(tmp_path, folds):
    folder = folds[0].write(tmp_path / "out", plot=False, whole=False)
    assert folder == tmp_path / "out" / "2koc_A6-9"
    names = {path.name for path in folder.iterdir()}
    assert {"ranking.csv", "ranking.json", "traces.pdb", "line.csv", "view.pml"} <= names
    assert not {"plot.png", "whole.pdb", "atoms.pdb"} & names
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["2koc_A6-9"]


def test_models_that_are_there_are_taken(tmp_path, folds):
    pytest.importorskip("rdkit")
    (loop,) = folds
    models = loop.atoms(max_candidates=1)
    folder = loop.write(tmp_path, atoms=models, hydrogens=True, separate=True, plot=False)
    content = json.loads((folder / "atoms.json").read_text())
    assert (content["models"], content["hydrogens"]) == ([1], True)
    assert (folder / "atoms_1.pdb").exists()


def test_a_frame_is_written_with_what_it_is(tmp_path):
    import MDAnalysis as mda

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        universe = mda.Universe(HAIRPIN)
    universe.trajectory[2]
    folds = le.fold(universe, **RODS)
    universe.trajectory[0]
    out = folds.write(tmp_path)
    folder = out / "universe_A6-9"
    content = json.loads((folder / "ranking.json").read_text())
    assert content["input"] == {"universe": "2koc.pdb", "frame": 2}
    assert {row["file"] for row in rows_of(out / "summary.csv")} == {"universe"}
    assert (folder / "plot.png").stat().st_size > 10_000
    assert "native.pdb" in (folder / "view.pml").read_text()
    assert "native.pdb" in (folder / "view.cxc").read_text()
    universe.trajectory[2]
    place = "".join(f"{x:8.3f}" for x in universe.atoms.positions[0])
    for name in ("whole.pdb", "native.pdb"):
        assert place in {line[30:54] for line in (folder / name).read_text().splitlines()}


def test_a_built_hairpin_has_the_folder_of_the_command(tmp_path):
    model = le.build("GGC(GAA)GCC", rna=False, candidates=2)
    folder = model.loop.write(tmp_path / "python", atoms=model.models)
    arguments = ["build", "GGC(GAA)GCC", "--dna", "--candidates", "2", "-o", str(tmp_path / "c")]
    assert CliRunner().invoke(app, arguments).exit_code == 0
    other = tmp_path / "c" / folder.name
    names = [{path.name for path in place.iterdir()} - {"scene.js"} for place in (folder, other)]
    assert names[0] == names[1]
    for name in ("ranking.csv", "atoms.pdb", "atoms.cif", "traces.pdb"):
        assert (folder / name).read_text() == (other / name).read_text()


def test_several_files_are_one_run(tmp_path, folds, refused):
    twin = Path(shutil.copy(HAIRPIN, tmp_path / "2koc.pdb"))
    gone = Path(shutil.copy(HAIRPIN, tmp_path / "gone.pdb"))
    every = le.Folds([*folds, *refused, *le.fold(twin, **RODS), *le.fold(gone, **RODS)])
    gone.unlink()
    out = every.write(tmp_path / "out", plot=False)
    rows = rows_of(out / "summary.csv")
    assert [row["folder"] for row in rows if row["rank"] == "1"] == ["2koc_A6-9", "2koc_A6-9_2"]
    assert {row["file"] for row in rows} == {str(HAIRPIN), str(twin)}
    failures = rows_of(out / "failures.csv")
    assert [row["file"] for row in failures] == [str(HAIRPIN), str(gone)]
    assert "no rod fits" in failures[0]["failure"]
    assert "cannot be read again" in failures[1]["failure"]
    assert all(row["failure"].count(f"{row['file']}: ") == 1 for row in failures)


def test_no_loops_are_two_empty_tables(tmp_path):
    out = le.Folds().write(tmp_path / "out")
    assert rows_of(out / "summary.csv") == rows_of(out / "failures.csv") == []


def test_what_another_wrote_stays(tmp_path, folds):
    (tmp_path / "summary.csv").write_text("mine\n")
    with pytest.raises(OSError, match=r"summary\.csv"):
        folds.write(tmp_path, plot=False)
    assert (tmp_path / "summary.csv").read_text() == "mine\n"
    taken = tmp_path / "other" / "2koc_A6-9"
    taken.mkdir(parents=True)
    (taken / "ranking.csv").write_text("mine\n")
    with pytest.raises(FileExistsError, match="2koc_A6-9"):
        folds[0].write(tmp_path / "other", plot=False)
    folds.write(tmp_path / "other", plot=False)
    assert "2koc_A6-9" in rows_of(tmp_path / "other" / "failures.csv")[0]["failure"]
    assert (taken / "ranking.csv").read_text() == "mine\n"


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"hydrogens": True}, "`hydrogens` needs `atoms`"),
        ({"names": "amber"}, "`names` needs `atoms`"),
        ({"contact": "sheared"}, "`contact` needs `atoms`"),
        ({"atoms": True, "names": "gromos"}, "`names` is 'gromos'"),
        ({"atoms": True, "contact": "no"}, "`contact` is 'no'"),
        ({"atoms": 3}, "`atoms` is 3; it must be True, False or the models"),
        ({"plot": "yes"}, "`plot` is 'yes'"),
    ],
)
def test_options_are_checked_before_anything_is_written(tmp_path, folds, options, sentence):
    for results in (folds, folds[0]):
        with pytest.raises(ValueError, match=sentence):
            results.write(tmp_path / "out", **options)
    assert not (tmp_path / "out").exists()


def test_an_unknown_option_and_an_odd_folder_are_named(tmp_path, folds, models):
    with pytest.raises(TypeError, match=r"write takes no `hydrogen`; .* `hydrogens`"):
        folds.write(tmp_path / "out", hydrogen=True)
    for results in (folds, folds[0]):
        with pytest.raises(ValueError, match="`folder` is 3"):
            results.write(3)
    with pytest.raises(ValueError, match="`atoms` is a list of models"):
        folds.write(tmp_path / "out", atoms=models)
    assert not (tmp_path / "out").exists()


def test_a_loop_that_was_not_folded_is_not_written(tmp_path, refused):
    with pytest.raises(le.StructureError, match=r"not folded.*no rod fits"):
        refused[0].write(tmp_path / "out")
    assert not (tmp_path / "out").exists()
