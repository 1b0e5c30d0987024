import os
import subprocess
import sys

import pytest


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
