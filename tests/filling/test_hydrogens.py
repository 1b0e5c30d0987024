"""Hydrogens of filled structures, and 5' phosphates."""

import gapped
import gemmi
import numpy as np
import pytest
from gemmi import cif

import loopelastica as le

pytest.importorskip("rdkit")

URIDINE = ["H5'", "H5''", "H4'", "H3'", "H2'", "HO2'", "H1'", "H3", "H5", "H6"]
CYTIDINE_3 = [*URIDINE[:4], "HO3'", "H2'", "HO2'", "H1'", "H41", "H42", "H5", "H6"]
REFUSED = (
    "A.G1: its 5' phosphate is refused by Amber's and CHARMM's templates; --no-5-phosphate takes"
    " it off"
)
WITHOUT = (
    "the file's nucleotides have hydrogens and what was built has none, for hydrogens were not"
    " requested"
)


def written(path, tmp_path, **options):
    """A filling and the file that it writes."""
    filling = le.fill(path, **options)
    return filling, filling.write(tmp_path / f"filled{path.suffix}")


def hydrogens(path, model=0):
    """Names of the hydrogens of each nucleotide, by its number and insertion code."""
    found = {}
    for chain in gapped.read(path)[model]:
        for residue in chain:
            names = [atom.name for atom in residue if atom.is_hydrogen()]
            assert len(set(names)) == len(names)
            found[str(residue.seqid)] = names
    return found


def carried(path):
    """Whether every hydrogen is bonded to one heavy atom, and to that alone."""
    for chain in gemmi.read_structure(str(path))[0]:
        heavy = np.array(
            [a.pos.tolist() for residue in chain for a in residue if not a.is_hydrogen()]
        )
        for residue in chain:
            for atom in residue:
                if atom.is_hydrogen():
                    away = np.sort(np.linalg.norm(heavy - atom.pos.tolist(), axis=1))
                    assert 0.9 < away[0] < 1.15, f"{residue} {atom.name}"
                    assert away[1] > 1.5, f"{residue} {atom.name}"
    return True


@pytest.mark.parametrize("kind", ["pdb", "cif"])
def test_every_nucleotide_gets_hydrogens_where_the_file_has_none(tmp_path, kind):
    make = gapped.gapped if kind == "pdb" else gapped.gapped_cif
    path = make(tmp_path / f"a.{kind}", {6, 7})
    filling, out = written(path, tmp_path, hydrogens=True)
    own = hydrogens(out)
    assert [str(k) for k in range(1, 15)] == list(own)
    expected = {"A": 11, "C": 11, "G": 11, "U": 10}
    for k, letter in enumerate(gapped.SEQUENCE, start=1):
        assert len(own[str(k)]) == expected[letter] + (k == 14)
    assert own["6"] == URIDINE
    assert own["14"] == CYTIDINE_3
    # all that was there is as it was
    added = gapped.added_rows(path, out)
    assert len(added) == 40 + sum(map(len, own.values()))
    assert carried(out)
    assert WITHOUT not in filling.remarks


def test_without_the_option_there_are_none(tmp_path):
    filling, out = written(gapped.gapped(tmp_path / "a.pdb", {6, 7}), tmp_path)
    assert not any(hydrogens(out).values())
    assert filling.remarks == ()


def test_what_is_built_alone_gets_hydrogens_where_the_file_has_some(tmp_path):
    path = gapped.gapped(tmp_path / "a.pdb", {6, 7}, hydrogens=True)
    filling, out = written(path, tmp_path, hydrogens=True)
    assert len(gapped.added_rows(path, out)) == 40 + 20
    before, after = hydrogens(path), hydrogens(out)
    assert after.pop("6") == after.pop("7") == URIDINE
    assert after == before
    assert WITHOUT not in filling.remarks


def test_a_file_with_hydrogens_says_that_what_was_built_has_none(tmp_path):
    path = gapped.gapped(tmp_path / "a.pdb", {6, 7}, hydrogens=True)
    filling, out = written(path, tmp_path)
    assert WITHOUT in filling.remarks
    assert WITHOUT in list(filling.notes)
    assert hydrogens(out)["6"] == []


