import dataclasses
import re

import numpy as np
import pytest

from loopelastica.atoms.checks import check
from loopelastica.atoms.relax import Status
from loopelastica.atoms.site import NOBODY, Around, site_of


def around(positions, metal=False, owner=NOBODY):
    n = len(positions)
    return Around(
        np.asarray(positions),
        np.zeros(n, dtype=np.int64),
        np.full(n, metal),
        np.full(n, owner),
        np.full(n, "MG1:MG" if metal else "C1:C"),
    )


def test_what_is_broken_is_found(koc, fold, models):
    model = models[0]
    site = site_of(koc, fold, koc.positions(0), fold.candidates[0].line)
    good = model.relaxed.positions_A
    line = np.zeros((4, 3))

    def checked(positions):
        return check(site, positions, line, good, Status.CONVERGED)

    assert checked(good).sound
    far = good.copy()
    far[model.molecule.index(1, "P")] += 0.3
    assert checked(far).chain_worst_A > 0.05
    assert not checked(far).sound
    mirrored = good * [1.0, 1.0, -1.0]
    assert "1:C1'" in checked(mirrored).wrong_chirality
    close = good.copy()
    shift = site.around.positions_A[0] - good[model.molecule.index(2, "O2")]
    close[model.molecule.index(2, "O2")] += shift * (1 - 1.0 / np.linalg.norm(shift))
    assert checked(close).closest_A < 1.1
    assert not checked(close).sound


@pytest.mark.parametrize(("share", "wrong"), [(0.45, True), (0.55, False)])
def test_a_sugar_centre_flattened_below_half_its_volume_is_wrong(koc, fold, models, share, wrong):
    """C1' of the first nucleotide, moved towards the plane of its neighbours."""
    model, site = models[0], site_of(koc, fold, koc.positions(0), fold.candidates[0].line)
    positions = model.relaxed.positions_A.copy()
    centre, *around = (model.molecule.index(0, name) for name in ("C1'", "O4'", "C2'", "N1"))
    a, b, c = positions[around]
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal)
    # signed volume of C1' with O4', C2' and N1 in the fibre: 2.45 Å³
    height = share * 2.45 / np.linalg.norm(np.cross(b - a, c - a))
    above = (positions[centre] - a) @ normal
    positions[centre] += (np.copysign(height, above) - above) * normal
    checks = check(site, positions, np.zeros((4, 3)), positions, Status.CONVERGED)
    assert ("1:C1'" in checks.wrong_chirality) == wrong


@pytest.fixture
def checked(koc, fold, models):
    """Check positions of the first candidate, beside other atoms than the stem's if need be."""
    site = site_of(koc, fold, koc.positions(0), fold.candidates[0].line)

    def check_them(positions, others=None, status=Status.CONVERGED, **kinds):
        here = site if others is None else dataclasses.replace(site, around=around(others, **kinds))
        return check(here, positions, np.zeros((4, 3)), positions, status)

    return check_them


def test_a_mirror_image_turns_the_sign_of_chi_and_not_its_name(models, checked):
    good = models[0].relaxed.positions_A
    here, there = checked(good), checked(good * [1.0, 1.0, -1.0])
    np.testing.assert_allclose(here.chi_deg, -np.array(there.chi_deg))
    assert here.chi == there.chi
    assert "anti" in here.chi


