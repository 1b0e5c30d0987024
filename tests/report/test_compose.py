import gzip
import io
import itertools
import random
import warnings

import gemmi
import numpy as np
import pytest
from deletion import draw_strands, put_back, structure_of, without_cif, without_pdb
from gemmi import cif
from hypothesis import given, settings
from hypothesis import strategies as st
from strand import NAMES, added, cif_text, pdb_lines, place_of

from loopelastica._files import data_path
from loopelastica.molecule.nucleotides import read_structure
from loopelastica.report.compose import Changes, Composed, compose, fits_pdb

KOC = data_path("hairpins/2koc.pdb").read_bytes().decode()
GAP = (added(3, 2), added(4, 3))


def _table(text):
    block = cif.read_string(text).sole_block()
    return {name: block.get_mmcif_category(name) for name in block.get_mmcif_category_names()}


def _read(path):
    with gzip.open(path, "rt") as file:
        return file.read()


def _residues(text):
    """Atom records by residue, but for serial number, and charge, which no change has.

    Of one residue in any order: not every program has that of the wwPDB.
    """
    lines = [line for line in text.splitlines() if line.startswith(("ATOM", "HETATM"))]
    records = [line[17:27] + line[:6] + line[11:78] for line in lines]
    return [sorted(group) for _, group in itertools.groupby(records, key=lambda r: r[:10])]


def _bonded(text):
    """Pairs of atoms, by place and name, that CONECT records join."""
    lines = text.splitlines()
    atoms = {x[6:11]: x[12:27] for x in reversed(lines) if x.startswith(("ATOM", "HETATM"))}
    bonds = set()
    for line in lines:
        if line.startswith("CONECT"):
            ends = [line[k : k + 5] for k in range(6, 31, 5) if line[k : k + 5].strip()]
            bonds |= {(atoms[ends[0]], atoms[end]) for end in ends[1:]}
    return bonds


def _same_categories(old, new):
    assert list(new) == list(old)
    for category, columns in old.items():
        assert list(new[category]) == list(columns)
        for name, values in columns.items():
            if category == "_atom_site." and name.startswith(("Cartn", "B_iso", "occupancy")):
                np.testing.assert_allclose(
                    np.array(new[category][name], float), np.array(values, float), atol=6e-3
                )
            elif (category, name) not in {
                ("_atom_site.", "id"),
                ("_atom_site.", "pdbx_formal_charge"),
            }:
                assert new[category][name] == values, (category, name)


# --- nothing changes ------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["pdb", "mmcif"])
def test_without_changes_a_file_comes_back_as_it_is(kind):
    text = (
        "HEADER\r\nATOM, odd\tlines é\n\n" if kind == "pdb" else "data_x\n# a comment\n_a.b 'c'\n"
    )
    assert compose(text, kind, Changes(software=("loopelastica", "1"))) == Composed(text, kind)
    assert compose(text.encode(), kind, Changes()).text == text


def test_a_file_that_is_no_utf8_is_read_all_the_same():
    content = "\n".join(["AUTHOR    J.MÜLLER", *pdb_lines([1, 2, 5])]).encode("latin-1")
    assert compose(content, "pdb", Changes(added=GAP)).text.startswith("AUTHOR    J.MÜLLER\nATOM")


def test_a_mark_of_the_byte_order_does_not_hide_the_first_record():
    text = "\ufeff" + "\n".join(pdb_lines([1, 2, 5]))
    assert compose(text, "pdb", Changes(added=GAP)).text.startswith("ATOM      1  P")


# --- what is taken out and put back ---------------------------------------------------------------


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_atoms_that_are_taken_out_and_put_back_give_the_same_pdb_file(seed):
    rng = random.Random(seed)
    structure = structure_of(KOC, "pdb")
    strands = draw_strands(structure, rng)
    changes = put_back(structure, strands)
    shuffled = list(changes.added)
    rng.shuffle(shuffled)
    composed = compose(without_pdb(KOC, strands), "pdb", Changes(added=tuple(shuffled)))
    assert composed == Composed(KOC, "pdb")


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_they_give_the_same_mmcif_file(seed):
    structure = structure_of(KOC, "pdb")
    del structure[2:]
    structure.setup_entities()
    structure.assign_label_seq_id()
    text = structure.make_mmcif_document().as_string()
    strands = draw_strands(structure, random.Random(seed))
    composed = compose(without_cif(text, strands), "mmcif", put_back(structure, strands))
    _same_categories(_table(text), _table(composed.text))


def test_they_do_so_in_every_second_shown_pdb_file(hairpin_folder):
    seen = 0
    for path in sorted(hairpin_folder.glob("*.pdb.gz"))[::2]:
        text = _read(path)
        if len(text) > 4_000_000:
            continue
        structure = structure_of(text, "pdb")
        strands = draw_strands(structure, random.Random(7))
        cut = without_pdb(text, strands)
        composed = compose(cut, "pdb", put_back(structure, strands))
        assert composed.kind == "pdb"
        assert _residues(composed.text) == _residues(text), path.name
        assert _bonded(composed.text) == _bonded(cut), path.name
        seen += 1
    assert seen > 12


