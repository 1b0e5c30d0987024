import sys

import numpy as np
import pytest

from loopelastica.errors import MissingDependencyError
from loopelastica.studies.nanostructures.designs import drawn
from loopelastica.studies.nanostructures.sheet import Sheet


@pytest.fixture
def sheet():
    pytest.importorskip("scadnano")
    return lambda number: Sheet(np.random.default_rng(1), number)


def test_designs_have_the_default_geometry_and_the_relaxed_one_in_turn(family):
    pytest.importorskip("scadnano")
    default, relaxed = (drawn(family("spacers"), number, 1) for number in (0, 1))
    assert default.geometry.inter_helix_gap == 1.0
    assert relaxed.geometry.inter_helix_gap == 0.1
    assert any(helix.roll for helix in relaxed.helices.values())
    assert not any(helix.roll for helix in default.helices.values())


def test_lattices_come_in_turn(family):
    pytest.importorskip("scadnano")
    grids = [str(drawn(family("tails"), number, 1).grid) for number in (0, 2, 4)]
    assert grids == ["Grid.square", "Grid.honeycomb", "Grid.hex"]


@pytest.mark.parametrize(("number", "pairs"), [(0, 12), (4, 16)])
def test_neighbours_are_those_of_the_lattice(number, pairs, sheet):
    # three by three: twelve sides of squares; with every second column shifted, four more
    made = sheet(number)
    for k in range(9):
        made.helix(k % 3, k // 3)
    assert len(made.neighbours()) == pairs


def test_a_helix_turns_to_where_its_loopout_goes(sheet):
    made = sheet(1)
    one, other = made.far(0, 0), made.far(1, 0)
    made.strand(made.domain(one, True, 0, 15), 4, made.domain(other, False, 0, 15))
    for helix in (one, other):
        made.strand(made.domain(helix, helix == other, 0, 15))
    design = made.design()
    assert all(abs(helix.roll) > 1 for helix in design.helices.values())
    assert [len(strand.domains) for strand in design.strands] == [3, 1, 1]


def test_without_scadnano_a_sentence_names_the_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "scadnano", None)
    with pytest.raises(MissingDependencyError, match=r"loopelastica\[origami\]"):
        Sheet(np.random.default_rng(1), 0)
