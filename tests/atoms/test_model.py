import dataclasses

import gapped
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import loopelastica as le
from loopelastica.atoms.hairpin import fold_sequence
from loopelastica.atoms.measures import bond_lengths
from loopelastica.atoms.model import build_atoms
from loopelastica.atoms.search import LINE_SD_A, best_near
from loopelastica.atoms.sequence import read_sequence
from loopelastica.errors import StructureError
from loopelastica.folding.fold import fold_model
from loopelastica.molecule.nucleotides import atom_positions, read_structure


def again(koc, fold, positions, **options):
    moved = fold_model(koc.nucleotides, fold.hairpin, positions, fold.options)
    return build_atoms(koc, moved, positions=positions, max_candidates=1, **options)[0]


def test_the_first_model_of_2koc_meets_the_figures(models, fold):
    checks = models[0].checks
    assert checks.sound
    assert checks.wrong_chirality == ()
    assert checks.chain_worst_A <= 0.05
    assert checks.bonds_within >= 0.99
    assert checks.angles_within >= 0.95
    assert checks.closest_A >= 2.2
    assert checks.line_after_A <= 2 * LINE_SD_A[0]
    assert models[0].rmsd_A <= fold.candidates[0].rmsd_A + 0.6
    assert set(checks.pucker) <= {"C3'-endo", "C2'-endo"}
    assert models[0].relaxed.message == "converged"
    assert len(models[0].alternatives) == 2


def test_the_checks_are_what_the_positions_say(models):
    model = models[0]
    o3, p = model.molecule.index(-1, "O3'"), model.molecule.index(0, "P")
    length = bond_lengths(model.positions_A, np.array([[o3, p]]))[0]
    assert model.checks.junction_5_A == pytest.approx(length)
    assert 1.55 < length < 1.66


def test_stem_atoms_are_the_files_own(koc, models):
    model = models[0]
    row = model.molecule.index(4, "P")
    atom = koc.nucleotides.columns(["P"])[9, 0]
    np.testing.assert_array_equal(model.positions_A[row], koc.positions(0)[atom])


@pytest.mark.slow
def test_rigid_motion_of_the_input_moves_the_atoms_by_the_same_motion(koc, fold, models, rng):
    positions = koc.positions(0)
    turn = Rotation.random(random_state=rng).as_matrix()
    shift = rng.uniform(-100, 100, 3)
    moved = again(koc, fold, positions @ turn.T + shift)
    np.testing.assert_allclose(models[0].positions_A @ turn.T + shift, moved.positions_A, atol=1e-4)


@pytest.mark.slow
def test_scrambling_the_loop_changes_no_atom(koc, fold, models, rng):
    positions = np.array(koc.positions(0))
    c1 = koc.nucleotides.columns(["C1'"])[fold.hairpin.loop, 0]
    resindices = koc.universe.atoms.resindices
    loop = np.isin(resindices, resindices[c1])
    positions[loop] += rng.normal(scale=4.0, size=(int(loop.sum()), 3))
    scrambled = again(koc, fold, positions)
    np.testing.assert_array_equal(scrambled.positions_A, models[0].positions_A)
    assert scrambled.rmsd_A > models[0].rmsd_A + 1.0


def test_limits_and_impossible_input_are_told(koc, fold):
    (model,) = build_atoms(koc, fold, max_candidates=1, tries=1, max_steps=3)
    assert "limit of steps" in model.relaxed.message
    with pytest.raises(ValueError, match="`tries` is 0"):
        build_atoms(koc, fold, tries=0)
    (short,) = le.fold(koc, length_per_nucleotide_A=2.0, all_models=False)
    with pytest.raises(StructureError, match="no rod fits"):
        build_atoms(koc, short)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *(("positions", "x"), ("positions", [1.0, 2.0]), ("positions", [[1j, 0, 0]])),
        *(("contact", "nonsense"), ("contact", 5), ("model", -1), ("model", "1"), ("tries", True)),
        *(("max_steps", 0), ("max_seconds", float("nan")), ("max_candidates", 1.5)),
    ],
)
def test_arguments_are_refused_by_name(koc, fold, name, value):
    with pytest.raises(ValueError, match=f"`{name}`"):
        le.build_atoms(koc, fold, **{name: value})


