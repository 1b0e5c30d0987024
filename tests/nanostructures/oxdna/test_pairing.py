from dataclasses import replace

import numpy as np
import pytest
import strands
from scipy.spatial.transform import Rotation

from loopelastica.nanostructures.oxdna.energies import hydrogen_bonds
from loopelastica.nanostructures.oxdna.model import duplex
from loopelastica.nanostructures.oxdna.pairing import BOND_ENERGY, find_helices, find_pairs

SEQUENCE = "GCATTGCAGCTTAGC"
N = len(SEQUENCE)


def paired(system):
    return replace(system, pair=find_pairs(system))


def crossed(gap=2.3):
    """Two duplexes side by side; a strand of each goes on in the other after the fourth pair."""
    one = strands.helix("GCATGACC")
    other = strands.moved(one, Rotation.identity(), [gap, 0.0, 0.0])
    n = 8

    def part(system, nucleotides):
        return (
            "".join(system.base[nucleotides]),
            system.centre[nucleotides],
            system.a1[nucleotides],
            system.a3[nucleotides],
        )

    def joined(*parts):
        sequence = "".join(p[0] for p in parts)
        return (sequence, *(np.concatenate([p[k] for p in parts]) for k in (1, 2, 3)))

    return strands.system_of(
        [
            joined(part(one, slice(0, 4)), part(other, slice(4, n))),
            joined(part(other, slice(0, 4)), part(one, slice(4, n))),
            part(one, slice(n, 2 * n)),
            part(other, slice(n, 2 * n)),
        ]
    )


def test_each_base_of_a_duplex_has_its_partner():
    expected = np.arange(2 * N)[::-1]
    np.testing.assert_array_equal(find_pairs(strands.helix(SEQUENCE)), expected)


def test_a_duplex_is_found_at_room_temperature(rng):
    shaken = strands.shaken(strands.helix(SEQUENCE), rng, shift=0.02, turn=0.08)
    np.testing.assert_array_equal(find_pairs(shaken), np.arange(2 * N)[::-1])


def test_bases_of_a_loop_have_no_partner():
    pair = find_pairs(strands.hairpin("GCGTAC", "TTTTTT"))
    np.testing.assert_array_equal(pair[6:12], -1)
    np.testing.assert_array_equal(pair[:6], np.arange(17, 11, -1))


def test_bases_that_do_not_fit_have_no_partner():
    system = strands.helix(SEQUENCE)
    bases = system.base.copy()
    bases[3] = "G"
    pair = find_pairs(replace(system, base=bases))
    assert pair[3] == pair[2 * N - 4] == -1
    assert (pair >= 0).sum() == 2 * N - 2


def test_a_design_without_a_sequence_is_paired_by_geometry():
    system = strands.helix(SEQUENCE)
    alike = replace(system, base=np.array(["T"] * 2 * N))
    assert (find_pairs(alike) == -1).all()
    np.testing.assert_array_equal(find_pairs(alike, any_bases=True), find_pairs(system))


def test_a_weak_hydrogen_bond_makes_no_pair():
    system = strands.helix("ACGTACGT")
    # one base turned about its normal by as much as leaves it little of its bond
    for degrees in (10.0, 20.0, 30.0, 40.0, 50.0):
        turn = Rotation.from_euler("z", degrees, degrees=True).as_matrix()
        a1 = system.a1.copy()
        a1[3] = turn @ a1[3]
        bent = replace(system, a1=a1)
        found = hydrogen_bonds(bent)
        energy = found.energy[(found.first == 3) | (found.second == 3)].min(initial=0)
        assert (find_pairs(bent)[3] >= 0) == (energy < BOND_ENERGY)
    assert energy > BOND_ENERGY


def test_of_two_partners_a_base_has_the_nearer_one():
    system = strands.helix("GCATTG")
    centre, a1, a3 = system.centre, system.a1, system.a3
    extra = centre[11] + 0.08 * np.array([0.0, 0.0, 1.0])
    more = strands.system_of(
        [
            ("".join(system.base[:6]), centre[:6], a1[:6], a3[:6]),
            (system.base[11], extra[None], a1[11:], a3[11:]),
            ("".join(system.base[6:]), centre[6:], a1[6:], a3[6:]),
        ]
    )
    pair = find_pairs(more)
    assert (pair[0], pair[6]) == (12, -1)


