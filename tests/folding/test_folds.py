"""The folded loops of a structure, as a list."""

import pickle

import loopelastica as le
from loopelastica._files import data_path

HAIRPIN = data_path("hairpins/2koc.pdb")
RODS = {"all_models": False, "shapes": "rod"}


def test_folds_are_a_list_that_says_what_failed():
    (loop,) = le.fold(HAIRPIN, **RODS)
    (refused,) = le.fold(HAIRPIN, length_per_nucleotide_A=2.0, **RODS)
    folds = le.Folds([loop, refused], ["a remark"])
    assert folds == [loop, refused]
    assert folds.failures == (refused.failure,)
    again = pickle.loads(pickle.dumps(folds))
    assert isinstance(again, le.Folds)
    assert again.remarks == ("a remark",)
    assert [repr(one) for one in again] == [repr(one) for one in folds]