def test_only_a_fold_gets_atoms(koc):
    with pytest.raises(ValueError, match="`fold` is 'fold'; it must be one of the loops"):
        le.build_atoms(koc, "fold")


def test_a_stem_without_the_atoms_of_a_junction_is_refused(tmp_path):
    from loopelastica._files import data_path

    lines = data_path("hairpins/2koc.pdb").read_text().split("ENDMDL")[0].splitlines()
    path = tmp_path / "no_p.pdb"
    kept = [x for x in lines if not (x[12:16].strip() == "OP1" and x[22:26].strip() == "10")]
    path.write_text("\n".join([*kept, "ENDMDL", "END", ""]))
    structure = read_structure(path)
    (loop,) = le.fold(structure)
    with pytest.raises(StructureError, match=r"A\.G10: no OP1 atom; the loop cannot be joined"):
        build_atoms(structure, loop)


# first candidates of a DNA triloop, a DNA tetraloop, a GNRA loop, a longer RNA loop
SAMPLE = ("1xue", "1ac7", "1jur", "1szy")


@pytest.mark.slow
@pytest.mark.parametrize("entry", SAMPLE)
def test_reference_hairpins_meet_the_figures(hairpin_folder, entry):
    structure = read_structure(hairpin_folder / f"{entry}.pdb.gz")
    (loop,) = le.fold(structure, all_models=False)
    (model,) = build_atoms(structure, loop, max_candidates=1)
    checks = model.checks
    assert checks.sound
    assert checks.bonds_within >= 0.99
    assert checks.angles_within >= 0.95
    assert model.rmsd_A <= loop.candidates[0].rmsd_A + 0.8


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("positions", np.zeros((3, 3))),
        ("positions", "abc"),
        ("contact", np.zeros(3)),
        ("contact", "stacked"),
        ("model", 20),
        ("model", (0,)),
        ("model", -1),
    ],
)
def test_arguments_of_another_kind_are_named(koc, fold, name, value):
    with pytest.raises(ValueError, match=f"`{name}`"):
        build_atoms(koc, fold, **{name: value})


def test_positions_of_no_structure_are_refused(koc, fold):
    with pytest.raises(StructureError, match="at the origin"):
        build_atoms(koc, fold, positions=np.zeros_like(koc.positions(0)))
    with pytest.raises(ValueError, match="`fold`"):
        build_atoms(koc, 1.0)


def test_chains_and_rods_get_sound_atoms_alike(koc, chains):
    models = build_atoms(koc, chains, max_candidates=3)
    assert chains.candidates[0].rod is None
    assert chains.candidates[2].rod is not None
    for candidate, model in zip(chains.candidates, models, strict=False):
        assert model.rank == candidate.rank
        assert model.checks.sound, (candidate, model.checks.wrong)
        assert model.checks.line_after_A < 0.8
        # of the atoms, not of their centroids; turning a suite into a cluster costs a third of it
        assert model.rmsd_A <= candidate.rmsd_A + 1.25
    # what is around is seen from where each line begins
    stem = models[0].molecule.index(-1, "O3'")
    np.testing.assert_array_equal(models[0].positions_A[stem], models[2].positions_A[stem])


def test_a_rigid_motion_moves_the_atoms_on_a_chain_along(koc, chains, of_chains, monkeypatch):
    monkeypatch.setattr("loopelastica.folding.fold.hypotheses", of_chains)
    turn, shift = Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix(), np.array([12.0, -3.0, 40.0])
    here = build_atoms(koc, chains, max_candidates=1)[0]
    there = again(koc, chains, koc.positions(0) @ turn.T + shift)
    np.testing.assert_allclose(here.positions_A @ turn.T + shift, there.positions_A, atol=1e-4)


