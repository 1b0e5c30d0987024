"""The clamps depend on the stem only, and move with it."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from loopelastica.errors import StructureError
from loopelastica.molecule.clamp_rule import StemClamp
from loopelastica.molecule.ends import fit_stem, stem_ends
from loopelastica.molecule.hairpins import find_hairpins
from loopelastica.molecule.nucleotides import BACKBONE, centroids, read_structure
from loopelastica.molecule.strands import A_RNA, B_DNA, line_frame, strand_atoms


def arrays(ends):
    return {
        "origins": np.array([ends.start_origin_A, ends.end_origin_A]),
        "frames": np.array([ends.start_frame, ends.end_frame]),
        "misfit": np.concatenate([ends.fit_rms_A, ends.stem_rms_A]),
    }


@pytest.fixture(scope="module")
def hairpin(koc):
    return find_hairpins(koc)[0]


@settings(max_examples=20, deadline=None)
@given(
    turn=st.tuples(*[st.floats(-3, 3)] * 3),
    shift=st.tuples(*[st.floats(-100, 100)] * 3),
)
def test_the_clamps_move_with_the_molecule(koc, hairpin, turn, shift):
    positions, rotation = koc.positions(0).copy(), Rotation.from_rotvec(turn)
    here = arrays(stem_ends(koc.nucleotides, hairpin, positions))
    there = arrays(stem_ends(koc.nucleotides, hairpin, rotation.apply(positions) + shift))
    np.testing.assert_allclose(there["origins"], rotation.apply(here["origins"]) + shift, atol=1e-9)
    np.testing.assert_allclose(there["frames"], rotation.as_matrix() @ here["frames"], atol=1e-9)
    np.testing.assert_allclose(there["misfit"], here["misfit"], atol=1e-9)


def test_no_atom_of_the_loop_is_looked_at(koc, hairpin):
    positions = koc.positions(0)
    loop = koc.nucleotides.atom_index[hairpin.loop]
    scrambled = positions.copy()
    scrambled[loop[loop >= 0]] = np.random.default_rng(1).normal(size=((loop >= 0).sum(), 3)) * 50
    missing = positions.copy()
    missing[loop[loop >= 0]] = np.nan
    here = arrays(stem_ends(koc.nucleotides, hairpin, positions))
    for other in (scrambled, missing):
        there = arrays(stem_ends(koc.nucleotides, hairpin, other))
        for name, value in here.items():
            np.testing.assert_array_equal(there[name], value)


@pytest.mark.parametrize("strand", [A_RNA, B_DNA], ids=lambda strand: strand.name)
def test_an_ideal_stem_gives_back_its_own_helix_line(koc, hairpin, strand):
    hairpin = dataclasses.replace(hairpin, is_dna=strand is B_DNA)
    backbone = koc.nucleotides.columns(BACKBONE)
    rng = np.random.default_rng(2)
    rotations = Rotation.random(2, rng)
    shifts = rng.normal(size=(2, 3)) * 20
    positions = koc.positions(0).copy()
    for rows, step, rotation, shift in zip(
        (hairpin.stem_5, hairpin.stem_3), (-1, 1), rotations, shifts, strict=True
    ):
        for k, row in enumerate(rows[:2]):
            atoms = backbone[row]
            positions[atoms] = rotation.apply(strand_atoms(strand, step * k)) + shift
    ends = stem_ends(koc.nucleotides, hairpin, positions)
    assert max(*ends.fit_rms_A, *ends.stem_rms_A) < 1e-12
    assert ends.length_A == pytest.approx(4 * strand.length_per_nucleotide_A)
    for origin, frame, phase, rotation, shift in zip(
        (ends.start_origin_A, ends.end_origin_A),
        (ends.start_frame, ends.end_frame),
        (0.5, -0.5),
        rotations,
        shifts,
        strict=True,
    ):
        point, ideal = line_frame(strand, phase)
        np.testing.assert_allclose(origin, rotation.apply(point) + shift, atol=1e-12)
        np.testing.assert_allclose(frame, rotation.as_matrix() @ ideal, atol=1e-12)


def test_the_clamps_lie_near_the_native_line_and_point_along_it(koc, hairpin):
    for positions in koc.models():
        middle = centroids(koc.nucleotides, positions)
        ends = stem_ends(koc.nucleotides, hairpin, positions)
        for origin, frame, i in (
            (ends.start_origin_A, ends.start_frame, 4),
            (ends.end_origin_A, ends.end_frame, 8),
        ):
            step = middle[i + 1] - middle[i]
            assert np.linalg.norm(origin - (middle[i] + middle[i + 1]) / 2) < 1.5
            assert frame[:, 2] @ step / np.linalg.norm(step) > np.cos(np.deg2rad(30))


def test_frames_are_rotations_that_look_at_the_axis(koc, hairpin):
    ends = stem_ends(koc.nucleotides, hairpin, koc.positions(0))
    stem = np.concatenate([hairpin.stem_5, hairpin.stem_3])
    axis_point = np.nanmean(centroids(koc.nucleotides, koc.positions(0))[stem[[0, 1, 5, 6]]], 0)
    for origin, frame in (
        (ends.start_origin_A, ends.start_frame),
        (ends.end_origin_A, ends.end_frame),
    ):
        np.testing.assert_allclose(frame.T @ frame, np.eye(3), atol=1e-12)
        assert np.linalg.det(frame) == pytest.approx(1.0)
        assert frame[:, 0] @ (axis_point - origin) > 0


def test_one_missing_atom_is_made_up_for_by_the_other_five(pdb, koc_lines, koc, hairpin):
    lines = [line for line in koc_lines if line[12:26] != " C5'   C A   5"]
    structure = read_structure(pdb(lines))
    ends = stem_ends(structure.nucleotides, find_hairpins(structure)[0], structure.positions(0))
    full = stem_ends(koc.nucleotides, hairpin, koc.positions(0))
    assert np.linalg.norm(ends.start_origin_A - full.start_origin_A) < 0.5
    np.testing.assert_allclose(ends.end_origin_A, full.end_origin_A, atol=1e-9)


def test_too_few_atoms_name_residue_fact_and_consequence(pdb, koc_lines):
    gone = (" P    ", " O5'  ", " C5'  ")
    lines = [line for line in koc_lines if not (int(line[22:26]) == 10 and line[12:18] in gone)]
    structure = read_structure(pdb(lines))
    (hairpin,) = find_hairpins(structure)
    with pytest.raises(StructureError) as caught:
        stem_ends(structure.nucleotides, hairpin, structure.positions(0))
    assert str(caught.value) == ("A.G10: no P, O5' and C5' atoms; its stem frame cannot be placed")


@pytest.mark.parametrize(("value", "fact"), [(np.nan, "no numbers"), (0.0, "at the origin")])
def test_a_stem_without_a_place_is_refused(koc, hairpin, value, fact):
    positions = koc.positions(0).copy()
    positions[koc.nucleotides.columns(BACKBONE)[hairpin.stem_3[0]]] = value
    with pytest.raises(StructureError, match=f"A.G10: .*{fact}.*; its stem frame"):
        stem_ends(koc.nucleotides, hairpin, positions)


def test_a_stem_of_one_pair_has_no_stem_misfit(koc, hairpin):
    short = dataclasses.replace(hairpin, stem_5=hairpin.stem_5[:1], stem_3=hairpin.stem_3[:1])
    ends = stem_ends(koc.nucleotides, short, koc.positions(0))
    assert ends.stem_rms_A is None
    full = stem_ends(koc.nucleotides, hairpin, koc.positions(0))
    np.testing.assert_array_equal(ends.start_origin_A, full.start_origin_A)


def test_dna_stem_whose_outer_nucleotide_lacks_its_phosphate(hairpins_folder):
    structure = read_structure(hairpins_folder / "1kr8.pdb.gz")
    (hairpin,) = find_hairpins(structure)
    assert hairpin.n_pairs == 2
    ends = stem_ends(structure.nucleotides, hairpin, structure.positions(0))
    assert ends.length_A == pytest.approx(18.9)
    assert ends.fit_rms_A.max() < 1.0


def test_the_z_stem_is_noticed_and_no_other(hairpins_folder, structure_of, found_in):
    for path in sorted(hairpins_folder.glob("*.gz")):
        if path.name.startswith("1s72"):
            continue
        structure = structure_of(path.name)
        for hairpin in found_in(path.name):
            ends = stem_ends(structure.nucleotides, hairpin, structure.positions(0))
            misfit = 0.0 if ends.stem_rms_A is None else ends.stem_rms_A.max()
            assert (misfit > 1.3) == path.name.startswith("1d16"), (path.name, hairpin.name)


@pytest.mark.parametrize("short_A", [-0.1, 0.1])
def test_a_line_shorter_than_the_way_between_its_ends_is_refused(koc, hairpin, short_A):
    stem = fit_stem(koc.nucleotides, hairpin, koc.positions(0))
    distance_A = stem.ends(StemClamp(0, 0, 0.0, 6.0)).distance_A
    ends = stem.ends(StemClamp(0, 0, 0.0, (distance_A - short_A) / 4))
    if short_A < 0:
        assert ends.check_reach("loop") is ends
    else:
        with pytest.raises(StructureError, match=r"^loop: the stem ends are 14\.5 Å apart"):
            ends.check_reach("loop")
