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
        le.LoopElastica(universe, max_candidates=2, length_per_nucleotide_A=3.634).run(
            stop=6, **how
        )
        for how in ({}, {"backend": backend, "n_workers": 2})
    )
    assert {*serial.results} == {*parallel.results}
    for name in serial.results.candidates:
        np.testing.assert_array_equal(serial.results[name], parallel.results[name])
        every = (one.results.candidates[name] for one in (serial, parallel))
        np.testing.assert_array_equal(*every)
    assert 0 < len(serial.results.failures) < 6
    assert serial.results.failures == parallel.results.failures
    assert [*serial.records()] == [*parallel.records()]


def test_a_frame_that_cannot_be_folded_is_told_and_the_others_are(universe):
    analysis = le.LoopElastica(universe, length_per_nucleotide_A=3.634).run(stop=6)
    failed = ~np.isfinite(analysis.results.energy_per_A[:, 0])
    assert 0 < failed.sum() < 6
    failures = analysis.results.failures
    assert [one.frame for one in failures] == np.flatnonzero(failed).tolist()
    assert {one.loop for one in failures} == {"A6-9"}
    assert all("no rod fits" in one.reason for one in failures)
    assert (analysis.results.shape[failed] == "").all()
    assert np.isfinite(analysis.results.traces_A[~failed]).all()
    assert not np.isnan(analysis.results.traces_A).any()


def test_the_table_has_a_line_per_frame_and_loop(universe):
    pytest.importorskip("pandas")
    analysis = le.LoopElastica(universe).run(stop=3)
    table = analysis.to_dataframe()
    assert table["frame"].tolist() == [0, 1, 2]
    assert table["loop"].tolist() == ["A6-9"] * 3
    assert table["rank"].tolist() == [1] * 3
    np.testing.assert_array_equal(table["rmsd_A"], analysis.results.rmsd_A[:, 0])
    assert table["failure"].isna().all()


def test_the_table_has_a_line_per_candidate_and_one_per_failure(universe):
    pytest.importorskip("pandas")
    options = {"max_candidates": 3, "shapes": "rod", "length_per_nucleotide_A": 3.634}
    analysis = le.LoopElastica(universe, **options).run(stop=6)
    table = le.to_dataframe(analysis)
    failed = table[table["failure"].notna()]
    assert failed["frame"].tolist() == [one.frame for one in analysis.results.failures]
    assert failed[["rank", "shape", "energy_kT", "rmsd_A"]].isna().all(axis=None)
    kept = table[table["failure"].isna()]
    finite = np.isfinite(analysis.results.candidates.energy_kT)
    np.testing.assert_array_equal(kept["energy_kT"], analysis.results.candidates.energy_kT[finite])
    assert not np.isinf(kept["rmsd_A"].to_numpy(dtype=float)).any()


def test_all_candidates_asked_for_are_kept_as_fold_gives_them(universe):
    asked = {"shapes": "rod", "persistence_length_A": 20.0}
    analysis = le.LoopElastica(universe, max_candidates=5, **asked).run(start=2, stop=3)
    universe.trajectory[2]
    (loop,) = le.fold(universe, **asked)
    results = analysis.results
    every = results.candidates
    n = len(loop.candidates)
    assert 1 < n < 5
    assert results.names == ("A6-9",)
    for name in ("energy_per_A", "energy_kT", "rmsd_A", "shape"):
        assert every[name].shape == (1, 1, 5)
        values = [getattr(candidate, name) for candidate in loop.candidates]
        assert every[name][0, 0, :n].tolist() == values
        assert results[name][0, 0] == values[0]
    assert np.isinf(every.energy_kT[0, 0, n:]).all()
    assert set(every["shape"][0, 0, n:]) == {""}
    for rank, candidate in enumerate(loop.candidates, start=1):
        np.testing.assert_array_equal(
            every.expected_rmsd_A[0, 0, rank - 1], candidate.expected_rmsd_A
        )
        np.testing.assert_array_equal(analysis.trace_A(0, rank)[0], candidate.trace)
    assert np.isinf(analysis.trace_A(0, n + 1)).all()
    assert results.traces_A.shape == (1, 4, 3)
    assert not any(np.isnan(array).any() for array in every.values() if array.dtype == float)


def test_frames_may_be_chosen_as_in_every_analysis(universe):
    analysis = le.LoopElastica(universe, shapes="rod")
    whole = analysis.run(stop=7).results.rmsd_A
    for how, rows in (
        ({"stop": 7, "step": 3}, [0, 3, 6]),
        ({"frames": [5, 1]}, [5, 1]),
        ({"stop": 0}, []),
    ):
        again = le.LoopElastica(universe, shapes="rod").run(**how)
        np.testing.assert_array_equal(again.results.rmsd_A, whole[rows])
        assert again.results.candidates.traces_A.shape == (len(rows), 4, 1, 3)
        assert [row["frame"] for row in again.records()] == rows


def test_an_analysis_that_has_not_run_has_no_table(universe):
    pytest.importorskip("pandas")
    with pytest.raises(ValueError, match="has not run"):
        le.to_dataframe(le.LoopElastica(universe))


def test_options_are_those_of_fold(universe):
    with pytest.raises(ValueError, match="taper"):
        le.LoopElastica(universe, taper=3.0)
    with pytest.raises(ValueError, match="`max_candidates`"):
        le.LoopElastica(universe, max_candidates=0)
    with pytest.raises(TypeError, match=r"LoopElastica takes no `tapper`; .* `taper`"):
        le.LoopElastica(universe, tapper=0.1)
    for name, value in (("all_models", False), ("max_size_MB", 3.0), ("max_atoms", 20)):
        with pytest.raises(ValueError, match=f"`{name}` does not apply to a trajectory"):
            le.LoopElastica(universe, **{name: value})
    for path in (HAIRPIN, str(HAIRPIN)):
        with pytest.raises(ValueError, match=r"`atoms` is neither .* a path; .*Universe\("):
            le.LoopElastica(path)
    with pytest.raises(ValueError, match="`atoms` is neither a Universe nor an AtomGroup but int"):
        le.LoopElastica(3)


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
