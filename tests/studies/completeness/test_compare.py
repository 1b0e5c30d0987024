import numpy as np
import pytest

import loopelastica as le
from loopelastica.studies.bench.judge import independent
from loopelastica.studies.completeness import compare
from loopelastica.studies.completeness.search import search

CLAMPING = le.Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])


@pytest.fixture(scope="module")
def rods():
    return search(CLAMPING, 1.0, 300, np.random.default_rng(1), 22.0)


@pytest.fixture(scope="module")
def found():
    return le.equilibria(CLAMPING, energy_max=30.0)


def test_a_list_has_what_was_hit(rods, found):
    assert (compare.matches(rods, found, CLAMPING) == np.eye(3)).all()
    assert compare.matches(rods, [], CLAMPING).shape == (3, 0)


def test_mirror_images_are_two_rods_of_one_energy():
    # a U-turn in one plane, and its image in another
    clamping = le.Clamping([0.2, 0.0, 0.1], np.diag([-1.0, 1.0, -1.0]))
    flat = search(clamping, 1.0, 80, np.random.default_rng(2), 60.0)
    pairs = [
        (a, b)
        for i, a in enumerate(flat)
        for b in flat[:i]
        if abs(a.energy - b.energy) < 1e-8 * a.energy
    ]
    assert pairs
    for a, b in pairs:
        its = compare.as_equilibrium(a, clamping, 1.0)
        assert compare.matches([a, b], [its], clamping).ravel().tolist() == [True, False]


def test_a_rod_of_the_search_is_an_equilibrium_of_the_package_at_any_tension():
    clamping = le.Clamping([0.0, 0.57, 0.75], np.diag([1.0, -1.0, -1.0]))
    rods = search(clamping, 0.5, 80, np.random.default_rng(3), 40.0)
    for rod in rods:
        its = compare.as_equilibrium(rod, clamping, 0.5)
        np.testing.assert_allclose(its.frames(2)[1], clamping.rotation, atol=1e-8)
        assert independent(its) < (1e-8, 1e-8)


def test_rods_at_the_bound_need_not_be_listed(rods):
    assert len(compare.below(rods, 30.0)) == 3
    assert len(compare.below(rods, rods[1].energy)) == 1
    assert len(compare.below(rods, rods[1].energy * (1.0 + 1e-5))) == 2


def test_a_row_counts_rods_and_hits_and_names_what_is_missing(rods, found, monkeypatch):
    def without_the_second(clamping, torsion_ratio, rounds):
        assert (clamping, torsion_ratio, rounds) == (CLAMPING, 1.0, None)
        partial = le.equilibria(clamping, torsion_ratio, energy_max=30.0)
        del partial[1]
        return partial

    monkeypatch.setattr(compare, "equilibria", without_the_second)
    row, missed = compare.judged(rods, CLAMPING, 1.0, "default")
    assert (row["listed"], row["listed_hit"], row["rods"], row["rods_listed"]) == (2, 2, 3, 2)
    assert row["hits"] == sum(rod.hits for rod in rods)
    assert row["hits_listed"] == row["hits"] - rods[1].hits
    (gone,) = missed
    assert gone["energy"] == rods[1].energy
    kind = gone["index"]
    assert row[kind] - row[f"{kind} listed"] == 1
    assert sum(row[name] for name in compare.INDICES) == 3
    assert gone["turns"] == found[1].turns
    assert gone["periods"] == pytest.approx(found[1].periods, rel=1e-4)
    assert [gone[name] for name in ("F1", "M3")] == pytest.approx(found[1].loads[[0, 5]])


def test_efforts_are_rounds_that_equilibria_takes():
    for rounds in compare.EFFORTS.values():
        le.equilibria(CLAMPING, energy_max=8.0, rounds=rounds)
    deepest = compare.EFFORTS["deepest"]
    with pytest.raises(ValueError, match="rounds"):
        le.equilibria(CLAMPING, rounds=deepest + 1)
