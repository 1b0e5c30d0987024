"""Answers for one loop: shapes of other loops, the rod in its surroundings, rods."""

import numpy as np
import pytest

import loopelastica as le
from loopelastica._files import data_path
from loopelastica.folding.hypotheses import straight_rods
from loopelastica.folding.lines import ChainLine
from loopelastica.molecule.identity import entry_of

HAIRPIN = data_path("hairpins/2koc.pdb")
LIGAND = "HETATM 9{n:03d}  C{n:<3d}LIG B   1    {x:8.3f}{y:8.3f}{z:8.3f}  1.00  0.00           C"
SURROUNDED = "rod in its surroundings"


def beside(path, lines, places):
    """A file of 2KOC's first model with atoms of a ligand at some places."""
    ligand = [LIGAND.format(n=n, x=x, y=y, z=z) for n, (x, y, z) in enumerate(places)]
    path.write_text("\n".join([*lines, *ligand, "END", ""]))
    return path


@pytest.fixture(scope="module")
def crowd(fold):
    """Atoms that the straight rod of 2KOC would run through."""
    middle = fold.candidates[0].line.points([0.4, 0.5, 0.6])
    return np.concatenate([middle, middle + [0.0, 0.0, 1.5]])


def of_shape(loop, shape):
    return [candidate for candidate in loop.candidates if candidate.shape == shape]


def test_a_rod_goes_round_what_is_in_its_way(tmp_path, koc_lines, crowd):
    (loop,) = le.fold(beside(tmp_path / "crowd.pdb", koc_lines, crowd))
    (bent,) = of_shape(loop, SURROUNDED)
    straight = of_shape(loop, "straight rod")[0]

    def nearest(candidate):
        gaps = candidate.line.points(201)[:, None] - crowd
        return np.linalg.norm(gaps, axis=2).min()

    assert nearest(straight) < 1.0
    assert nearest(bent) > 2.5
    assert bent.line.energy > straight.line.energy
    assert bent.stable
    assert bent.residual < 1e-4


def test_surroundings_are_left_out_on_request(tmp_path, koc_lines, crowd):
    path = beside(tmp_path / "crowd.pdb", koc_lines, crowd)
    for options in ({"surroundings": False}, {"shapes": "rod"}):
        (loop,) = le.fold(path, **options)
        assert not of_shape(loop, SURROUNDED)


def test_its_own_hairpin_and_what_is_far_are_no_surroundings(tmp_path, koc_lines, crowd):
    for path in (HAIRPIN, beside(tmp_path / "far.pdb", koc_lines, crowd + [60.0, 0.0, 0.0])):
        (loop,) = le.fold(path, all_models=False)
        assert not of_shape(loop, SURROUNDED)


def test_a_rod_that_its_surroundings_do_not_move_is_no_answer_of_its_own(tmp_path, koc_lines, fold):
    line = fold.candidates[0].line.points(41)
    away = line[20] - line[[0, -1]].mean(axis=0)
    # beyond the top of the loop, out of the reach of the repulsion
    ligand = line[20] + 7.0 * away / np.linalg.norm(away)
    (loop,) = le.fold(beside(tmp_path / "near.pdb", koc_lines, ligand[None]))
    assert not of_shape(loop, SURROUNDED)


def test_each_model_has_its_own_surroundings(tmp_path, koc_lines, crowd):
    paths = [
        beside(tmp_path / name, koc_lines, crowd + shift)
        for name, shift in (("near.pdb", 0.0), ("far.pdb", [60.0, 0.0, 0.0]))
    ]
    texts = [path.read_text().removesuffix("END\n") for path in paths]
    both = tmp_path / "both.pdb"
    both.write_text(
        "".join(f"MODEL {k:8d}\n{text}ENDMDL\n" for k, text in enumerate(texts, 1)) + "END\n"
    )
    (loop,), *alone = (le.fold(path, rank="energy") for path in (both, *paths))
    assert of_shape(loop, SURROUNDED)
    for k, (one,) in enumerate(alone):
        for candidate, other in zip(loop.candidates, one.candidates, strict=False):
            assert candidate.rmsd_models_A[k] == other.rmsd_A


