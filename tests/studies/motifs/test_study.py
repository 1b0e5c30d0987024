"""The study of loop shapes, on few loops and on many."""

import csv
import json
import shutil
from collections import defaultdict

import numpy as np
import pytest
from typer.testing import CliRunner

import loopelastica as le
from loopelastica._files import data_path
from loopelastica.cli.app import app
from loopelastica.folding.library_file import load_library
from loopelastica.studies.motifs.study import run

FEW = ("1bjh", "1k2g", "1szy", "1zih")
# of each list of answers, so many count as its first ones
FIRST = 5


def command(*arguments):
    return CliRunner().invoke(app, ["studies", "motifs", *map(str, arguments)])


def answers(folder):
    with (folder / "answers.csv").open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def few(hairpin_folder, tmp_path_factory):
    folder = tmp_path_factory.mktemp("few")
    for path in hairpin_folder.iterdir():
        if path.name.startswith(FEW):
            shutil.copy(path, folder)
    # the loop of 2KOC in two entries
    shutil.copy(data_path("hairpins/2koc.pdb"), folder)
    _, _, rest = data_path("hairpins/2koc.pdb").read_text().partition("\n")
    (folder / "9zzz.pdb").write_text(rest)
    (folder / "broken.pdb").write_text("nothing\n")
    return folder


@pytest.fixture(scope="module")
def done(few, tmp_path_factory):
    out = tmp_path_factory.mktemp("out") / "study"
    return out, command(few, "-o", out)


def test_a_study_writes_tables_a_library_and_a_report(done):
    out, _ = done
    names = {path.name for path in out.iterdir()}
    assert names == {"answers.csv", "loops.lib", "motifs.json", "motifs.md"}
    assert len(load_library(out / "loops.lib")) >= len(FEW) + 2
    json.loads((out / "motifs.json").read_text(), parse_constant=pytest.fail)
    rows = answers(out)
    assert {row["level"] for row in rows} == {"relatives out", "strict", "entry out"}
    assert all(np.isfinite(float(row["rmsd_A"])) for row in rows)


def test_the_screen_has_the_tables_and_says_what_could_not_be_read(done):
    out, result = done
    assert result.exit_code == 1
    assert "RNA, 3 to 9 nucleotides" in result.stdout
    assert f"written to {out}" in result.stdout.replace("\n", "")
    assert "broken.pdb: " in result.stderr
    assert "could not be read" not in result.stdout
    report = (out / "motifs.md").read_text()
    assert result.stdout.splitlines()[0] in report
    assert "broken.pdb: " in report


def test_a_second_study_writes_the_same_to_the_byte(few, done, tmp_path):
    run(few, tmp_path)
    for path in done[0].iterdir():
        assert (tmp_path / path.name).read_bytes() == path.read_bytes()


def test_own_entries_and_own_sequences_have_no_part_in_an_answer(few, done):
    """Of three levels only the last may know the loop of another entry of the same sequence."""
    kinds = defaultdict(set)
    for row in answers(done[0]):
        kinds[row["source"].split()[0], row["level"]].add(row["kind"])
    for entry in ("2koc", "9zzz"):
        assert "motif UNCG" in kinds[entry, "entry out"]
        for level in ("strict", "relatives out"):
            assert "same sequence" not in kinds[entry, level]
            assert "motif UNCG" not in kinds[entry, level]


def test_one_loop_alone_has_no_answers_and_no_traceback(tmp_path):
    folder = tmp_path / "one"
    folder.mkdir()
    shutil.copy(data_path("hairpins/2koc.pdb"), folder)
    result = command(folder, "-o", tmp_path / "out")
    assert (result.exit_code, result.stderr.count("Traceback")) == (0, 0)
    assert answers(tmp_path / "out") == []
    assert json.loads((tmp_path / "out" / "motifs.json").read_text())["motifs"] == []
    assert len(load_library(tmp_path / "out" / "loops.lib")) == 1


def test_a_folder_without_structures_is_refused(tmp_path):
    for folder in (tmp_path, tmp_path / "absent"):
        result = command(folder, "-o", tmp_path / "out")
        assert result.exit_code == 2
        assert "holds no PDB or mmCIF file" in " ".join(result.stderr.split())
    assert not (tmp_path / "out").exists()


