"""Tables of loop shapes: who is related to whom."""

import numpy as np
import pytest
from loop_shapes import found

from loopelastica.folding.shape_table import copies_of, empty_table, joined, rms_A, table_of


def table(*sequences, **more):
    return table_of(len(sequences[0]) - 2, [found(s, **more) for s in sequences])


@pytest.mark.parametrize(
    ("query", "shape", "related"),
    [
        # the same loop, whatever closes it
        ("CGAAG", "CGAAG", True),
        ("CGAAG", "UGAAA", True),
        ("CUUCGG", "GUUCGC", True),
        # up to four nucleotides a substitution makes another loop, and so does another pair more
        ("CGAAG", "CGCAG", False),
        ("CUUCGG", "CUACGG", False),
        # from five on one substitution, closing pair included
        ("GAAAAAC", "GAACAAC", True),
        ("GAAAAAC", "UAAAAAA", True),
        ("GAAAAAC", "GAACCAC", False),
        ("GAAAAAC", "UAACAAC", False),
        ("GAAAAAAC", "GAACAAAC", True),
        ("GAAAAAAC", "GAACCAAC", False),
        # from seven on two
        ("GAAAAAAAC", "GAACACAAC", True),
        ("GAAAAAAAC", "CAACAAAAC", True),
        ("GAAAAAAAC", "CAACACAAC", False),
        ("GAAAAAAAC", "CAAAAAAAG", True),
    ],
)
def test_relatives_by_sequence(query, shape, related):
    assert table(shape).relatives(query).tolist() == [related]
    assert table(query).relatives(shape).tolist() == [related]


def test_thymine_is_uracil_and_kinds_make_no_difference():
    shapes = table("CTTTG", "CUUUG", is_dna=True)
    assert shapes.sequence(0) == "CUUUG"
    assert shapes.relatives("CTTTG").all()
    assert shapes.relatives("cuuug").all()


@pytest.mark.parametrize("ask", ["relatives", "same_loop"])
def test_a_sequence_of_another_length_is_refused(ask):
    with pytest.raises(ValueError, match="`sequence` has 4 letters; loops of 3 nucleotides have 5"):
        getattr(table("CUUUG"), ask)("CUUG")


def test_relatives_agree_with_a_count_letter_by_letter():
    rng = np.random.default_rng(7)
    for n in range(3, 10):
        base = "".join(rng.choice(list("AC"), n + 2))
        others = ["".join(rng.choice(list("AC"), n + 2)) for _ in range(200)]
        most = 2 if n >= 7 else 1 if n >= 5 else 0
        expected = [
            base[1:-1] == other[1:-1]
            or sum(a != b for a, b in zip(base, other, strict=True)) <= most
            for other in others
        ]
        assert table(*others).relatives(base).tolist() == expected


def test_entries_are_compared_in_lower_case():
    shapes = table_of(3, [found("CUUUG", "1abc"), found("CUUUG", "model_3")])
    assert shapes.of_entries(["1ABC", "mine"]).tolist() == [True, False]
    assert shapes.of_entries([]).tolist() == [False, False]


def test_the_same_loop_is_known_by_its_shape():
    loops = [found("CUUUG"), found("CUUUG", bend=0.3), found("CUAUG"), found("CUUUG", seed=1)]
    shapes = table_of(3, loops)
    assert shapes.like(loops[0].shape, 0.05).tolist() == [True, False, False, False]
    far = rms_A(loops[1].shape.nodes_A, loops[0].shape.nodes_A)
    assert shapes.like(loops[0].shape, far + 0.01).tolist() == [True, True, False, False]


def test_copies_are_counted_without_the_closing_pair():
    shapes = table("CUUUG", "GUUUC", "CUAUG", "CUUUG")
    assert shapes.copies.tolist() == [3, 3, 1, 3]
    assert copies_of(shapes.letters[:0]).tolist() == []


def test_a_table_gives_its_shapes_and_parts():
    loops = [found("CUUUG", seed=k, place=f"A.{k}-A.{k + 4}") for k in range(5)]
    shapes = table_of(3, loops)
    part = shapes.take(np.array([3, 1]))
    assert (len(part), part.nucleotides) == (2, 3)
    for row, k in enumerate((3, 1)):
        shape = part.shape(row)
        assert (shape.sequence, shape.is_dna) == ("CUUUG", False)
        assert shape.source == f"1abc A.{k}-A.{k + 4}"
        np.testing.assert_array_equal(shape.steps_A, loops[k].shape.steps_A)
        np.testing.assert_array_equal(shape.end_frame, loops[k].shape.end_frame)
        np.testing.assert_array_equal(part.nodes_A[row], loops[k].shape.nodes_A)
    both = joined([part, shapes])
    assert both.sources.tolist() == [*part.sources, *shapes.sources]
    with pytest.raises(ValueError, match="read-only"):
        shapes.steps_A[0] = 0.0


def test_an_empty_table_answers_everything():
    shapes = empty_table(4)
    assert len(shapes) == 0
    assert shapes.relatives("CUUCGG").shape == shapes.of_entries(["1abc"]).shape == (0,)
    assert shapes.like(found("CUUCGG").shape).shape == (0,)
    assert shapes.nodes_A.shape == (0, 6, 3)
