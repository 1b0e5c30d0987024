"""Shapes of other loops as answers: which are used, which mean comes first, what follows."""

import dataclasses

import MDAnalysis
import numpy as np
import pytest
from loop_shapes import found
from scipy.spatial.transform import Rotation

import loopelastica as le
from loopelastica._files import data_path
from loopelastica.folding.known import FIRST, known_shapes, library_at, usable_shapes
from loopelastica.folding.library import Library
from loopelastica.folding.library_file import save_library
from loopelastica.folding.motifs import typical_spread_A
from loopelastica.molecule.ends import fit_stem
from loopelastica.molecule.hairpins import find_hairpins
from loopelastica.molecule.trace import rmsd_A

FILE = data_path("hairpins/2koc.pdb")


@pytest.fixture(scope="module")
def hairpin(koc):
    return find_hairpins(koc)[0]


@pytest.fixture(scope="module")
def poses(koc, hairpin):
    return fit_stem(koc.nucleotides, hairpin, koc.positions(0)).closing()


@pytest.fixture
def save(tmp_path):
    def saved(*loops):
        save_library(Library.of(loops), tmp_path / "some.lib")
        return str(tmp_path / "some.lib")

    return saved


def different(count, sequence="CACACG", **about):
    return [found(sequence, f"{k + 1}xyz", seed=k, **about) for k in range(count)]


def shapes_of(path=FILE, **options):
    (loop,) = le.fold(path, all_models=False, **options)
    return [candidate.shape for candidate in loop.candidates]


# which shapes


def test_a_loop_is_never_answered_by_its_own_entry(hairpin):
    library = library_at(None)
    assert library.of_length(4).of_entries(["2koc"]).any()
    table = usable_shapes(library, hairpin, ("2koc",))
    assert len(table)
    assert "2koc" not in table.entries
    # the answers are those of a library without it
    count = int(table.same_loop(hairpin.sequence).sum())
    assert shapes_of()[0] == f"motif UNCG, same sequence, {count} loops"


def test_another_name_of_the_file_does_not_hide_its_entry(tmp_path):
    path = tmp_path / "9zzz.pdb"
    path.write_text(FILE.read_text())
    assert "HEADER" in path.read_text()[:80]
    assert shapes_of(path) == shapes_of()


def test_relatives_are_left_out_on_request(hairpin):
    table = usable_shapes(library_at(None), hairpin, exclude_relatives=True)
    assert not table.relatives(hairpin.sequence).any()
    assert {table.sequence(k)[1:-1] for k in np.flatnonzero(table.letters[:, 4] == ord("G"))}
    shape = shapes_of(exclude_relatives=True)[0]
    assert shape.startswith("motif UNCG, ")
    assert "same sequence" not in shape


def test_loops_of_rna_take_no_shape_of_dna_and_those_of_dna_both(koc, hairpin):
    library = Library.of([*different(2), found("CTTCGG", "9xyz", is_dna=True)])
    assert not usable_shapes(library, hairpin).is_dna.any()
    dna = dataclasses.replace(hairpin, is_dna=True)
    assert usable_shapes(library, dna).is_dna.tolist().count(True) == 1
    assert len(usable_shapes(library, dna)) == 3


# which mean


def test_the_same_sequence_is_taken_before_all_others(save):
    library = save(*different(5), found("GUUCGC", "8xyz"), found("CUACGG", "7xyz", seed=9))
    assert shapes_of(library=library)[0] == "motif UNCG, same sequence, 1 loop"
    assert shapes_of(library=library, exclude_relatives=True)[0] == "motif UNCG, 1 loop"
    other = save(*different(5))
    assert shapes_of(library=other)[0] == "mean of 5 loops"


def test_without_a_motif_the_same_sequence_says_so(hairpin, poses):
    other = dataclasses.replace(hairpin, sequence="CUCUGG")
    table = Library.of([*different(3), found("AUCUGU", "8xyz")]).of_length(4)
    first = known_shapes(other, poses, table).answers([])[0]
    assert first.kind == "same sequence"
    assert first.line.shape.source == "same sequence, 1 loop"


def test_the_first_answer_is_the_mean_of_its_shapes_on_this_stem(hairpin, poses):
    table = Library.of(different(6)).of_length(4)
    known = known_shapes(hairpin, poses, table)
    first = known.answers([])[0]
    assert first.kind == "mean"
    mean = poses.to_file(np.average(known.weighted.nodes_A, axis=0, weights=known.weighted.weights))
    np.testing.assert_allclose(first.trace_A, mean, atol=1e-6)
    assert first.energy == pytest.approx(known.weighted.weights @ known.energies)


# what follows


@pytest.fixture(scope="module")
def loop():
    (loop,) = le.fold(FILE, all_models=False)
    return loop


def test_the_first_five_answers_are_distinct(loop):
    first = [c for c in loop.candidates if not c.contacts.touching][:FIRST]
    assert len(first) == FIRST
    assert len({c.shape for c in first}) == FIRST
    for k, one in enumerate(first):
        for other in first[:k]:
            assert rmsd_A(one.trace, other.trace) > 0.5


def test_a_rod_by_the_rule_is_among_the_first_five_and_no_other_rod(loop):
    first = [c.shape for c in loop.candidates[:FIRST]]
    assert first.count("straight rod") == 1


