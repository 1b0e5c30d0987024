"""The command line, as a user meets it."""

import csv
import gzip
import hashlib
import json
import os
import subprocess
import sys
import warnings

import gapped
import numpy as np
import pytest
from typer.testing import CliRunner

from loopelastica._files import data_path
from loopelastica.cli.app import app

HAIRPIN = data_path("hairpins/2koc.pdb")


def run(*arguments):
    return CliRunner().invoke(app, [str(a) for a in arguments])


def words(result):
    """What was printed, as one line."""
    return " ".join(result.output.split())


def table(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def folders(path):
    return sorted(p.name for p in path.iterdir() if p.is_dir())


@pytest.fixture(scope="module")
def folded(tmp_path_factory):
    out = tmp_path_factory.mktemp("out")
    result = run("fold", HAIRPIN, "-o", out)
    assert result.exit_code == 0, result.output
    return out / "2koc_A6-9", result


def test_fold_writes_one_folder_per_hairpin(folded):
    folder, result = folded
    names = {p.name for p in folder.iterdir()}
    assert names == {
        *("ranking.csv", "ranking.json", "traces.pdb", "line.csv", "plot.png"),
        *("whole.pdb", "view.pml", "view.cxc", "tubes.pdb"),
    }
    assert {p.name for p in folder.parent.iterdir()} == {"2koc_A6-9", "summary.csv", "failures.csv"}
    assert "CUUCGG" in result.output


def test_ranking_json_tells_all_that_is_needed_to_repeat_it(folded):
    content = json.loads((folded[0] / "ranking.json").read_text())
    assert content["input"]["sha256"] == hashlib.sha256(HAIRPIN.read_bytes()).hexdigest()
    assert content["length"]["length_A"] == 24.0
    assert content["parameters"]["persistence_length_A"] == 10.0
    first = content["candidates"][0]
    assert first["rmsd_A"] < 2.2
    assert content["clamp"]["taper"] == 0.2
    assert content["clamp"]["stem_rms_A"] < 1.3
    assert len(first["rmsd_models_A"]) == 20
    assert len(content["clamp"]["clamping_parameters"]) == 6
    with (folded[0] / "ranking.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [int(r["rank"]) for r in rows] == list(range(1, len(rows) + 1))
    assert float(rows[0]["energy_per_A"]) == first["energy_per_A"]


def test_traces_are_read_back_with_chain_numbers_and_expected_errors(folded):
    import MDAnalysis as mda

    content = json.loads((folded[0] / "ranking.json").read_text())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        universe = mda.Universe(folded[0] / "traces.pdb", in_memory=True)
    assert universe.residues.resids.tolist() == [6, 7, 8, 9]
    assert set(universe.atoms.chainIDs) == {"A"}
    assert len(universe.trajectory) == len(content["candidates"])
    for frame, candidate in zip(universe.trajectory, content["candidates"], strict=True):
        np.testing.assert_allclose(frame.positions, candidate["trace_A"], atol=6e-4)
    b_factors = [
        float(line[60:66])
        for line in (folded[0] / "traces.pdb").read_text().splitlines()
        if line.startswith("ATOM")
    ]
    expected = [c["expected_rmsd_A"][1] for c in content["candidates"] for _ in range(4)]
    np.testing.assert_allclose(
        b_factors, np.minimum(8 * np.pi**2 / 3 * np.square(expected), 999.0), atol=0.006
    )


def test_the_dense_line_ends_at_the_stem_and_has_unit_tangents(folded):
    content = json.loads((folded[0] / "ranking.json").read_text())
    table = np.genfromtxt(folded[0] / "line.csv", delimiter=",", names=True)
    ranks = [c["rank"] for c in content["candidates"] if c["shape"] == "straight rod"]
    first = table[table["rank"] == ranks[0]]
    points = np.stack([first["x_A"], first["y_A"], first["z_A"]], axis=1)
    tangents = np.stack([first["tx"], first["ty"], first["tz"]], axis=1)
    np.testing.assert_allclose(points[0], content["clamp"]["start_origin_A"], atol=1e-6)
    np.testing.assert_allclose(points[-1], content["clamp"]["end_origin_A"], atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(tangents, axis=1), 1, atol=1e-7)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert steps.sum() == pytest.approx(24.0, abs=0.01)
    # curvature is the turning of the tangent per Å
    turning = np.linalg.norm(np.gradient(tangents, first["s_A"], axis=0), axis=1)
    np.testing.assert_allclose(turning[1:-1], first["curvature_per_A"][1:-1], rtol=5e-3)


def test_the_picture_shows_something(folded):
    from matplotlib.image import imread

    picture = imread(folded[0] / "plot.png")[:, :, :3]
    assert picture.shape[0] > 300
    third = picture.shape[1] // 3
    # each third holds coloured lines, not only black on white
    for start in range(0, 3 * third, third):
        part = picture[:, start : start + third]
        assert (np.ptp(part, axis=2) > 0.3).sum() > 200


def bad_files(folder):
    good = HAIRPIN.read_text().splitlines(keepends=True)
    first_model = good[: next(i for i, s in enumerate(good) if s.startswith("ENDMDL")) + 1]
    atoms = [line for line in first_model if line.startswith("ATOM")]
    noise = np.random.default_rng(1).integers(0, 256, 5000, dtype=np.uint8).tobytes()
    protein = (
        "ATOM      1  N   ALA A   1      11.104   6.134  -6.504  1.00  0.00           N\n"
        "ATOM      2  CA  ALA A   1      11.639   6.071  -5.147  1.00  0.00           C\n"
        "ATOM      3  C   ALA A   1      10.656   5.387  -4.203  1.00  0.00           C\n"
        "ATOM      4  O   ALA A   1       9.500   5.150  -4.550  1.00  0.00           O\n"
        "END\n"
    )
    contents = {
        "empty.pdb": b"",
        "noise.pdb": noise,
        "protein.pdb": protein.encode(),
        "zero.pdb": "".join(a[:30] + "   0.000" * 3 + a[54:] for a in atoms).encode(),
        "nan.pdb": "".join(a[:30] + "     nan" * 3 + a[54:] for a in atoms).encode(),
        "cut.pdb": "".join(atoms).encode()[: len("".join(atoms[:200])) + 40],
        "cut.pdb.gz": gzip.compress(HAIRPIN.read_bytes())[:20000],
        "missing_atoms.pdb": "".join(
            a for a in atoms if not (a[22:26].strip() == "5" and a[12:16].strip() in
                                     {"C4'", "C3'", "P", "O5'"})
        ).encode(),
    }  # fmt: skip
    for name, content in contents.items():
        (folder / name).write_bytes(content)
    (folder / "folder.pdb").mkdir()
    return [folder / name for name in [*contents, "folder.pdb", "absent.pdb"]]


def test_every_bad_file_is_one_sentence_and_a_row(tmp_path):
    for path in bad_files(tmp_path):
        out = tmp_path / "out"
        result = run("fold", path, "-o", out)
        assert result.exit_code == 1, path
        assert "Traceback" not in result.output
        sentences = [s for s in result.stderr.splitlines() if s.strip()]
        assert len(sentences) == 1, (path, result.stderr)
        assert path.name in sentences[0]
        assert len(sentences[0]) > len(str(path)) + 10
        assert {p.name for p in out.iterdir()} == {"summary.csv", "failures.csv"}, path
        assert table(out / "failures.csv") == [{"file": str(path), "failure": sentences[0]}]
        assert table(out / "summary.csv") == []


def test_a_bad_file_in_a_batch_is_a_row_and_the_others_are_folded(tmp_path):
    (tmp_path / "bad.pdb").write_text("nothing\n")
    copy = tmp_path / "again" / "2koc.pdb"
    copy.parent.mkdir()
    copy.write_bytes(HAIRPIN.read_bytes())
    result = run(
        "fold", HAIRPIN, tmp_path / "bad.pdb", copy, "-o", tmp_path / "out", "--no-plot",
        "--first-model",
    )  # fmt: skip
    assert result.exit_code == 1
    assert "bad.pdb" in result.stderr
    # two inputs of one name
    assert folders(tmp_path / "out") == ["2koc_A6-9", "2koc_A6-9_2"]


def test_hairpins_lists_the_loop_and_the_secondary_structure():
    result = run("hairpins", HAIRPIN)
    assert result.exit_code == 0
    assert "A.C5–A.G10" in result.output
    assert ">A 1-14\nGGCACUUCGGUGCC\n(((((....)))))\n" in result.output
    assert run("hairpins", "absent.pdb").exit_code == 1


@pytest.mark.parametrize("option", ["--json", "-o"])
def test_hairpins_writes_json(tmp_path, option):
    path = tmp_path / "new" / "hairpins.json"
    assert run("hairpins", HAIRPIN, option, path).exit_code == 0
    content = json.loads(path.read_text())
    assert content["input"]["sha256"] == hashlib.sha256(HAIRPIN.read_bytes()).hexdigest()
    assert content["input"]["models"] == 20
    (hairpin,) = content["hairpins"]
    assert (hairpin["name"], hairpin["nucleotides"], hairpin["absent"]) == ("A6-9", 4, 0)
    assert 0.4 < hairpin["stem_rms_A"] < 0.6
    assert hairpin["regular"] is True
    assert content["chains"][0]["dot_bracket"] == "(((((....)))))"
    assert [p.name for p in path.parent.iterdir()] == ["hairpins.json"]


def test_hairpins_takes_pairs_brackets_and_loops_from_the_user():
    assert "UUCG " in run("hairpins", HAIRPIN, "--pair", "A.6-A.9").output
    assert "ACUUCGGU" in run("hairpins", HAIRPIN, "--dot-bracket", "((((......))))").output
    assert "UUCG " in run("hairpins", HAIRPIN, "--loop", "A.7-8").output
    result = run("hairpins", HAIRPIN, "--pair", "A.5")
    assert result.exit_code == 2
    assert "--pair is 'A.5'" in result.stderr
    result = run("hairpins", HAIRPIN, "--loop", "A.60-70")
    assert result.exit_code == 1
    assert result.stderr.count("\n") == 1
    assert "2koc.pdb" in result.stderr


def test_hairpins_names_what_is_odd(hairpin_folder):
    result = run("hairpins", hairpin_folder / "1rnk.pdb.gz")
    assert result.exit_code == 1
    assert "A.C5–A.G15: a pseudoknot" in result.output
    assert "(((((..[[[[[[.)))))........]]]]]]." in result.output
    assert "no hairpin loop found" in result.stderr
    result = run("hairpins", hairpin_folder / "1y26.pdb.gz")
    assert "X31-39 kisses X60-66" in result.output
    result = run("hairpins", hairpin_folder / "1ehz.cif.gz")
    assert "A.2MG10 (G), A.H2U16 (U)" in result.output
    assert "A.5MC40" in result.output
    result = run("hairpins", hairpin_folder / "1msy.pdb.gz")
    assert "alternative locations in 2 nucleotide(s)" in result.output
    assert "A.G2663 B" in result.output
    assert "irregular" in run("hairpins", hairpin_folder / "1d16.pdb.gz").output


def test_an_irregular_stem_is_folded_on_request_only(hairpin_folder, tmp_path):
    path, out = hairpin_folder / "1d16.pdb.gz", tmp_path / "out"
    result = run("fold", path, "-o", out, "--no-plot")
    assert result.exit_code == 1
    assert "1.56 Å" in result.stderr
    assert "(--irregular folds it)" in result.stderr
    assert "--irregular" in table(out / "failures.csv")[0]["failure"]
    assert folders(out) == []
    result = run("fold", path, "-o", out, "--no-plot", "--irregular")
    assert result.exit_code == 0
    assert "means little" in result.output
    content = json.loads((out / "1d16_A7-10" / "ranking.json").read_text())
    assert content["clamp"]["stem_rms_A"] == pytest.approx(1.56, abs=0.01)
    assert content["parameters"]["irregular"] is True


def test_a_loop_absent_from_the_file_is_folded_when_it_is_named(tmp_path):
    lines = HAIRPIN.read_text().split("ENDMDL")[0].splitlines()
    path = tmp_path / "absent.pdb"
    path.write_text("\n".join(s for s in lines if s[22:26].strip() not in {"6", "7", "8", "9"}))
    out = tmp_path / "out"
    result = run("fold", path, "-o", out, "--no-plot")
    assert result.exit_code == 1
    assert "--loop A.6-9 folds it" in result.output
    result = run("fold", path, "-o", out, "--loop", "A.6-9")
    assert result.exit_code == 0, result.output
    folder = out / "absent_A6-9"
    with (folder / "ranking.csv").open() as file:
        row = next(csv.DictReader(file))
    assert (row["sequence"], row["rmsd_A"]) == ("CNNNNG", "")
    trace = (folder / "traces.pdb").read_text().split("ENDMDL")[0]
    assert trace.count("CEN   N A") == 4
    assert "NaN" not in (folder / "ranking.json").read_text()


def test_the_whole_structure_is_the_users_choice(tmp_path):
    result = run("fold", HAIRPIN, "-o", tmp_path, "--no-plot", "--no-whole", "--first-model")
    assert result.exit_code == 0
    assert not (tmp_path / "2koc_A6-9" / "whole.pdb").exists()


def test_solve_prints_equilibria_or_one_sentence():
    result = run("solve", "--clamping", "-0.4 -0.1 0.5 4.8 1.4 2.2", "--json")
    energies = [rod["energy"] for rod in json.loads(result.output)["equilibria"]]
    assert energies == sorted(energies)
    assert len(energies) > 1
    assert "energy" in run("solve", "--clamping", "-0.4 -0.1 0.5 4.8 1.4 2.2").output
    for wrong in ("1 2 3", "0 0 2 0 0 0", "a b c d e f", "0 0 nan 0 0 0", "nonsense"):
        result = run("solve", "--clamping", wrong)
        assert result.exit_code == 2
        assert f"--clamping {wrong!r}: " in result.stderr
    assert run("solve", "--clamping", "0 0 0.5 0 0 0", "--torsion-ratio", "-1").exit_code == 2


def test_an_option_out_of_range_is_refused(tmp_path):
    result = run("fold", HAIRPIN, "-o", tmp_path / "out", "--persistence-length", "-3")
    assert result.exit_code == 2
    assert "--persistence-length is -3.0" in result.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("--contact", "sheared"), "--contact needs --atoms"),
        (("--hydrogens",), "--hydrogens needs --atoms"),
        (("--names", "amber"), "--names needs --atoms"),
        (("--no-5-phosphate",), "--no-5-phosphate needs --atoms"),
        (("--separate",), "--separate needs --atoms"),
        (("--atoms", "--names", "gromos"), "--names is 'gromos'"),
        (("--torsion-ratio", "0.7"), "--torsion-ratio needs --darboux"),
        (("--jobs", "2", "--atoms"), "--atoms goes without --jobs"),
        (("--jobs", "2", "--whole"), "--whole goes without --jobs"),
        (("--pair", "A.5"), "--pair is 'A.5'"),
        (("--atoms", "--contact", "hoogsteen", "--first-model"), "--contact is 'hoogsteen'"),
    ],
)
def test_an_option_without_what_it_needs_is_refused(tmp_path, arguments, sentence):
    result = run("fold", HAIRPIN, "-o", tmp_path / "out", *arguments)
    assert result.exit_code == 2
    assert sentence in result.stderr
    assert not (tmp_path / "out").exists()


