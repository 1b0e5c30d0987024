import numpy as np
import pytest

from loopelastica.rod._starts import problem_of
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.kernels.multistart import new_rows, shortening_of
from loopelastica.rod.kernels.records import (
    LAYERS,
    SEGMENTS,
    START,
    Method,
    Start,
    Status,
    starts_array,
)


def test_methods_and_states_are_numbers_with_words():
    assert Status.CONVERGED == 0
    # numbers stand in files: they must not move
    assert [m.name for m in Method] == [
        "NONE", "SHOOTING", "BOUNDARY_LAYERS", "REFINED_LAYERS", "DISCRETE_ROD",
        "DISCRETE_ROD_LAYERS", "DISCRETE_ROD_SHOOTING", "CONTINUATION", "NEARBY", "GUESS",
        "STRAIGHT",
        "NEARLY_STRAIGHT", "MIDDLE",
    ]  # fmt: skip
    assert list(Method) == list(range(13))
    assert list(Status) == list(range(8))
    labels = [method.label for method in Method]
    assert len(set(labels)) == len(labels)
    assert all(str(method) == method.label for method in Method)


def test_starts_become_rows_of_the_same_fields():
    table = starts_array((Start(), Start(2.0, bow=0.5, over_1=True, minimized=False)))
    assert table.dtype == START
    assert START.names == Start._fields
    assert table[0].tolist() == (0.0, 0.0, 0.0, False, False, True)
    assert table[1].tolist() == (2.0, 0.5, 0.0, False, True, False)


def test_a_solution_has_room_for_every_node():
    rows = new_rows(3)
    assert rows.node_s.shape == (3, SEGMENTS + 1)
    assert rows.layers.dtype == LAYERS
    assert rows.node_pose.shape == (3, SEGMENTS + 1, 7)
    assert np.isinf(rows.energy).all()
    assert (rows.method == Method.NONE).all()


def test_a_problem_is_a_clamping_that_kernels_may_write_to():
    clamping = Clamping.from_parameters([0.3, -0.2, 0.5, 4.8, 1.4, 2.2], free_spin=True)
    problem = problem_of(clamping, 0.7, 1e-8)
    assert problem.position.flags.writeable
    np.testing.assert_array_equal(problem.position, clamping.position)
    assert (problem.torsion_ratio, problem.free_spin, problem.tolerance) == (0.7, True, 1e-8)
    assert problem.shortening == pytest.approx(1 - np.linalg.norm(clamping.position), rel=1e-14)


@pytest.mark.parametrize("shortening", [0.5, 1e-4, 1e-8, 1e-12])
def test_the_shortening_is_one_minus_the_length(shortening):
    from decimal import Decimal

    position = (1 - shortening) * np.array([0.48, 0.6, 0.64])
    exact = float(1 - sum(Decimal(x) ** 2 for x in position).sqrt())
    assert shortening_of(position) == pytest.approx(exact, rel=1e-15, abs=4e-16)
