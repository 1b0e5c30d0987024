"""Which loops of a folder are judged, and which are relatives."""

import shutil

import pytest

import loopelastica as le
from loopelastica._files import data_path
from loopelastica.studies.motifs.corpus import read_corpus

HEAD = "file,entry,chain,closing_5,closing_3,sequence,contact_elsewhere,family,motif\n"


@pytest.fixture
def folder(tmp_path):
    for name in ("2koc.pdb", "9zzz.pdb"):
        shutil.copy(data_path("hairpins/2koc.pdb"), tmp_path / name)
    return tmp_path


def table(folder, *rows, head=HEAD):
    (folder / "loops.csv").write_text(head + "".join(f"{row}\n" for row in rows))
    return folder


def test_without_a_table_relatives_are_those_by_sequence(folder):
    # both files say that they are 2KOC: one entry, one loop of it counts
    (loop,), left_out, failures = read_corpus(folder)
    assert (loop.family, loop.motif, loop.loop) == ("UNCG", "UNCG", "RNA UUCG")
    assert loop.found.shape.source == "2koc A.5-A.10"
    assert (left_out, failures) == ([], [])


def test_a_table_says_entry_family_and_which_loops_count(folder):
    rows = ("2koc.pdb,2koc,A,5,10,CUUCGG,0,7,UNCG", "9zzz.pdb,9zzz,A,5,10,CUUCGG,0,8,")
    found = read_corpus(table(folder, *rows)).loops
    assert [(x.found.entry, x.family, x.motif) for x in found] == [
        ("2koc", "7", "UNCG"),
        ("9zzz", "8", ""),
    ]
    rows = ("2koc.pdb,2koc,A,5,10,CUUCGG,1,7,UNCG", "9zzz.pdb,9zzz,A,5,10,CGAAAG,0,8,")
    loops, left_out, _ = read_corpus(table(folder, *rows))
    assert loops == []
    assert left_out == [
        "2koc.pdb A6-9: it pairs with something else",
        "9zzz.pdb: no such loop is found in it",
    ]


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("name,sequence\nx,y\n", "it has no column file"),
        ("file,length\n2koc.pdb,4\n", "it has no column sequence"),
        ("file,sequence\n", "it has no row"),
        ("", "it has no row"),
        ("file,sequence\n\xff\xfe\n", "this is no table"),
    ],
)
def test_a_table_that_says_nothing_is_refused(folder, text, why):
    (folder / "loops.csv").write_bytes(text.encode("latin-1"))
    with pytest.raises(le.LoopelasticaError, match=rf"loops\.csv: {why}"):
        read_corpus(folder)


def test_a_row_that_is_cut_short_is_no_loop(folder):
    loops, left_out, _ = read_corpus(table(folder, "2koc.pdb", "9zzz.pdb,9zzz,A,5,10,CUUCGG"))
    assert [loop.found.entry for loop in loops] == ["9zzz"]
    assert left_out == ["2koc.pdb: no such loop is found in it"]


def test_a_file_that_cannot_be_read_stops_no_other(folder):
    (folder / "broken.pdb").write_text("nothing\n")
    loops, _, failures = read_corpus(folder)
    assert len(loops) == 1
    assert len(failures) == 1
    assert "broken.pdb: " in failures[0]
