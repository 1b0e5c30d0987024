"""Strands with the shapes of a library's hairpin loops."""

import gapped
import MDAnalysis
import numpy as np
import pytest

import loopelastica as le
from loopelastica._files import data_path
from loopelastica.errors import LoopelasticaError
from loopelastica.filling.folder import record_of
from loopelastica.filling.options import FillOptions
from loopelastica.folding.known import library_at
from loopelastica.molecule.templates import monomer_of
from loopelastica.molecule.trace import rmsd_A

pytest.importorskip("rdkit")

LIBRARY = str(data_path("loops.lib"))
ROD = "rod in its surroundings"


def same(sequence="CUUCGG", without=()):
    """How many loops of a sequence the library has, but for those of some entries."""
    table = library_at(LIBRARY).of_length(len(sequence) - 2, False)
    return int((table.same_loop(sequence) & ~table.of_entries(without)).sum())


@pytest.fixture
def open_loop(tmp_path):
    """2KOC without its loop, UUCG."""
    return gapped.gapped(tmp_path / "open.pdb", {6, 7, 8, 9})


@pytest.fixture(scope="module")
def native(koc):
    """Centroids of the backbone of that loop."""
    rows = (monomer_of(koc.nucleotides, row, koc.positions(0)) for row in range(5, 9))
    return np.array([monomer.backbone_A.mean(axis=0) for monomer in rows])


def shapes(strand):
    return [candidate.shape for candidate in strand.candidates]


def test_a_gap_gets_the_mean_over_its_sequence(open_loop, native):
    (plain,) = le.fill(open_loop).strands
    (strand,) = le.fill(open_loop, library=LIBRARY).strands
    assert strand.sound
    assert strand.shape == f"motif UNCG, same sequence, {same()} loops"
    assert strand.candidates[0].trace.shape == (4, 3)
    assert rmsd_A(strand.candidates[0].trace, native) < 0.8
    assert rmsd_A(strand.candidates[0].trace, native) < 0.6 * rmsd_A(
        plain.candidates[0].trace, native
    )
    low, middle, high = strand.expected_rmsd_A
    assert 0 < low < middle < high
    assert middle < plain.expected_rmsd_A[1]


def test_without_a_library_nothing_is_as_it_would_be_with_one(open_loop):
    (strand,) = le.fill(open_loop, candidates=3).strands
    assert set(shapes(strand)) == {ROD}
    assert FillOptions().library is None


def test_the_chain_is_sound_and_nothing_else_changes(open_loop, tmp_path):
    out = le.fill(open_loop, library=LIBRARY).write(tmp_path / "filled.pdb")
    gapped.check_chain(gapped.read(out))
    gapped.added_rows(open_loop, out)
    assert "motif UNCG, same sequence" in out.read_text()


def test_a_motif_counts_for_a_sequence_that_is_asked_for(open_loop):
    (strand,) = le.fill(open_loop, strands="A.6-9=GAGA", library=LIBRARY).strands
    assert strand.shape.startswith("motif GNRA, ")
    assert strand.sound


def test_any_other_sequence_keeps_its_rod_and_gets_further_candidates(open_loop):
    request = {"strands": "A.6-9=ACAC", "library": LIBRARY}
    (strand,) = le.fill(open_loop, **request).strands
    assert shapes(strand) == [ROD]
    (strand,) = le.fill(open_loop, candidates=4, **request).strands
    sound = [candidate.shape for candidate in strand.candidates if candidate.sound]
    assert sound[0] == ROD
    assert any(shape.startswith("mean of ") for shape in shapes(strand))
    assert any(shape.startswith("library ") for shape in shapes(strand))
    assert [candidate.rank for candidate in strand.candidates] == [1, 2, 3, 4]


def test_candidates_differ(open_loop):
    (strand,) = le.fill(open_loop, library=LIBRARY, candidates=4).strands
    assert shapes(strand)[0].startswith("motif UNCG, same sequence, ")
    assert len(set(shapes(strand))) == 4
    for k, one in enumerate(strand.candidates):
        for other in strand.candidates[:k]:
            assert rmsd_A(one.trace, other.trace) > 0.25


def test_a_template_comes_first(open_loop, tmp_path):
    other = gapped.pdb(tmp_path / "eighth.pdb", gapped.chain(model=8))
    (strand,) = le.fill(open_loop, like=f"{other}:A.5-A.10", library=LIBRARY, candidates=3).strands
    assert shapes(strand)[0] == "like eighth A.5-A.10"
    assert shapes(strand)[1].startswith("motif UNCG, same sequence, ")
    assert shapes(strand)[2] == ROD
    assert strand.remarks == ()


def test_where_a_template_has_no_such_strand_the_library_stands_in(tmp_path):
    other = gapped.pdb(tmp_path / "eighth.pdb", gapped.chain(model=8))
    path = gapped.gapped(tmp_path / "two.pdb", {2, 6, 7, 8, 9})
    first, second = le.fill(path, like=f"{other}:A.1-A.3", library=LIBRARY).strands
    assert first.shape == "like eighth A.1-A.3"
    assert second.shape.startswith("motif UNCG, same sequence, ")


