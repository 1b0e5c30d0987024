"""Which entry a file is."""

import gzip

import pytest

from loopelastica._files import data_path
from loopelastica.molecule.identity import entries_of, entry_of
from loopelastica.molecule.nucleotides import read_structure

HEADER = f"{'HEADER':10}{'RNA':40}01-JAN-20   {{}}\n"


@pytest.mark.parametrize(
    ("name", "entry"),
    [
        ("1zih.pdb", "1zih"),
        ("1ZIH.pdb.gz", "1zih"),
        ("pdb1zih.ent.gz", "1zih"),
        ("1zih_a4.pdb", "1zih"),
        ("1zih-assembly1.cif", "1zih"),
        ("430d.pdb", "430d"),
        ("pdb_00001zih.cif", "1zih"),
        ("pdb_00001234.cif", "1234"),
        # no identifiers: a longer name, dates, numbers
        ("1ziha.pdb", "1ziha"),
        ("2024-05-01.pdb", "2024-05-01"),
        ("2024_b.pdb", "2024_b"),
        ("model_3.pdb", "model_3"),
    ],
)
def test_a_name_begins_with_an_identifier_or_is_one_itself(name, entry, tmp_path):
    (tmp_path / name).write_text("")
    assert entry_of(tmp_path / name) == entry_of(name) == entry


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("mine.pdb", HEADER.format("1ZIH")),
        ("mine.ent", f"REMARK before\r\n{HEADER.format('1zih')}"),
        ("mine.cif", "data_x\n_entry.id   1ZIH\n"),
        ("mine.cif", "data_x\n_entry.id '1zih'\n"),
        ("mine.cif", "data_pdb_00001zih\n_entry.id pdb_00001zih\n"),
    ],
)
def test_what_a_file_says_of_itself_comes_before_its_name(name, text, tmp_path):
    (tmp_path / name).write_text(text)
    assert entries_of(tmp_path / name) == ("1zih", "mine")
    packed = tmp_path / f"{name}.gz"
    packed.write_bytes(gzip.compress(text.encode()))
    assert entry_of(packed) == "1zih"


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("mine.pdb", HEADER.format("XXXX")),
        ("mine.pdb", HEADER.format("")),
        ("mine.cif", "_entry.id model\n"),
        ("mine.cif", "_entry.id 1zihabc\n"),
        ("mine.pdb", ""),
        ("mine.gro", "1ZIH\n"),
    ],
)
def test_a_placeholder_is_no_identifier(name, text, tmp_path):
    (tmp_path / name).write_text(text)
    assert entries_of(tmp_path / name) == ("mine",)


def test_a_structure_and_its_universe_are_the_entry_of_their_file(koc):
    assert entries_of(koc) == ("2koc",)
    assert (
        entries_of(koc.universe)
        == entries_of(koc.universe.atoms[:10])
        == entries_of(read_structure(koc.universe))
    )
    assert entries_of(data_path("hairpins/2koc.pdb")) == ("2koc",)


@pytest.mark.parametrize("source", [None, 3, object()])
def test_what_has_no_file_is_no_entry(source):
    assert (entry_of(source), entries_of(source)) == ("", ())
