"""Single strands laid between helices of designs."""

from dataclasses import replace

import laying
import numpy as np
import oracle
import pytest
from helix_designs import duplex, write
from scipy.spatial.transform import Rotation
from strands import moved

from loopelastica.nanostructures.laying.lay import lay
from loopelastica.nanostructures.oxdna.energies import bonds
from loopelastica.nanostructures.oxdna.files import read_oxdna, write_oxdna
from loopelastica.nanostructures.oxdna.model import UNIT_NM, backbone_sites
from loopelastica.nanostructures.scadnano.reading import read_design


@pytest.fixture
def read(tmp_path):
    """The system of a design."""
    return lambda design: read_design(write(design, tmp_path)).system


def of(laid, status="laid"):
    """Which nucleotides are in strands of a status."""
    found = np.zeros(len(laid.system), dtype=bool)
    for one in laid.strands:
        found[one.nucleotides] = one.status == status
    return found


def test_hairpins_of_all_lengths_can_start(read):
    system = read(laying.hairpins([1, 2, *range(3, 61, 3)]))
    laid = lay(system)
    assert {one.kind for one in laid.strands} == {"hairpin"}
    assert not laid.refused
    assert not laid.conflicts
    assert laid.system.placed.all()
    laying.assert_starts(laid.system, of(laid))


@pytest.mark.parametrize(
    ("apart", "length"), [(1, 3), (1, 4), (1, 10), (1, 60), (2, 8), (2, 15), (3, 10), (3, 30)]
)
def test_linkers_can_start_and_go_round_the_helices_between(read, apart, length):
    laid = lay(read(laying.linker(apart, length)))
    assert not laid.refused
    assert not laid.conflicts
    laying.assert_starts(laid.system, of(laid))


def test_helices_do_not_move(read):
    system = read(laying.linker(2, 8))
    laid = lay(system, sample=1)
    paired = system.pair >= 0
    for one in (laid.system, laid.samples[0].system):
        for name in ("centre", "a1", "a3"):
            np.testing.assert_array_equal(getattr(one, name)[paired], getattr(system, name)[paired])


def test_a_linker_that_is_too_short_is_refused_with_the_number_that_is_enough(read):
    system = read(laying.linker(2, 3))
    laid = lay(system)
    (one,) = laid.refused
    assert one.status == "refused"
    assert "helix 0, offset 20" in one.reason
    assert "helix 2, offset 20" in one.reason
    assert "linker of 3 nucleotides" in one.reason
    assert f"{one.distance * UNIT_NM:.2f} nm ({one.distance:.2f} of oxDNA's units)" in one.reason
    assert not laid.system.placed[one.nucleotides].any()
    assert laid.system.placed[system.pair >= 0].all()
    assert (one.length, one.energy, one.spacing, one.nearest) == (None, None, None, None)
    enough = int(one.reason.split()[-4])
    assert not lay(read(laying.linker(2, enough))).refused
    assert lay(read(laying.linker(2, enough - 1))).refused


def test_a_refused_strand_does_not_keep_the_others_from_being_laid(read):
    design = laying.linker(2, 3)
    design.helices[0].max_offset = 60
    design.draw_strand(0, 45).move(10).loopout(0, 5).move(-10)
    laid = lay(read(design))
    assert [one.status for one in laid.strands] == ["refused", "laid"]
    laying.assert_starts(laid.system, of(laid))


@pytest.mark.parametrize("length", [1, 2, 3, 10])
def test_bulges_leave_their_helix(read, length):
    design = laying.designs.row_of(1, 32, **laying.FITTING)
    design.draw_strand(0, 0).move(16).loopout(0, length).move(16)
    design.draw_strand(0, 32).move(-32)
    laid = lay(read(design))
    assert not laid.conflicts
    laying.assert_starts(laid.system, of(laid))


def test_a_rod_that_nothing_is_near_is_the_equilibrium(read):
    from loopelastica.nanostructures.laying.ends import helix_ends
    from loopelastica.rod.clamping import Clamping
    from loopelastica.rod.solve import solve

    laid = lay(read(laying.hairpins([12])))
    (one,) = laid.strands
    assert one.shape == "rod"
    ends = helix_ends(laid.system, np.array([one.before, one.after]))
    length = 13 * 0.7564
    start = ends.frame[0]
    clamping = Clamping(
        start.T @ (ends.point[1] - ends.point[0]) / length, start.T @ ends.frame[1], True
    )
    rod = solve(clamping)
    assert one.energy_per_nm * UNIT_NM * length == pytest.approx(rod.energy, rel=1e-6)
    line = ends.point[0] + length * rod.centerline(2001) @ start.T
    rows = one.nucleotides
    system = laid.system
    sites = backbone_sites(system.centre[rows], system.a1[rows], system.a3[rows])
    far = np.linalg.norm(sites[:, None] - line[None], axis=2).min(axis=1)
    assert far.max() < 0.01


