from dataclasses import replace

import numpy as np
import oracle
import pytest
import strands
from scipy.spatial.transform import Rotation

from loopelastica.nanostructures.oxdna.energies import (
    base_numbers,
    bonds,
    coaxial_stacking,
    electrostatics,
    energies,
    excluded_volume,
    hydrogen_bonds,
)
from loopelastica.nanostructures.oxdna.model import backbone_sites

SEQUENCE = "GCATTGCAGCTTAGC"
MADE = {
    "an ideal duplex": lambda rng: strands.helix(SEQUENCE),
    "a shaken duplex": lambda rng: strands.shaken(strands.helix(SEQUENCE), rng),
    "a nicked duplex": lambda rng: strands.shaken(strands.nicked(SEQUENCE, 7), rng, 0.01, 0.05),
    "a hairpin": lambda rng: strands.hairpin("GCGTAC", "TTTTTT"),
    "a shaken hairpin": lambda rng: strands.shaken(strands.hairpin("GCGTAC", "TATAGA"), rng),
}


@pytest.fixture(params=MADE)
def made(request, rng):
    return MADE[request.param](rng)


@pytest.mark.parametrize(("temperature_K", "salt_M"), [(300.0, 0.5), (330.0, 0.2)])
def test_each_energy_is_that_of_lammps(made, tmp_path, temperature_K, salt_M):
    theirs = oracle.energies(made, tmp_path, temperature_K / 3000, salt_M)
    ours = energies(made, temperature_K, salt_M)
    volume = ours["bonded_excluded_volume"] + ours["nonbonded_excluded_volume"]
    # LAMMPS has no half charges at ends
    charges = electrostatics(made, temperature_K, salt_M, half_charged_ends=False).energy.sum()
    for mine, other in (
        (ours["backbone"], "bond"),
        (volume, "excv"),
        (ours["stacking"], "stk"),
        (ours["hydrogen_bonding"], "hbond"),
        (ours["cross_stacking"], "xstk"),
        (ours["coaxial_stacking"], "coaxstk"),
        (charges, "dh"),
    ):
        assert mine == pytest.approx(theirs[other], rel=2e-6, abs=1e-9), other


def test_energies_of_a_shaken_nicked_duplex_are_those_that_lammps_gave():
    """Without LAMMPS too: values of its version of 2025-07-22, of a duplex drawn from a seed."""
    rng = np.random.default_rng(21)
    system = strands.shaken(strands.nicked(SEQUENCE, 7), rng, 0.01, 0.05)
    ours = energies(system, 300.0, 0.5)
    charges = electrostatics(system, 300.0, 0.5, half_charged_ends=False).energy.sum()
    assert ours["backbone"] == pytest.approx(0.6196799374, rel=1e-9)
    assert ours["bonded_excluded_volume"] == 0
    assert ours["nonbonded_excluded_volume"] == pytest.approx(0.8751876907, rel=1e-9)
    assert ours["stacking"] == pytest.approx(-27.3791307693, rel=1e-9)
    assert ours["hydrogen_bonding"] == pytest.approx(-11.8160877748, rel=1e-9)
    assert ours["cross_stacking"] == pytest.approx(-4.5499634185, rel=1e-9)
    assert ours["coaxial_stacking"] == pytest.approx(-0.6039553972, rel=1e-9)
    # screening of charges: constants of the program have fewer digits
    assert charges == pytest.approx(0.2264449187, rel=2e-6)


def test_excluded_volume_of_strands_that_overlap_is_that_of_lammps(tmp_path, rng):
    one = strands.shaken(strands.helix(SEQUENCE), rng)
    other = strands.moved(one, Rotation.from_euler("xy", [70, 20], degrees=True), [1.2, 0.3, 2.0])
    n = len(SEQUENCE)
    both = strands.system_of(
        [
            ("".join(s.base[k]), s.centre[k], s.a1[k], s.a3[k])
            for s in (one, other)
            for k in (slice(0, n), slice(n, 2 * n))
        ]
    )
    ours = energies(both)
    assert ours["nonbonded_excluded_volume"] > 1
    total = ours["bonded_excluded_volume"] + ours["nonbonded_excluded_volume"]
    assert total == pytest.approx(oracle.energies(both, tmp_path)["excv"], rel=1e-6)