def test_atoms_are_written_as_a_force_field_takes_them(tmp_path):
    result = run(
        *("fold", HAIRPIN, "-o", tmp_path, "--first-model", "--shapes", "rod", "--candidates", "1"),
        *("--no-plot", "--atoms", "--hydrogens", "--names", "amber", "--no-5-phosphate"),
        "--separate",
    )
    assert result.exit_code == 0, result.output
    assert "Atoms of 1 of 1 are sound: no bond is off by more than" in words(result)
    assert "note: " in result.output
    assert "the 5' phosphate was taken off at A.G1" in words(result)
    folder = tmp_path / "2koc_A6-9"
    for name in ("atoms.pdb", "atoms_1.pdb"):
        atoms = [one for one in (folder / name).read_text().splitlines() if one.startswith("ATOM")]
        assert {one[17:20].strip() for one in atoms} == {"G5", "G", "C", "A", "U", "C3"}
        assert {one[22:26] for one in atoms if one[76:78] == " H"} == {one[22:26] for one in atoms}
    (ranked,), (row,) = table(folder / "ranking.csv"), table(tmp_path / "summary.csv")
    assert row["atoms_sound"] == "True"
    content = json.loads((folder / "atoms.json").read_text())
    (candidate,) = content["candidates"]
    for column, name in (
        ("atoms_worst_bond_A", "worst_bond_A"),
        ("atoms_worst_angle_deg", "worst_angle_deg"),
        ("atoms_closest_A", "closest_contact_A"),
    ):
        assert float(row[column]) == float(ranked[column]) == candidate[name]
    assert content["hydrogens"] is True
    assert content["names"] == "amber"
    written = json.loads((folder / "ranking.json").read_text())["written"]["atoms"]
    assert written == {
        "contact": None, "hydrogens": True, "names": "amber", "no_5_phosphate": True,
        "separate": True,
    }  # fmt: skip