def test_a_loop_that_has_to_give_way_has_the_energy_of_its_hinges_near_the_rod_s(read):
    # hairpins of three are touched by nothing; in this row the loops of fifteen meet
    alone = lay(read(laying.hairpins([15]))).strands[0]
    row = lay(read(laying.hairpins([15] * 4)))
    assert not row.conflicts
    for one in row.strands:
        assert one.energy_per_nm == pytest.approx(alone.energy_per_nm, rel=0.25)


@pytest.mark.parametrize("tails", ["straight", "relaxed"])
def test_tails_leave_nicks_and_ends(read, tails):
    laid = lay(read(laying.tailed(6, 9)), tails=tails)
    assert sorted({str(one.kind) for one in laid.strands}) == ["tail 3'", "tail 5'"]
    assert not laid.conflicts
    laying.assert_starts(laid.system, of(laid))


def test_straight_tails_are_straight(read):
    laid = lay(read(laying.tailed(6, 9)))
    system = laid.system
    for one in laid.strands:
        assert one.shape == "straight"
        assert one.energy == 0
        rows = one.nucleotides
        sites = backbone_sites(system.centre[rows], system.a1[rows], system.a3[rows])
        steps = np.diff(sites, axis=0)
        np.testing.assert_allclose(steps, np.broadcast_to(steps[0], steps.shape), atol=1e-9)


def test_laid_strands_move_with_their_design(read):
    system = read(laying.hairpins([4, 9]))
    turn, shift = Rotation.from_rotvec([0.4, 1.0, -2.0]), np.array([5.0, -3.0, 40.0])
    before, after = lay(system), lay(moved(system, turn, shift))
    expected = before.system.centre @ turn.as_matrix().T + shift
    np.testing.assert_allclose(after.system.centre, expected, atol=1e-5)


def test_a_strand_that_is_paired_nowhere_is_laid_beside_the_others(read):
    design = laying.designs.row_of(2, 30)
    design.draw_strand(0, 0).move(20)
    design.draw_strand(0, 20).move(-20)
    design.draw_strand(1, 0).move(30)
    system = read(design)
    laid = lay(system)
    (one,) = laid.strands
    assert (one.kind, one.shape) == ("free strand", "straight")
    laying.assert_starts(laid.system, of(laid))
    far = np.linalg.norm(
        laid.system.centre[one.nucleotides][:, None] - laid.system.centre[system.pair >= 0],
        axis=2,
    )
    assert far.min() > 2


def test_free_strands_and_circles_that_have_a_place_keep_it(read):
    system = read(laying.hairpins([12]))
    free = replace(
        lay(system).system, pair=np.full(len(system), -1), n3=np.roll(np.arange(len(system)), -1),
        n5=np.roll(np.arange(len(system)), 1),
    )  # fmt: skip
    laid = lay(free)
    assert [(one.kind, one.shape) for one in laid.strands] == [("circle", "as given")]
    np.testing.assert_array_equal(laid.system.centre, free.centre)


def test_a_circle_without_a_place_is_one(read):
    system = read(laying.hairpins([12]))
    n = len(system)
    ring = replace(
        system, pair=np.full(n, -1), placed=np.zeros(n, dtype=bool),
        n3=np.roll(np.arange(n), -1), n5=np.roll(np.arange(n), 1),
    )  # fmt: skip
    laid = lay(ring)
    assert laid.strands[0].shape == "circle"
    np.testing.assert_allclose(bonds(laid.system).length, 0.7564)
    laying.assert_starts(laid.system, of(laid))
    # 2π² over the length
    (one,) = laid.strands
    assert one.energy == pytest.approx(2 * np.pi**2, rel=0.01)


def test_a_circle_of_two_is_refused(read):
    system = read(laying.hairpins([3]))
    n = len(system)
    n3, n5, pair = (np.full(n, -1) for _ in range(3))
    n3[[0, 1]] = n5[[0, 1]] = [1, 0]
    placed = np.arange(n) > 1
    laid = lay(replace(system, n3=n3, n5=n5, pair=pair, placed=placed))
    assert "circle of 2" in laid.refused[0].reason


def test_the_same_seed_draws_the_same_samples_and_another_one_others(read):
    system = read(laying.hairpins([20]))
    one, same, other = (lay(system, sample=2, seed=seed) for seed in (3, 3, 4))
    for k in (0, 1):
        np.testing.assert_array_equal(one.samples[k].system.centre, same.samples[k].system.centre)
    assert np.abs(one.samples[0].system.centre - one.samples[1].system.centre).max() > 0.5
    assert np.abs(one.samples[0].system.centre - other.samples[0].system.centre).max() > 0.5
    np.testing.assert_array_equal(one.system.centre, other.system.centre)


def test_samples_can_start(read):
    for design in (laying.hairpins([4, 12, 40]), laying.linker(1, 20), laying.tailed(12, 20)):
        laid = lay(read(design), sample=2, seed=1)
        for one in laid.samples:
            assert not one.conflicts
            laying.assert_starts(one.system, of(laid))


