"""From files of designs to nucleotides in space, and back to files."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import helix_designs as designs
import numpy as np
import pytest
import strands as made

import loopelastica as le
from loopelastica._files import OutputError
from loopelastica.errors import StructureError
from loopelastica.nanostructures.laying.laid import Conflict
from loopelastica.nanostructures.nanostructure import STRAND_COLUMNS, nanostructure
from loopelastica.nanostructures.oxdna.files import read_oxdna
from loopelastica.nanostructures.scadnano.reading import read_design


@pytest.fixture
def hairpin(tmp_path):
    return designs.write(designs.hairpin(6), tmp_path)


@pytest.fixture
def far(tmp_path):
    """Two helices that two nucleotides cannot join."""
    return designs.write(designs.linker(2, apart=3), tmp_path)


def oxdna_pair(system, place):
    """Files of a system as other programs write them: other digits, velocities, 3' end first."""
    n = len(system)
    rows = np.concatenate([system.centre, system.a1, system.a3], axis=1)[::-1]
    lines = ["t = 5000", "b = 60.0 60.0 60.0", "E = -1.25 -1.5 0.25"]
    for k, row in enumerate(rows.tolist()):
        lines.append("  ".join(f"{x:+.15e}" for x in row) + f" {k} 0.5 -0.25 1e-3 0 1")
    back = n - 1 - np.arange(n)
    columns = []
    for i in back.tolist():
        three, five = (-1 if x < 0 else n - 1 - x for x in (system.n3[i], system.n5[i]))
        columns.append(f"{system.strand[i] + 1} {system.base[i]} {three} {five}")
    place.with_suffix(".dat").write_text("\n".join(lines) + "\n")
    head = f"{n} {len(system.strand_name)}"
    place.with_suffix(".top").write_text("\n".join([head, *columns]) + "\n")
    return place.with_suffix(".top")


def linked():
    """A design of two helices and a linker, with bases and all places."""
    return designs.linker(12)


def lines_of(path):
    return Path(path).read_text().splitlines()


def test_a_design_gets_a_place_for_every_nucleotide(hairpin):
    found = nanostructure(hairpin)
    assert [(s.kind, s.status, len(s)) for s in found.strands] == [("hairpin", "laid", 6)]
    assert found.system.placed.all()
    assert np.isfinite(found.system.centre).all()
    assert found.check().sound, found.check().sentences()
    assert repr(found) == (
        f"<Nanostructure {hairpin}: 30 nucleotides, 1 single strands laid, 0 refused>"
    )


def test_what_is_paired_stays_where_the_design_draws_it(tmp_path):
    file = designs.write(linked(), tmp_path)
    before, after = read_design(file).system, nanostructure(file).system
    paired = before.pair >= 0
    for name in ("centre", "a1", "a3"):
        np.testing.assert_array_equal(getattr(before, name)[paired], getattr(after, name)[paired])


def test_a_row_says_what_a_strand_is_and_where(tmp_path):
    file = designs.write(linked(), tmp_path)
    found = nanostructure(file)
    (row,) = found.records()
    assert tuple(row) == ("file", *STRAND_COLUMNS)
    assert row["kind"] == "linker"
    assert row["drawn"] == "loopout"
    assert row["before"] == "helix 0, offset 19"
    assert row["after"] == "helix 1, offset 19"
    assert (row["nucleotides"], row["sequence"]) == (12, "T" * 12)
    assert (row["status"], row["reason"]) == ("laid", None)
    assert 0.5064 < row["spacing_nm"] / 0.8518 < 1.0064
    np.testing.assert_allclose(row["length_nm"], 13 * row["spacing_nm"], rtol=1e-3)


def test_rows_become_a_table_of_pandas(tmp_path):
    pytest.importorskip("pandas")
    table = le.to_dataframe(nanostructure(designs.write(linked(), tmp_path)))
    assert list(table.columns) == ["file", *STRAND_COLUMNS]
    assert table["kind"].tolist() == ["linker"]


@pytest.mark.parametrize("form", ["old", "new"])
@pytest.mark.parametrize("which", ["hairpin", "linker"])
def test_paired_nucleotides_of_oxdna_files_keep_their_lines_to_the_byte(tmp_path, which, form):
    design = {"hairpin": designs.hairpin(7), "linker": linked()}[which]
    placed = nanostructure(designs.write(design, tmp_path)).system
    topology = oxdna_pair(placed, tmp_path / "given")
    found = nanostructure(topology)
    found.write(tmp_path / "out", form=form)
    given = lines_of(tmp_path / "given.dat")[3:]
    written = lines_of(tmp_path / "out" / "given.dat")[3:]
    paired = found.system.pair >= 0
    assert paired.sum() == (placed.pair >= 0).sum()
    assert len(written) == len(given) == len(placed)
    if form == "new":
        # that form lists strands from 5' to 3', and the given files from 3' to 5'
        again = read_oxdna(tmp_path / "out" / "given.top")
        assert again.form == "new"
        kept = [line for line in written if line in set(given)]
        expected = {line for line, pair in zip(given, paired, strict=True) if pair}
        assert expected <= set(kept)
        np.testing.assert_array_equal(
            again.system.pair >= 0, [line in expected for line in written]
        )
    else:
        for old, new, pair in zip(given, written, paired, strict=True):
            assert not pair or new == old
        assert lines_of(tmp_path / "out" / "given.top") == lines_of(topology)
    # what was laid keeps its velocities
    assert sorted(line.split()[9:] for line in written) == sorted(
        line.split()[9:] for line in given
    )


