"""Helices moved so that strands can cross between them."""

from dataclasses import replace

import helix_designs as designs
import numpy as np
import oracle
import pytest
from scipy.spatial.transform import Rotation

from loopelastica.nanostructures.laying.lay import lay
from loopelastica.nanostructures.oxdna.checks import check_start
from loopelastica.nanostructures.oxdna.energies import bonds, excluded_volume
from loopelastica.nanostructures.scadnano.fitting import Crossings, _Fit, fitted
from loopelastica.nanostructures.scadnano.helices import Helices
from loopelastica.nanostructures.scadnano.reading import read_design

sc = designs.sc


def crossed(grid, every=32, count=3):
    """Two helices, whole strands on the one side, strands that cross and go back on the other."""
    length = every * count
    places = ((0, 0), (0, 1))
    helices = [sc.Helix(max_offset=length, grid_position=place) for place in places]
    design = sc.Design(helices=helices, grid=grid)
    design.draw_strand(0, length).move(-length)
    design.draw_strand(1, 0).move(length)
    for start in range(0, length, every):
        design.draw_strand(0, start).move(every).cross(1).move(-every)
    return design


def rectangle():
    """A rectangle as published ones are: eight helices, 8 columns of staples."""
    module = pytest.importorskip("scadnano.origami_rectangle")
    return module.create(num_helices=8, num_cols=8, assign_seq=False)


@pytest.fixture
def read(tmp_path):
    def made(design, **options):
        return read_design(designs.write(design, tmp_path), **options)

    return made


def test_a_rectangle_that_is_drawn_out_of_the_window_fits_as_a_whole(read):
    drawn, fit = read(rectangle()), read(rectangle(), fit=True)
    assert len(check_start(drawn.system).broken) > 50
    assert check_start(fit.system).sound
    assert any("helices were fitted" in note for note in fit.notes)
    assert not any("`helices`" in note for note in fit.notes)
    assert any("`helices`" in note for note in drawn.notes)


def test_helices_that_were_fitted_do_not_run_into_each_other(read):
    system = read(rectangle(), fit=True).system
    # the ideal duplex has nothing of this; thermal energy is 0.1 per nucleotide
    assert excluded_volume(system).energy.sum() < 0.1 * len(system)


def test_the_duplex_itself_stays_what_it_was(read):
    drawn, fit = read(rectangle()).system, read(rectangle(), fit=True).system
    before, after = (bonds(system).length for system in (drawn, fit))
    along = before < 0.8  # bonds along a helix; those between helices are longer than 1
    np.testing.assert_allclose(after[along], before[along], atol=0.01)
    before, after = (
        np.linalg.norm(each.centre - each.centre[each.pair], axis=1) for each in (drawn, fit)
    )
    np.testing.assert_allclose(after, before, atol=1e-9)


@pytest.mark.parametrize("grid", ["square", "honeycomb", "hex"])
def test_two_helices_come_near_on_any_grid(read, grid):
    design = crossed(sc.Grid[grid])
    drawn, fit = read(design).system, read(design, fit=True).system
    assert len(check_start(drawn).broken)
    assert check_start(fit).sound


def test_crossings_that_cannot_fit_are_counted_and_push_no_helices_into_each_other(read):
    # every one and a half turns: on opposite sides of the helix
    design = read(crossed(sc.square, every=16, count=6), fit=True)
    faults = check_start(design.system)
    assert len(faults.broken)
    assert not len(faults.close)
    (note,) = (note for note in design.notes if "fitted" in note)
    assert f"of 6 bonds between helices {len(faults.broken)} are outside" in note
    a, b = design.axes
    assert np.linalg.norm(np.cross(b.begin - a.begin, a.direction)) > 2.2


def test_helices_without_crossings_stay_where_they_are(read):
    design = designs.linker(12, apart=2)
    one, other = read(design), read(design, fit=True)
    np.testing.assert_array_equal(one.system.centre, other.system.centre)
    assert one.notes == other.notes


def test_single_strands_are_laid_between_fitted_helices(read):
    design = rectangle()
    for helix in range(8):
        end = design.helices[helix].max_offset
        design.helices[helix].max_offset = end + 16
        design.draw_strand(helix, end).move(16).loopout(helix, 6).move(-16)
    laid = lay(read(design, fit=True).system)
    assert {one.status for one in laid.strands} == {"laid"}
    assert check_start(laid.system).sound


def two_helices():
    rng = np.random.default_rng(3)
    n = 5
    axis = np.tile([0.0, 0.0, 1.0], (n, 1))
    origin = np.column_stack([3.5 * np.arange(n), np.zeros(n), rng.normal(size=n)])
    up = np.column_stack([np.cos(np.arange(n)), np.sin(np.arange(n)), np.zeros(n)])
    ones = np.ones(n)
    helices = Helices(
        np.arange(n), origin, axis, up, 0.39 * ones, 0.6 * ones, np.radians(150) * ones
    )
    row = np.array([[0, 1, 2, 3, 0], [1, 2, 3, 4, 1]])
    steps = np.array([[5, 10, 20, 30, 37], [5, 11, 20, 30, 37]], dtype=float)
    forward = np.array([[True, False, True, False, False], [False, True, False, True, True]])
    return helices, Crossings(row, steps, forward), np.tile([0.0, 40.0], (n, 1))


def test_derivatives_are_those_of_central_differences():
    fit = _Fit(*two_helices())
    rng = np.random.default_rng(1)
    x = rng.normal(scale=0.3, size=fit.scale.size)
    slopes = fit._slopes(x).toarray()
    step = 1e-6
    for k in range(len(x)):
        ahead, behind = x.copy(), x.copy()
        ahead[k] += step
        behind[k] -= step
        difference = (fit._misses(ahead) - fit._misses(behind)) / (2 * step)
        np.testing.assert_allclose(slopes[:, k], difference, atol=1e-6)


def test_a_design_that_is_moved_and_turned_is_fitted_alike():
    helices, crossings, extent = two_helices()
    turn, shift = Rotation.from_rotvec([0.4, -1.1, 0.7]), np.array([5.0, -3.0, 11.0])
    moved = replace(
        helices,
        origin=turn.apply(helices.origin) + shift,
        direction=turn.apply(helices.direction),
        up=turn.apply(helices.up),
    )
    one, other = (fitted(each, crossings, extent)[0] for each in (helices, moved))
    np.testing.assert_allclose(other.origin, turn.apply(one.origin) + shift, atol=1e-4)
    np.testing.assert_allclose(other.up, turn.apply(one.up), atol=1e-4)
    np.testing.assert_allclose(other.direction, turn.apply(one.direction), atol=1e-12)


@pytest.mark.slow
def test_dynamics_of_a_fitted_rectangle_run_in_lammps(read, tmp_path):
    system = read(rectangle(), fit=True).system
    centre, energy = oracle.run(system, tmp_path, 1000)
    assert np.isfinite(centre).all()
    assert energy < -0.8 * len(system)
