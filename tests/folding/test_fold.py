"""From file to candidates on real hairpins."""

import json
import re
import warnings

import gapped
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import loopelastica as le
from loopelastica._files import data_path
from loopelastica.errors import StructureError
from loopelastica.folding.fold import fold_model
from loopelastica.folding.options import FoldOptions
from loopelastica.molecule.hairpins import find_hairpins
from loopelastica.molecule.nucleotides import read_structure

PLAIN = {"stem_extend_5": 0, "stem_extend_3": 0, "taper": 0.0, "shapes": "rod"}
RODS = FoldOptions(shapes="rod")
HAIRPIN = data_path("hairpins/2koc.pdb")


@pytest.fixture(scope="module")
def structure():
    return read_structure(HAIRPIN)


@pytest.fixture(scope="module")
def loop():
    (loop,) = le.fold(HAIRPIN, shapes="rod")
    return loop


def test_the_shipped_hairpin_folds_near_its_loop(loop):
    assert loop.hairpin.sequence == "CUUCGG"
    assert loop.hairpin.closing_pair == ("A.C5", "A.G10")
    first = loop.candidates[0]
    assert first.rank == 1
    assert first.rmsd_A <= 2.2
    assert not first.contacts.touching
    assert first.residual < 1e-9
    assert first.trace.shape == (4, 3)
    assert first.rmsd_models_A.shape == (20,)
    assert first.rmsd_models_A[0] == first.rmsd_A
    assert np.ptp(first.rmsd_models_A) > 0.1
    energies = [c.energy_per_A for c in loop.candidates]
    assert energies == sorted(energies)
    assert first.energy_per_A == pytest.approx(first.rod.energy / 24.0)
    assert first.energy_kT == pytest.approx(10.0 * first.energy_per_A)


@pytest.mark.parametrize(
    ("entry", "limit"),
    [("1kr8", 1.0), ("1xue", 1.0), ("1bjh", 1.0), ("1ac7", 1.3), ("2koc", 1.7)],
)
def test_first_ranked_rmsd_of_the_clamp_at_the_closing_pair(hairpin_folder, entry, limit):
    (loop,) = le.fold(hairpin_folder / f"{entry}.pdb.gz", all_models=False, **PLAIN)
    assert loop.candidates[0].rmsd_A <= limit


# a sketch of this rule had 2.10, 1.58, 6.26, 2.99, 3.82, 2.45 Å
@pytest.mark.parametrize(
    ("entry", "loop_name", "clamp", "rmsd"),
    [
        ("2koc.pdb", "A6-9", (0, 0), 2.10),
        ("1ecu.pdb", "A9-11", (0, 0), 1.58),
        ("1anr.pdb", "A30-35", (0, 1), 6.26),
        ("1szy.pdb", "A8-14", (1, 2), 2.99),
        ("1ehz.cif", "A31-39", (1, 3), 3.82),
        ("1ehz.cif", "A54-60", (1, 2), 2.45),
    ],
)
def test_first_ranked_rmsd_by_the_rule(hairpin_folder, entry, loop_name, clamp, rmsd):
    loops = le.fold(hairpin_folder / f"{entry}.gz", all_models=False, shapes="rod")
    (loop,) = (loop for loop in loops if loop.hairpin.name == loop_name)
    assert (loop.ends.clamp.stem_extend_5, loop.ends.clamp.stem_extend_3) == clamp
    assert loop.candidates[0].rmsd_A == pytest.approx(rmsd, abs=0.05)
    assert loop.candidates[0].trace.shape == (len(loop.hairpin), 3)


def test_an_extension_too_far_for_the_rod_is_taken_back_unless_given(hairpin_folder):
    path = hairpin_folder / "1y26.pdb.gz"

    def clamp(**options):
        loop = le.fold(path, all_models=False, **options)[1]
        return loop if loop.ends is None else loop.ends.clamp

    assert (clamp().stem_extend_5, clamp().stem_extend_3) == (1, 1)
    for given in ({"stem_extend_3": 2}, {"stem_extend_5": 1, "stem_extend_3": 2}):
        assert "no rod fits" in clamp(**given).failure
    with pytest.raises(ValueError, match="stem_extend_3"):
        clamp(stem_extend_3=-1)
    with pytest.raises(ValueError, match="taper"):
        clamp(taper=0.5)