@pytest.mark.slow
def test_they_do_so_in_a_ribosome(hairpin_folder):
    text = _read(hairpin_folder / "1s72.pdb.gz")
    structure = structure_of(text, "pdb")
    strands = draw_strands(structure, random.Random(7), n_strands=20)
    cut = without_pdb(text, strands)
    composed = compose(cut, "pdb", put_back(structure, strands))
    assert _residues(composed.text) == _residues(text)
    assert _bonded(composed.text) == _bonded(cut)


def _check_cif(path):
    text = _read(path)
    structure = structure_of(text, "mmcif")
    strands = draw_strands(structure, random.Random(7))
    if not strands:
        return False
    changes = put_back(structure, strands)
    composed = compose(without_cif(text, strands), "mmcif", changes)
    assert composed.kind == "mmcif"
    _same_categories(_table(text), _table(composed.text))
    return True


def test_atoms_that_are_taken_out_and_put_back_give_the_same_mmcif_file(gap_folder):
    paths = sorted(gap_folder.glob("*.cif.gz"), key=lambda path: path.stat().st_size)[:12]
    assert sum(map(_check_cif, paths)) >= 10


@pytest.mark.slow
def test_they_do_so_in_every_second_shown_mmcif_file(gap_folder):
    assert sum(map(_check_cif, sorted(gap_folder.glob("*.cif.gz"))[::2])) > 25


# --- what reads it --------------------------------------------------------------------------------


def _chain(universe):
    atoms = universe.select_atoms("name O3' P and resname U")
    steps = np.linalg.norm(np.diff(atoms.positions, axis=0), axis=1)
    names = list(atoms.names)
    return [step for step, a in zip(steps, names[:-1], strict=True) if a == "O3'"]


@pytest.mark.parametrize("kind", ["pdb", "mmcif"])
def test_gemmi_mdanalysis_and_rdkit_read_a_filled_strand_in_the_order_of_the_chain(kind, tmp_path):
    import MDAnalysis as mda
    from rdkit import Chem

    number = 0 if kind == "pdb" else 100
    chain = "A" if kind == "pdb" else "X"
    text = "\n".join([*pdb_lines([1, 2, 5, 6]), "TER", "END", ""])
    text = text if kind == "pdb" else cif_text([1, 2, 5, 6])
    gap = [added(k, None, chain=chain) for k in (3, 4)]
    gap = [
        added(
            k + number,
            (chain, k + number - 1, ""),
            chain=chain,
            record=k,
        )
        for k in (3, 4)
    ]
    for residue, k in zip(gap, (3, 4), strict=True):
        object.__setattr__(
            residue, "positions_A", np.array([place_of(k, name) for name in NAMES], float)
        )
    composed = compose(text, kind, Changes(added=tuple(gap)))
    structure = structure_of(composed.text, kind)
    assert [r.seqid.num - number for r in structure[0][chain]] == [1, 2, 3, 4, 5, 6]
    path = tmp_path / f"filled.{'pdb' if kind == 'pdb' else 'cif'}"
    path.write_text(composed.text)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        universe = mda.Universe(str(path))
    assert universe.residues.resids.tolist() == [k + number for k in range(1, 7)]
    np.testing.assert_allclose(_chain(universe), 1.6, atol=1e-3)
    old = [universe.select_atoms(f"resid {k + number}").positions for k in (1, 2, 5, 6)]
    np.testing.assert_allclose(
        np.concatenate(old), [place_of(k, name) for k in (1, 2, 5, 6) for name in NAMES], atol=1e-3
    )
    block = composed.text if kind == "pdb" else structure.make_pdb_string()
    mol = Chem.MolFromPDBBlock(block, sanitize=False, removeHs=False)
    infos = [atom.GetPDBResidueInfo() for atom in mol.GetAtoms()]
    assert [i.GetName().strip() for i in infos] == list(NAMES) * 6
    assert len({i.GetSerialNumber() for i in infos}) == len(infos)


# --- where the PDB format ends --------------------------------------------------------------------


def _numbers(composed):
    structure = structure_of(composed.text, composed.kind)
    return [residue.seqid.num for chain in structure[0] for residue in chain]


