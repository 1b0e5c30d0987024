"""Atoms of `fold`, where they are asked for."""

import subprocess
import sys

from typer.testing import CliRunner

from loopelastica._files import data_path
from loopelastica.cli.app import app


def run(*arguments):
    return CliRunner().invoke(app, [str(a) for a in arguments])


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