def test_a_stem_that_is_no_helix_is_refused(hairpin_folder):
    (loop,) = le.fold(hairpin_folder / "1d16.pdb.gz")
    assert "A.DG6–A.DC11" in loop.failure
    assert "1.56 Å" in loop.failure
    assert loop.candidates == ()


def test_shapes_that_touch_come_after_those_that_do_not(structure, loop):
    # a rod much too long for its loop runs into the stem
    (long,) = le.fold(
        HAIRPIN, length_per_nucleotide_A=20.0, all_models=False, max_candidates=30, shapes="rod"
    )
    touching = [c.contacts.touching for c in long.candidates]
    assert any(touching)
    assert touching == sorted(touching)
    for kind in (False, True):
        energies = [c.energy_per_A for c in long.candidates if c.contacts.touching == kind]
        assert energies == sorted(energies)


@pytest.mark.parametrize("entry", ["2koc.pdb", "1szy.pdb"])
def test_scrambling_the_loop_changes_no_prediction_of_the_rule(hairpin_folder, entry, rng):
    structure = read_structure(hairpin_folder / f"{entry}.gz")
    (hairpin,) = find_hairpins(structure)
    positions = structure.positions(0)
    atoms = np.unique(structure.nucleotides.atom_index[hairpin.loop])
    scrambled = positions.copy()
    scrambled[atoms[atoms >= 0]] += rng.normal(scale=9.0, size=((atoms >= 0).sum(), 3))
    here, there = (
        fold_model(structure.nucleotides, hairpin, x, RODS) for x in (positions, scrambled)
    )
    for a, b in zip(here.candidates, there.candidates, strict=True):
        np.testing.assert_array_equal(a.trace, b.trace)
        assert a.contacts == b.contacts


def test_each_model_is_clamped_by_its_own_stem_and_compared_with_its_own_loop(structure, loop):
    for model in (3, 7):
        alone = fold_model(structure.nucleotides, loop.hairpin, structure.positions(model), RODS)
        assert alone.candidates[0].rmsd_A == loop.candidates[0].rmsd_models_A[model]


def test_scrambling_the_loop_changes_no_prediction(structure, loop, rng):
    hairpin = loop.hairpin
    atoms = np.unique(structure.nucleotides.atom_index[hairpin.loop])
    atoms = atoms[atoms >= 0]
    positions = structure.positions(0)
    reference = fold_model(structure.nucleotides, hairpin, positions, RODS)
    scrambled = positions.copy()
    scrambled[atoms] += rng.normal(scale=5.0, size=(len(atoms), 3))
    other = fold_model(structure.nucleotides, hairpin, scrambled, RODS)
    for a, b in zip(reference.candidates, other.candidates, strict=True):
        np.testing.assert_array_equal(a.trace, b.trace)
        assert a.rod.energy == b.rod.energy
        assert abs(a.rmsd_A - b.rmsd_A) > 0.1


@pytest.mark.parametrize("free_spin", [True, False])
def test_rigid_motion_moves_the_answer_by_the_same_motion(structure, rng, free_spin):
    (hairpin,) = find_hairpins(structure)
    positions = structure.positions(0)
    chosen = FoldOptions(free_spin=free_spin)
    reference = fold_model(structure.nucleotides, hairpin, positions, chosen)
    for turn in Rotation.random(3, random_state=rng):
        shift = rng.uniform(-100, 100, 3)
        moved = fold_model(
            structure.nucleotides, hairpin, positions @ turn.as_matrix().T + shift, chosen
        )
        assert len(moved.candidates) == len(reference.candidates)
        for a, b in zip(reference.candidates, moved.candidates, strict=True):
            np.testing.assert_allclose(a.trace @ turn.as_matrix().T + shift, b.trace, atol=1e-6)


def test_rigid_motion_through_a_pdb_file(tmp_path, rng, loop):
    import MDAnalysis as mda

    turn = Rotation.random(random_state=rng)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        universe = mda.Universe(HAIRPIN)
        universe.atoms.positions = turn.apply(universe.atoms.positions) + [10.0, -20.0, 5.0]
        universe.atoms.write(tmp_path / "moved.pdb")
    (moved,) = le.fold(tmp_path / "moved.pdb", shapes="rod")
    expected = loop.candidates[0].trace @ turn.as_matrix().T + [10.0, -20.0, 5.0]
    np.testing.assert_allclose(moved.candidates[0].trace, expected, atol=2e-3)


