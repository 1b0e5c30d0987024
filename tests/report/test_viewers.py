"""Scripts that show the candidates in PyMOL and ChimeraX."""

import dataclasses
import json
import os
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import loopelastica as le
from loopelastica._files import data_path
from loopelastica.molecule.setting import Settings
from loopelastica.report.folder import write_fold
from loopelastica.report.palette import colour
from loopelastica.report.viewers import path_from, write_chimerax, write_pymol

HAIRPIN = data_path("hairpins/2koc.pdb")


@pytest.mark.parametrize(
    ("script", "load"),
    [("view.pml", r"^load (.*), native$"), ("view.cxc", r'^open "(.*)"$')],
)
def test_scripts_show_every_candidate_over_the_file(shipped, script, load):
    folder, fold = shipped
    text = (folder / script).read_text()
    (source,) = re.findall(load, text, re.M)
    assert (folder / source).resolve() == HAIRPIN.resolve()
    assert re.search(r"^(load|open) tubes\.pdb", text, re.M)
    names = {"view.pml": "color 0x{}, rank_{:02d}_", "view.cxc": "color #1.{1} #{0}"}
    for candidate in fold.candidates:
        assert names[script].format(colour(candidate.rank)[1:], candidate.rank) in text
        assert f"expected RMSD {candidate.expected_rmsd_A[1]:.1f} A" in text
    assert re.search(r"chain A and resi 6\+7\+8\+9|#2\.1/A:6,7,8,9", text)


def test_scripts_escape_negative_numbers(tmp_path, written, koc_lines):
    lines = [s[:22] + f"{int(s[22:26]) - 8:4d}" + s[26:] for s in koc_lines]
    path = tmp_path / "negative.pdb"
    path.write_text("\n".join([*lines, "END", ""]))
    folder, _ = written(path, tmp_path)
    assert r"resi \-2+\-1+0+1" in (folder / "view.pml").read_text()
    assert "/A:-2,-1,0,1 atoms" in (folder / "view.cxc").read_text()


def test_paths_hold_when_both_ends_are_moved(tmp_path):
    (tmp_path / "a").mkdir()
    assert path_from(tmp_path / "out" / "x", tmp_path / "a" / "b.pdb") == "../../a/b.pdb"


@pytest.mark.parametrize(("n_models", "native"), [(1, "#2/A:6,7,8,9"), (2, "#2.1/A:6,7,8,9")])
def test_chimerax_numbers_the_models_of_a_file_that_has_several(tmp_path, fold, n_models, native):
    write_chimerax(tmp_path / "view.cxc", fold, "native.pdb", "A", n_models)
    assert f"show {native} atoms" in (tmp_path / "view.cxc").read_text()


ODD_FILES = (
    *("semi;system touch X;.pdb", "two\nsystem touch X.pdb", 'quote".pdb', "quote'.pdb"),
    *("a,b.pdb", "a b.pdb", "$HOME.pdb", "#1.pdb", "[red].pdb", "back\\.pdb", "é.pdb", "a*.pdb"),
    os.fsdecode(b"\xff.pdb"),
)


@pytest.mark.parametrize("name", ODD_FILES)
def test_scripts_find_a_file_of_any_name_by_one_that_says_nothing(
    tmp_path, written, koc_lines, name
):
    path = tmp_path / name
    path.write_text("\n".join([*koc_lines, "END", ""]))
    folder, _ = written(path, tmp_path)
    for script, load in (
        ("view.pml", "load native.pdb, native"),
        ("view.cxc", 'open "native.pdb"'),
    ):
        lines = (folder / script).read_text(encoding="utf-8").splitlines()
        assert load in lines
        assert not any(sign in line for line in lines for sign in (";", "touch", "$", "[", "é"))
    assert (folder / "native.pdb").resolve() == path.resolve()
    assert (folder / "native.pdb").read_bytes() == path.read_bytes()


def test_so_does_a_folder_of_any_name_and_a_link_that_cannot_be_made_is_a_copy(
    tmp_path, written, koc_lines, monkeypatch
):
    def no_links(*_):
        raise OSError("no links here")

    monkeypatch.setattr("pathlib.Path.symlink_to", no_links)
    path = tmp_path / "my structures" / "2koc.pdb"
    path.parent.mkdir()
    path.write_text("\n".join([*koc_lines, "END", ""]))
    folder, _ = written(path, tmp_path)
    assert not (folder / "native.pdb").is_symlink()
    assert (folder / "native.pdb").read_bytes() == path.read_bytes()


