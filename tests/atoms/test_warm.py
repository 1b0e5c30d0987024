import os
import subprocess
import sys

import pytest

USES = """
import sys; sys.path.insert(0, sys.argv[1])
from numba.core import event
with event.install_recorder("numba:compile") as compiled:
    from cut_strands import cut, heavy, ideal_line, left, monomers
    from loopelastica._files import data_path
    from loopelastica.atoms.strand import build_strand
    from loopelastica.molecule.nucleotides import read_structure
    rna = monomers(read_structure(data_path("hairpins/2koc.pdb")))
    gap = cut(rna, 3, 2)
    assert build_strand(gap, ideal_line(gap), heavy(left(rna, gap))).checks.sound
print(*sorted({e.data["dispatcher"].py_func.__name__ for _, e in compiled.buffer}))
"""


@pytest.mark.slow
def test_nothing_is_left_to_be_compiled_when_atoms_are_built(tmp_path):
    pytest.importorskip("rdkit")
    environment = {**os.environ, "LOOPELASTICA_CACHE": str(tmp_path)}

    def run(*arguments):
        command = [sys.executable, *arguments]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout.strip()

    run("-m", "loopelastica.atoms.warm")
    assert run("-c", USES, os.path.dirname(__file__)) == ""