@pytest.mark.parametrize(
    "residue",
    [
        added(10000, 2),
        added(-1000, 2),
        added(3, 2, resname="ABCD"),
        added(3, 2, occupancy=1.0, names=("P", "O3'")),
    ],
    ids=["number", "negative number", "residue name", "coordinates"],
)
def test_what_the_pdb_format_cannot_hold_comes_as_mmcif(residue):
    if residue.number == 3 and residue.resname == "U":
        object.__setattr__(residue, "positions_A", residue.positions_A + 1e4)
    text = "\n".join(
        [
            "CRYST1   50.000   50.000   50.000  90.00  90.00  90.00 P 1           1",
            *pdb_lines([1, 2, 5]),
            "END",
            "",
        ]
    )
    changes = Changes(added=(residue,), notes=("Modelled.",))
    assert not fits_pdb(text, changes)
    composed = compose(text, "pdb", changes)
    assert composed.kind == "mmcif"
    assert _numbers(composed) == [1, 2, residue.number, 5]
    table = _table(composed.text)
    assert table["_cell."]["length_a"] == ["50"]
    assert table["_database_PDB_remark."]["text"] == ["Modelled."]
    place = structure_of(composed.text, "mmcif")[0]["A"][2][0].pos.tolist()
    np.testing.assert_allclose(place, residue.positions_A[0], atol=1e-2)


def test_an_mmcif_file_made_of_a_pdb_file_has_no_invented_cell():
    text = "\n".join([*pdb_lines([1, 2, 5]), "END", ""])
    composed = compose(text, "pdb", Changes(added=(added(10000, 2),)))
    assert "_cell." not in _table(composed.text)
    assert "_symmetry." not in _table(composed.text)


@pytest.mark.parametrize(("segment", "chain"), [("", ""), ("RNA1", ""), ("RNA1", "RNA1")])
def test_a_chain_without_a_name_is_called_by_its_segment_at_most(segment, chain, tmp_path):
    lines = [
        f"{x[:21]} {x[22:72]}{other:4}{x[76:]}"
        for other in (segment, "X")
        for x in pdb_lines([1, 2, 5])[: 3 * len(NAMES) if other == segment else 1]
    ]
    gap = (added(10000, 2, chain=chain),)
    composed = compose("\n".join([*lines, "END", ""]), "pdb", Changes(added=gap))
    found = structure_of(composed.text, "mmcif")[0]
    assert [c.name for c in found] == ([chain, "X"] if chain else [""])
    assert [residue.seqid.num for residue in found[0]][:4] == [1, 2, 10000, 5]
    (path := tmp_path / "filled.cif").write_text(composed.text)
    assert read_structure(path).nucleotides.resid.tolist()[:4] == [1, 2, 10000, 5]


@pytest.mark.slow
def test_more_atoms_than_serial_numbers_come_as_mmcif():
    lines = pdb_lines([1, 2, 5])
    waters = [
        f"HETATM{k:5d}  O   HOH B{k % 10000:4d}    {k % 999:8.3f}{100:8.3f}{k / 999:8.3f}"
        "  1.00 20.00           O"
        for k in range(len(lines) + 1, 99_990)
    ]
    text = "\n".join([*lines, *waters, "END", ""])
    assert fits_pdb(text, Changes(added=(added(3, 2),)))
    assert not fits_pdb(text, Changes(added=GAP))
    composed = compose(text, "pdb", Changes(added=GAP))
    assert composed.kind == "mmcif"
    assert len(_table(composed.text)["_atom_site."]["id"]) == 99_989 + 2 * len(NAMES)
    ids = _table(composed.text)["_atom_site."]["id"]
    assert len(set(ids)) == len(ids)


def test_an_mmcif_file_is_read_by_the_package_that_wrote_it(tmp_path):
    path = tmp_path / "filled.cif"
    text = "\n".join([*pdb_lines([1, 2, 5]), "END", ""])
    path.write_text(compose(text, "pdb", Changes(added=(added(10000, 2),))).text)
    assert read_structure(path).nucleotides.resid.tolist() == [1, 2, 10000, 5]


def test_lines_are_those_of_the_file_where_nothing_concerns_them():
    text = KOC
    changes = Changes(moved={(0, "A", 3, "", "P"): np.array([1.0, 2.0, 3.0])})
    old, new = (io.StringIO(t).readlines() for t in (text, compose(text, "pdb", changes).text))
    differ = [(a, b) for a, b in zip(old, new, strict=True) if a != b]
    assert len(differ) == 1
    assert differ[0][1][30:54] == "   1.000   2.000   3.000"
    assert differ[0][0][:30] + differ[0][0][54:] == differ[0][1][:30] + differ[0][1][54:]


def test_gemmi_finds_the_same_entities_as_before():
    composed = compose(
        cif_text([1, 2, 5]),
        "mmcif",
        Changes(added=(added(103, ("X", 102, ""), chain="X", record=3),)),
    )
    block = cif.read_string(composed.text).sole_block()
    (chain,) = gemmi.make_structure_from_block(block)[0]
    assert [r.label_seq for r in chain] == [1, 2, 3, 5]
    assert {r.subchain for r in chain} == {"A"}
    assert {r.entity_id for r in chain} == {"1"}