@pytest.mark.parametrize(
    ("chain", "pymol", "chimerax"),
    [
        ("AA", "chain AA and resi 6+7+8+9", "#2/AA:6,7,8,9"),
        ("a b", 'chain "a b" and resi 6+7+8+9', '#2//chain_id="a b":6,7,8,9'),
        ("A-2", 'chain "A-2" and resi 6+7+8+9', '#2//chain_id="A-2":6,7,8,9'),
        *(
            (chain, "resi 6+7+8+9", "#2:6,7,8,9")
            for chain in ("a\nb", "a;system b", 'a"b', "a*", " ")
        ),
    ],
)
def test_a_chain_is_named_where_it_can_be_and_its_residues_by_their_numbers_alone_elsewhere(
    tmp_path, fold, chain, pymol, chimerax
):
    pair = tuple(label.replace("A.", f"{chain}.") for label in fold.hairpin.closing_pair)
    hairpin = dataclasses.replace(fold.hairpin, chain=chain, closing_pair=pair)
    loop = dataclasses.replace(fold, hairpin=hairpin)
    write_pymol(tmp_path / "view.pml", loop, "native.cif", chain)
    write_chimerax(tmp_path / "view.cxc", loop, "native.cif", chain, 1)
    lines = (tmp_path / "view.pml").read_text().splitlines()
    assert f"select loop, native and {pymol}" in lines
    assert f"show {chimerax} atoms" in (tmp_path / "view.cxc").read_text().splitlines()
    # nothing of the label in the headline ends it or begins a command
    assert [line.startswith("#") for line in lines[:4]] == [True, True, False, False]
    assert lines[2] == "set connect_mode, 1"
    assert ";" not in "".join(lines)


def test_an_insertion_code_that_is_no_letter_says_nothing(tmp_path, fold):
    icode = fold.hairpin.icode.astype("<U20")
    icode[0], icode[1] = "; quit", "B"
    loop = dataclasses.replace(fold, hairpin=dataclasses.replace(fold.hairpin, icode=icode))
    write_pymol(tmp_path / "view.pml", loop, "native.pdb", "A")
    assert "resi 6+7B+8+9" in (tmp_path / "view.pml").read_text()


def test_what_runs_into_the_stem_is_loaded_and_not_shown(tmp_path, fold):
    write_pymol(tmp_path / "view.pml", fold, "native.pdb", "A")
    write_chimerax(tmp_path / "view.cxc", fold, "native.pdb", "A", 1)
    hidden = {c.rank for c in fold.candidates if c.contacts.touching and c.rank > 1}
    assert hidden
    text = (tmp_path / "view.pml").read_text()
    assert {int(k) for k in re.findall(r"^disable rank_(\d+)", text, re.M)} == hidden
    text = (tmp_path / "view.cxc").read_text()
    assert {int(k) for k in re.findall(r"^hide #1\.(\d+) models", text, re.M)} == hidden


def test_no_name_of_a_shape_is_a_command(tmp_path, fold):
    odd = [
        dataclasses.replace(c, shape=f"like {c.rank}; quit\nsystem touch X, \"'$[red]é")
        for c in fold.candidates
    ]
    loop = dataclasses.replace(fold, candidates=tuple(odd))
    write_pymol(tmp_path / "view.pml", loop, "native.pdb", "A")
    write_chimerax(tmp_path / "view.cxc", loop, "native.pdb", "A", 1)
    for script in ("view.pml", "view.cxc"):
        text = (tmp_path / script).read_text(encoding="utf-8")
        first, *rest = text.splitlines()
        assert first.startswith("# ")
        assert not re.search("[;$é']", "".join(rest))
        assert not re.search("^(quit|system)", text, re.M)


def test_a_hairpin_from_its_sequence_is_seen_with_its_atoms(tmp_path):
    from loopelastica.report.atoms import LoopAtoms

    built = le.build("GGCAC(UUCG)GUGCC", candidates=2)
    hairpin = built.hairpin
    atoms = LoopAtoms(hairpin.structure, hairpin.fold, built.models, hairpin.positions_A)
    write_fold(tmp_path / "a", "GGCAC(UUCG)GUGCC", hairpin.fold, hairpin.structure, False, None,
               atoms)  # fmt: skip
    lines = (tmp_path / "a" / "view.pml").read_text().splitlines()
    assert "load atoms.pdb, native" in lines
    assert "load loop.sdf, atoms" in lines
    # the loop of that file is the first candidate's and no other's
    assert not any(line.startswith("show sticks, loop") for line in lines)
    assert 'open "atoms.pdb"' in (tmp_path / "a" / "view.cxc").read_text()