def test_dna_keeps_its_rod(tmp_path):
    path = gapped.gapped(tmp_path / "dna.pdb", {6, 7, 8, 9}, dna=True)
    (strand,) = le.fill(path, library=LIBRARY).strands
    assert (strand.kind, strand.shape) == ("DNA", ROD)


# own entry


def test_nothing_is_filled_with_itself(tmp_path):
    path = gapped.gapped(tmp_path / "2koc.pdb", {6, 7, 8, 9})
    count = same(without=["2koc"])
    assert count < same()
    (strand,) = le.fill(path, library=LIBRARY).strands
    assert strand.shape == f"motif UNCG, same sequence, {count} loops"
    universe = MDAnalysis.Universe(str(path))
    (strand,) = le.fill(universe, strands="A.6-9=UUCG", library=LIBRARY).strands
    assert strand.shape == f"motif UNCG, same sequence, {count} loops"


def test_what_a_file_says_of_itself_counts_too(tmp_path):
    header = f"HEADER    {'RNA':40}01-JAN-01   2KOC"
    path = gapped.pdb(
        tmp_path / "mine.pdb", gapped.chain({6, 7, 8, 9}), head=[header, *gapped.seqres()]
    )
    (strand,) = le.fill(path, library=LIBRARY).strands
    assert strand.shape == f"motif UNCG, same sequence, {same(without=['2koc'])} loops"


# where a library knows nothing


def test_a_strand_that_no_loop_is_like_is_filled_as_usual_and_that_is_said(tmp_path):
    path = gapped.gapped(tmp_path / "two.pdb", {2, 6, 7, 8, 9})
    first, second = le.fill(path, library=LIBRARY).strands
    assert first.shape == ROD
    assert first.remarks == (
        "A.2: the library has no other loop of 1 nucleotide; it is made without the library",
    )
    assert second.shape.startswith("motif UNCG, same sequence, ")
    assert second.remarks == ()


def test_a_strand_of_a_helix_is_filled_as_usual_and_that_is_said(tmp_path):
    path = gapped.gapped(tmp_path / "helix.pdb", {2, 3, 4})
    (plain,) = le.fill(path).strands
    (strand,) = le.fill(path, library=LIBRARY).strands
    assert strand.remarks == (
        "A.2-4: its ends are not like those of a hairpin loop; it is made without the library",
    )
    np.testing.assert_array_equal(strand.candidates[0].trace, plain.candidates[0].trace)
    np.testing.assert_array_equal(strand.expected_rmsd_A, plain.expected_rmsd_A)


# what may be a library


def test_a_folder_of_structures_is_one(tmp_path, open_loop):
    folder = tmp_path / "loops"
    gapped.pdb(folder / "1abc.pdb", gapped.chain(model=8))
    (strand,) = le.fill(open_loop, library=folder).strands
    assert strand.shape == "motif UNCG, same sequence, 1 loop"


@pytest.mark.parametrize(
    ("content", "fragment"),
    [(None, "no such file"), ("ATOM", "library")],
    ids=["absent", "no library"],
)
def test_a_file_that_is_none_is_refused_by_its_name(tmp_path, open_loop, content, fragment):
    path = tmp_path / "some.lib"
    if content is not None:
        path.write_text(content)
    with pytest.raises(LoopelasticaError, match=r"some\.lib") as caught:
        le.fill(open_loop, library=path)
    assert fragment in str(caught.value)


def test_a_folder_without_a_loop_is_refused_by_its_name(tmp_path, open_loop):
    (tmp_path / "empty").mkdir()
    with pytest.raises(LoopelasticaError, match="empty"):
        le.fill(open_loop, library=tmp_path / "empty")


@pytest.mark.parametrize("library", ["", 3, b"loops.lib", True])
def test_what_is_no_name_is_refused(open_loop, library):
    with pytest.raises(ValueError, match="`library` is"):
        le.fill(open_loop, library=library)


# wherever


def test_the_same_file_has_the_same_answer_in_another_place(tmp_path, open_loop):
    (here,) = le.fill(open_loop, library=LIBRARY).strands
    (again,) = le.fill(open_loop, library=LIBRARY).strands
    np.testing.assert_array_equal(here.candidates[0].trace, again.candidates[0].trace)
    path = gapped.gapped(tmp_path / "moved.pdb", {6, 7, 8, 9}, moved=30.0)
    (there,) = le.fill(path, library=LIBRARY).strands
    assert there.shape == here.shape
    np.testing.assert_allclose(
        there.candidates[0].trace, here.candidates[0].trace + 30.0, atol=1e-2
    )


def test_what_the_record_says(open_loop):
    record = record_of(le.fill(open_loop, library=LIBRARY))
    assert record["parameters"]["library"] == LIBRARY
    (candidate,) = record["strands"][0]["candidates"]
    assert candidate["shape"].startswith("motif UNCG, same sequence, ")
    assert candidate["contact_energy_per_A"] is None
    assert candidate["stable"] is True
    assert candidate["residual"] < 1e-6
    assert len(candidate["trace_A"]) == 4