def test_a_strand_and_its_sample_do_not_depend_on_strands_that_are_far(read):
    few, many = (lay(read(laying.pairs(count, 5)), sample=1) for count in (1, 3))
    rows = few.strands[0].nucleotides
    np.testing.assert_array_equal(many.strands[0].nucleotides, rows)
    for one, other in ((few.system, many.system), (few.samples[0].system, many.samples[0].system)):
        np.testing.assert_array_equal(one.centre[rows], other.centre[rows])


def test_long_strands_are_called_random_coils_by_their_persistence_length(read):
    system = read(laying.hairpins([3, 60]))
    assert [bool(one.remark) for one in lay(system).strands] == [False, True]
    stiff = lay(system, persistence_length_nm=50)
    assert not any(one.remark for one in stiff.strands)
    assert (
        "random coil: 13 persistence lengths"
        in lay(system, persistence_length_nm=3).strands[1].remark
    )


def test_what_cannot_be_brought_apart_is_named_with_both(read):
    # its ends are almost as far apart as its bonds can be, and two helices are between them
    laid = lay(read(laying.linker(3, 8)))
    (one,) = laid.strands
    assert one.status == "laid"
    assert one.conflicts
    conflict = one.conflicts[0]
    assert one.label in conflict.sentence
    assert laid.system.label[conflict.second] in conflict.sentence
    found = bonds(laid.system)
    own = of(laid)[found.first] | of(laid)[found.second]
    assert np.isfinite(found.backbone[own]).all()


def test_records_say_how_a_strand_lies(read):
    laid = lay(read(laying.hairpins([12])))
    (one,) = laid.strands
    assert len(one) == 12
    assert one.spacing == pytest.approx(one.length / 13)
    assert one.energy == pytest.approx(one.energy_per_nm * one.length_nm, rel=1e-12)
    assert one.nearest > 0.4
    assert repr(one) == "<LaidStrand: hairpin of 12, rod>"
    assert "0 refused" in repr(laid)
    assert not one.nucleotides.flags.writeable
    assert not laid.system.centre.flags.writeable


def test_a_system_without_single_strands_stays_as_it_is(read):
    system = read(duplex(20))
    laid = lay(system, sample=1)
    assert laid.strands == ()
    np.testing.assert_array_equal(laid.system.centre, system.centre)
    np.testing.assert_array_equal(laid.samples[0].system.centre, system.centre)


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"tails": "curly"}, "`tails`"),
        ({"sample": -1}, "`sample`"),
        ({"seed": 0.5}, "`seed`"),
        ({"persistence_length_nm": 0}, "`persistence_length_nm`"),
    ],
)
def test_bad_options_are_named(read, options, sentence):
    with pytest.raises(ValueError, match=sentence):
        lay(read(duplex(20)), **options)


def test_a_paired_nucleotide_without_a_place_is_named(read):
    system = read(duplex(20))
    placed = np.arange(len(system)) != 7
    with pytest.raises(ValueError, match="helix 0, offset 7 is paired and has no place"):
        lay(replace(system, placed=placed))


def test_strands_in_a_periodic_box_lie_as_they_do_without_one(read):
    system = read(laying.hairpins([9, 9]))
    free = lay(system).system
    shifted = lay(replace(system, box=np.full(3, 60.0), centre=system.centre + 55.0)).system
    np.testing.assert_allclose(shifted.centre - 55.0, free.centre, atol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("design", ["hairpins", "linker"])
def test_dynamics_of_the_start_run_in_lammps(read, design, tmp_path):
    made = laying.hairpins([3, 7, 20]) if design == "hairpins" else laying.linker(2, 8)
    system = lay(read(made)).system
    centre, energy = oracle.run(system, tmp_path, 10_000)
    assert np.isfinite(centre).all()
    assert energy < -0.5 * len(system)


def test_files_of_oxdna_go_round_with_paired_nucleotides_unchanged(read, tmp_path):
    system = lay(read(laying.hairpins([7, 20]))).system
    write_oxdna(system, tmp_path / "a.top", tmp_path / "a.dat")
    files = read_oxdna(tmp_path / "a.top")
    np.testing.assert_array_equal(files.system.pair >= 0, system.pair >= 0)
    laid = lay(files.system)
    assert [len(one) for one in laid.strands] == [7, 20]
    laying.assert_starts(laid.system, of(laid))
    write_oxdna(laid.system, tmp_path / "b.top", tmp_path / "b.dat", files=files)
    before, after = ((tmp_path / name).read_bytes().splitlines() for name in ("a.dat", "b.dat"))
    paired = np.flatnonzero(system.pair >= 0)
    assert [after[3 + i] for i in paired] == [before[3 + i] for i in paired]
    assert (tmp_path / "a.top").read_bytes() == (tmp_path / "b.top").read_bytes()
