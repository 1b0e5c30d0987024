import gzip

import pytest

from loopelastica.errors import StructureError
from loopelastica.molecule.fasta import read_fasta


def test_entries_come_in_their_order(tmp_path):
    path = tmp_path / "hairpins.fa"
    path.write_bytes(
        b"\xef\xbb\xbf; a comment\r\n>one first of all\r\nGGC\r\n(UUU)GCC\r\n\r\n>\r\n> two\r\nGC"
    )
    entries = read_fasta(path)
    assert entries == [("one", "GGC\n(UUU)GCC"), ("2", ""), ("two", "GC")]
    assert str(entries[0]) == "one"


def test_a_compressed_file_is_read(tmp_path):
    path = tmp_path / "hairpins.fa.gz"
    path.write_bytes(gzip.compress(b">one\nGGC(UUU)GCC\n"))
    assert read_fasta(path) == [("one", "GGC(UUU)GCC")]


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "the file is empty"),
        (b"\n \n", "the file is empty"),
        (b"GGC(UUU)GCC\n", 'line 1: no entry begins here; in a FASTA file a line with ">"'),
        (b">a\n\xff\xfe\n", "this is no text in UTF-8"),
    ],
)
def test_what_is_no_fasta_file_is_refused(tmp_path, content, said):
    path = tmp_path / "hairpins.fa"
    path.write_bytes(content)
    with pytest.raises(StructureError, match=said) as refused:
        read_fasta(path)
    assert str(refused.value).startswith(str(path))


def test_what_is_not_there_is_refused(tmp_path):
    with pytest.raises(StructureError, match="there is no such file"):
        read_fasta(tmp_path / "absent.fa")
    with pytest.raises(StructureError, match="this is a folder"):
        read_fasta(tmp_path)