def test_a_file_with_hydrogens_in_which_nothing_is_built_says_nothing(tmp_path):
    path = gapped.gapped(tmp_path / "a.pdb", (), hydrogens=True)
    assert WITHOUT not in le.fill(path).remarks


def test_a_file_without_gaps_gets_hydrogens_too(tmp_path):
    path = gapped.gapped(tmp_path / "a.pdb", ())
    _, out = written(path, tmp_path, hydrogens=True)
    assert all(hydrogens(out).values())
    assert len(gapped.added_rows(path, out)) == sum(map(len, hydrogens(out).values()))
    le.fill(path, hydrogens=True).write(tmp_path / "folder")
    assert (tmp_path / "folder" / "filled.pdb").read_text() == out.read_text()


def test_a_whole_file_with_hydrogens_stays_as_it_is(tmp_path):
    path = gapped.gapped(tmp_path / "a.pdb", (), hydrogens=True)
    filling, out = written(path, tmp_path, hydrogens=True)
    assert out.read_text() == path.read_text()
    assert REFUSED in filling.remarks


def test_a_completed_nucleotide_gets_the_hydrogens_that_it_lacks(tmp_path):
    gone = {(11, "N3"), (11, "C4"), (11, "O4"), (11, "C5"), (11, "H5"), (11, "H6"), (6, "P")}
    path = gapped.gapped(tmp_path / "a.pdb", gone, hydrogens=True)
    before = hydrogens(path)
    _, out = written(path, tmp_path, hydrogens=True)
    after = hydrogens(out)
    # its own H3 was carried by an atom that was not there
    assert sorted(after.pop("11")) == sorted([*set(before.pop("11")) | {"H5", "H6"}])
    assert after == before


def test_one_candidate_after_the_other_gets_its_hydrogens(tmp_path):
    path = gapped.gapped(tmp_path / "a.pdb", {4, 5, 6, 7, 8, 9, 10})
    filling = le.fill(path, hydrogens=True, candidates=3)
    filling.write(tmp_path / "out")
    places = []
    for name in ("filled.pdb", "filled_2.pdb"):
        out = tmp_path / "out" / name
        assert len(hydrogens(out)["6"]) == 10
        places.append([a.pos.tolist() for a in gapped.read(out)[0]["A"]["6"][0]])
    assert np.abs(np.subtract(*places)).max() > 0.1


def test_hydrogens_at_what_ends_a_chain_no_more_go(tmp_path):
    lines = gapped.chain({6, 7}, hydrogens=True)
    c3, o3 = (
        next(line for line in lines if line[12:16] == f" {name}" and line[22:26] == "   5")
        for name in ("C3'", "O3'")
    )
    carbon, oxygen = (np.array([float(line[i : i + 8]) for i in (30, 38, 46)]) for line in (c3, o3))
    x, y, z = oxygen + 0.96 * (oxygen - carbon) / np.linalg.norm(oxygen - carbon)
    cap = f"{o3[:12]}HO3'{o3[16:30]}{x:8.3f}{y:8.3f}{z:8.3f}{o3[54:76]} H  "
    lines.insert(lines.index(o3) + 1, cap)
    path = gapped.pdb(tmp_path / "a.pdb", lines, head=gapped.seqres())
    assert "HO3'" in hydrogens(path)["5"]
    for options in ({}, {"hydrogens": True}):
        _, out = written(path, tmp_path, **options)
        assert "HO3'" not in hydrogens(out)["5"]
        assert "HO3'" in hydrogens(out)["14"]


