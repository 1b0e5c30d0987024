import csv
import subprocess
import sys

import numpy as np
import pytest
from typer.testing import CliRunner

from loopelastica._files import data_path
from loopelastica.atoms.sequence import ideal_hairpin, read_sequence
from loopelastica.cli.app import app
from loopelastica.molecule.nucleotides import atom_positions
from loopelastica.molecule.pairs import canonical_pairs


@pytest.mark.parametrize(
    ("text", "is_dna", "said"),
    [
        ("GGCAC", False, "two strands with the loop in brackets"),
        ("GGC(UUCG)GTC", False, "T is no base of RNA"),
        ("GGC(UUU)GCC", True, "U is no base of DNA"),
        ("GGC(UUCG)GC", False, "needs equal ones"),
        ("GGC(UUCG)GAC", False, "do not pair"),
        ("GGC(UU)GCC", False, "has 2 nucleotides"),
    ],
)
def test_a_sequence_that_is_no_hairpin_is_refused(text, is_dna, said):
    with pytest.raises(ValueError, match=said):
        read_sequence(text, is_dna)


@pytest.mark.parametrize("is_dna", [False, True])
def test_the_ideal_stem_is_paired_and_joined(is_dna):
    text = "GACG(TTTT)CGTC" if is_dna else "GACG(UUUU)CGUC"
    structure, hairpin, positions = ideal_hairpin(text, is_dna)
    table = structure.nucleotides
    assert hairpin.closing_pair == (("A.DG4", "A.DC9") if is_dna else ("A.G4", "A.C9"))
    assert "".join(table.letter) == text.replace("(", "").replace(")", "")
    stem = structure.positions(0)
    pairs = [pair for pair in canonical_pairs(table, stem).tolist() if pair[0] < 4]
    assert pairs == [[0, 11], [1, 10], [2, 9], [3, 8]]
    o3, p = np.moveaxis(atom_positions(table, stem, ("O3'", "P")), 1, 0)
    for k in (0, 1, 2, 8, 9, 10):
        assert np.linalg.norm(p[k + 1] - o3[k]) == pytest.approx(1.59, abs=0.02)
    loop = table.atom_index[hairpin.loop]
    assert np.isnan(positions[loop[loop >= 0]]).all()


def run(*arguments):
    return CliRunner().invoke(app, [str(a) for a in arguments])


def test_build_writes_a_hairpin_from_its_sequence(tmp_path):
    result = run("build", "GGC(TTTT)GCC", "--dna", "-o", tmp_path, "--candidates", 1)
    assert result.exit_code == 0, result.output
    (folder,) = tmp_path.iterdir()
    assert folder.name == "GGCTTTTGCC_A4-7"
    names = {path.name for path in folder.iterdir()}
    assert {"atoms.pdb", "loop.sdf", "atoms.json", "traces.pdb", "plot.png"} <= names
    with (folder / "ranking.csv").open() as file:
        (row,) = csv.DictReader(file)
    assert row["atoms_sound"] == "True"
    assert row["rmsd_A"] == row["atoms_rmsd_A"] == ""


def test_build_refuses_in_one_sentence(tmp_path):
    result = run("build", "GGC(GAA)GCA", "--dna", "-o", tmp_path)
    assert result.exit_code == 2
    assert "do not pair" in result.output
    assert not list(tmp_path.iterdir())


def test_fold_writes_atoms_only_when_asked(tmp_path):
    file = data_path("hairpins/2koc.pdb")
    options = ("--first-model", "--candidates", 1, "--no-plot", "-o")
    assert run("fold", file, *options, tmp_path / "plain").exit_code == 0
    assert run("fold", file, "--atoms", *options, tmp_path / "atoms").exit_code == 0
    plain, atoms = (
        {path.name for path in (tmp_path / name / "2koc_A6-9").iterdir()}
        for name in ("plain", "atoms")
    )
    assert atoms - plain >= {"atoms.pdb", "loop.sdf", "atoms.json"}
    assert plain < atoms


def test_the_atoms_are_not_loaded_unless_asked_for():
    # (MDAnalysis itself loads parts of rdkit where that is installed)
    code = (
        "import sys, loopelastica as le; from loopelastica._files import data_path;"
        "le.fold(data_path('hairpins/2koc.pdb'), all_models=False);"
        "assert not any(m.startswith('loopelastica.atoms') for m in sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
