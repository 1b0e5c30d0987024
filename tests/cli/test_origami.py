"""The command `origami`, as a user meets it."""

import csv
import json
import shutil

import helix_designs as designs
import pytest
from typer.testing import CliRunner

from loopelastica.cli.app import app
from loopelastica.nanostructures.oxdna.files import read_oxdna

sc = designs.sc


def run(*arguments):
    result = CliRunner().invoke(app, ["origami", *(str(a) for a in arguments)])
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    return result


def table(path):
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def results(out):
    return {p.name for p in out.iterdir() if not p.name.startswith((".", "summary.", "failures."))}


def sentence(result):
    lines = [line for line in result.stderr.splitlines() if line.strip() and "%|" not in line]
    assert len(lines) == 1, lines
    return lines[0]


@pytest.fixture
def out(tmp_path):
    return tmp_path / "out"


@pytest.fixture
def hairpin(tmp_path):
    return designs.write(designs.hairpin(6), tmp_path / "pin.sc")


@pytest.fixture
def far(tmp_path):
    return designs.write(designs.linker(2, apart=3), tmp_path / "far.sc")


def test_a_design_becomes_files_for_oxdna_and_a_row(hairpin, out):
    result = run(hairpin, "-o", out)
    assert result.exit_code == 0, result.output
    assert result.stderr == ""
    assert {"pin.top", "pin.dat", "pin.json", "pin.cif", "pin.pdb"} <= results(out)
    assert len(read_oxdna(out / "pin.top").system) == 30
    (row,) = table(out / "summary.csv")
    assert row["file"] == str(hairpin)
    assert (row["kind"], row["nucleotides"], row["status"]) == ("hairpin", "6", "laid")
    assert table(out / "failures.csv") == []


def test_the_screen_has_a_row_per_strand_in_80_columns(hairpin, far, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # a long path is not broken, so that it can be copied
    result = run(hairpin.name, far.name, "-o", "out")
    assert max(map(len, result.stdout.splitlines())) <= 80
    for words in ("pin.sc", "hairpin, helix 0:11", "laid", "linker, helix 0:19", "refused"):
        assert words in result.stdout


def test_what_cannot_be_spanned_is_refused_by_name_and_only_the_record_is_written(far, out):
    result = run(far, "-o", out)
    assert result.exit_code == 1
    said = sentence(result)
    for words in (str(far), "helix 0, offset 19", "helix 3, offset 19", "2 nucleotides", "nm"):
        assert words in said
    assert results(out) == {"far.json"}
    (failure,) = table(out / "failures.csv")
    assert failure["failure"] == said
    (row,) = table(out / "summary.csv")
    assert row["status"] == "refused"
    assert row["reason"] in said
    content = json.loads((out / "far.json").read_text())
    assert content["refused"] == [row["reason"]]
    assert not content["checks"]["sound"]


def test_one_bad_design_does_not_stop_the_others(hairpin, far, tmp_path, out):
    bad = tmp_path / "bad.sc"
    bad.write_text("{")
    result = run(bad, far, tmp_path / "absent.sc", hairpin, "-o", out)
    assert result.exit_code == 1
    assert results(out) >= {"far.json", "pin.top", "pin.dat"}
    assert {row["file"] for row in table(out / "failures.csv")} == {
        str(bad),
        str(far),
        str(tmp_path / "absent.sc"),
    }
    assert [row["status"] for row in table(out / "summary.csv")] == ["refused", "laid"]


def unknown_version(content):
    content["version"] = "99.1.0"


def no_helices(content):
    content["helices"] = []


def loopout_at_the_end(content):
    content["strands"][0]["domains"].append({"loopout": 4})


def without_positions(content):
    content["grid"] = "none"
    for helix in content["helices"]:
        helix.pop("grid_position", None)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (unknown_version, ["'99.1.0'", "unknown"]),
        (no_helices, ["no helices"]),
        (loopout_at_the_end, ["loopout", "3' end"]),
        (without_positions, ["grid is none", "helix 0", "position"]),
    ],
)
def test_a_bad_design_is_one_sentence_and_no_file(tmp_path, out, change, words):
    file = designs.changed(designs.hairpin(), tmp_path, change)
    result = run(file, "-o", out)
    assert result.exit_code == 1
    said = sentence(result)
    assert said.startswith(f"{file}: ")
    for word in words:
        assert word in said
    assert results(out) == set()


def test_a_circular_strand_is_laid_or_refused_in_a_sentence(tmp_path, out):
    design = designs.row_of(1)
    design.draw_strand(0, 0).move(16).loopout(0, 6).move(-16).as_circular()
    result = run(designs.write(design, tmp_path / "ring.sc"), "-o", out)
    if result.exit_code == 0:
        system = read_oxdna(out / "ring.top").system
        assert (system.n3 >= 0).all()
    else:
        assert "ring.sc: " in sentence(result)


def test_oxdna_files_go_in_as_one_or_as_two(hairpin, tmp_path, out):
    run(hairpin, "-o", tmp_path)
    top, dat = tmp_path / "pin.top", tmp_path / "pin.dat"
    for k, given in enumerate(((top,), (dat,), (top, dat), (dat, top))):
        result = run(*given, "-o", out / str(k))
        assert result.exit_code == 0, result.output
        assert {"pin.top", "pin.dat", "pin.json"} <= results(out / str(k))
        assert (out / str(k) / "pin.top").read_bytes() == top.read_bytes()