def test_energies_do_not_depend_on_where_the_system_is(made, rng):
    there = strands.moved(made, Rotation.random(rng=rng), [3.0, -40.0, 7.0])
    for name, energy in energies(made).items():
        assert energies(there)[name] == pytest.approx(energy, rel=1e-7, abs=1e-9), name


def test_energies_do_not_depend_on_the_periodic_image(made, rng):
    box = np.array([31.0, 29.0, 37.0])
    images = rng.integers(-2, 3, size=(len(made), 3))
    wrapped = replace(made, centre=made.centre + images * box, box=box)
    for name, energy in energies(made).items():
        assert energies(wrapped)[name] == pytest.approx(energy, rel=1e-7, abs=1e-9), name


def test_energies_do_not_depend_on_the_order_of_strands():
    one = strands.nicked(SEQUENCE, 7)
    parts = [np.flatnonzero(one.strand == k) for k in (2, 0, 1)]
    other = strands.system_of(
        [("".join(one.base[p]), one.centre[p], one.a1[p], one.a3[p]) for p in parts]
    )
    for name, energy in energies(one).items():
        assert energies(other)[name] == pytest.approx(energy), name


def test_a_nick_stacks_coaxially_where_a_bond_did():
    whole, nicked = strands.helix(SEQUENCE), strands.nicked(SEQUENCE, 7)
    assert energies(whole)["coaxial_stacking"] == 0
    found = coaxial_stacking(nicked)
    assert {*found.first.tolist(), *found.second.tolist()} == {6, 7}
    assert found.energy.sum() < -0.5


def test_bonds_out_of_the_window_have_no_finite_energy():
    system = strands.helix("ACGT")
    centre = system.centre.copy()
    centre[0] += [0, 0, -1]
    found = bonds(replace(system, centre=centre))
    assert np.isinf(found.backbone).tolist() == [True] + [False] * 5
    assert found.length[0] > 1.0064
    assert (found.first[0], found.second[0]) == (0, 1)


def test_an_unstretched_bond_has_no_energy():
    system = strands.helix("AC")
    sites = backbone_sites(system.centre, system.a1, system.a3)
    bond = sites[1] - sites[0]
    centre = system.centre.copy()
    centre[1] += bond * (0.7564 / np.linalg.norm(bond) - 1)
    assert bonds(replace(system, centre=centre)).backbone[0] == pytest.approx(0.0, abs=1e-12)


def test_nucleotides_without_a_place_have_no_energy():
    system = strands.helix(SEQUENCE)
    n = len(SEQUENCE)
    placed = np.arange(2 * n) < n
    centre = np.where(placed[:, None], system.centre, np.nan)
    alone = replace(system, placed=placed, centre=centre)
    found = energies(alone)
    assert found["hydrogen_bonding"] == found["cross_stacking"] == 0
    assert len(bonds(alone).first) == n - 1
    assert found["stacking"] == pytest.approx(energies(system)["stacking"] / 2)


def test_a_system_without_any_place_has_no_energies():
    system = replace(strands.helix("ACGT"), placed=np.zeros(8, dtype=bool))
    assert set(energies(system).values()) == {0.0}


def test_special_bases_bind_only_their_own_partner():
    system = strands.helix("ACG")
    bases = np.array(["A", "C", "G", "C", "-10", "T"])
    assert len(hydrogen_bonds(replace(system, base=bases)).energy) == 2
    bases = np.array(["A", "13", "G", "C", "-10", "T"])
    found = hydrogen_bonds(replace(system, base=bases))
    assert (1, 4) in list(zip(found.first.tolist(), found.second.tolist(), strict=True))
    assert base_numbers(np.array(["13", "-10"])).sum() == 3


def test_two_nucleotides_in_one_place_repel_each_other_finitely():
    system = strands.helix("AAAA")
    centre, a1, a3 = (getattr(system, x).copy() for x in ("centre", "a1", "a3"))
    for x in (centre, a1, a3):
        x[3] = x[0]
    found = excluded_volume(replace(system, centre=centre, a1=a1, a3=a3))
    assert np.isfinite(found.energy).all()
    assert found.energy.max() > 1e10


@pytest.mark.parametrize(("name", "value"), [("temperature_K", 0.0), ("salt_M", float("nan"))])
def test_impossible_conditions_are_refused_by_name(name, value):
    with pytest.raises(ValueError, match=f"`{name}`"):
        energies(strands.helix("ACGT"), **{name: value})
