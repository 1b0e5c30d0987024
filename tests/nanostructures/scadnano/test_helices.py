"""Helices in the geometry of oxDNA2; the oracles are scadnano's exporter and its angles."""

import dataclasses

import helix_designs as designs
import numpy as np
import pytest

from loopelastica.errors import StructureError
from loopelastica.nanostructures.oxdna.energies import bonds
from loopelastica.nanostructures.oxdna.model import HELIX_RADIUS, UNIT_NM, backbone_sites
from loopelastica.nanostructures.oxdna.pairing import find_pairs
from loopelastica.nanostructures.scadnano.helices import helix_bond
from loopelastica.nanostructures.scadnano.reading import read_design

sc = designs.sc


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_with_the_models_groove_nucleotides_are_where_scadnano_exports_them(tmp_path, seed):
    design = designs.turned_groups(minor_groove_angle=140, seed=seed)
    system = read_design(designs.write(design, tmp_path)).system
    assert system.placed.all()
    for own, theirs in zip(
        (system.centre, system.a1, system.a3), designs.exported(design), strict=True
    ):
        np.testing.assert_allclose(own, theirs, atol=1e-9)


@pytest.mark.parametrize("groove", [120, 150])
def test_with_another_groove_each_centre_turns_by_half_of_what_partners_miss(tmp_path, groove):
    design = designs.turned_groups(minor_groove_angle=groove)
    system = read_design(designs.write(design, tmp_path)).system
    _, a1, _ = designs.exported(design)
    np.testing.assert_allclose((system.a1 * a1).sum(1), np.cos(np.radians((groove - 140) / 2)))


def test_partners_face_each_other_and_their_bases_are_as_far_apart_as_in_the_model(tmp_path):
    system = read_design(designs.write(designs.turned_groups(150), tmp_path)).system
    np.testing.assert_allclose(system.a1, -system.a1[system.pair], atol=1e-9)
    bases = system.centre + 0.4 * system.a1
    np.testing.assert_allclose(np.linalg.norm(bases - bases[system.pair], axis=1), 0.4)


def test_axes_are_orthonormal(tmp_path):
    system = read_design(designs.write(designs.turned_groups(150), tmp_path)).system
    axes = np.stack([system.a1, system.a2, system.a3], axis=2)
    identity = np.broadcast_to(np.eye(3), axes.shape)
    np.testing.assert_allclose(axes.transpose(0, 2, 1) @ axes, identity, atol=1e-12)


def test_base_normals_point_from_3_to_5(tmp_path):
    system = read_design(designs.write(designs.duplex(), tmp_path)).system
    inner = np.flatnonzero(system.n5 >= 0)
    steps = system.centre[system.n5[inner]] - system.centre[inner]
    np.testing.assert_allclose((steps * system.a3[inner]).sum(1), 0.332 / UNIT_NM)


@pytest.mark.parametrize("forward", [True, False])
@pytest.mark.parametrize("groove", [140, 150])
def test_backbones_are_at_the_angles_that_scadnano_draws(tmp_path, forward, groove):
    design = designs.duplex(21, minor_groove_angle=groove)
    design.helices[0].roll = 25
    read = read_design(designs.write(design, tmp_path))
    system = read.system
    # in scadnano's side view x points right and y down, and 0° is straight up, turning clockwise
    x, y, _ = (backbone_sites(system.centre, system.a1, system.a3) - read.axes[0].begin).T
    drawn = np.degrees(np.arctan2(x, -y))
    own = system.strand == (0 if forward else 1)
    geometry = design.geometry
    expected = [
        design.helices[0].backbone_angle_at_offset(offset, forward, geometry)
        for offset in read.offset[own].tolist()
    ]
    difference = (drawn[own] - expected + 180) % 360 - 180
    # 140°, to the tenth of a degree that the model's sites leave
    assert np.abs(difference).max() < (groove - 140) / 2 + 0.1