def test_a_5_phosphate_is_named_where_it_stays(tmp_path):
    result = run(
        *("fold", HAIRPIN, "-o", tmp_path, "--first-model", "--shapes", "rod", "--candidates", "1"),
        *("--no-plot", "--atoms"),
    )
    assert "A.G1: its 5' phosphate is refused" in words(result)
    content = json.loads((tmp_path / "2koc_A6-9" / "atoms.json").read_text())
    assert any("A.G1" in remark for remark in content["remarks"])
    assert "5' phosphate" in (tmp_path / "2koc_A6-9" / "atoms.pdb").read_text()


def test_the_package_runs_as_a_module():
    command = [sys.executable, "-m", "loopelastica"]
    done = subprocess.run([*command, "--version"], capture_output=True, text=True, check=True)
    assert done.stdout.startswith("loopelastica ")
    done = subprocess.run([*command, "fold", "absent.pdb"], capture_output=True, text=True)
    assert done.returncode == 1
    assert done.stderr == "absent.pdb: there is no such file\n"


@pytest.mark.parametrize(
    "arguments", [["-c", "import loopelastica"], ["-m", "loopelastica.cli.app", "--help"]]
)
def test_import_and_help_load_nothing_heavy(arguments):
    heavy = {"MDAnalysis", "rdkit", "numba", "matplotlib", "numpy", "scipy", "pandas"}
    code = (
        "import runpy, sys, atexit\n"
        f"atexit.register(lambda: print('HEAVY', sorted({heavy!r} & set(sys.modules))))\n"
    )
    if arguments[0] == "-c":
        code += arguments[1]
    else:
        code += "sys.argv = ['loopelastica', '--help']\n"
        code += "runpy.run_module('loopelastica.cli.app', run_name='__main__')"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "HEAVY []" in out.stdout