def test_repaired_nucleotides_get_their_hydrogens_back(tmp_path):
    lines = gapped.chain(hydrogens=True)
    moved = []
    for line in lines:
        if line[22:26] == "   8" and line[12:16].strip() in ("P", "OP1", "OP2", "O5'"):
            line = f"{line[:30]}{float(line[30:38]) + 2.5:8.3f}{line[38:]}"
        moved.append(line)
    path = gapped.pdb(tmp_path / "a.pdb", moved, head=gapped.seqres())
    filling, out = written(path, tmp_path, repair=True, hydrogens=True)
    assert filling.repaired
    before, after = hydrogens(path), hydrogens(out)
    assert {k: sorted(names) for k, names in after.items()} == {
        k: sorted(names) for k, names in before.items()
    }
    _, without = written(path, tmp_path, repair=True)
    assert len(hydrogens(without)["8"]) < len(before["8"])


def test_models_are_judged_one_by_one(tmp_path):
    models = [gapped.chain(hydrogens=True), gapped.chain({6, 7}, model=2)]
    path = gapped.pdb(tmp_path / "a.pdb", *models, head=gapped.seqres())
    filling, out = written(path, tmp_path, hydrogens=True)
    assert hydrogens(out) == hydrogens(path)
    assert all(hydrogens(out, model=1).values())
    assert filling.remarks == (REFUSED,)
    assert le.fill(path).remarks == ()


def test_a_remark_names_the_model_that_it_is_about(tmp_path):
    models = [gapped.chain(), gapped.chain({6, 7}, model=2, hydrogens=True)]
    path = gapped.pdb(tmp_path / "a.pdb", *models, head=gapped.seqres())
    assert le.fill(path).remarks == (f"model 2: {WITHOUT}",)


def test_a_5_phosphate_is_named_with_hydrogens_only(tmp_path):
    path = gapped.gapped(tmp_path / "a.pdb", {6, 7})
    assert le.fill(path).remarks == ()
    assert le.fill(path, hydrogens=True).remarks == (REFUSED,)


@pytest.mark.parametrize("kind", ["pdb", "cif"])
def test_a_5_phosphate_goes_by_its_option_alone(tmp_path, kind):
    make = gapped.gapped if kind == "pdb" else gapped.gapped_cif
    path = make(tmp_path / f"a.{kind}", {6, 7})
    filling, out = written(path, tmp_path, no_5_phosphate=True)
    assert filling.remarks == ()
    first, second = list(gapped.neighbours(gapped.read(out)))[:2]
    assert {atom.name for atom in first} & {"P", "OP1", "OP2", "OP3"} == set()
    assert "O5'" in first
    assert "P" in second
    assert len(gapped.rows_of(out)) == len(gapped.rows_of(path)) + 40 - 4


def test_without_its_phosphate_a_chain_begins_with_a_hydrogen(tmp_path):
    for with_hydrogens in (False, True):
        path = gapped.gapped(tmp_path / "a.pdb", {6, 7}, hydrogens=with_hydrogens)
        _, out = written(path, tmp_path, hydrogens=True, no_5_phosphate=True)
        assert hydrogens(out)["1"][-1] == "HO5'"
        assert carried(out)


def test_an_unknown_nucleotide_is_named(tmp_path):
    path = gapped.gapped(tmp_path / "a.pdb", {6, 7})
    text = path.read_text().replace("  A A   4", "XQZ A   4").replace("C   A   C", "C XQZ   C")
    path.write_text(text)
    filling, out = written(path, tmp_path, hydrogens=True)
    assert "A.XQZ4: XQZ is not in the table of hydrogens; it gets none" in filling.remarks
    assert hydrogens(out)["4"] == []
    assert hydrogens(out)["3"]