@pytest.mark.parametrize(("rise", "bases"), [(0.332, 10.5), (0.34, 10.67), (0.28, 11.0)])
def test_bonds_along_a_helix_have_the_length_that_is_stated(tmp_path, rise, bases):
    design = designs.duplex(rise_per_base_pair=rise, bases_per_turn=bases)
    found = bonds(read_design(designs.write(design, tmp_path)).system)
    np.testing.assert_allclose(found.length, helix_bond(rise / UNIT_NM, 2 * np.pi / bases))
    assert np.isfinite(found.backbone).all()


def test_centres_stand_at_the_models_radius_around_the_designs_axes(tmp_path):
    read = read_design(designs.write(designs.turned_groups(150), tmp_path))
    system = read.system
    axes = {axis.index: axis for axis in read.axes}
    assert len(axes) == 16
    for index, axis in axes.items():
        own = system.centre[read.helix == index] - axis.begin
        along = own @ axis.direction
        distance = np.linalg.norm(own - along[:, None] * axis.direction, axis=1)
        np.testing.assert_allclose(distance, HELIX_RADIUS)
        assert along.min() == pytest.approx(0, abs=1e-9)
        assert along.max() == pytest.approx(np.linalg.norm(axis.end - axis.begin))


def test_groups_have_their_own_geometry(tmp_path):
    groups = {
        "a": sc.HelixGroup(grid=sc.square),
        "b": sc.HelixGroup(grid=sc.square, geometry=sc.Geometry(rise_per_base_pair=0.3)),
    }
    helices = [sc.Helix(max_offset=20, group=name, grid_position=(0, 0)) for name in groups]
    groups["b"].position = sc.Position3D(50, 0, 0)
    design = sc.Design(helices=helices, groups=groups)
    for i in range(2):
        design.draw_strand(i, 0).move(20)
        design.draw_strand(i, 20).move(-20)
    first, second = read_design(designs.write(design, tmp_path)).axes
    assert np.linalg.norm(first.end - first.begin) == pytest.approx(19 * 0.332 / UNIT_NM)
    assert np.linalg.norm(second.end - second.begin) == pytest.approx(19 * 0.3 / UNIT_NM)


@pytest.mark.parametrize(
    ("geometry", "said"),
    [
        ({"rise_per_base_pair": 1.0}, "a rise of 1 nm and 10.5 bases per turn make every bond 1.3"),
        ({"bases_per_turn": 2.0}, "make every bond 2.0"),
        ({"rise_per_base_pair": -0.332}, "rise_per_base_pair is -0.332; it must be above 0"),
        ({"bases_per_turn": 0}, "bases_per_turn is 0; it must be above 0"),
    ],
)
def test_a_geometry_in_which_no_strand_can_be_bound_is_refused(tmp_path, geometry, said):
    path = designs.write(designs.duplex(**geometry), tmp_path)
    with pytest.raises(StructureError, match="geometry of helix 0") as caught:
        read_design(path)
    assert said in str(caught.value)


def test_a_helix_turns_with_its_group_and_nothing_of_it_changes(tmp_path):
    flat = designs.turned_groups(150)
    turned = designs.turned_groups(150)
    for group in turned.groups.values():
        group.yaw, group.pitch, group.roll = group.yaw + 70, -group.pitch, group.roll - 33
    one, other = (read_design(designs.write(design, tmp_path)).system for design in (flat, turned))
    assert np.abs(one.centre - other.centre).max() > 1
    lengths = [bonds(s).length for s in (one, other)]
    np.testing.assert_allclose(*lengths)


def test_partners_are_those_that_the_models_hydrogen_bonds_find(tmp_path):
    system = read_design(designs.write(designs.turned_groups(150), tmp_path)).system
    np.testing.assert_array_equal(find_pairs(system), system.pair)


def test_bases_stack_along_each_strand(tmp_path):
    system = read_design(designs.write(designs.duplex(), tmp_path)).system
    # turned over, with a3 from 5' to 3', nothing stacks
    assert bonds(system).stacking.max() < -1
    over = dataclasses.replace(system, a3=-system.a3)
    np.testing.assert_array_equal(bonds(over).stacking, 0)
