import numpy as np
import pytest
from draws import closed_ring, drawn_rods, load_drawn

import loopelastica as le
from loopelastica.rod._same import same
from loopelastica.rod.descent import ways_down
from loopelastica.rod.kernels.records import Status
from loopelastica.rod.morse import homotopy_class
from loopelastica.rod.stability import assess

FIGURE_6 = [-0.4, -0.1, 0.5, 4.8, 1.4, 2.2]


@pytest.mark.parametrize("free_spin", [False, True])
@pytest.mark.parametrize("torsion_ratio", [0.3, 1.0, 3.0])
def test_ways_lead_down_to_equilibria_of_the_same_clamping(rng, torsion_ratio, free_spin):
    arrived = []
    for rod in drawn_rods(rng, 6, torsion_ratio, free_spin, force=100.0):
        rod = assess(rod)
        ways = ways_down(rod)
        assert len(ways) == 2 * rod.index
        for low in ways:
            arrived.append(low.converged)
            if low.converged:
                assert low.energy < rod.energy
                assert low.residual < 1e-9
                assert low.clamping == rod.clamping
                assert homotopy_class(low) == homotopy_class(rod)
    assert np.mean(arrived) > 0.9


def test_smaller_steps_lead_to_the_same_minima(rng):
    compared = 0
    for free_spin in (False, True):
        for position, rotation in zip(*load_drawn(rng, 3, 1.0, free_spin), strict=True):
            rods = le.equilibria(le.Clamping(position, rotation, free_spin), rounds=1)
            for rod in rods:
                if rod.index != 1:
                    continue
                for low, close in zip(ways_down(rod), ways_down(rod, reach=0.03), strict=True):
                    assert same(low, close)
                    compared += 1
    assert compared > 10


def test_a_minimum_has_no_way_down():
    assert ways_down(le.solve(le.Clamping.from_parameters(FIGURE_6))) == []


def test_the_two_ways_of_a_pass_are_the_minima_that_it_separates():
    rods = le.equilibria(le.Clamping.from_parameters(FIGURE_6))
    saddle = next(rod for rod in rods if abs(rod.energy - 40.2113) < 1e-3)
    assert saddle.index == 1
    ends = sorted(rod.energy for rod in ways_down(saddle))
    assert ends == pytest.approx([19.146374, 23.272426], abs=1e-5)
    # from a copy that has no index
    bare = le.Equilibrium.from_dict({**saddle.to_dict(), "index": None})
    assert sorted(rod.energy for rod in ways_down(bare)) == pytest.approx(ends, abs=1e-7)


def test_a_double_ring_falls_to_what_has_its_parity():
    # twice around and no twist: the figure eight, E = 56.220, may open to it with one crossing less
    ring = closed_ring(2)
    ways = ways_down(ring)
    assert len(ways) == 4
    for low in ways:
        assert low.converged
        assert low.energy < ring.energy
        assert homotopy_class(low) == homotopy_class(ring) != homotopy_class(closed_ring(1))


def test_what_did_not_converge_is_refused():
    rod = le.solve(le.Clamping.from_parameters(FIGURE_6))
    failed = le.Equilibrium.from_dict({**rod.to_dict(), "status": int(Status.STALLED)})
    with pytest.raises(ValueError, match="`rod` has not converged"):
        ways_down(failed)
    with pytest.raises(ValueError, match="`rod`"):
        ways_down("rod")
