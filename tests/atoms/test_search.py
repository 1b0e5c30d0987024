import numpy as np
import pytest
from cut_strands import cut, heavy, ideal_line, left, monomers

from loopelastica.atoms.carry import Bent
from loopelastica.atoms.strand import build_strand

pytest.importorskip("rdkit")


@pytest.fixture(scope="module")
def rna(koc):
    return monomers(koc)


@pytest.fixture(scope="module")
def gap(rna):
    return cut(rna, 2, 3)


def test_the_first_sound_model_ends_the_search_and_more_are_compared_if_asked_for(rna, gap):
    line, atoms = ideal_line(gap), heavy(left(rna, gap))
    one = build_strand(gap, line, atoms)
    three = build_strand(gap, line, atoms, tries=3)
    assert one.attempts == 1
    assert three.attempts >= 3
    assert three.checks.sound
    again = build_strand(gap, line, atoms)
    np.testing.assert_array_equal(one.positions_A, again.positions_A)


def test_a_line_that_runs_through_other_atoms_is_bent_round_them(rna, gap):
    """A lump of atoms on the middle of the line, 3 Å wide."""
    line = ideal_line(gap)
    middle = line.at([2.0])[0][0]
    steps = np.arange(-1.5, 1.6, 1.5)
    lump = [("LMP", "C", middle + [a, b, c]) for a in steps for b in steps for c in steps]
    atoms = heavy(left(rna, gap), *lump)
    model = build_strand(gap, line, atoms)
    assert model.checks.sound
    away = np.linalg.norm(model.positions_A[model.built] - middle, axis=1)
    assert away.min() > 2.2


def test_a_bent_line_keeps_its_ends_and_has_its_own_tangents(gap):
    line = ideal_line(gap)
    aside = np.array([1.0, -2.0, 0.5])
    for waves, most in ((1, 2.0), (2, 1.25)):
        bent = Bent(line, 3, aside, waves)
        np.testing.assert_allclose(bent.at([0.5, 3.5])[0], line.at([0.5, 3.5])[0], atol=1e-9)
        np.testing.assert_allclose(bent.at([most])[0][0] - line.at([most])[0][0], aside, atol=1e-9)
        phases = np.array([1.0, 1.7, 2.6])
        frames = bent.at(phases)[1]
        np.testing.assert_allclose(
            np.swapaxes(frames, 1, 2) @ frames, np.broadcast_to(np.eye(3), (3, 3, 3)), atol=1e-9
        )
        step = 1e-4
        slope = bent.at(phases + step)[0] - bent.at(phases - step)[0]
        slope /= np.linalg.norm(slope, axis=1)[:, None]
        np.testing.assert_allclose(frames[:, :, 2], slope, atol=5e-3)
