"""A library in memory: kinds and lengths, copies."""

import pickle

import numpy as np
import pytest
from loop_shapes import found

from loopelastica.folding.library import Kind, Library
from loopelastica.folding.shape_table import COPY_A, rms_A


@pytest.fixture(scope="module")
def loops():
    return [
        found("CUUCGG", "1abc"),
        found("CUUUG", "2abc"),
        found("CUUUG", "2abc", is_dna=True),
        found("GAAAC", "3abc", bend=0.3),
    ]


def test_shapes_are_kept_by_kind_and_length(loops):
    library = Library.of(loops)
    assert library.counts == {Kind(False, 3): 2, Kind(False, 4): 1, Kind(True, 3): 1}
    assert len(library) == 4
    assert repr(library) == "<Library of 4 loops: RNA3, RNA4, DNA3>"
    assert library.of_length(3, is_dna=False).entries.tolist() == ["2abc", "3abc"]
    assert library.of_length(3, is_dna=True).entries.tolist() == ["2abc"]


def test_both_kinds_come_where_both_are_asked_for(loops):
    both = Library.of(loops).of_length(3)
    assert both.is_dna.tolist() == [False, False, True]
    # a DNA loop is no copy of an RNA loop
    assert both.copies.tolist() == [1, 1, 1]
    np.testing.assert_array_equal(both.steps_A[0], both.steps_A[2])


@pytest.mark.parametrize("is_dna", [None, False, True])
def test_a_length_or_kind_that_is_not_there_is_an_empty_table(loops, is_dna):
    for library in (Library.of(loops), Library.of([])):
        table = library.of_length(9, is_dna)
        assert (len(table), table.nucleotides) == (0, 9)
    assert len(Library.of(loops).of_length(4, is_dna=True)) == 0


@pytest.mark.parametrize("n", [0, -1, 2.5, "3", None])
def test_a_length_is_a_whole_number(loops, n):
    with pytest.raises(ValueError, match=r"^`nucleotides` is "):
        Library.of(loops).of_length(n)


def test_an_empty_library_is_one():
    library = Library.of([])
    assert (len(library), library.counts, list(library.tables())) == (0, {}, [])
    assert repr(library) == "<Library of 0 loops: none>"


def columns(library):
    return [
        getattr(table, name).tolist()
        for _, table in library.tables()
        for name in ("letters", "steps_A", "end_frames", "entries", "sources", "copies")
    ]


def test_the_order_of_loops_changes_nothing(rng):
    loops = [
        found("CUUUG", f"{e}abc", place=f"{c}.1-{c}.5", bend=0.02 * k)
        for e in (1, 2)
        for c in "AB"
        # the same place twice, in two files of one entry
        for k in (*range(8), 7)
    ]
    expected = columns(Library.of(loops))
    for _ in range(5):
        assert columns(Library.of(loops[i] for i in rng.permutation(len(loops)))) == expected


def test_copies_within_an_entry_are_kept_once():
    """Same entry, kind and sequence, and a shape not far off: the first place stays."""
    near, far = 0.05, 0.6
    distance = [
        rms_A(found("CUUUG", bend=bend).shape.nodes_A, found("CUUUG").shape.nodes_A)
        for bend in (near, far)
    ]
    assert distance[0] < COPY_A < distance[1]
    library = Library.of(
        [
            found("CUUUG", place="B.1-B.5", bend=near),
            found("CUUUG", place="A.1-A.5"),
            found("CUUUG", place="C.1-C.5", bend=far),
            found("CUAUG", place="D.1-D.5", bend=near),
            found("CUUUG", "2abc", place="A.1-A.5", bend=near),
            found("CUUUG", is_dna=True, place="E.1-E.5", bend=near),
        ]
    )
    assert library.of_length(3).sources.tolist() == [
        *("1abc D.1-D.5", "1abc A.1-A.5", "1abc C.1-C.5", "2abc A.1-A.5", "1abc E.1-E.5"),
    ]
    assert library.of_length(3).copies.tolist() == [1, 3, 3, 3, 1]


def test_a_library_survives_being_sent_to_another_process(loops):
    library = Library.of(loops)
    assert columns(pickle.loads(pickle.dumps(library))) == columns(library)
