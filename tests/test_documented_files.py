"""What docs/files.md and the schemas say of the files is what is written."""

import csv
import json
import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from loopelastica._files import data_path
from loopelastica.batch.shapes import COLUMNS as LIBRARY_COLUMNS
from loopelastica.cli.app import app
from loopelastica.studies.evaluation.loops import COLUMNS as LOOP_COLUMNS

DOCS = Path(__file__).resolve().parents[1] / "docs"
SOURCE = data_path("hairpins/2koc.pdb")


def documented(title):
    """The columns of the table under a heading of files.md, in their order."""
    text = (DOCS / "files.md").read_text("utf-8")
    section = text.split(f"\n## {title}\n")[1].split("\n## ")[0]
    return re.findall(r"^\| `(\w+)` \|", section, re.M)


def written(path):
    with path.open(encoding="utf-8", newline="") as lines:
        return next(csv.reader(lines))


def run(*words):
    result = CliRunner().invoke(app, [str(word) for word in words])
    assert result.exit_code in (0, 1), result.output


def check(path, schema):
    """The file against its schema, which must be one itself."""
    jsonschema = pytest.importorskip("jsonschema")
    rules = json.loads((DOCS / "schemas" / f"{schema}.schema.json").read_text("utf-8"))
    validator = jsonschema.Draft202012Validator
    validator.check_schema(rules)
    validator(rules).validate(json.loads(path.read_text("utf-8")))


@pytest.fixture(scope="module")
def folded(tmp_path_factory):
    """2KOC folded twice, with atoms and without, beside a file that cannot be."""
    out = tmp_path_factory.mktemp("documented")
    (out / "broken.pdb").write_text("nothing\n")
    atoms = ("--atoms", "--candidates", 2)
    run("fold", SOURCE, out / "broken.pdb", "--first-model", *atoms, "-o", out / "atoms")
    run("fold", SOURCE, "--first-model", "--shapes", "rod", "-o", out / "rods")
    return out


@pytest.fixture(scope="module")
def filled(tmp_path_factory):
    """A gap that is filled, and the same four nucleotides wide with room for one, refused."""
    out = tmp_path_factory.mktemp("filled")
    model = SOURCE.read_text().split("ENDMDL")[0].splitlines(keepends=True)
    atoms = [line for line in model if line.startswith("ATOM")]
    kept = [line for line in atoms if not 6 <= int(line[22:26]) <= 9]
    (out / "gap.pdb").write_text("".join(kept))
    numbers = [(line, int(line[22:26])) for line in kept]
    near = [f"{line[:22]}{n - 3 * (n > 9):4d}{line[26:]}" for line, n in numbers]
    (out / "wide.pdb").write_text("".join(near))
    run("fill", out / "gap.pdb", "--strand", "A.6-9=UUCG", "-o", out / "run")
    run("fill", out / "wide.pdb", "--strand", "A.6=U", "-o", out / "run")
    return out / "run"


@pytest.fixture(scope="module")
def laid(tmp_path_factory):
    """A hairpin that is laid and sampled, and a linker that cannot be."""
    designs = pytest.importorskip("helix_designs")
    out = tmp_path_factory.mktemp("laid")
    designs.write(designs.hairpin(6), out / "pin.sc")
    designs.write(designs.linker(2, apart=3), out / "far.sc")
    run("origami", out / "pin.sc", out / "far.sc", "--sample", 1, "-o", out / "run")
    return out / "run"


@pytest.mark.parametrize("name", ["ranking.csv", "line.csv"])
def test_the_columns_of_a_loop_are_the_documented_ones(folded, name):
    assert written(folded / "atoms" / "2koc_A6-9" / name) == documented(f"`{name}`")


def test_without_atoms_a_ranking_lacks_their_columns_and_no_others(folded):
    without = [name for name in documented("`ranking.csv`") if not name.startswith("atoms_")]
    assert written(folded / "rods" / "2koc_A6-9" / "ranking.csv") == without


def test_the_columns_of_a_run_are_the_documented_ones(folded, filled):
    folds = documented("`summary.csv` of `fold` and `build`")
    assert written(folded / "atoms" / "summary.csv") == folds
    assert written(filled / "summary.csv") == documented("`summary.csv` of `fill`")
    for run_folder in (folded / "atoms", filled):
        assert written(run_folder / "failures.csv") == documented("`failures.csv`")


def test_the_columns_of_a_scan_are_the_documented_ones(tmp_path):
    run("scan", SOURCE, "-o", tmp_path / "scan.csv")
    assert written(tmp_path / "scan.csv") == documented("`scan.csv`")


def test_the_columns_of_evaluations_and_libraries_are_the_documented_ones():
    assert list(LOOP_COLUMNS) == documented("`loops.csv` of `evaluate`")
    assert list(LIBRARY_COLUMNS) == documented("`loops.csv` of `library build`")


@pytest.mark.parametrize("run_name", ["atoms", "rods"])
def test_a_ranking_is_as_its_schema_says(folded, run_name):
    check(folded / run_name / "2koc_A6-9" / "ranking.json", "ranking")


def test_atoms_are_as_their_schema_says(folded):
    check(folded / "atoms" / "2koc_A6-9" / "atoms.json", "atoms")


@pytest.mark.parametrize(("name", "status"), [("gap", "filled"), ("wide", "refused")])
def test_filled_and_refused_strands_are_as_their_schema_says(filled, name, status):
    path = filled / name / "fill.json"
    (strand,) = json.loads(path.read_text("utf-8"))["strands"]
    assert strand["status"] == status
    check(path, "fill")


def test_the_columns_of_nanostructures_are_the_documented_ones(laid):
    assert written(laid / "summary.csv") == documented("`summary.csv` of `origami`")


@pytest.mark.parametrize(("name", "status"), [("pin", "written"), ("far", "refused")])
def test_nanostructures_are_as_their_schema_says(laid, name, status):
    path = laid / f"{name}.json"
    assert json.loads(path.read_text("utf-8"))["status"] == status
    check(path, "nanostructure")


def test_hairpins_are_as_their_schema_says(tmp_path):
    run("hairpins", SOURCE, "-o", tmp_path / "hairpins.json")
    check(tmp_path / "hairpins.json", "hairpins")


def test_a_schema_refuses_entries_that_it_does_not_describe(folded):
    jsonschema = pytest.importorskip("jsonschema")
    path = folded / "atoms" / "2koc_A6-9" / "ranking.json"
    content = json.loads(path.read_text("utf-8"))
    content["candidates"][0]["invented_A"] = 1.0
    (folded / "invented.json").write_text(json.dumps(content))
    with pytest.raises(jsonschema.ValidationError):
        check(folded / "invented.json", "ranking")


@pytest.mark.slow
def test_files_of_real_structures_are_as_their_schemas_say(hairpin_folder, tmp_path):
    sources = sorted(hairpin_folder.glob("*.pdb*"))[:12]
    assert sources
    run(
        "fold", *sources, "--first-model", "--shapes", "rod", "--no-plot", "-o", tmp_path / "folded"
    )
    rankings = list(tmp_path.glob("folded/*/ranking.json"))
    assert rankings
    for path in rankings:
        check(path, "ranking")
    for number, source in enumerate(sources):
        run("hairpins", source, "-o", tmp_path / f"{number}.json")
        check(tmp_path / f"{number}.json", "hairpins")
