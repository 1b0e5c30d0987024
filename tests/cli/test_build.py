"""The command `build`, as a user meets it."""

import csv
import json

import pytest
from typer.testing import CliRunner

from loopelastica.cli.app import app


def run(*arguments):
    return CliRunner().invoke(app, ["build", *(str(a) for a in arguments)])


def folders(path):
    return [place for place in path.iterdir() if place.is_dir()]


FAST = ("--candidates", 1, "--no-plot")


def test_a_hairpin_is_built_from_its_sequence(tmp_path):
    result = run("GGC(TTTT)GCC", "-o", tmp_path, "--candidates", 1)
    assert result.exit_code == 0, result.output
    (folder,) = folders(tmp_path)
    assert folder.name == "GGCTTTTGCC_A4-7"
    names = {path.name for path in folder.iterdir()}
    assert {"atoms.pdb", "loop.sdf", "atoms.json", "traces.pdb", "plot.png"} <= names
    with (folder / "ranking.csv").open() as file:
        (row,) = csv.DictReader(file)
    assert row["atoms_sound"] == "True"
    assert row["rmsd_A"] == row["atoms_rmsd_A"] == ""
    with (tmp_path / "summary.csv").open() as file:
        (summed,) = csv.DictReader(file)
    assert (summed["file"], summed["folder"]) == ("GGCTTTTGCC", folder.name)
    assert summed["atoms_closest_A"] == row["atoms_closest_A"]
    ranking = json.loads((folder / "ranking.json").read_text())
    assert ranking["input"] == {"sequence": "GGC(TTTT)GCC"}
    assert ranking["hairpin"]["kind"] == "DNA"


@pytest.mark.parametrize("kind", ["--rna", "--dna"])
def test_the_kind_may_be_given(tmp_path, kind):
    result = run("GGC(GAA)GCC", kind, *FAST, "-o", tmp_path)
    assert result.exit_code == 0, result.output
    (pdb,) = tmp_path.glob("*/atoms.pdb")
    assert ("DG " in pdb.read_text()) == (kind == "--dna")


def test_a_dot_bracket_and_options_are_taken(tmp_path):
    result = run("ggucuucgguuc", "((((....))))", "--5-phosphate", "--mismatches", *FAST, "-o",
                 tmp_path)  # fmt: skip
    assert result.exit_code == 0, result.output
    said = " ".join(result.output.split())
    assert "U3·U10 do not pair; they stand where they find room" in said
    assert "the 5' end has a phosphate" in said
    (folder,) = folders(tmp_path)
    assert folder.name == "GGUCUUCGGUUC_A5-8"
    first = [line for line in (folder / "atoms.pdb").read_text().splitlines()
             if line.startswith("ATOM") and line[22:26].strip() == "1"]  # fmt: skip
    assert {"P", "OP1", "OP2", "OP3"} <= {line[12:16].strip() for line in first}
    assert len(json.loads((folder / "ranking.json").read_text())["remarks"]) >= 2


@pytest.mark.parametrize(
    ("arguments", "status", "said"),
    [
        (["GGC(GAA)GCA", "--dna"], 2, "G1·A9 do not pair"),
        (["GGC(GAA)GCC"], 2, "--rna or --dna is needed: the sequence has neither U nor T"),
        (["GGC(UAT)GCC"], 2, "SEQUENCE has both U (nucleotide 4)"),
        (["GGC(UUU)GCC", "--dna"], 2, "U (nucleotide 4) is no base of DNA"),
        (["GGC(UUU)GC"], 2, "a stem needs equal ones"),
        (["GGACUUUGCC", "((.(...)))"], 2, "a bulge, A3"),
        (["GGC(A[H2U]A)GCC"], 2, "H2U (nucleotide 5) is a nucleotide that cannot be built"),
        (["GGC(UUU)GCC", "--contact", "wobble"], 2, "--contact is 'wobble'"),
        (["GGC(UUU)GCC", "--candidates", "0"], 2, "--candidates"),
        (["GGC(UUU)GCC", "--names", "gromos"], 2, "--names is 'gromos'"),
        ([""], 2, "it must be two strands with the loop in brackets"),
        (["absent.fa"], 1, "absent.fa: there is no such file"),
        (["no/such"], 1, "no/such: there is no such file"),
        (["{tmp}"], 1, "this is a folder"),
        (["{tmp}", "(((...)))"], 2, "STRUCTURE goes without a FASTA file"),
    ],
)
def test_what_cannot_be_built_is_refused_in_one_sentence(tmp_path, arguments, status, said):
    out = tmp_path / "out"
    result = run(*(a.replace("{tmp}", str(tmp_path)) for a in arguments), "-o", out)
    assert result.exit_code == status, result.output
    assert said in " ".join(result.output.replace("│", " ").split())
    assert "Traceback" not in result.output
    assert not out.exists()