def test_dna_has_the_rod_first(hairpin_folder):
    (loop,) = le.fold(hairpin_folder / "1bjh.pdb.gz", all_models=False, exclude_relatives=True)
    assert loop.hairpin.is_dna
    assert loop.candidates[0].shape == "straight rod"
    shapes = [c.shape for c in loop.candidates[1:FIRST]]
    assert any(shape.startswith("library ") for shape in shapes)
    assert not any(shape.startswith(("mean", "motif")) for shape in shapes)


def test_dna_of_a_known_sequence_has_its_mean_second(koc, hairpin, poses):
    dna = dataclasses.replace(hairpin, is_dna=True)
    table = usable_shapes(Library.of([*different(4), found("CTTCGG", "9xyz", is_dna=True)]), dna)

    class Rod:
        trace, energy = np.zeros((4, 3)), 1.0

    kinds = [one.kind for one in known_shapes(dna, poses, table).answers([Rod(), Rod()])]
    assert kinds[:2] == ["rod", "same sequence"]
    assert kinds[-1] == "further rod"
    assert kinds.count("library") == FIRST - 2
    # without a rod a mean is all there is
    assert known_shapes(dna, poses, table).answers([])[0].kind == "same sequence"


def test_few_shapes_are_few_answers(hairpin, poses):
    known = known_shapes(hairpin, poses, Library.of(different(1)).of_length(4))
    # it is its own mean, and no second answer
    assert [one.kind for one in known.answers([])] == ["library"]
    assert known_shapes(hairpin, poses, Library.of([]).of_length(4)) is None


@pytest.mark.parametrize("loops", [[], [found("CUUUG")]], ids=["none", "of another length"])
def test_where_a_library_has_no_such_loop_the_table_has(save, loops):
    library = save(*loops)
    shapes = shapes_of(library=library)
    assert shapes[:2] == ["motif UNCG, 56 loops", "straight rod"]
    # of a mean nobody can take a relative away
    assert set(shapes_of(library=library, exclude_relatives=True)) == {"straight rod"}


# expected errors


def test_every_answer_has_an_error_to_expect(loop):
    for candidate in loop.candidates:
        low, middle, high = candidate.expected_rmsd_A
        assert 0.0 <= low < middle < high < 60.0


def test_an_answer_far_from_all_shapes_is_less_sure(hairpin, poses):
    known = known_shapes(hairpin, poses, usable_shapes(library_at(None), hairpin))
    first = known.answers([])[0].trace_A
    assert known.spread_A(first) < known.spread_A(first + [3.0, 0.0, 0.0])
    gaps = [rmsd_A(poses.to_file(nodes), first) for nodes in known.weighted.nodes_A]
    sequences = len(np.unique(known.table.letters[:, 1:-1], axis=0))
    squares = sequences * (known.weighted.weights @ gaps) ** 2 + 3 * typical_spread_A(4) ** 2
    assert known.spread_A(first) == pytest.approx(np.sqrt(squares / (sequences + 3)))


def test_of_few_shapes_nobody_is_sure(hairpin, poses):
    known = known_shapes(hairpin, poses, Library.of(different(1)).of_length(4))
    (only,) = known.answers([])
    assert known.spread_A(only.trace_A) > 0.8 * typical_spread_A(4)


def test_atoms_in_its_way_make_a_shape_lighter(hairpin, poses):
    table = Library.of(different(6)).of_length(4)
    free = known_shapes(hairpin, poses, table)
    k = int(np.argmax(free.weighted.weights))
    atoms = poses.to_file(free.weighted.nodes_A[k])
    crowded = known_shapes(hairpin, poses, table, np.repeat(atoms, 3, axis=0))
    assert crowded.weighted.weights[k] < free.weighted.weights[k]
    # atoms elsewhere change nothing
    away = known_shapes(hairpin, poses, table, atoms + 500.0)
    np.testing.assert_array_equal(away.weighted.weights, free.weighted.weights)


# whatever the place


def test_the_same_file_has_the_same_answers_to_the_bit(loop):
    (again,) = le.fold(FILE, all_models=False)
    for one, other in zip(loop.candidates, again.candidates, strict=True):
        assert one.shape == other.shape
        assert one.trace.tobytes() == other.trace.tobytes()
        assert one.expected_rmsd_A.tobytes() == other.expected_rmsd_A.tobytes()


def test_another_place_of_the_file_changes_no_answer(rng):
    universe = MDAnalysis.Universe(str(FILE))
    (before,) = le.fold(universe.atoms)
    turn, shift = Rotation.random(random_state=rng).as_matrix(), rng.normal(scale=20.0, size=3)
    universe.atoms.positions = universe.atoms.positions @ turn.T + shift
    (after,) = le.fold(universe.atoms)
    for one, other in zip(before.candidates, after.candidates, strict=True):
        assert one.shape == other.shape
        np.testing.assert_allclose(one.trace @ turn.T + shift, other.trace, atol=2e-3)
        np.testing.assert_allclose(one.expected_rmsd_A, other.expected_rmsd_A, rtol=1e-3)
        assert one.rmsd_A == pytest.approx(other.rmsd_A, abs=2e-3)
