import itertools

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from loopelastica.atoms.carry import Line
from loopelastica.atoms.measures import chi_torsion, torsion_deg
from loopelastica.atoms.site import site_of
from loopelastica.atoms.states import place, ring_plane
from loopelastica.atoms.turn import _clash, _stacking, check_contact, turned
from loopelastica.molecule.strands import ideal_strand


@pytest.fixture(scope="module")
def site(koc, fold):
    return site_of(koc, fold, koc.positions(0), fold.candidates[0].line)


@pytest.fixture(scope="module")
def line(fold):
    candidate = fold.candidates[0]
    return Line.between(candidate.rod, fold.ends, ideal_strand(False))


def test_omega_turns_about_the_tangent_and_chi_about_the_glycosidic_bond(line):
    still = place("G", False, line, 2, 0.0, 0.0)
    turned_once = place("G", False, line, 2, 90.0, 0.0)
    point, frame = line.at([2.0])
    turn = Rotation.from_rotvec(np.deg2rad(90.0) * frame[0][:, 2])
    for name, at in still.items():
        np.testing.assert_allclose(
            turned_once[name], turn.apply(at - point[0]) + point[0], atol=1e-9
        )
    twisted = place("G", False, line, 2, 0.0, 30.0)
    before, after = (torsion_deg(*(p[a] for a in chi_torsion("G"))) for p in (still, twisted))
    assert (after - before) % 360.0 == pytest.approx(30.0)
    np.testing.assert_allclose(still["O3'"], twisted["O3'"], atol=1e-12)


def test_combinations_are_sorted_distinct_and_the_same_again(site, line):
    found = turned("UUCG", [False] * 4, line, site.stem, keep=5)
    assert len(found) == 5
    scores = [turns.score for turns in found]
    assert scores == sorted(scores)
    for a, b in itertools.combinations(found, 2):
        apart = np.abs((np.subtract(a.omega_deg, b.omega_deg) + 180.0) % 360.0 - 180.0)
        syn = np.abs(np.subtract(a.chi_change_deg, b.chi_change_deg)) > 90.0
        assert (apart >= 45.0).any() or syn.any()
    assert turned("UUCG", [False] * 4, line, site.stem, keep=5) == found


def test_a_contact_that_is_asked_for_lowers_the_score_and_brings_the_bases_together(site, line):
    def distance(turns):
        first, last = (
            place(letter, False, line, k, turns.omega_deg[k - 1], turns.chi_change_deg[k - 1])
            for k, letter in ((1, "G"), (4, "A"))
        )
        return np.linalg.norm(first["N2"] - last["N7"])

    plain = turned("GAAA", [False] * 4, line, site.stem)[0]
    sheared = turned("GAAA", [False] * 4, line, site.stem, contact="sheared")[0]
    assert sheared.score <= plain.score
    assert distance(sheared) <= distance(plain) + 1e-9
    with pytest.raises(ValueError, match="`contact` is 'hoogsteen'"):
        turned("GAAA", [False] * 4, line, site.stem, contact="hoogsteen")


def test_clashes_and_stacking_are_counted_as_said(rng):
    a, b = rng.normal(scale=2.0, size=(3, 4, 3)), rng.normal(scale=2.0, size=(2, 5, 3))
    expected = [
        [sum(max(3.2 - np.linalg.norm(p - q), 0.0) ** 2 for p in one for q in other) for other in b]
        for one in a
    ]
    np.testing.assert_allclose(_clash(a, b), expected)
    up = np.array([[0.0, 0.0, 1.0]])
    stacked = _stacking((np.zeros((1, 3)), up), (np.array([[0.0, 0.0, 3.4]]), -up))
    beside = _stacking((np.zeros((1, 3)), up), (np.array([[7.0, 0.0, 0.0]]), up))
    assert stacked[0, 0] == pytest.approx(-2.0)
    assert abs(beside[0, 0]) < 1e-6


@pytest.mark.filterwarnings("error")
def test_nothing_stacks_on_a_ring_that_has_noring_plane(rng):
    centre, normal = ring_plane(np.stack([np.ones((6, 3)), rng.normal(size=(6, 3))]))
    np.testing.assert_array_equal(normal[0], 0.0)
    assert np.linalg.norm(normal[1]) == pytest.approx(1.0)
    np.testing.assert_array_equal(centre[0], 1.0)


@pytest.mark.parametrize("odd", [np.ones((3, 3)), "a\nb", 5, []])
def test_an_odd_contact_is_named_in_one_line(odd):
    with pytest.raises(ValueError, match=r"^`contact` is .* watson-crick$"):
        check_contact(odd)
