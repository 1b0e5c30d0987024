"""tubes.pdb."""

import numpy as np
import pytest

from loopelastica.molecule.setting import Settings
from loopelastica.report.pdb import b_factor
from loopelastica.report.tubes import tubes_text


def models(text):
    """Atom records of each MODEL."""
    return [
        [line for line in part.splitlines() if line.startswith(("ATOM", "HETATM"))]
        for part in text.split("MODEL     ")[1:]
    ]


def places(lines):
    return np.array([[float(line[k : k + 8]) for k in (30, 38, 46)] for line in lines])


def test_each_candidate_is_a_model_with_its_line_and_its_nucleotides(koc, chains):
    setting = Settings(koc).of(chains.hairpin)
    text = tubes_text(chains, koc, setting, "A")
    found = models(text)
    assert len(found) == len(chains.candidates)
    for candidate, lines in zip(chains.candidates, found, strict=True):
        assert {len(line) for line in lines if "TUB" in line} == {78}
        points = places([line for line in lines if line[12:16].strip() == "CEN"])
        np.testing.assert_allclose(points, candidate.trace, atol=6e-4)
        line = places([line for line in lines if line[12:16].strip() == "TUB"])
        np.testing.assert_allclose(line[0], setting.strand_5_A[-1], atol=6e-4)
        expected = b_factor(float(candidate.expected_rmsd_A[1]))
        assert {float(line[60:66]) for line in lines} == {round(expected, 2)}
    n = sum("TUB" in line for line in found[0])
    # every point of the line is bonded to the next, and the nucleotides to none
    bonds = [(int(s[6:11]), int(s[11:16])) for s in text.splitlines() if s.startswith("CONECT")]
    assert bonds == [(k, k + 1) for k in range(1, n)]


# the points of nucleotides are of no element
@pytest.mark.filterwarnings("ignore:Unknown")
def test_a_reader_of_structures_reads_it(tmp_path, koc, chains):
    import MDAnalysis as mda

    path = tmp_path / "tubes.pdb"
    path.write_text(tubes_text(chains, koc, None, "", chains.candidates[:1]))
    universe = mda.Universe(str(path))
    assert len(universe.select_atoms("name CEN")) == 4
    assert len(universe.bonds) == len(universe.select_atoms("name TUB")) - 1
