"""The ideal stem of a sequence, and the loop folded on it."""

import numpy as np
import pytest

from loopelastica.atoms.hairpin import fold_sequence, ideal_hairpin
from loopelastica.atoms.sequence import read_sequence
from loopelastica.molecule.nucleotides import atom_positions
from loopelastica.molecule.pairs import canonical_pairs


@pytest.mark.parametrize("text", ["GACG(TTTT)CGTC", "GACG(UUUU)CGUC", "GGUG(UUUU)CGCC"])
def test_the_ideal_stem_is_paired_and_joined(text):
    structure, hairpin, positions = ideal_hairpin(read_sequence(text))
    table = structure.nucleotides
    kind = "D" if "T" in text else ""
    assert hairpin.closing_pair == (f"A.{kind}G4", f"A.{kind}C9")
    assert "".join(table.letter) == text.replace("(", "").replace(")", "")
    stem = structure.positions(0)
    pairs = [pair for pair in canonical_pairs(table, stem).tolist() if pair[0] < 4]
    assert pairs == [[0, 11], [1, 10], [2, 9], [3, 8]]
    o3, p = np.moveaxis(atom_positions(table, stem, ("O3'", "P")), 1, 0)
    for k in (0, 1, 2, 8, 9, 10):
        assert np.linalg.norm(p[k + 1] - o3[k]) == pytest.approx(1.607, abs=0.02)
    loop = table.atom_index[hairpin.loop]
    assert np.isnan(positions[loop[loop >= 0]]).all()


def test_shapes_of_other_loops_are_among_the_candidates():
    fold = fold_sequence(read_sequence("GGCAC(UUCG)GUGCC"), max_candidates=3).fold
    assert len(fold.candidates) == 3
    assert fold.candidates[0].shape.startswith("motif UNCG, same sequence")
    assert any(candidate.shape.startswith("library") for candidate in fold.candidates)