def test_hydrogens_and_names_are_options(tmp_path):
    result = run("GGC(GAA)GCC", "--rna", "--hydrogens", "--names", "amber", *FAST, "-o", tmp_path)
    assert result.exit_code == 0, result.output
    (pdb,) = tmp_path.glob("*/atoms.pdb")
    atoms = [line for line in pdb.read_text().splitlines() if line.startswith("ATOM")]
    assert {line[17:20].strip() for line in atoms} == {"G5", "G", "C", "A", "C3"}
    assert sum(line[76:78].strip() == "H" for line in atoms) > 90


def test_hairpins_of_a_fasta_file_are_built_apart(tmp_path):
    path, out = tmp_path / "hairpins.fa", tmp_path / "out"
    path.write_text(
        ">uucg from 2KOC\nGGCACUUCGGUGCC\n(((((....))))) (-5.20)\n"
        ">bulge\nGGACUUUGCC\n((.(...)))\n"
        ">a/b.1\nggc(ttt)gcc\n"
        ">uucg\nGGCAC(UUCG)GUGCC\n"
        ">empty\n"
    )
    result = run(path, *FAST, "-o", out)
    assert result.exit_code == 1
    assert {p.name for p in out.iterdir()} == {
        "uucg_A6-9", "a_b.1_A4-6", "uucg_A6-9_2", "summary.csv", "failures.csv"
    }  # fmt: skip
    with (out / "summary.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert {row["atoms_sound"] for row in rows} == {"True"}
    assert [(row["file"], row["kind"], row["folder"]) for row in rows] == [
        ("uucg", "RNA", "uucg_A6-9"),
        ("a/b.1", "DNA", "a_b.1_A4-6"),
        ("uucg", "RNA", "uucg_A6-9_2"),
    ]
    with (out / "failures.csv").open() as file:
        failures = {row["file"]: row["failure"] for row in csv.DictReader(file)}
    assert list(failures) == ["bulge", "empty"]
    assert failures["bulge"].startswith("bulge: STRUCTURE is no unbroken stem")
    assert failures["bulge"] in result.output
    assert all("atoms.pdb" in {p.name for p in (out / row["folder"]).iterdir()} for row in rows)


def test_a_fasta_file_of_good_hairpins_is_done(tmp_path):
    path = tmp_path / "hairpins.fasta"
    path.write_text(">one\nGGC(GAA)GCC\n")
    result = run(path, "--dna", *FAST, "-o", tmp_path / "out")
    assert result.exit_code == 0, result.output
    assert (tmp_path / "out" / "failures.csv").read_text().strip() == "file,failure"


def test_tables_of_others_stay(tmp_path):
    path, out = tmp_path / "hairpins.fa", tmp_path / "out"
    path.write_text(">one\nGGC(UUU)GCC\n")
    out.mkdir()
    (out / "summary.csv").write_text("mine")
    result = run(path, *FAST, "-o", out)
    assert result.exit_code == 1
    assert (out / "summary.csv").read_text() == "mine"
    assert [p.name for p in out.iterdir()] == ["summary.csv"]