def test_a_configuration_without_its_topology_is_named(hairpin, tmp_path, out):
    run(hairpin, "-o", tmp_path / "made")
    alone = shutil.copy(tmp_path / "made" / "pin.dat", tmp_path / "alone.dat")
    result = run(alone, "-o", out)
    assert result.exit_code == 1
    assert "there is no alone.top beside it" in sentence(result)


def test_designs_of_a_folder_are_all_laid(tmp_path, out):
    folder = tmp_path / "designs"
    folder.mkdir()
    for k in (3, 4):
        designs.write(designs.hairpin(k), folder / f"pin{k}.sc")
    assert run(folder, "-o", out).exit_code == 0
    assert {"pin3.dat", "pin4.dat"} <= results(out)
    assert [row["nucleotides"] for row in table(out / "summary.csv")] == ["3", "4"]


def test_results_in_the_folder_of_the_designs_are_no_designs_the_next_time(tmp_path):
    designs.write(designs.hairpin(3), tmp_path / "pin.sc")
    for _ in range(2):
        assert run(tmp_path, "-o", tmp_path).exit_code == 0
        assert len(table(tmp_path / "summary.csv")) == 1


def test_designs_of_one_name_get_files_of_different_names(tmp_path, out):
    files = []
    for folder, loop in (("a", 3), ("b", 5)):
        (tmp_path / folder).mkdir()
        files.append(designs.write(designs.hairpin(loop), tmp_path / folder / "pin.sc"))
    files.append(designs.write(designs.hairpin(7), tmp_path / "pin_2.sc"))
    assert run(*files, "-o", out).exit_code == 0
    assert len(read_oxdna(out / "pin.top").system) == 27
    assert len(read_oxdna(out / "pin_2.top").system) == 29
    assert len(read_oxdna(out / "pin_2_2.top").system) == 31


def test_an_input_is_never_written_over(hairpin, tmp_path, out):
    run(hairpin, "-o", out)
    kept = {name: (out / f"pin.{name}").read_bytes() for name in ("top", "dat")}
    result = run(out / "pin.top", "-o", out)
    assert result.exit_code == 1
    assert "this is the input, which is not written over" in sentence(result)
    assert {name: (out / f"pin.{name}").read_bytes() for name in kept} == kept


def test_nor_is_what_others_have_put_there(hairpin, out):
    out.mkdir()
    (out / "pin.dat").write_text("mine")
    result = run(hairpin, "-o", out)
    assert result.exit_code == 1
    assert "not written by this program" in sentence(result)
    assert results(out) == {"pin.dat"}
    assert (out / "pin.dat").read_text() == "mine"


def test_the_same_command_does_nothing_twice_and_mends_what_is_lost(hairpin, far, out):
    run(hairpin, far, "-o", out)
    written = (out / "pin.dat").stat().st_mtime_ns
    again = run(hairpin, far, "-o", out)
    assert again.exit_code == 1
    assert (out / "pin.dat").stat().st_mtime_ns == written
    assert len(table(out / "summary.csv")) == 2
    (out / "pin.dat").unlink()
    run(hairpin, far, "-o", out)
    assert (out / "pin.dat").exists()


def test_options_reach_what_is_written(hairpin, out):
    options = ("--form", "new", "--sample", "2", "--seed", "5", "--tails", "relaxed")
    result = run(hairpin, "-o", out, *options, "--persistence-length", "0.8")
    assert result.exit_code == 0, result.output
    assert (out / "pin.top").read_text().splitlines()[0] == "30 1 5->3"
    assert {"pin_sample1.dat", "pin_sample2.dat"} <= results(out)
    record = json.loads((out / "pin.json").read_text())
    expected = {"sample": 2, "seed": 5, "tails": "relaxed", "persistence_length_nm": 0.8}
    assert {name: record["parameters"][name] for name in expected} == expected
    assert record["form"] == "new"


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("--form", "newer"),
        ("--tails", "curly"),
        ("--pairs", "luck"),
        ("--sample", "-1"),
        ("--persistence-length", "0"),
    ],
)
def test_a_wrong_option_is_named_before_anything_is_made(hairpin, out, option, value):
    result = run(hairpin, "-o", out, option, value)
    assert result.exit_code == 2
    assert option in result.stderr
    assert not out.exists()


def test_quiet_says_only_what_has_failed(hairpin, far, out):
    assert run(hairpin, "-q", "-o", out).output == ""
    result = run(hairpin, far, "--quiet", "-o", out)
    assert result.stdout == ""
    assert "far.sc" in sentence(result)


def test_json_is_one_document_and_nothing_else(hairpin, far, out):
    result = run(hairpin, far, "--json", "-o", out)
    assert result.exit_code == 1
    content = json.loads(result.stdout)
    assert content["command"] == "origami"
    assert [(one["file"], one["status"]) for one in content["designs"]] == [
        (str(hairpin), "written"),
        (str(far), "refused"),
    ]
    (failure,) = content["failures"]
    assert failure["file"] == str(far)
    assert content["folder"] == str(out)
