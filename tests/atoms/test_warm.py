import importlib
import os
import subprocess
import sys

import pytest

from loopelastica.atoms.kernels import clash, lbfgs, terms


@pytest.mark.slow
def test_nothing_is_left_to_be_compiled_when_atoms_are_built(tmp_path):
    """Kernels of a build after warming, and all that it left in the folder."""
    pytest.importorskip("rdkit")
    warm = [sys.executable, "-m", "loopelastica.atoms.warm"]
    environment = {**os.environ, "LOOPELASTICA_CACHE": str(tmp_path)}
    subprocess.run(warm, env=environment, check=True)
    before = {path for path in tmp_path.rglob("*") if path.is_file()}
    assert before
    script = (
        "import sys; sys.path.insert(0, sys.argv[1])\n"
        "from cut_strands import cut, heavy, ideal_line, left, monomers\n"
        "from loopelastica._files import data_path\n"
        "from loopelastica.atoms.strand import build_strand\n"
        "from loopelastica.molecule.nucleotides import read_structure\n"
        "rna = monomers(read_structure(data_path('hairpins/2koc.pdb')))\n"
        "gap = cut(rna, 3, 2)\n"
        "assert build_strand(gap, ideal_line(gap), heavy(left(rna, gap))).checks.sound\n"
    )
    here = os.path.dirname(__file__)
    subprocess.run([sys.executable, "-c", script, here], env=environment, check=True)
    assert {path for path in tmp_path.rglob("*") if path.is_file()} == before


def test_every_kernel_module_of_the_room_is_warmed():
    warm = importlib.import_module("loopelastica.atoms.warm")
    for module in (clash, lbfgs, terms):
        assert any(name in vars(warm) for name in vars(module) if not name.startswith("_"))
