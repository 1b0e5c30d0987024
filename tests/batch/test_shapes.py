"""Libraries made of many files."""

import csv
import gzip
import json
import random
import shutil

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import loopelastica as le
from loopelastica._files import TakenError, data_path
from loopelastica.batch import shapes
from loopelastica.batch.shapes import COLUMNS, build_library
from loopelastica.batch.workers import Outcome
from loopelastica.folding.library_file import load_library
from loopelastica.molecule.hairpins import find_hairpins
from loopelastica.molecule.shapes import loop_shape

KOC = data_path("hairpins/2koc.pdb")


def records(lines, chain="A", moved=0.0, change=lambda line: line):
    """Atom records of 2KOC under another chain name, moved along x."""
    made = []
    for line in map(change, lines):
        if line is not None:
            x = float(line[30:38]) + moved
            made.append(f"{line[:21]}{chain}{line[22:30]}{x:8.3f}{line[38:]}")
    return made


@pytest.fixture
def write(koc_lines):
    def write(path, *chains, head=()):
        """A file of chains, each the arguments of `records`."""
        lines = list(head)
        for chain in chains or ({},):
            lines += [*records(koc_lines, **chain), "TER"]
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("\n".join([*lines, "END", ""]))
        return path

    return write


@pytest.fixture
def out(tmp_path):
    return tmp_path / "result" / "loops.lib"


def table(path):
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def reasons(build):
    return [row["left_out"] for row in table(build.table)]


def test_the_shape_of_a_loop_is_that_of_its_file(out, koc):
    build = build_library(KOC, out)
    shapes = load_library(out).of_length(4)
    shape, _ = loop_shape(koc.nucleotides, find_hairpins(koc)[0], koc.positions(0))
    assert (shapes.sequence(0), shapes.sources[0], shapes.entries[0]) == (
        *("CUUCGG", "2koc A.5-A.10", "2koc"),
    )
    np.testing.assert_allclose(shapes.steps_A[0], shape.steps_A, atol=2e-6)
    np.testing.assert_allclose(shapes.end_frames[0], shape.end_frame, atol=2e-7)
    (row,) = table(build.table)
    assert tuple(row) == COLUMNS
    assert (row["file"], row["loop"], row["left_out"]) == (str(KOC), "A6-9", "")
    assert float(row["stem_rms_A"]) == pytest.approx(shapes.stem_rms_A[0], abs=1e-6)
    assert (build.n_files, build.n_resumed, build.failures, build.notes) == (1, 0, (), ())
    assert len(build.library) == 1


def test_a_shape_has_no_place(out, koc_lines, tmp_path):
    turn = Rotation.from_rotvec([0.3, -1.2, 2.0])
    moved = []
    for line in koc_lines:
        place = turn.apply([float(line[c : c + 8]) for c in (30, 38, 46)]) + [10.0, -20.0, 5.0]
        moved.append(line[:30] + "".join(f"{x:8.3f}" for x in place) + line[54:])
    (tmp_path / "moved.pdb").write_text("\n".join([*moved, "END", ""]))
    build_library([KOC, tmp_path / "moved.pdb"], out)
    both = load_library(out).of_length(4)
    assert both.entries.tolist() == ["2koc", "moved"]
    np.testing.assert_allclose(both.steps_A[1], both.steps_A[0], atol=3e-3)
    np.testing.assert_allclose(both.end_frames[1], both.end_frames[0], atol=1e-3)


def test_folders_and_files_of_both_formats_are_taken(out, tmp_path, write, write_cif):
    folder = tmp_path / "in"
    write(folder / "a.pdb")
    write_cif(folder / "b.cif", "B")
    (folder / "deep").mkdir()
    packed = gzip.compress((folder / "b.cif").read_bytes())
    (folder / "deep" / "c.cif.gz").write_bytes(packed)
    (folder / "notes.txt").write_text("no structure")
    build = build_library([folder, str(KOC)], out)
    assert build.library.of_length(4).entries.tolist() == ["2koc", "a", "b", "c"]
    assert build.failures == ()


def test_a_file_that_is_given_twice_counts_once(out, tmp_path, write):
    write(tmp_path / "in" / "a.pdb")
    build = build_library([tmp_path / "in", tmp_path / "in" / "a.pdb"], out)
    assert build.n_files == len(build.library) == 1
    assert "counts once" in build.notes[0]


def test_bad_files_are_rows_and_the_others_go_on(out, tmp_path, write):
    folder = tmp_path / "in"
    write(folder / "a.pdb")
    (folder / "broken.pdb").write_text("nothing\n")
    (folder / "empty.cif").write_text("")
    (folder / "cut.pdb.gz").write_bytes(gzip.compress(KOC.read_bytes())[:5000])
    build = build_library([folder, tmp_path / "absent.pdb"], out)
    assert len(load_library(out)) == 1
    failed = table(out.with_name("loops.lib.run") / "failures.csv")
    assert sorted(row["file"] for row in failed) == sorted(
        str(p) for p in (folder / "broken.pdb", folder / "empty.cif", folder / "cut.pdb.gz",
                         tmp_path / "absent.pdb")
    )  # fmt: skip
    assert {row["failure"] for row in failed} == set(build.failures)
    assert all(row["failure"].startswith(f"{row['file']}: ") for row in failed)
    # they failed, and nobody can say whether they have a loop
    assert build.notes == ()