def test_the_new_form_of_a_design_is_one_line_per_strand(hairpin, tmp_path):
    nanostructure(hairpin).write(tmp_path / "out", form="new")
    head, *strands = lines_of(tmp_path / "out" / "design.top")
    assert head == "30 1 5->3"
    assert len(strands) == 1
    again = read_oxdna(tmp_path / "out" / "design.top").system
    assert (again.pair >= 0).sum() == 24


def test_what_cannot_be_spanned_is_refused_by_name(far):
    found = nanostructure(far)
    (strand,) = found.refused
    for words in (
        "helix 0, offset 19",
        "helix 3, offset 19",
        "2 nucleotides",
        "nm",
        "would suffice",
    ):
        assert words in strand.reason
    assert "1 refused" in repr(found)


def test_nothing_is_written_of_a_design_with_a_refused_strand(far, tmp_path):
    found = nanostructure(far)
    for name in ("out", "one.dat", "one.cif"):
        with pytest.raises(StructureError, match=r"nothing is written.*would suffice"):
            found.write(tmp_path / name)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["design.sc"]


def test_a_folder_gets_files_for_oxdna_and_for_viewers(hairpin, tmp_path):
    out = tmp_path / "out"
    assert nanostructure(hairpin, sample=2, seed=3).write(out) == out
    suffixes = (".cif", ".dat", ".json", ".oxview", ".pdb", ".pml", ".top")
    expected = {f"design{suffix}" for suffix in suffixes}
    expected |= {"design_sample1.dat", "design_sample2.dat"}
    assert {path.name for path in out.iterdir()} == expected
    for name in ("design_sample1.dat", "design_sample2.dat"):
        read_oxdna(out / "design.top", out / name)
    first, second = (lines_of(out / f"design_sample{k}.dat") for k in (1, 2))
    assert first != second


def test_names_of_files_say_what_is_written(hairpin, tmp_path):
    found = nanostructure(hairpin)
    found.write(tmp_path / "a.dat")
    found.write(str(tmp_path / "b.pdb"))
    found.write(tmp_path / "c.cif")
    found.write(tmp_path / "d.conf")
    found.write(tmp_path / "e.mmcif")
    found.write(tmp_path / "f.oxview")
    written = {path.name for path in tmp_path.iterdir() if path.is_file()} - {"design.sc"}
    pairs = {"a.top", "a.dat", "d.top", "d.conf"}
    assert written == pairs | {"b.pdb", "c.cif", "e.mmcif", "f.oxview"}
    assert (tmp_path / "d.conf").read_bytes() == (tmp_path / "a.dat").read_bytes()


@pytest.mark.parametrize("name", ["", " ", None, 3])
def test_a_name_that_is_none_is_refused_and_nothing_written(hairpin, tmp_path, monkeypatch, name):
    found = nanostructure(hairpin)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ValueError, match=r"`path` is .*; it must be the name of a file"):
        found.write(name)
    assert [path.name for path in tmp_path.iterdir()] == ["design.sc"]


@pytest.mark.parametrize("taken", ["a.top", "a.dat"])
def test_of_a_pair_both_files_are_written_or_none(hairpin, tmp_path, taken):
    (tmp_path / taken).mkdir()
    with pytest.raises(OutputError, match=f"{taken}: this is a folder"):
        nanostructure(hairpin).write(tmp_path / "a.top")
    assert {path.name for path in tmp_path.iterdir()} == {"design.sc", taken}


@pytest.mark.parametrize("name", ["given.dat", "given.top", "."])
def test_an_input_is_not_written_over(tmp_path, name):
    topology = oxdna_pair(made.hairpin("GCGTAC", "TTTTTT"), tmp_path / "given")
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    with pytest.raises(OutputError, match="this is the input, which is not written over"):
        nanostructure(topology).write(tmp_path / name)
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_an_unknown_form_is_refused_in_one_sentence(hairpin, tmp_path):
    with pytest.raises(ValueError, match=r"`form` is 'newer'; it must be 'old' or 'new'"):
        nanostructure(hairpin).write(tmp_path / "out", form="newer")


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"tails": "curly"}, "`tails`"),
        ({"pairs": "luck"}, "`pairs`"),
        ({"sample": -1}, "`sample`"),
        ({"seed": 0.5}, "`seed`"),
        ({"persistence_length_nm": 0}, "`persistence_length_nm`"),
        ({"other": ""}, "`other`"),
    ],
)
def test_an_option_out_of_range_is_named(hairpin, options, said):
    with pytest.raises(ValueError, match=said):
        nanostructure(hairpin, **options)