@pytest.mark.parametrize(("most", "there"), [(451, True), (450, False)])
def test_the_whole_structure_is_written_up_to_a_number_of_atoms(
    tmp_path, koc_lines, monkeypatch, most, there
):
    monkeypatch.setattr("loopelastica.report.pdb.WHOLE_ATOMS", most)
    assert len(koc_lines) == 451
    for option, expected in (((), there), (("--whole",), True)):
        out = tmp_path / str(len(option))
        result = run("fold", HAIRPIN, "-o", out, "--no-plot", "--first-model", *option)
        assert result.exit_code == 0, result.output
        assert (out / "2koc_A6-9" / "whole.pdb").exists() == expected


def test_hairpins_says_which_loops_cannot_be_clamped(tmp_path, koc_lines):
    path = tmp_path / "missing.pdb"
    gone = {"P", "O5'", "C5'"}
    kept = [s for s in koc_lines if s[22:26] != "  10" or s[12:16].strip() not in gone]
    path.write_text("\n".join([*kept, "END", ""]))
    result = run("hairpins", path)
    assert result.exit_code == 0
    sentence = "note: A.G10: no P, O5' and C5' atoms; its stem frame cannot be placed"
    assert sentence in result.output.splitlines()


def model_1(path):
    """The first model of 2KOC under another name."""
    path.parent.mkdir(exist_ok=True)
    path.write_text(HAIRPIN.read_text().split("ENDMDL")[0] + "ENDMDL\nEND\n")
    return path


