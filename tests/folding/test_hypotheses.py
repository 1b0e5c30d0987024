"""Answers for one loop: shapes of other loops, the rod in its surroundings, rods."""

import numpy as np
import pytest

import loopelastica as le
from loopelastica._files import data_path
from loopelastica.folding.hypotheses import rods_expected, straight_rods, surrounded_rod
from loopelastica.folding.lines import ChainLine

LIGAND = "HETATM 9{n:03d}  C{n:<3d}LIG B{r:4d}    {x:8.3f}{y:8.3f}{z:8.3f}  1.00  0.00           C"


def beside(path, lines, places):
    """A file of 2KOC's first model with atoms of a ligand at some places."""
    ligand = [LIGAND.format(n=n, r=1, x=x, y=y, z=z) for n, (x, y, z) in enumerate(places)]
    path.write_text("\n".join([*lines, *ligand, "END", ""]))
    return path


@pytest.fixture(scope="module")
def crowd(fold):
    """Atoms that the straight rod of 2KOC would run through."""
    middle = fold.candidates[0].line.points([0.4, 0.5, 0.6])
    return np.concatenate([middle, middle + [0.0, 0.0, 1.5]])


def test_a_rod_goes_round_what_is_in_its_way(fold, crowd):
    free = fold.candidates[0].rod
    (found,) = surrounded_rod(fold.hairpin, fold.ends, free, crowd)
    assert found.shape == "rod in its surroundings"
    assert found.line.rod.nearest > 2.5
    assert found.line.energy > free.energy
    assert found.line.stable


def test_where_nothing_is_in_its_way_it_is_the_straight_rod(fold):
    far = fold.candidates[0].trace.mean(axis=0) + 100.0
    assert surrounded_rod(fold.hairpin, fold.ends, fold.candidates[0].rod, far[None]) == ()


def test_fold_takes_the_surroundings_of_the_file(tmp_path, koc_lines, crowd):
    path = beside(tmp_path / "crowd.pdb", koc_lines, crowd)

    def shapes(**options):
        (loop,) = le.fold(path, **options)
        return [c.shape for c in loop.candidates]

    assert shapes().count("rod in its surroundings") == 1
    assert shapes().index("rod in its surroundings") < shapes().index("straight rod")
    assert "rod in its surroundings" not in shapes(surroundings=False)
    assert set(shapes(shapes="rod")) == {"straight rod"}


def test_its_own_hairpin_and_what_is_far_are_no_surroundings(tmp_path, koc_lines, crowd):
    for path in (
        data_path("hairpins/2koc.pdb"),
        beside(tmp_path / "far.pdb", koc_lines, crowd + [60.0, 0.0, 0.0]),
    ):
        (loop,) = le.fold(path, all_models=False)
        assert "rod in its surroundings" not in {c.shape for c in loop.candidates}


def test_each_model_has_its_own_surroundings(tmp_path, koc_lines, crowd):
    near = beside(tmp_path / "a", koc_lines, crowd).read_text()
    far = beside(tmp_path / "b", koc_lines, crowd + [60.0, 0.0, 0.0]).read_text()
    models = [
        f"MODEL {k}\n{text.removesuffix('END' + chr(10))}ENDMDL\n"
        for k, text in enumerate((near, far), start=1)
    ]
    path = tmp_path / "two.pdb"
    path.write_text("".join([*models, "END\n"]))
    (loop,) = le.fold(path)
    first = next(c for c in loop.candidates if c.shape == "rod in its surroundings")
    assert np.isfinite(first.rmsd_models_A).all()
    (alone,) = le.fold(beside(tmp_path / "b.pdb", koc_lines, crowd + [60.0, 0.0, 0.0]))
    assert loop.candidates[0].rmsd_models_A[1] == alone.candidates[0].rmsd_A


def test_chains_come_first_and_rods_follow(chains):
    kinds = [isinstance(c.line, ChainLine) for c in chains.candidates if not c.contacts.touching]
    assert kinds == sorted(kinds, reverse=True)
    first = chains.candidates[0]
    assert first.shape == "like 2koc A.5-A.10"
    assert first.rod is None
    assert first.rmsd_A < 1.5
    assert first.expected_rmsd_A.tolist() == [0.5, 1.2, 2.0]


def test_shapes_that_are_not_wanted_are_not_made(koc, of_chains, monkeypatch):
    monkeypatch.setattr("loopelastica.folding.fold.hypotheses", of_chains)
    (loop,) = le.fold(koc, all_models=False, shapes="rod")
    assert {c.shape for c in loop.candidates} == {"straight rod"}


def test_a_shape_that_cannot_be_had_is_the_loops_failure(koc, monkeypatch):
    def refuse(hairpin, poses, options):
        raise le.StructureError(f"{hairpin.label}: the library has no such loop")

    monkeypatch.setattr("loopelastica.folding.fold.hypotheses", refuse)
    (loop,) = le.fold(koc)
    assert loop.failure == "A.C5–A.G10: the library has no such loop"


@pytest.mark.parametrize("is_rule", [True, False])
def test_the_error_of_rods_grows_from_10_to_90_percent(fold, is_rule):
    low, middle, high = rods_expected(fold.hairpin, is_rule)
    assert 0.0 < low < middle < high


def test_only_the_first_rod_of_the_rule_has_its_error(fold):
    rods = [c.rod for c in fold.candidates]
    first, second, *_ = straight_rods(fold.hairpin, rods, fold.ends)
    assert first.expected_rmsd_A[1] == 1.9
    assert second.expected_rmsd_A[1] > 1.9
    other = straight_rods(fold.hairpin, rods, fold.ends, is_rule=False)[0]
    assert other.expected_rmsd_A[1] > 1.9