@pytest.fixture(scope="module")
def like_8(koc, tmp_path_factory):
    """2KOC's first model folded like its eighth."""
    path = gapped.pdb(tmp_path_factory.mktemp("like") / "eighth.pdb", gapped.chain(model=8))
    (loop,) = le.fold(koc, like=f"{path}:A.5-A.10", all_models=False, max_candidates=1)
    return loop


def off_A(koc, model):
    """RMSD of the bases from the file's own, where they are."""
    names = ("N1", "C2", "N3", "C4", "C5", "C6")
    own = atom_positions(koc.nucleotides, koc.positions(0), names)[5:9]
    rows = [[model.molecule.index(k, name) for name in names] for k in range(4)]
    return float(np.sqrt(((model.positions_A[np.array(rows)] - own) ** 2).sum(axis=-1).mean()))


def test_atoms_begin_where_a_templates_were_carried(koc, like_8):
    (carried,) = build_atoms(koc, like_8)
    bare = dataclasses.replace(like_8.candidates[0], carried=())
    (on_line,) = build_atoms(koc, dataclasses.replace(like_8, candidates=(bare,)))
    assert carried.checks.sound
    assert (carried.carried, on_line.carried) == (True, False)
    assert carried.rmsd_A < 1.0
    assert off_A(koc, carried) < 1.5
    assert off_A(koc, carried) < 0.5 * off_A(koc, on_line)


def test_a_template_with_the_two_free_oxygens_exchanged_is_as_good(koc, like_8):
    first = like_8.candidates[0]
    swap = {"OP1": "OP2", "OP2": "OP1"}
    exchanged = tuple(
        dataclasses.replace(one, atoms_A={swap.get(x, x): at for x, at in one.atoms_A.items()})
        for one in first.carried
    )
    other = dataclasses.replace(first, carried=exchanged)
    (model,) = build_atoms(koc, dataclasses.replace(like_8, candidates=(other,)))
    assert model.checks.sound
    assert model.carried
    assert off_A(koc, model) < 1.5


def test_where_a_template_leads_to_nothing_sound_the_line_is_searched(koc, like_8, monkeypatch):
    def unsound(*arguments):
        attempt, tried = best_near(*arguments)
        checks = dataclasses.replace(attempt.checks, wrong_chirality=("1:P",))
        return dataclasses.replace(attempt, checks=checks), tried

    monkeypatch.setattr("loopelastica.atoms.search.best_near", unsound)
    (model,) = build_atoms(koc, like_8)
    assert model.checks.sound
    assert not model.carried


def test_a_contact_that_is_sought_is_reached_or_said_to_be_missed(koc, fold):
    """UUCG has no sheared pair of its ends; a loop of GCAA has."""
    (none,) = build_atoms(koc, fold, contact="sheared", max_candidates=1)
    assert none.checks.contact_A is None
    assert none.checks.contact_reached is None
    folded = fold_sequence(read_sequence("GGCAC(GCAA)GUGCC", rna=True), max_candidates=2)
    built = build_atoms(
        folded.structure, folded.fold, positions=folded.positions_A, contact="sheared"
    )
    for model in built:
        molecule, at = model.molecule, model.positions_A
        lengths = [
            np.linalg.norm(at[molecule.index(0, a)] - at[molecule.index(3, b)])
            for a, b in (("N2", "N7"), ("N3", "N6"))
        ]
        assert model.checks.contact_A == pytest.approx(max(lengths), abs=1e-6)
        assert model.checks.contact_reached == (max(lengths) <= 3.2)
        assert model.checks.sound
    assert built[0].checks.contact_reached


def test_suites_are_named_and_most_are_in_clusters(models):
    names = [name for model in models for name in model.checks.suites]
    assert len(names) == 2 * 5
    assert sum(name == "!!" for name in names) <= 4