def test_a_folder_without_a_loop_to_judge_says_why(tmp_path):
    (tmp_path / "broken.pdb").write_text("nothing\n")
    with pytest.raises(le.LoopelasticaError, match=r"no loop in it can be judged; .*broken\.pdb"):
        run(tmp_path, tmp_path / "out")
    assert command(tmp_path, "-o", tmp_path / "out").exit_code == 1
    assert not (tmp_path / "out" / "motifs.json").exists()


# the corpus that the shipped tables are from


@pytest.fixture(scope="module")
def corpus(hairpin_folder, tmp_path_factory):
    loops = hairpin_folder.parent / "loops"
    if not loops.is_dir():
        pytest.skip("the corpus of loops is not beside this checkout (../shared/loops)")
    out = tmp_path_factory.mktemp("corpus")
    run(loops, out)
    return out


def figures(rows, wanted, measure):
    """Median and 90 % over sequences, at the level where relatives are out."""
    by_loop = defaultdict(list)
    for row in rows:
        if row["level"] == "relatives out" and wanted(row):
            by_loop[row["loop"], row["source"]].append((int(row["place"]), float(row["rmsd_A"])))
    by_sequence = defaultdict(list)
    for (loop, _), found in by_loop.items():
        by_sequence[loop].append(measure([value for _, value in sorted(found)]))
    return np.quantile([np.mean(values) for values in by_sequence.values()], [0.5, 0.9])


def first(values):
    return values[0]


def best(values):
    return min(values[:FIRST])


def rna(row):
    return row["acid"] == "RNA" and 3 <= int(row["n"]) <= 9


@pytest.mark.slow
def test_answers_are_as_good_as_is_said(corpus):
    rows = answers(corpus)
    assert figures(rows, lambda row: row["motif"] == "GNRA", first)[0] <= 0.95
    assert figures(rows, lambda row: row["motif"] == "UNCG", first)[0] <= 1.25
    assert (figures(rows, rna, first) <= [2.95, 6.8]).all()
    assert (figures(rows, rna, best) <= [2.2, 5.0]).all()
    assert figures(rows, lambda row: row["acid"] == "DNA", first)[0] <= 1.35
    assert figures(rows, lambda row: row["acid"] == "DNA", best)[0] <= 1.5


@pytest.mark.slow
def test_the_80_percent_interval_holds_for_families_that_were_not_seen(corpus):
    rows = [
        row
        for row in answers(corpus)
        if row["level"] == "relatives out" and row["place"] == "1" and row["expected_50_A"]
    ]
    by_sequence = defaultdict(list)
    for row in rows:
        error = float(row["rmsd_A"])
        low, high = float(row["expected_10_A"]), float(row["expected_90_A"])
        by_sequence[row["loop"]].append((low <= error <= high, high / low))
    inside, ratio = np.array([np.mean(found, axis=0) for found in by_sequence.values()]).T
    assert 0.75 <= inside.mean() <= 0.85
    assert np.median(ratio) <= 4.1


@pytest.mark.slow
def test_the_shipped_tables_and_library_are_what_the_study_makes(corpus):
    shipped, made = (
        json.loads(path.read_text()) for path in (data_path("motifs.json"), corpus / "motifs.json")
    )
    for group in ("motifs", "lengths"):
        for one, other in zip(shipped[group], made[group], strict=True):
            counts = ("name", "pattern", "kind", "loops", "sequences", "families")
            assert [one[c] for c in counts] == [other[c] for c in counts]
            np.testing.assert_allclose(one["steps_A"], other["steps_A"], atol=1e-3)
            np.testing.assert_allclose(one["end_frame"], other["end_frame"], atol=1e-4)
    assert shipped["errors"].keys() == made["errors"].keys()
    for kind, one in shipped["errors"].items():
        np.testing.assert_allclose(one["b"], made["errors"][kind]["b"], atol=0.02)
        for name, quantiles in one["quantiles"].items():
            np.testing.assert_allclose(
                quantiles, made["errors"][kind]["quantiles"][name], atol=0.02
            )
    there, again = (load_library(p) for p in (data_path("loops.lib"), corpus / "loops.lib"))
    assert there.counts == again.counts
    for (_, one), (_, other) in zip(there.tables(), again.tables(), strict=True):
        assert one.sources.tolist() == other.sources.tolist()
        np.testing.assert_allclose(one.steps_A, other.steps_A, atol=1e-3)