@pytest.mark.parametrize(("distance_A", "clashes"), [(2.75, 1), (2.85, 0)])
def test_a_carbon_clashes_with_an_atom_of_the_stem_below_2_8_A(
    models, checked, distance_A, clashes
):
    model = models[0]
    positions = model.relaxed.positions_A
    loop = model.molecule.loop_atoms
    # beside C6 of a pyrimidine, where no other atom is near
    carbon = model.molecule.index(1, "C6")
    directions = np.random.default_rng(0).normal(size=(500, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    others = positions[[row for row in loop if row != carbon]]
    places = positions[carbon] + distance_A * directions
    room = np.linalg.norm(places[:, None] - others, axis=2).min(axis=1)
    assert room.max() > 3.0
    far = np.full((1, 3), 1e3)
    alone = checked(positions, far).clashes_per_1000
    beside = checked(positions, places[[room.argmax()]]).clashes_per_1000
    assert (beside - alone) * len(loop) / 1000 == pytest.approx(clashes)


def test_atoms_three_bonds_apart_as_across_a_ring_are_no_clash(models, checked):
    # in a pyrimidine N1 and C4 lie 2.8 Å apart, and the radii add up to 3.25 Å
    # of the two, the one without an overlap between nucleotides
    model = min(models, key=lambda one: one.checks.clashes_per_1000)
    molecule, positions = model.molecule, model.relaxed.positions_A
    n1, c4 = (positions[molecule.index(0, name)] for name in ("N1", "C4"))
    assert np.linalg.norm(n1 - c4) == pytest.approx(2.8, abs=0.1)
    assert checked(positions, np.full((1, 3), 1e3)).clashes_per_1000 == 0


@pytest.mark.parametrize(
    ("figure", "good", "bad", "phrase"),
    [
        ("worst_angle_deg", 9.9, 10.1, "angle .* off by 10°"),
        ("worst_bond_A", 0.049, 0.051, "bond .* off by 0.05 Å"),
        ("closest_A", 2.21, 2.19, "are 2.19 Å apart"),
        ("wrong_chirality", (), ("2:C3'",), "wrong hand at 2:C3'"),
        ("status", "converged", "the limit of steps was reached", "the limit of steps"),
    ],
)
def test_each_figure_by_itself_keeps_a_model_from_being_sound(models, figure, good, bad, phrase):
    checks = models[0].checks
    assert dataclasses.replace(checks, **{figure: good}).sound
    wrong = dataclasses.replace(checks, **{figure: bad})
    assert not wrong.sound
    assert wrong.excess > 0.0
    (told,) = wrong.wrong
    assert re.search(phrase, told)


def test_an_angle_that_is_off_is_found_and_named(models, checked):
    molecule, positions = models[0].molecule, models[0].relaxed.positions_A.copy()
    o6, c6, c5 = (molecule.index(3, name) for name in ("O6", "C6", "C5"))
    bond = positions[o6] - positions[c6]
    # about the normal of the plane of the three
    across = np.cross(np.cross(bond, positions[c5] - positions[c6]), bond)
    across *= np.linalg.norm(bond) / np.linalg.norm(across)
    angle = np.deg2rad(14.0)
    positions[o6] = positions[c6] + np.cos(angle) * bond + np.sin(angle) * across
    checks = checked(positions, np.full((1, 3), 1e3))
    assert checks.worst_angle_deg == pytest.approx(14.0, abs=3.0)
    assert "4:O6" in checks.worst_angle
    assert "4:C6" in checks.worst_angle
    assert not checks.sound


@pytest.mark.parametrize(("metal", "distance_A", "sound"), [
    (True, 1.95, True), (True, 1.85, False), (False, 2.15, False), (False, 2.25, True),
])  # fmt: skip
def test_a_metal_may_be_nearer_to_an_oxygen_than_anything_else(
    models, checked, metal, distance_A, sound
):
    molecule, positions = models[0].molecule, models[0].relaxed.positions_A
    oxygen, p = positions[molecule.index(1, "OP1")], positions[molecule.index(1, "P")]
    directions = np.random.default_rng(0).normal(size=(500, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    places = oxygen + distance_A * directions
    others = np.delete(positions, molecule.index(1, "OP1"), axis=0)
    room = np.linalg.norm(places[:, None] - others, axis=2).min(axis=1)
    place = places[[room.argmax()]]
    assert np.linalg.norm(place - p) > 2.3
    assert checked(positions, place, metal=metal).sound == sound