@pytest.fixture
def universe():
    import MDAnalysis as mda

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return mda.Universe(HAIRPIN)


def test_a_universe_counts_with_its_current_frame(universe, structure, loop):
    universe.trajectory[7]
    (here,) = le.fold(universe, shapes="rod")
    assert universe.trajectory.frame == 7
    alone = fold_model(structure.nucleotides, loop.hairpin, structure.positions(7), RODS)
    np.testing.assert_allclose(here.candidates[0].trace, alone.candidates[0].trace, atol=1e-9)
    assert abs(here.candidates[0].rmsd_A - loop.candidates[0].rmsd_A) > 0.05
    # one frame is one model
    np.testing.assert_array_equal(here.candidates[0].rmsd_models_A, [here.candidates[0].rmsd_A])
    assert le.find_hairpins(universe)[0].name == "A6-9"
    (scanned,) = le.scan(universe, extend_5_max=0, extend_3_max=0, tapers=[0.2])
    np.testing.assert_array_equal(scanned.candidates[0].candidate.trace, here.candidates[0].trace)


def test_of_a_group_of_atoms_only_its_nucleotides_count(universe, loop):
    (folded,) = le.fold(universe.select_atoms("resid 4:11"), shapes="rod")
    np.testing.assert_array_equal(folded.candidates[0].trace, loop.candidates[0].trace)
    assert folded.hairpin.n_pairs == 2
    assert le.find_hairpins(universe.select_atoms("resid 1:8")) == []
    assert le.find_hairpins(universe.atoms[::-1])[0].n_pairs == 5
    with pytest.raises(le.StructureError, match="no nucleotide"):
        le.fold(universe.select_atoms("name P"))


def test_darboux_clamping_and_line_length_are_the_users_choice(loop):
    (clamped,) = le.fold(
        HAIRPIN, free_spin=False, torsion_ratio=0.7, all_models=False, shapes="rod"
    )
    assert clamped.candidates[0].rod.torsion_ratio == 0.7
    assert clamped.candidates[0].rod.energy > loop.candidates[0].rod.energy
    (longer,) = le.fold(HAIRPIN, length_per_nucleotide_A=7.0, all_models=False)
    assert longer.length_A == 28.0


def test_a_line_too_short_for_the_stem_ends_is_refused(loop):
    (short,) = le.fold(HAIRPIN, length_per_nucleotide_A=2.0)
    assert short.candidates == ()
    assert "no rod fits" in short.failure
    assert "A.C5" in short.failure


def test_results_can_be_kept_as_json(loop):
    rod = loop.candidates[0].rod
    again = le.Equilibrium.from_dict(json.loads(json.dumps(rod.to_dict())))
    np.testing.assert_array_equal(again.loads, rod.loads)


def test_pairs_of_the_user_move_the_clamp():
    (moved,) = le.fold(HAIRPIN, all_models=False, pair="A.6-A.8")
    assert moved.hairpin.residues == ("A.U7",)
    assert moved.parameters["pair"] == ["A.6-A.8"]
    assert "no rod fits" in moved.failure
    (wider,) = le.fold(HAIRPIN, all_models=False, dot_bracket="((((......))))")
    assert wider.candidates[0].trace.shape == (6, 3)


def test_a_model_that_lacks_a_loop_is_folded_but_not_compared(tmp_path):
    first, second = re.split(r"ENDMDL *\n", HAIRPIN.read_text())[:2]
    kept = [s for s in second.splitlines() if s[12:26] != " P     C A   8"]
    path = tmp_path / "unequal.pdb"
    path.write_text(first + "ENDMDL\n" + "\n".join(kept) + "\nENDMDL\nEND\n")
    (unequal,) = le.fold(path)
    rmsd_A = unequal.candidates[0].rmsd_models_A
    assert np.isfinite(rmsd_A).tolist() == [True, False]
    assert unequal.model_failures == ()


def test_models_that_cannot_be_folded_are_numbered_as_in_the_file():
    (loop,) = le.fold(HAIRPIN, length_per_nucleotide_A=3.634, shapes="rod")
    numbers = [int(re.match(r"model (\d+): ", s)[1]) for s in loop.model_failures]
    missing = ~np.isfinite(loop.candidates[0].rmsd_models_A)
    assert numbers == (1 + np.flatnonzero(missing)).tolist()
    assert numbers