def test_where_no_loop_is_found_no_library_is_written(out, tmp_path):
    (tmp_path / "broken.pdb").write_text("nothing\n")
    with pytest.raises(le.LoopelasticaError) as error:
        build_library(tmp_path / "broken.pdb", out)
    sentence = str(error.value)
    assert sentence.startswith(f"{out}: no library is written, for there is no loop: {tmp_path}")
    assert not out.exists()
    assert len(table(out.with_name("loops.lib.run") / "failures.csv")) == 1


def without(name, number):
    return lambda line: None if (line[12:16].strip(), int(line[22:26])) == (name, number) else line


def shifted(number, by):
    def change(line):
        if int(line[22:26]) != number:
            return line
        return f"{line[:38]}{float(line[38:46]) + by:8.3f}{line[46:]}"

    return change


def without_backbone(number):
    names = ("P", "O5'", "C5'", "O3'")
    drop = [without(name, number) for name in names]
    return lambda line: None if any(f(line) is None for f in drop) else line


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (without("O5'", 8), "a backbone atom is missing"),
        (without_backbone(5), "a backbone atom is missing"),
        # C4' far from its neighbours, while O3' and P stay bonded
        (
            lambda line: (
                shifted(8, 40.0)(line)
                if line[12:16].strip() in ("C4'", "C5'", "O5'", "C3'")
                else line
            ),
            "its chain is broken or runs into itself",
        ),
    ],
)
def test_a_loop_that_is_not_sound_is_left_out_with_the_reason(out, tmp_path, write, change, reason):
    write(tmp_path / "bad.pdb", {"change": change})
    build = build_library([KOC, tmp_path / "bad.pdb"], out)
    assert reasons(build) == ["", reason]
    assert build.notes == (f"1 loop is left out: {reason}",)
    assert len(build.library) == 1


def test_an_irregular_stem_is_left_out(out, tmp_path, hairpin_folder):
    """1D16: a DNA hairpin in the left-handed form."""
    build = build_library([KOC, hairpin_folder / "1d16.pdb.gz"], out)
    assert reasons(build) == ["", "its stem is no A or B helix"]
    assert len(build.library) == 1


def test_loops_that_pair_elsewhere_come_on_request(out, tmp_path, hairpin_folder):
    """A transfer RNA: its D and T loops meet."""
    trna = hairpin_folder / "1ehz.cif.gz"
    first = build_library(trna, out)
    n_paired = reasons(first).count("it pairs elsewhere")
    assert n_paired > 0
    assert any("`with_contacts` takes such loops" in note for note in first.notes)
    second = build_library(trna, out, with_contacts=True)
    assert second.n_resumed == 0
    assert reasons(second).count("it pairs elsewhere") == 0
    assert len(second.library) == len(first.library) + n_paired


def test_copies_in_one_entry_are_kept_once_across_chains_and_files(out, tmp_path, write):
    chains = [{"chain": "A"}, {"chain": "B", "moved": 60.0}]
    write(tmp_path / "1abc_1.pdb", *chains)
    write(tmp_path / "1abc_2.pdb", {"chain": "C"})
    write(tmp_path / "2abc.pdb")
    build = build_library([tmp_path / f"{n}.pdb" for n in ("1abc_2", "2abc", "1abc_1")], out)
    assert build.library.of_length(4).sources.tolist() == ["1abc A.5-A.10", "2abc A.5-A.10"]
    assert build.library.of_length(4).copies.tolist() == [2, 2]
    assert build.notes == (
        "2 loops are copies of another one of the same entry, within 0.5 Å, and left out",
    )


def test_the_header_says_which_entry_a_file_is(out, tmp_path, write):
    write(tmp_path / "mine.pdb", head=[f"{'HEADER':62}1ABC"])
    assert build_library(tmp_path / "mine.pdb", out).library.of_length(4).entries[0] == "1abc"


def test_dna_is_kept_apart(out, hairpin_folder):
    library = build_library([KOC, hairpin_folder / "1ac7.pdb.gz"], out).library
    assert library.of_length(4, is_dna=True).entries.tolist() == ["1ac7"]
    assert library.of_length(4, is_dna=False).entries.tolist() == ["2koc"]
    assert library.of_length(4, is_dna=True).sequence(0) == "AGUUAU"


@pytest.fixture
def many(tmp_path, koc_lines, write):
    """Ten files of one to three chains, three of them of one entry."""
    rng = np.random.default_rng(5)
    files = []
    for k in range(10):
        entry = "9abc" if k < 3 else f"{k}xyz"
        chains = [{"chain": c, "moved": 60.0 * i, "change": _noise(rng)}
                  for i, c in enumerate("ABC"[: 1 + k % 3])]  # fmt: skip
        files.append(write(tmp_path / "many" / f"{entry}_{k}.pdb", *chains))
    return files


