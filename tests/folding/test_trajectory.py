"""The analysis of a trajectory: equal results from all backends."""

import warnings

import numpy as np
import pytest

import loopelastica as le
from loopelastica._files import data_path
from loopelastica.folding.hypotheses import straight_rods

# a remark of MDAnalysis on PDB files
pytestmark = pytest.mark.filterwarnings("ignore:Reader has no dt")
HAIRPIN = data_path("hairpins/2koc.pdb")


@pytest.fixture
def universe():
    import MDAnalysis as mda

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return mda.Universe(HAIRPIN)


@pytest.fixture(scope="module")
def loop():
    (loop,) = le.fold(HAIRPIN)
    return loop


def test_frames_are_folded_as_models_are(universe, loop):
    analysis = le.LoopElastica(universe).run(stop=5)
    results = analysis.results
    np.testing.assert_array_equal(results.rmsd_A[:, 0], loop.candidates[0].rmsd_models_A[:5])
    assert results.energy_per_A[0, 0] == loop.candidates[0].energy_per_A
    np.testing.assert_array_equal(analysis.trace_A(0)[0], loop.candidates[0].trace)
    assert results.touching.shape == (5, 1)
    assert not results.touching.any()
    assert results.failures == []


@pytest.mark.parametrize(
    "backend", ["multiprocessing", pytest.param("dask", marks=pytest.mark.slow)]
)
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_backends_agree(universe, backend):
    if backend == "dask":
        pytest.importorskip("dask")
    serial, parallel = (
        le.LoopElastica(universe).run(stop=4, **how)
        for how in ({}, {"backend": backend, "n_workers": 2})
    )
    for name in ("energy_per_A", "rmsd_A", "touching", "traces_A"):
        np.testing.assert_array_equal(serial.results[name], parallel.results[name])
    assert serial.results.failures == parallel.results.failures


def test_a_frame_that_cannot_be_folded_is_told_and_the_others_are(universe):
    analysis = le.LoopElastica(universe, length_per_nucleotide_A=3.634).run(stop=6)
    failed = ~np.isfinite(analysis.results.energy_per_A[:, 0])
    assert 0 < failed.sum() < 6
    assert [frame for frame, _ in analysis.results.failures] == np.flatnonzero(failed).tolist()
    assert np.isfinite(analysis.results.traces_A[~failed]).all()
    assert not np.isnan(analysis.results.traces_A).any()


def test_the_table_has_a_line_per_frame_and_loop(universe):
    pytest.importorskip("pandas")
    analysis = le.LoopElastica(universe).run(stop=3)
    table = analysis.to_dataframe()
    assert table["frame"].tolist() == [0, 1, 2]
    assert table["loop"].tolist() == ["A6-9"] * 3
    np.testing.assert_array_equal(table["rmsd_A"], analysis.results.rmsd_A[:, 0])


def test_options_are_those_of_fold(universe):
    with pytest.raises(ValueError, match="taper"):
        le.LoopElastica(universe, taper=3.0)
    with pytest.raises(TypeError, match="tapper"):
        le.LoopElastica(universe, tapper=0.1)
    for name, value in (
        ("all_models", False),
        ("max_candidates", 3),
        ("persistence_length_A", 20.0),
    ):
        with pytest.raises(ValueError, match=f"`{name}` does not apply to a trajectory"):
            le.LoopElastica(universe, **{name: value})
    with pytest.raises(ValueError, match="`atoms` is neither"):
        le.LoopElastica(HAIRPIN)


def test_loops_and_pairs_that_are_named_are_those_analysed(universe):
    wider = le.LoopElastica(universe, loop="A.5-10").run(stop=2)
    assert [hairpin.name for hairpin in wider.hairpins] == ["A5-10"]
    assert wider.results.traces_A.shape == (2, 6, 3)
    (loop,) = le.fold(HAIRPIN, loop="A.5-10")
    np.testing.assert_array_equal(wider.results.rmsd_A[:, 0], loop.candidates[0].rmsd_models_A[:2])
    by_brackets = le.LoopElastica(universe, dot_bracket="((((......))))")
    assert [hairpin.name for hairpin in by_brackets.hairpins] == ["A5-10"]
    paired = le.LoopElastica(universe, pair="A.6-A.9")
    assert [hairpin.residues for hairpin in paired.hairpins] == [("A.U7", "A.C8")]


def test_a_group_of_atoms_is_followed_as_the_whole(universe):
    whole = le.LoopElastica(universe).run(stop=3)
    group = le.LoopElastica(universe.select_atoms("resid 3:12")).run(stop=3)
    np.testing.assert_array_equal(group.results.rmsd_A, whole.results.rmsd_A)


def test_what_is_around_a_loop_counts_in_each_frame(universe, monkeypatch):
    seen = []

    def rods(hairpin, stem, ends, rods, *more):
        seen.append(more[-1].others)
        return straight_rods(hairpin, rods, ends)

    monkeypatch.setattr("loopelastica.folding.fold.hypotheses", rods)
    le.LoopElastica(universe).run(stop=2)
    assert all(len(others.rows) > 100 for others in seen)
    # gathered once
    assert seen[0] is seen[1]
    le.LoopElastica(universe, surroundings=False).run(stop=1)
    assert seen[2:] == [None]