def test_the_loops_own_coordinates_change_no_answer(tmp_path, koc_lines, fold):
    """Neither which answers there are nor where they lie: only stem and surroundings count."""
    moved = [
        line[:30] + f"{float(line[30:38]) + 0.3:8.3f}" + line[38:]
        if int(line[22:26]) in (6, 7, 8, 9) else line
        for line in koc_lines
    ]  # fmt: skip
    there, here = (
        le.fold(beside(tmp_path / f"2koc_{k}.pdb", lines, []))[0].candidates
        for k, lines in enumerate((moved, koc_lines))
    )
    for one, other in zip(there, here, strict=True):
        assert one.shape == other.shape
        np.testing.assert_array_equal(one.trace, other.trace)
        np.testing.assert_array_equal(one.expected_rmsd_A, other.expected_rmsd_A)


def test_a_loop_is_not_answered_with_itself_under_another_name(tmp_path, koc_lines):
    known = le.fold(beside(tmp_path / "2koc_model.pdb", koc_lines, []), all_models=False)[0]
    renamed = le.fold(beside(tmp_path / "model.pdb", koc_lines, []), all_models=False)[0]
    assert entry_of(tmp_path / "model.pdb") == "model"
    for one, other in zip(known.candidates, renamed.candidates, strict=True):
        assert one.shape == other.shape
        np.testing.assert_array_equal(one.trace, other.trace)


def test_rods_alone_are_folded_on_request():
    (loop,) = le.fold(HAIRPIN, all_models=False, shapes="rod")
    assert {candidate.shape for candidate in loop.candidates} == {"straight rod"}


def test_the_first_answers_differ_and_each_says_what_it_is_and_how_unsure():
    (loop,) = le.fold(HAIRPIN, all_models=False)
    assert any(isinstance(candidate.line, ChainLine) for candidate in loop.candidates)
    for k, candidate in enumerate(loop.candidates[:5]):
        assert candidate.shape
        low, middle, high = candidate.expected_rmsd_A
        assert 0.0 <= low < middle < high < 60.0
        for other in loop.candidates[:k]:
            assert np.abs(candidate.trace - other.trace).max() > 0.5


def test_a_shape_that_cannot_be_had_is_the_loops_failure(koc, monkeypatch):
    def refuse(hairpin, *_):
        raise le.StructureError(f"{hairpin.label}: the library has no such loop")

    monkeypatch.setattr("loopelastica.folding.fold.hypotheses", refuse)
    (loop,) = le.fold(koc)
    assert loop.failure == "A.C5–A.G10: the library has no such loop"


def test_the_first_rod_is_surer_than_the_others(fold):
    rods = [candidate.rod for candidate in fold.candidates]
    expected = [one.expected_rmsd_A for one in straight_rods(fold.hairpin, rods, fold.ends)]
    assert all((np.diff(values) > 0.0).all() for values in expected)
    assert all(expected[0][1] < values[1] for values in expected[1:])


def test_chains_come_first_and_rods_follow(chains):
    """Where the answers are put into that order."""
    kinds = [isinstance(c.line, ChainLine) for c in chains.candidates if not c.contacts.touching]
    assert kinds == sorted(kinds, reverse=True)
    first = chains.candidates[0]
    assert first.shape == "like 2koc A.5-A.10"
    assert first.rod is None
    assert first.rmsd_A < 1.5
    assert first.expected_rmsd_A.tolist() == [0.5, 1.2, 2.0]


@pytest.fixture
def absent(tmp_path, koc_lines):
    """Fold a loop of n nucleotides that the file lacks, on the stem of 2KOC."""

    def folded(n):
        lines = []
        for line in koc_lines:
            number = int(line[22:26])
            if number <= 5:
                lines.append(line)
            elif number >= 10:
                lines.append(f"{line[:22]}{number + n - 4:4d}{line[26:]}")
        path = beside(tmp_path / f"{n}.pdb", lines, [])
        (loop,) = le.fold(path, loop=f"A.6-{n + 5}")
        assert len(loop.hairpin) == n
        assert loop.failure is None
        return loop.candidates

    return folded


@pytest.mark.parametrize("n", [3, 8, 12])
def test_a_loop_without_a_known_sequence_has_the_mean_of_its_length(absent, n):
    first = absent(n)[0]
    assert first.shape.startswith("mean of ")
    assert first.rmsd_A is None
    assert np.isfinite(first.expected_rmsd_A).all()


def test_loops_longer_than_any_known_one_are_rods_and_less_and_less_sure(absent):
    found = [absent(n) for n in (13, 18, 24)]
    assert {candidate.shape for loop in found for candidate in loop} == {"straight rod"}
    medians = [loop[0].expected_rmsd_A[1] for loop in found]
    assert (np.diff(medians) > 0.0).all()
    for loop in found:
        for candidate in loop:
            low, middle, high = candidate.expected_rmsd_A
            assert 0.0 < low < middle < high < 200.0