@pytest.mark.parametrize(
    ("n", "rest"),
    [
        (3, ()),
        (4, ("1 more nucleotide does not get all hydrogens",)),
        (6, ("3 more nucleotides do not get all hydrogens",)),
    ],
)
def test_many_nucleotides_without_all_hydrogens_are_counted(tmp_path, n, rest):
    path = gapped.gapped(tmp_path / "a.pdb", ())
    lines = path.read_text().splitlines()
    unknown = {f"{k:4d}" for k in range(4, 4 + n)}
    for k, line in enumerate(lines):
        if line.startswith("ATOM") and line[22:26] in unknown:
            lines[k] = f"{line[:17]}XQZ{line[20:]}"
    path.write_text("\n".join(line for line in lines if not line.startswith("SEQRES")))
    remarks = le.fill(path, hydrogens=True, no_5_phosphate=True).remarks
    named = [one for one in remarks if "XQZ is not in the table of hydrogens" in one]
    assert len(named) == 3
    assert remarks[-len(rest) :] == rest if rest else remarks[-1] == named[-1]


def test_old_names_of_atoms_stay_in_their_spelling(tmp_path):
    path = gapped.gapped(tmp_path / "a.pdb", {6, 7})
    path.write_text(path.read_text().replace("'", "*").replace("OP1", "O1P").replace("OP2", "O2P"))
    _, out = written(path, tmp_path, hydrogens=True, no_5_phosphate=True)
    names = hydrogens(out)
    assert names["1"][-1] == "HO5*"
    assert len(names["2"]) == 11
    assert carried(out)


def test_the_file_says_so(tmp_path):
    _, out = written(gapped.gapped(tmp_path / "a.pdb", {6, 7}), tmp_path, hydrogens=True)
    said = " ".join(
        line[11:].strip() for line in out.read_text().splitlines() if line.startswith("REMARK  99")
    )
    assert "Hydrogens stand at ideal lengths and angles" in said
    # hydrogens of the file's own nucleotides are marked as modelled
    rows = [line for line in out.read_text().splitlines() if line[76:78] == " H"]
    assert {row[54:60] for row in rows} == {"  0.01"}


def test_serial_numbers_and_identifiers_are_unique(tmp_path):
    _, out = written(gapped.gapped(tmp_path / "a.pdb", {6, 7}), tmp_path, hydrogens=True)
    serials = [line[6:11] for line in out.read_text().splitlines() if line.startswith("ATOM")]
    assert len(set(serials)) == len(serials)
    _, out = written(gapped.gapped_cif(tmp_path / "a.cif", {6, 7}), tmp_path, hydrogens=True)
    block = cif.read_string(out.read_text()).sole_block()
    ids = list(block.find_values("_atom_site.id"))
    assert len(set(ids)) == len(ids)
    symbols = set(block.find_values("_atom_site.type_symbol"))
    assert symbols == {"C", "H", "N", "O", "P"}


def test_openmm_accepts_what_is_written(tmp_path):
    app = pytest.importorskip("openmm.app")
    path = gapped.gapped(tmp_path / "a.pdb", {6, 7})
    _, out = written(path, tmp_path, hydrogens=True, no_5_phosphate=True)
    pdb = app.PDBFile(str(out))
    system = app.ForceField("amber14/RNA.OL3.xml").createSystem(pdb.topology)
    assert system.getNumParticles() == pdb.topology.getNumAtoms()
    _, out = written(path, tmp_path, hydrogens=True)
    with pytest.raises(ValueError, match="No template found for residue 0"):
        app.ForceField("amber14/RNA.OL3.xml").createSystem(app.PDBFile(str(out)).topology)


@pytest.mark.parametrize("name", ["hydrogens", "no_5_phosphate"])
def test_what_is_no_truth_value_is_refused(tmp_path, name):
    path = gapped.gapped(tmp_path / "a.pdb", {6, 7})
    with pytest.raises(ValueError, match=f"`{name}` is 'yes'; it must be True or False"):
        le.fill(path, **{name: "yes"})


def test_a_universe_gets_hydrogens_too(tmp_path):
    import MDAnalysis as mda

    path = gapped.gapped(tmp_path / "a.pdb", {6, 7})
    universe = mda.Universe(str(path))
    filling = le.fill(universe, strands="A.6-7=UU", hydrogens=True, no_5_phosphate=True)
    out = filling.write(tmp_path / "b.pdb")
    assert len(hydrogens(out)["6"]) == 10
    assert all(hydrogens(out).values())