# what PyMOL is asked when the script is done
_ASK = """
import json
from pymol import cmd
tubes = [n for n in cmd.get_names("objects") if n.startswith("rank_")]
answer = {
    "objects": cmd.get_names("objects"),
    "enabled": cmd.get_names("objects", 1),
    "tubes": {n: cmd.get_coords(n + " and name TUB", 1).tolist() for n in tubes},
    "bonds": {n: len(cmd.get_model(n + " and name TUB").bond) for n in tubes},
    "loop": cmd.count_atoms("loop"),
    "shown": cmd.count_atoms("rep cartoon or rep lines or rep sticks"),
    "view": cmd.get_view(),
}
json.dump(answer, open("answer.json", "w"))
"""


@pytest.fixture(scope="module")
def in_pymol():
    """Run view.pml of a folder in PyMOL: its log, and what is there afterwards."""
    program = shutil.which("pymol")
    if program is None:
        pytest.skip("PyMOL is not installed")

    def run(folder):
        (folder / "ask.py").write_text(_ASK)
        # PyMOL is a Python program: it must find its own interpreter and packages
        environment = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}
        environment["PATH"] = f"{Path(program).parent}:/usr/bin:/bin"
        command = [program, "-cq", "view.pml", "ask.py"]
        done = subprocess.run(
            command, cwd=folder, env=environment, capture_output=True, text=True, timeout=300
        )
        return done.stdout + done.stderr, json.loads((folder / "answer.json").read_text())

    return run


def test_pymol_shows_tubes_that_join_the_stem(tmp_path, in_pymol, koc, chains):
    folder = tmp_path / "a"
    write_fold(folder, HAIRPIN, chains, koc, plot=False)
    log, there = in_pymol(folder)
    assert not re.search("error|warning|traceback|unknown|not found", log, re.I), log
    assert len(there["tubes"]) == len(chains.candidates)
    assert {"native", "names"} < set(there["objects"])
    assert there["loop"] > 80
    setting = Settings(koc).of(chains.hairpin)
    for name, points in there["tubes"].items():
        points = np.array(points)
        np.testing.assert_allclose(points[0], setting.strand_5_A[-1], atol=0.01)
        np.testing.assert_allclose(points[-1], setting.strand_3_A[0], atol=0.01)
        # one line without gaps
        assert there["bonds"][name] == len(points) - 1
        assert np.linalg.norm(np.diff(points, axis=0), axis=1).max() < 2.0
    # loop up: what is higher in the molecule is higher on the screen
    rotation = np.array(there["view"][:9]).reshape(3, 3)
    stem = setting.strand_5_A.mean(axis=0) + setting.strand_3_A.mean(axis=0)
    upwards = (chains.candidates[0].trace.mean(axis=0) - 0.5 * stem) @ rotation
    assert np.argmax(np.abs(upwards)) == 1
    assert upwards[1] > 0


@pytest.mark.slow
def test_pymol_shows_of_a_ribosome_what_is_near(tmp_path, in_pymol, hairpin_folder):
    from loopelastica.molecule.nucleotides import read_structure

    path = hairpin_folder / "1s72.pdb.gz"
    structure = read_structure(path)
    (loop,) = le.fold(structure, loop="0.2781-2793", max_candidates=2)
    write_fold(tmp_path / "a", path, loop, structure, plot=False)
    log, there = in_pymol(tmp_path / "a")
    assert not re.search("error|traceback", log, re.I), log
    assert 500 < there["shown"] < 20_000


def test_pymol_shows_a_loop_that_the_file_does_not_have(tmp_path, in_pymol, koc_lines):
    from loopelastica.molecule.nucleotides import read_structure

    path = tmp_path / "absent.pdb"
    path.write_text(
        "\n".join([*(s for s in koc_lines if s[22:26].strip() not in "6789"), "END", ""])
    )
    structure = read_structure(path)
    (loop,) = le.fold(structure, loop="A.6-9", max_candidates=2)
    write_fold(tmp_path / "a", path, loop, structure, plot=False)
    log, there = in_pymol(tmp_path / "a")
    assert not re.search("error|traceback", log, re.I), log
    assert there["loop"] == 0
    assert len(there["tubes"]) == 2