@pytest.mark.parametrize("chain", ["/../../", "/..", "..", "a b", "a\nb", "=1+1", "[/]", "$x"])
def test_a_chain_of_any_name_is_folded_inside_the_folder_of_results(tmp_path, write_cif, chain):
    pytest.importorskip("gemmi")
    file, out = write_cif(tmp_path / "x.cif", chain), tmp_path / "a" / "out"
    theirs = [tmp_path / "6-9", tmp_path / "a" / "6-9", out / "6-9", out / "x_", out / ".x_.old"]
    for folder in theirs:
        folder.mkdir(parents=True)
        (folder / "notes").write_text("mine")
    before = {path for path in tmp_path.rglob("*") if not path.is_relative_to(out)}
    result = run("fold", file, "-o", out)
    assert result.exit_code == 0, result.output
    assert {path for path in tmp_path.rglob("*") if not path.is_relative_to(out)} == before
    assert all((folder / "notes").read_text() == "mine" for folder in theirs)
    (folder,) = (path.parent for path in out.glob("*/ranking.json"))
    assert folder.parent == out
    assert json.loads((folder / "ranking.json").read_text())["hairpin"]["chain"] == chain
    with (folder / "ranking.csv").open() as table:
        row = next(csv.DictReader(table))
    assert row["chain"] == {"=1+1": "'=1+1", "a\nb": "a\\nb"}.get(chain, chain)