def test_a_loop_with_a_missing_atom_is_folded_but_not_compared(tmp_path, loop):
    lines = HAIRPIN.read_text().split("ENDMDL")[0].splitlines()
    path = tmp_path / "missing.pdb"
    path.write_text("\n".join(s for s in lines if s[12:26] != " P     C A   8"))
    (folded,) = le.fold(path, shapes="rod")
    np.testing.assert_array_equal(folded.candidates[0].trace, loop.candidates[0].trace)
    assert folded.candidates[0].rmsd_A is None
    assert "lacks backbone atoms" in folded.remarks[0]


def test_missing_stem_atoms_cost_one_loop_and_not_the_others(hairpin_folder, tmp_path):
    import gzip

    lines = gzip.decompress((hairpin_folder / "1k2g.pdb.gz").read_bytes()).decode().splitlines()
    kept = [
        s for s in lines if not (s[22:26] == "   5" and s[12:16].strip() in {"P", "O5'", "C5'"})
    ]
    path = tmp_path / "missing.pdb"
    path.write_text("\n".join(kept))
    first, second = le.fold(path)
    assert first.failure == "A.C5: no P, O5' and C5' atoms; its stem frame cannot be placed"
    assert second.failure is None


@pytest.fixture
def like_8(tmp_path):
    """The eighth model of 2KOC as a template."""
    return gapped.pdb(tmp_path / "eighth.pdb", gapped.chain(model=8))


def test_a_template_is_the_first_candidate(like_8):
    (plain,) = le.fold(HAIRPIN, all_models=False)
    (loop,) = le.fold(HAIRPIN, like=f"{like_8}:A.5-A.10", all_models=False)
    first = loop.candidates[0]
    assert first.shape == "like eighth A.5-A.10"
    assert first.rmsd_A < 1.0
    assert len(first.carried) == 4
    low, middle, high = first.expected_rmsd_A
    assert 0 < low < middle < high
    # what there was without comes after it
    assert [c.shape for c in loop.candidates[1:]] == [c.shape for c in plain.candidates][:9]
    assert [c.rank for c in loop.candidates] == list(range(1, len(loop.candidates) + 1))
    assert all(c.carried == () for c in loop.candidates[1:])
    assert not any("eighth" in sentence for sentence in loop.remarks)


def test_a_template_is_for_every_model(like_8):
    (loop,) = le.fold(HAIRPIN, like=like_8)
    assert len(loop.candidates[0].rmsd_models_A) == 20
    assert loop.candidates[0].rmsd_models_A.max() < 2.0


def test_a_template_of_one_nucleotide_less_is_respaced_and_that_is_said(hairpin_folder):
    """1BJH has three loop nucleotides, 1AC7 four."""
    like = f"{hairpin_folder / '1bjh.pdb.gz'}"
    (loop,) = le.fold(hairpin_folder / "1ac7.pdb.gz", like=like, all_models=False)
    first = loop.candidates[0]
    assert first.shape == "like 1bjh A.4-A.8, 3 → 4 nucleotides"
    assert (len(first.trace), first.carried) == (4, ())
    assert any("no loop of 4 nucleotides; the line of 3 is respaced" in s for s in loop.remarks)


def test_a_loop_that_no_template_fits_is_folded_without_beside_one_that_it_fits(hairpin_folder):
    """The loops of a tRNA have eight, nine and seven nucleotides."""
    path = hairpin_folder / "1ehz.cif.gz"
    loops = le.fold(path, like=f"{path}:A.53-A.61", all_models=False)
    firsts = [loop.candidates[0].shape for loop in loops]
    assert firsts[0] == "like 1ehz A.53-A.61, 7 → 8 nucleotides"
    assert not firsts[1].startswith("like")
    assert firsts[2] == "like 1ehz A.53-A.61"
    said = [sum("1ehz.cif.gz" in sentence for sentence in loop.remarks) for loop in loops]
    assert said == [1, 1, 0]


def test_a_template_that_fits_no_loop_is_refused(hairpin_folder, like_8):
    with pytest.raises(StructureError, match=r"eighth\.pdb: its loop has 4 nucleotides"):
        le.fold(hairpin_folder / "1anr.pdb.gz", like=like_8, all_models=False)


def test_a_template_that_cannot_be_read_is_refused():
    with pytest.raises(StructureError, match=r"nowhere\.pdb: there is no such file"):
        le.fold(HAIRPIN, like="nowhere.pdb")
