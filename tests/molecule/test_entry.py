"""Files as their text and gemmi's reading; a Universe as the same."""

from __future__ import annotations

import bz2
import gzip
import subprocess
import sys
import warnings

import gemmi
import numpy as np
import pytest
from chain_files import SEQUENCE, mmcif_sites, seqres

from loopelastica._files import data_path
from loopelastica.errors import StructureError
from loopelastica.molecule.entry import read_entry
from loopelastica.molecule.gaps import find_gaps
from loopelastica.molecule.reading import Limits
from loopelastica.molecule.surroundings import heavy_atoms

KOC = data_path("hairpins/2koc.pdb")


@pytest.fixture
def universe():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import MDAnalysis

        return MDAnalysis.Universe(str(KOC))


def test_the_text_of_a_file_is_kept():
    entry = read_entry(str(KOC))
    assert entry.text == KOC.read_text()
    assert (entry.kind, entry.path, entry.where) == ("pdb", KOC, str(KOC))
    assert read_entry(entry) is entry


@pytest.mark.parametrize(("suffix", "pack"), [(".gz", gzip.compress), (".bz2", bz2.compress)])
def test_compressed_files(tmp_path, lines, suffix, pack):
    text = "\n".join(["data_x", *mmcif_sites(lines()), ""])
    for name, content in (("some.cif", text), ("some.ent", KOC.read_text())):
        path = tmp_path / f"{name}{suffix}"
        path.write_bytes(pack(content.encode()))
        entry = read_entry(path)
        assert entry.text == content
        assert entry.kind == ("mmcif" if name == "some.cif" else "pdb")


def test_line_ends_and_a_byte_order_mark(tmp_path):
    path = tmp_path / "windows.pdb"
    path.write_bytes(b"\xef\xbb\xbf" + KOC.read_bytes().replace(b"\n", b"\r\n"))
    assert read_entry(path).text == KOC.read_text()


@pytest.mark.parametrize(
    ("name", "content", "cause"),
    [
        ("empty.pdb", b"", "empty"),
        ("blank.cif", b"\n \n", "empty"),
        ("page.pdb", b"<html></html>", "no ATOM"),
        ("nothing.cif", b"data_x\n_a.b 1\n", "no atoms"),
        ("noise.cif", bytes(range(256)), "gemmi cannot read"),
        ("two.cif", b"data_x\n_a.b 1\ndata_y\n_a.b 1\n", "gemmi cannot read"),
        ("short.pdb", b"ATOM      1  P     G A   1      -8.886\n", "line 1 is cut short"),
        ("some.gro", b"x", "only PDB and mmCIF"),
        ("cut.pdb.gz", gzip.compress(b"ATOM" * 100, mtime=0)[:-9], "cut short"),
    ],
)
def test_a_bad_file_is_one_sentence(tmp_path, name, content, cause):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(StructureError) as caught:
        read_entry(path)
    sentence = str(caught.value)
    assert sentence.startswith(str(path))
    assert cause in sentence
    assert "\n" not in sentence


def test_absent_file_and_no_source(tmp_path):
    with pytest.raises(StructureError, match="no such file"):
        read_entry(tmp_path / "absent.cif")
    with pytest.raises(ValueError, match="`source` is neither"):
        read_entry(7)


@pytest.mark.parametrize("x", ["     nan", "     inf"])
def test_coordinates_that_are_no_numbers(tmp_path, lines, x):
    records = lines([])
    records[5] = f"{records[5][:30]}{x}{records[5][38:]}"
    path = tmp_path / "nan.pdb"
    path.write_text("\n".join([*records, "END", ""]))
    with pytest.raises(StructureError, match=r"no numbers|no readable|cannot read"):
        read_entry(path)


def test_limits_hold():
    with pytest.raises(StructureError, match="`max_atoms`"):
        read_entry(KOC, Limits(max_atoms=10))
    with pytest.raises(StructureError, match="`max_size_MB`"):
        read_entry(KOC, Limits(max_size_MB=0.01))


def test_a_universe_is_taken_in_its_current_frame(universe, koc):
    universe.trajectory[3]
    entry = read_entry(universe)
    assert (entry.name, entry.path, entry.kind, entry.n_models) == ("universe", None, "pdb", 1)
    assert entry.loaded_from == universe.filename
    mine = np.array([a.pos.tolist() for c in entry.model(0) for r in c for a in r])
    np.testing.assert_allclose(mine, koc.positions(3), atol=6e-4)


def test_a_group_of_atoms_with_a_gap(universe):
    group = universe.select_atoms("not resid 6:9")
    found = find_gaps(read_entry(group), strands="A.6-9=UUCG")
    assert [gap.name for gap in found.gaps] == ["A.6-9"]
    with pytest.raises(StructureError, match="it has no atoms"):
        read_entry(universe.select_atoms("resid 99"))


def test_a_universe_that_no_pdb_file_holds_becomes_mmcif(universe):
    universe.atoms.chainIDs = ["RNA1"] * len(universe.atoms)
    universe.residues.resids = universe.residues.resids + 20_000
    entry = read_entry(universe.select_atoms("not resid 20006:20009"))
    assert entry.kind == "mmcif"
    assert entry.document is not None
    found = find_gaps(entry, strands="RNA1.20006-20009=UUCG")
    assert [gap.name for gap in found.gaps] == ["RNA1.20006-20009"]
    # the same numbers to the third decimal, and no noise behind
    assert gemmi.cif.read_string(entry.text).sole_block().find_values("_atom_site.Cartn_x")


def test_a_universe_without_names_or_coordinates():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import MDAnalysis

        bare = MDAnalysis.Universe.empty(3, trajectory=True)
        without = MDAnalysis.Universe.empty(3)
    with pytest.raises(StructureError, match="the atoms have no names"):
        read_entry(bare)
    with pytest.raises(StructureError, match="it has no coordinates"):
        read_entry(without)


def test_neither_mdanalysis_nor_compiled_code_is_imported(tmp_path, lines):
    path = tmp_path / "gap.pdb"
    path.write_text("\n".join([*seqres(SEQUENCE), *lines(), "END", ""]))
    script = (
        "import sys\n"
        "from loopelastica.molecule.entry import read_entry\n"
        "from loopelastica.molecule.gaps import find_gaps\n"
        "from loopelastica.molecule.surroundings import heavy_atoms\n"
        f"entry = read_entry({str(path)!r})\n"
        "print(find_gaps(entry).gaps[0].name, len(heavy_atoms(entry).name))\n"
        "print([m for m in ('MDAnalysis', 'numba', 'scipy', 'rdkit') if m in sys.modules])\n"
    )
    result = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    n = len(heavy_atoms(read_entry(path)).name)
    assert result.stdout.splitlines() == [f"A.6-9 {n}", "[]"]