def test_a_second_run_keeps_what_a_user_put_beside_the_results(tmp_path):
    out, folder = tmp_path / "out", tmp_path / "out" / "a_A6-9"
    file = model_1(tmp_path / "a.pdb")
    assert run("fold", file, "-o", out).exit_code == 0
    (folder / "notes.txt").write_text("mine")
    assert run("fold", file, "-o", out, "--no-plot").exit_code == 0
    assert (folder / "notes.txt").read_text() == "mine"
    assert not (folder / "plot.png").exists()


@pytest.mark.parametrize("many", [(), ("--jobs", "1")])
def test_a_folder_that_cannot_be_written_is_a_sentence_and_the_others_are_written(tmp_path, many):
    out, elsewhere = tmp_path / "out", tmp_path / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "notes").write_text("mine")
    (out / "b_A6-9").mkdir(parents=True)
    (out / "b_A6-9" / "ranking.csv").write_text("mine")
    (out / "a_A6-9").symlink_to(elsewhere)
    files = [model_1(tmp_path / f"{name}.pdb") for name in "abc"]
    result = run("fold", *files, "-o", out, "--no-plot", *many)
    assert result.exit_code == 1
    sentences = [line for line in result.stderr.splitlines() if str(out) in line]
    assert len(sentences) == 2, result.stderr
    assert "a_A6-9: this is a symbolic link" in sentences[0]
    assert "b_A6-9/ranking.csv: not written by this program" in sentences[1]
    assert [path.name for path in elsewhere.iterdir()] == ["notes"]
    assert [path.name for path in (out / "b_A6-9").iterdir()] == ["ranking.csv"]
    assert (out / "c_A6-9" / "ranking.json").is_file()
    assert not list(out.glob(".*.part"))


def test_build_leaves_a_folder_of_somebody_else_alone(tmp_path):
    (tmp_path / "GGCACUUCGGUGCC_A6-9").mkdir()
    (tmp_path / "GGCACUUCGGUGCC_A6-9" / "atoms.pdb").write_text("mine")
    result = run("build", "GGCAC(UUCG)GUGCC", "--rna", "-o", tmp_path, "--candidates", "1")
    assert result.exit_code == 1
    assert "atoms.pdb: not written by this program" in result.stderr
    assert (tmp_path / "GGCACUUCGGUGCC_A6-9" / "atoms.pdb").read_text() == "mine"
    assert [path.name for path in tmp_path.rglob("*.pdb")] == ["atoms.pdb"]