def test_a_design_without_single_strands_says_so(tmp_path):
    found = nanostructure(designs.write(designs.duplex(), tmp_path))
    assert found.strands == ()
    assert "no single strand; every nucleotide has a partner" in list(found.notes)


def test_many_notes_of_one_kind_are_one(tmp_path):
    found = nanostructure(designs.write(designs.hairpins(5, loop=40), tmp_path))
    coils = [note for note in found.notes if "random coil" in note]
    assert len(coils) == 1
    assert coils[0].startswith("5 single strands")


def test_samples_in_conflict_are_counted_and_the_first_is_named(hairpin):
    found = nanostructure(hairpin, sample=3)
    assert not any("samples" in note for note in found.notes)
    clash = Conflict(first=12, second=3, distance=0.3, energy=9.0, sentence="one hits the other")
    one, *others = found.samples
    crowded = [replace(sample, conflicts=(clash, clash)) for sample in others]
    (note,) = (note for note in replace(found, samples=(one, *crowded)).notes if "samples" in note)
    assert note.startswith("2 of 3 samples with conflicts; the first, of sample 2: one hits")


def without(bases, instead, topology):
    text = topology.read_text()
    topology.write_text("".join(instead if c in bases else c for c in text))


def test_pairs_of_bases_that_do_not_fit_are_found_by_geometry(tmp_path):
    topology = oxdna_pair(made.hairpin("GCGCGC", "TTTTTA"), tmp_path / "given")
    without("CG", "C", topology)
    none = nanostructure(topology)
    assert (none.system.pair >= 0).sum() == 0
    (note,) = (note for note in none.notes if "no base pair was found" in note)
    assert note.endswith("the option pairs=geometry would take any bases")
    found = nanostructure(topology, pairs="geometry")
    assert (found.system.pair >= 0).sum() == 12
    assert not any("pair" in note for note in found.notes)


def test_pairs_of_a_file_without_sequences_are_found_and_it_is_said_how(tmp_path):
    topology = oxdna_pair(made.hairpin("GCGTAC", "TTTTTT"), tmp_path / "given")
    without("ACG", "T", topology)
    found = nanostructure(topology)
    assert (found.system.pair >= 0).sum() == 12
    assert any(note.endswith("its pairs were found by geometry") for note in found.notes)
    (strand,) = found.strands
    assert (strand.kind, len(strand)) == ("hairpin", 6)


def test_a_strand_of_one_base_is_paired_with_nothing_and_stays(tmp_path):
    centre = np.arange(8)[:, None] * np.array([0.0, 0.0, 0.7])
    a1, a3 = np.tile([1.0, 0, 0], (8, 1)), np.tile([0, 0, 1.0], (8, 1))
    topology = oxdna_pair(made.system_of([("T" * 8, centre, a1, a3)]), tmp_path / "given")
    found = nanostructure(topology)
    assert (found.system.pair < 0).all()
    assert any(note.endswith("every nucleotide stays where it is") for note in found.notes)
    found.write(tmp_path / "out.top")
    assert lines_of(tmp_path / "out.dat") == lines_of(tmp_path / "given.dat")


def test_the_record_names_inputs_options_strands_and_checks(hairpin, tmp_path):
    nanostructure(hairpin).write(tmp_path)
    record = json.loads((tmp_path / "design.json").read_text())
    assert record["status"] == "written"
    assert [one["file"] for one in record["inputs"]] == ["design.sc"]
    assert len(record["inputs"][0]["sha256"]) == 64
    assert record["parameters"]["tails"] == "straight"
    assert record["checks"]["sound"] is True
    assert record["checks"]["bond_window"] == [0.5064, 1.0064]
    low, high = record["checks"]["bonds"]
    assert 0.5064 < low <= high < 1.0064
    assert record["checks"]["closest_centres"] > 0.4
    (strand,) = record["strands"]
    # the old form lists a strand from 3' to 5'
    assert strand["lines"] == list(range(17, 11, -1))
    assert set(record["files"]) == {p.name for p in tmp_path.glob("design.*")} - {"design.sc"}


@pytest.mark.parametrize("first", ["", "import loopelastica.nanostructures.oxdna.files"])
def test_the_function_can_be_called_whatever_was_imported_before(hairpin, first):
    code = f"{first}\nimport loopelastica as le\nprint(len(le.nanostructure({str(hairpin)!r})"
    code += ".system))\nfrom loopelastica.nanostructures.oxdna.files import read_oxdna"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "30"