def _noise(rng):
    def change(line):
        place = [float(line[c : c + 8]) + rng.normal(0.0, 0.05) for c in (30, 38, 46)]
        return line[:30] + "".join(f"{x:8.3f}" for x in place) + line[54:]

    return change


def test_the_file_is_the_same_to_the_byte_in_whatever_order(many, tmp_path):
    build_library(many, tmp_path / "a.lib")
    expected = (tmp_path / "a.lib").read_bytes()
    build_library(tmp_path / "many", tmp_path / "b.lib")
    assert (tmp_path / "b.lib").read_bytes() == expected
    for seed in range(3):
        shuffled = random.Random(seed).sample(many, len(many))
        build_library(shuffled, tmp_path / f"{seed}.lib")
        assert (tmp_path / f"{seed}.lib").read_bytes() == expected


@pytest.mark.slow
def test_the_file_is_the_same_to_the_byte_on_two_processes(many, tmp_path):
    pytest.importorskip("distributed")
    build_library(many, tmp_path / "a.lib")
    build_library(many[::-1], tmp_path / "b.lib", jobs=2)
    assert (tmp_path / "a.lib").read_bytes() == (tmp_path / "b.lib").read_bytes()


def test_a_stopped_run_goes_on_and_comes_to_the_same(many, tmp_path, monkeypatch):
    build_library(many, tmp_path / "a.lib")
    out = tmp_path / "b.lib"

    def stopped(function, tasks, jobs, scheduler):
        for count, task in enumerate(tasks):
            if count == 4:
                raise KeyboardInterrupt
            yield Outcome(task, function(task))

    with monkeypatch.context() as patch:
        patch.setattr("loopelastica.batch.run.outcomes", stopped)
        with pytest.raises(KeyboardInterrupt, match="4 of 10 files are done and kept"):
            build_library(many, out)
    assert not out.exists()
    build = build_library(many, out)
    assert (build.n_files, build.n_resumed) == (10, 4)
    assert out.read_bytes() == (tmp_path / "a.lib").read_bytes()
    again = build_library(many, out)
    assert again.n_resumed == 10
    assert again.notes == build.notes
    assert out.read_bytes() == (tmp_path / "a.lib").read_bytes()


def test_a_file_that_changed_is_done_again(out, tmp_path, write):
    file = write(tmp_path / "a.pdb")
    build_library([KOC, file], out)
    before = out.read_bytes()
    write(file, {"change": shifted(8, 0.2)})
    build = build_library([KOC, file], out)
    assert build.n_resumed == 1
    assert out.read_bytes() != before


def test_nothing_of_others_is_replaced_and_nothing_is_done_before(tmp_path, monkeypatch):
    monkeypatch.setattr(shapes, "run", lambda *_: pytest.fail("a run was begun"))
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(TakenError, match="this is no library of loop shapes"):
        build_library(KOC, tmp_path / "notes.txt")
    with pytest.raises(TakenError, match="this is no library of loop shapes"):
        build_library(KOC, tmp_path)
    assert {p.name for p in tmp_path.iterdir()} == {"notes.txt"}


@pytest.mark.parametrize(
    ("arguments", "options", "sentence"),
    [
        (((), "x.lib"), {}, "`sources` is (); it must be one or more paths"),
        ((3, "x.lib"), {}, "`sources` is 3; it must be one or more paths"),
        (([KOC, None], "x.lib"), {}, "`sources` is"),
        (("{tmp}", "x.lib"), {}, "`sources` {tmp} holds no PDB or mmCIF file"),
        ((KOC, None), {}, "`out` is None; it must be a path"),
        ((KOC, "x.lib"), {"with_contacts": "yes"}, "`with_contacts` is 'yes'"),
        ((KOC, "x.lib"), {"limits": 3}, "`limits` is 3"),
        ((KOC, "x.lib"), {"jobs": 0}, "`jobs` is 0"),
    ],
)
def test_an_argument_that_cannot_be_is_named(tmp_path, monkeypatch, arguments, options, sentence):
    monkeypatch.chdir(tmp_path)
    filled = [a.format(tmp=tmp_path) if a == "{tmp}" else a for a in arguments]
    with pytest.raises(ValueError) as error:  # noqa: PT011 - the sentence is compared below
        build_library(*filled, **options)
    assert str(error.value).startswith(sentence.format(tmp=tmp_path))
    assert list(tmp_path.iterdir()) == []


def test_results_of_the_program_are_no_source(out, tmp_path, write):
    write(tmp_path / "in" / "a.pdb")
    write(tmp_path / "in" / "out" / "a" / "filled.pdb")
    manifest = {"program": "loopelastica", "files": ["filled.pdb"]}
    (tmp_path / "in" / "out" / "a" / "fill.json").write_text(json.dumps(manifest))
    assert build_library(tmp_path / "in", out).n_files == 1
    shutil.copytree(tmp_path / "in" / "out", tmp_path / "named")
    # what is given by its own name is taken
    assert build_library(tmp_path / "named" / "a", tmp_path / "b.lib").n_files == 1