@pytest.mark.parametrize(
    "name",
    [
        "semi;system touch X;.pdb",
        "a,b.pdb",
        "a\nb.pdb",
        "$x.pdb",
        "[red].pdb",
        "=1+1.pdb",
        b"\xff.pdb",
    ],
)
def test_a_file_of_any_name_is_folded_with_all_its_pictures_and_scripts(tmp_path, name):
    file = model_1(tmp_path / os.fsdecode(name))
    result = run("fold", file, "-o", tmp_path / "out")
    assert result.exit_code == 0, result.output
    (folder,) = (path.parent for path in (tmp_path / "out").glob("*/plot.png"))
    content = json.loads((folder / "ranking.json").read_text())
    assert content["input"]["file"] == file.name
    assert "system" not in (folder / "view.pml").read_text()
    # and again: what is there is the program's own
    assert run("fold", file, "-o", tmp_path / "out").exit_code == 0


@pytest.mark.parametrize("command", ["fold", "hairpins", "scan"])
def test_a_refusal_is_one_line_whatever_the_name(tmp_path, command):
    (tmp_path / "a\nb[red].pdb").write_text("nothing\n")
    out = ("-o", tmp_path / "out") if command == "fold" else ()
    result = run(command, tmp_path / "a\nb[red].pdb", *out)
    assert result.exit_code == 1
    (sentence,) = result.stderr.splitlines()
    assert r"a\nb[red].pdb" in sentence


def test_hairpins_shows_a_chain_of_any_name(tmp_path, write_cif):
    pytest.importorskip("gemmi")
    result = run("hairpins", write_cif(tmp_path / "x.cif", "[/]\nb"))
    assert result.exit_code == 0, result.output
    assert r">[/]\nb 1-14" in result.output


def test_limits_of_a_file_are_options_of_every_command_that_reads_one(tmp_path):
    for command in (("hairpins",), ("scan",), ("fold", "-o", tmp_path / "out")):
        for option, value in (("--max-size", "0.5"), ("--max-atoms", "450")):
            result = run(*command, HAIRPIN, option, value)
            assert result.exit_code == 1, result.output
            assert option in result.output
            assert "2koc.pdb" in result.output
        assert run(*command, HAIRPIN, "--max-atoms", "0").exit_code == 2
    assert run("hairpins", HAIRPIN, "--max-size", "1", "--max-atoms", "451").exit_code == 0


def test_a_pipe_among_many_files_is_a_row_and_the_others_go_on(tmp_path):
    pipe = tmp_path / "pipe.pdb"
    os.mkfifo(pipe)
    for jobs in ((), ("--jobs", "1")):
        out = tmp_path / f"out{len(jobs)}"
        result = run("fold", pipe, HAIRPIN, "-o", out, "--first-model", "--no-plot", *jobs)
        assert result.exit_code == 1, result.output
        assert "this is a pipe" in result.output
        assert any(path.name.startswith("2koc") for path in out.iterdir())


def test_limits_reach_the_workers_and_their_files(tmp_path):
    result = run("fold", HAIRPIN, "-o", tmp_path, "--jobs", "1", "--max-atoms", "450")
    assert result.exit_code == 1
    assert "--max-atoms" in (tmp_path / "failures.csv").read_text()


def ranks(out, *names):
    rows = table(out / "summary.csv")
    return [tuple(row[name] for name in names) for row in rows]


def test_the_order_is_the_users_and_both_are_in_every_table(tmp_path, of_chains, monkeypatch):
    monkeypatch.setattr("loopelastica.folding.fold.hypotheses", of_chains)
    for order, title in (("default", "nearest first"), ("energy", "least energy first")):
        out = tmp_path / order
        result = run(
            "fold", HAIRPIN, "-o", out, "--no-plot", "--first-model", "--rank", order,
        )  # fmt: skip
        assert result.exit_code == 0, result.output
        assert title in " ".join(result.output.split())
        assert "like 2koc" in result.output
        content = json.loads((out / "2koc_A6-9" / "ranking.json").read_text())
        for rows in (table(out / "summary.csv"), table(out / "2koc_A6-9" / "ranking.csv")):
            for row, candidate in zip(rows, content["candidates"], strict=True):
                for name in ("rank", "rank_energy"):
                    assert int(row[name]) == candidate[name]
                assert row["shape"] == candidate["shape"]
                assert float(row["expected_rmsd_A"]) == candidate["expected_rmsd_A"][1]
                low, high = float(row["expected_10_A"]), float(row["expected_90_A"])
                assert low < float(row["expected_rmsd_A"]) < high
    default, energy = (
        ranks(tmp_path / order, "shape", "rank_energy", "energy_per_A")
        for order in ("default", "energy")
    )
    assert sorted(default, key=lambda row: int(row[1])) == energy
    assert default[0][0] == "like 2koc A.5-A.10"


