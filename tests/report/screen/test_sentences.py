"""Sentences that are alike become one."""

import pytest

from loopelastica.report.screen.sentences import gathered


def test_one_failure_of_nineteen_models_is_one_sentence():
    said = [f"a.pdb: model {k}: A.C5–A.G10: no P atom" for k in range(2, 21)]
    assert gathered(said) == ["a.pdb: models 2-20: A.C5–A.G10: no P atom"]


def test_models_with_other_causes_keep_sentences_of_their_own():
    said = ["a: model 2: x", "a: model 3: y", "a: model 4: x"]
    assert gathered(said) == ["a: models 2, 4: x", "a: model 3: y"]


def test_models_that_differ_in_figures_are_counted_behind_the_first():
    said = [f"a: model {k}: {k}.25 Å is too far" for k in range(2, 8)]
    assert gathered([*said, "a: model 9: odd"]) == [
        "a: model 2: 2.25 Å is too far (and 5 more models)",
        "a: model 9: odd",
    ]


def test_models_of_other_loops_are_counted_apart():
    said = [f"a: model {k}: {loop}: {k}.25 Å off" for loop in ("1.40-42", "2.5-9") for k in (2, 3)]
    assert gathered(said) == [
        "a: model 2: 1.40-42: 2.25 Å off (and 1 more model)",
        "a: model 2: 2.5-9: 2.25 Å off (and 1 more model)",
    ]


def test_many_single_models_are_counted():
    said = [f"model {k}: x" for k in range(1, 41, 2)]
    assert gathered(said) == ["models 1, 3, 5, 7, 9, 11, and 14 more: x"]


def test_the_same_of_many_loops_is_said_once_with_their_places():
    said = [f"a.pdb: {chain}.C5–{chain}.G10: irregular" for chain in "ABCDE"]
    assert gathered(said) == [
        "a.pdb: A.C5–A.G10, B.C5–B.G10, C.C5–C.G10 and 2 more places: irregular"
    ]


def test_the_same_of_many_files_is_said_once():
    said = [f"{k}.pdb: no hairpin loop found" for k in range(20)]
    assert gathered(said) == ["0.pdb, 1.pdb, 2.pdb and 17 more files: no hairpin loop found"]


@pytest.mark.parametrize(
    "said",
    [
        [],
        ["a: b", "c: d", "no colon at all"],
        ["a.pdb: the file cannot be read (x)", "a.pdb: A.6: far", "b.pdb: A.7: near"],
        # the cause behind a second colon belongs to other words
        ["a.pdb: no frame at all: x", "a.pdb: no line at all: x"],
        ["a model 2: the second part", "https://files.rcsb.org/x"],
    ],
)
def test_sentences_that_differ_stay_as_they_are(said):
    assert gathered(said) == said


def test_what_is_said_twice_is_shown_once():
    assert gathered(["a: b", "a: b"]) == ["a: b"]
