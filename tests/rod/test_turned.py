import pytest

import loopelastica as le
from loopelastica.rod._same import same
from loopelastica.rod._turned import turned
from loopelastica.rod.stability import assess

FIGURE_6 = le.Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])


def test_a_turned_end_leads_to_equilibria_of_the_first_clamping():
    rods = le.equilibria(FIGURE_6)
    found = list(turned(rods[0], 1e-9))
    assert found
    for rod in found:
        assert rod.converged
        assert rod.clamping == FIGURE_6
        assert rod.residual < 1e-9
        assert any(same(rod, other) for other in rods if rod.energy < rods.energy_max)
    # a whole turn further: docstring of `twist_end`
    assert min(abs(rod.energy - 19.1464) for rod in found) < 1e-3


def test_from_a_pass_come_passes_with_other_twist():
    rods = le.equilibria(FIGURE_6)
    saddle = next(rod for rod in rods if abs(rod.energy - 40.2113) < 1e-3)
    others = [assess(rod) for rod in turned(saddle, 1e-9)]
    assert any(rod.index == 1 and not same(rod, saddle) for rod in others)


def test_a_free_spin_has_nothing_to_turn():
    rod = le.solve(le.Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2], free_spin=True))
    with pytest.raises(ValueError, match="free"):
        list(turned(rod, 1e-9))