def test_all_that_is_written_of_chains_can_be_read(tmp_path, of_chains, monkeypatch):
    monkeypatch.setattr("loopelastica.folding.fold.hypotheses", of_chains)
    out = tmp_path / "out"
    result = run("fold", HAIRPIN, "-o", out, "--first-model", "--atoms", "--candidates", "2")
    assert result.exit_code == 0, result.output
    folder = out / "2koc_A6-9"
    rows = table(folder / "ranking.csv")
    assert [row["shape"] for row in rows] == ["like 2koc A.5-A.10", "like small"]
    assert {row["atoms_sound"] for row in rows} == {"True"}
    line = np.genfromtxt(folder / "line.csv", delimiter=",", names=True)
    assert all(np.isfinite(line[name]).all() for name in line.dtype.names)
    for text in (path.read_text(errors="replace") for path in folder.glob("*.*s*")):
        assert "NaN" not in text


@pytest.mark.parametrize(
    ("option", "value", "sentence"),
    [
        ("--rank", "best", "--rank is 'best'; it must be 'default' or 'energy'"),
        ("--shapes", "chain", "--shapes is 'chain'; it must be 'all' or 'rod'"),
        ("--like", "", "--like is ''; it must be the name of a file"),
        ("--library", "", "--library is ''; it must be the name of a file"),
    ],
)
def test_what_is_no_order_no_kind_and_no_file_is_refused(tmp_path, option, value, sentence):
    result = run("fold", HAIRPIN, "-o", tmp_path / "out", option, value)
    assert result.exit_code == 2
    assert sentence in " ".join(result.stderr.replace("│", " ").split())
    assert not (tmp_path / "out").exists()


def test_rods_alone_are_folded_on_request(tmp_path):
    result = run("fold", HAIRPIN, "-o", tmp_path, "--no-plot", "--first-model", "--shapes", "rod")
    assert result.exit_code == 0
    assert {shape for (shape,) in ranks(tmp_path, "shape")} == {"straight rod"}


@pytest.fixture
def eighth(tmp_path):
    """The eighth model of 2KOC as a template."""
    return gapped.pdb(tmp_path / "eighth.pdb", gapped.chain(model=8))


@pytest.mark.parametrize("jobs", [(), ("--jobs", "1")])
def test_a_loop_like_another_one_is_the_first_candidate(tmp_path, eighth, jobs):
    out = tmp_path / "out"
    like = f"{eighth}:A.5-A.10"
    result = run("fold", HAIRPIN, "--first-model", "--like", like, "-o", out, *jobs)
    assert result.exit_code == 0, result.output
    first, *others = table(out / "summary.csv")
    assert first["shape"] == "like eighth A.5-A.10"
    assert float(first["rmsd_A"]) < 1.0
    assert not any(row["shape"].startswith("like") for row in others)
    content = json.loads((out / "2koc_A6-9" / "ranking.json").read_text())
    assert content["parameters"]["like"] == like


@pytest.mark.parametrize("jobs", [(), ("--jobs", "1")])
@pytest.mark.parametrize(
    ("like", "status", "fragment"),
    [
        ("{}:loop", 2, "--like"),
        ("nowhere.pdb", 1, "nowhere.pdb: there is no such file"),
        ("{}:A.6-A.9", 1, "A.6-A.9 closes no hairpin loop"),
    ],
)
def test_a_template_that_is_none_is_one_sentence_and_nothing_is_written(
    tmp_path, eighth, jobs, like, status, fragment
):
    out = tmp_path / "out"
    result = run("fold", HAIRPIN, "--like", like.format(eighth), "-o", out, *jobs)
    assert result.exit_code == status
    assert fragment in result.stderr
    assert not out.exists()
