import numpy as np
import pytest

import loopelastica as le
from loopelastica._files import data_path
from loopelastica.atoms.carry import IdealCurve
from loopelastica.atoms.habits import LEAST, TERMS, Habits, holds, of_motif, usual
from loopelastica.atoms.states import states_on
from loopelastica.folding.motifs import motif_of
from loopelastica.molecule.strands import ideal_strand


def test_terms_hold_where_they_say():
    rows = holds("GUAG", [False] * 4)
    named = [[name for name, one in zip(TERMS, row, strict=True) if one] for row in rows]
    assert named == [
        ["all", "first", "four", "G"],
        ["all", "second", "four", "U"],
        ["all", "last but one", "four", "A"],
        ["all", "last", "four", "G", "G last"],
    ]
    assert holds("AG", [True, True]).sum(axis=1).tolist() == [2.0, 2.0]
    assert holds("", []).shape == (0, len(TERMS))


def test_a_short_loop_is_stretched_and_deoxyribose_is_c2_endo():
    assert usual("AAA", [False] * 3).c2_endo.min() > 0.5
    assert usual("AAAAAAA", [False] * 7).c2_endo.max() < 0.5
    assert usual("ACGT", [True] * 4).c2_endo.min() > 0.7


def test_costs_are_minus_logarithms_and_never_infinite():
    states = states_on("U", False, IdealCurve(ideal_strand(False), np.eye(3), np.zeros(3)), 1)
    costs = Habits(np.array([0.25]), np.array([0.0])).costs(0, states)
    assert np.isfinite(costs).all()
    rare = states.c2_endo & states.syn
    np.testing.assert_allclose(costs[rare], -np.log(0.25 * LEAST))
    np.testing.assert_allclose(costs[~states.c2_endo & ~states.syn], -np.log(0.75 * (1 - LEAST)))


def test_a_motif_remembers_its_sugars_and_bases():
    uncg, gnra = (of_motif(motif_of(s)) for s in ("CUUCGG", "CGAAAG"))
    assert uncg.syn.argmax() == 3
    assert uncg.syn[3] > 0.5
    assert (uncg.c2_endo > 0.5).tolist() == [False, True, True, False]
    assert gnra.c2_endo.max() < 0.1


@pytest.mark.parametrize("relatives", [False, True])
def test_what_a_motif_remembers_is_built_unless_relatives_are_left_out(relatives):
    path = data_path("hairpins/2koc.pdb")
    (loop,) = le.fold(path, all_models=False, max_candidates=1, exclude_relatives=relatives)
    (model,) = le.build_atoms(path, loop)
    assert model.checks.sound
    found = (model.checks.pucker[1:3] == ("C2'-endo", "C2'-endo"), model.checks.chi[3])
    assert (found == (True, "syn")) == (not relatives)