def test_pairs_do_not_depend_on_the_periodic_image(rng):
    box = np.array([30.0, 31.0, 32.0])
    system = strands.helix(SEQUENCE)
    images = rng.integers(-1, 2, size=(2 * N, 3))
    wrapped = replace(system, centre=system.centre + images * box, box=box)
    np.testing.assert_array_equal(find_pairs(wrapped), find_pairs(system))
    assert len(find_helices(paired(wrapped))) == 1


def test_a_duplex_is_one_helix():
    (helix,) = find_helices(paired(strands.helix(SEQUENCE)))
    np.testing.assert_array_equal(helix, np.stack([np.arange(N), 2 * N - 1 - np.arange(N)], axis=1))


def test_a_nick_does_not_end_a_helix():
    (helix,) = find_helices(paired(strands.nicked(SEQUENCE, 7)))
    np.testing.assert_array_equal(helix[:, 0], np.arange(N))


def test_the_stem_of_a_hairpin_is_one_helix():
    (helix,) = find_helices(paired(strands.hairpin("GCGTAC", "TTTTTT")))
    np.testing.assert_array_equal(helix, np.stack([np.arange(6), 17 - np.arange(6)], axis=1))


def test_a_crossover_leads_from_one_helix_to_another():
    system = paired(crossed())
    helices = find_helices(system)
    assert [len(helix) for helix in helices] == [8, 8]
    # the strands that do not cross hold each helix together
    for helix in helices:
        whole = [k for k in (0, 1) if len(set(system.strand[helix[:, k]])) == 1]
        assert len(whole) == 1


def test_helices_do_not_fork():
    # on the pair 2–1 lie two: 3–4 by the one strand and 5–0 by the other
    centre, a1, a3 = duplex(2)
    up, down = (0, slice(None)), (1, slice(None, None, -1))
    system = strands.system_of(
        [
            ("AC", *(x[down] for x in (centre, a1, a3))),
            ("GT", *(x[up] for x in (centre, a1, a3))),
            ("A", *(x[1, 1:] for x in (centre, a1, a3))),
            ("T", *(x[0, 1:] for x in (centre, a1, a3))),
        ],
        pair=[5, 2, 1, 4, 3, 0],
    )
    assert [helix.tolist() for helix in find_helices(system)] == [[[0, 5]], [[4, 3], [1, 2]]]


def test_a_helix_ends_where_a_base_has_no_partner():
    system = strands.helix(SEQUENCE)
    bases = system.base.copy()
    bases[5] = "C"
    helices = find_helices(paired(replace(system, base=bases)))
    assert [len(helix) for helix in helices] == [5, N - 6]


def test_every_pair_is_in_one_helix(rng):
    system = paired(strands.shaken(crossed(), rng, 0.02, 0.08))
    members = np.concatenate([helix.ravel() for helix in find_helices(system)])
    np.testing.assert_array_equal(np.sort(members), np.flatnonzero(system.pair >= 0))


def test_a_closed_ring_of_pairs_is_one_helix():
    n = 60
    angle = 2 * np.pi * np.arange(n) / n
    radius = 0.39 * n / (2 * np.pi)
    spoke = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    along = np.stack([-np.sin(angle), np.cos(angle), 0 * angle], axis=1)
    twist = (2 * np.pi * 6 / n) * np.arange(n)[:, None]
    out = np.cos(twist) * spoke + np.sin(twist) * np.array([0, 0, -1.0])
    sequence = "GCATTGCAGC" * 6
    other = "".join(strands.COMPLEMENT[b] for b in reversed(sequence))
    middle = radius * spoke
    ring = strands.system_of(
        [
            (sequence, middle - 0.6 * out, out, -along),
            (other, (middle + 0.6 * out)[::-1], -out[::-1], along[::-1]),
        ],
        circular=(0, 1),
    )
    (helix,) = find_helices(replace(ring, pair=np.arange(2 * n)[::-1]))
    assert sorted(helix[:, 0]) == list(range(n))


def test_a_system_without_pairs_has_no_helices():
    system = strands.helix("AAAA")
    alone = replace(system, base=np.array(["A"] * 8))
    assert find_helices(paired(alone)) == []


@pytest.mark.parametrize("missing", [0, 9])
def test_a_nucleotide_without_a_place_has_no_partner(missing):
    system = strands.helix(SEQUENCE)
    placed = np.arange(2 * N) != missing
    pair = find_pairs(replace(system, placed=placed))
    assert pair[missing] == pair[2 * N - 1 - missing] == -1
