"""Arguments that several public functions of the rod take."""

import math

import numpy as np
import pytest

import loopelastica as le
from loopelastica.rod._arguments import arc_lengths, check_loads, check_torsion_ratio


@pytest.mark.parametrize("value", [0.0, -1.0, math.inf, math.nan, 1e-308, 1e300])
def test_a_torsion_ratio_is_positive_and_finite(value):
    with pytest.raises(ValueError, match="`torsion_ratio` is"):
        check_torsion_ratio(value)
    assert check_torsion_ratio(np.float32(0.5)) == 0.5


@pytest.mark.parametrize("loads", [np.ones(5), np.ones((6, 1)), [0, 0, 0, 0, 0, math.nan]])
def test_loads_are_six_finite_numbers(loads):
    with pytest.raises(ValueError, match="`loads` must be six"):
        check_loads(loads)


@pytest.mark.parametrize(
    "odd",
    [["x"] * 6, [1j] * 6, None, [True] * 6, np.ma.masked_array(np.ones(6), [True, *[False] * 5])],
)
def test_what_are_no_real_numbers_are_neither_loads_nor_arc_lengths(odd):
    with pytest.raises(ValueError, match="`loads`"):
        check_loads(odd)
    with pytest.raises(ValueError, match="`n`"):
        arc_lengths(odd)


def test_truth_is_no_number_of_points():
    with pytest.raises(ValueError, match="`n` is True"):
        arc_lengths(True)


def test_checked_loads_are_a_copy():
    given = np.arange(6.0)
    check_loads(given)[0] = 7.0
    assert given[0] == 0.0


def test_points_are_equally_spaced_with_both_ends():
    assert arc_lengths(5).tolist() == [0.0, 0.25, 0.5, 0.75, 1.0]
    assert arc_lengths(np.int64(2)).tolist() == [0.0, 1.0]
    assert arc_lengths(1).tolist() == [0.0]


def test_given_arc_lengths_keep_their_order_and_are_copied():
    given = np.array([1.0, 0.0, 0.3, 0.9])[::2]
    found = arc_lengths(given)
    assert found.tolist() == [1.0, 0.3]
    assert found.flags.c_contiguous
    found[0] = 0.5
    assert given[0] == 1.0


@pytest.mark.parametrize(
    ("n", "why"),
    [
        (0, "at least 1"),
        (0.5, "one-dimensional"),
        ([[0.1]], "one-dimensional"),
        ([0.0, 1.5], "outside"),
        ([-1e-9], "outside"),
        ([math.nan], "outside"),
    ],
)
def test_what_are_no_arc_lengths_is_refused(n, why):
    with pytest.raises(ValueError, match=f"`n` .*{why}"):
        arc_lengths(n)


def test_a_caller_may_need_both_ends():
    with pytest.raises(ValueError, match="`n` is 1; it must be at least 2"):
        arc_lengths(1, least=2)


FIGURE_6 = le.Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])
NO_NUMBERS = (
    ["a", "b", "c"], [1j, 0, 0], [None, 0, 0], [10**400, 0, 0], [[1], [1, 2], [3]], object(), True,
    np.ma.masked_array([0.0, 0.0, 0.5], [False, True, False]), np.array([1 + 0j, 0, 0]),
)  # fmt: skip


@pytest.mark.parametrize("odd", NO_NUMBERS, ids=lambda v: repr(v)[:20])
@pytest.mark.parametrize(
    ("name", "call"),
    [
        ("position", lambda odd: le.Clamping(odd, np.eye(3))),
        ("rotation", lambda odd: le.Clamping(np.zeros(3), odd)),
        ("q", le.Clamping.from_parameters),
        (
            "start_origin",
            lambda odd: le.Clamping.from_frames(odd, np.eye(3), [0] * 3, np.eye(3), 1),
        ),
        ("end_frame", lambda odd: le.Clamping.from_frames([0] * 3, np.eye(3), [0] * 3, odd, 1)),
        ("guess", lambda odd: le.solve(FIGURE_6, guess=odd)),
        ("positions", lambda odd: le.solve_batch(odd, np.eye(3)[None])),
        ("rotations", lambda odd: le.solve_batch(np.zeros((1, 3)), odd)),
        ("torsion_ratio", lambda odd: le.solve_batch(np.zeros((1, 3)), np.eye(3)[None], odd)),
        ("loads", le.PhysicalParameters.from_loads),
    ],
)
def test_arrays_of_anything_but_real_numbers_are_refused_by_name(name, call, odd):
    with pytest.raises(ValueError, match=f"`{name}`") as caught:
        call(odd)
    assert "\n" not in str(caught.value)


ROD = le.solve(FIGURE_6)


@pytest.mark.parametrize(
    ("name", "call"),
    [
        ("free_spin", lambda odd: le.Clamping([0, 0, 0.5], np.eye(3), odd)),
        ("free_spin", lambda odd: le.solve_batch(np.zeros((1, 3)), np.eye(3)[None], 1.0, odd)),
        ("lowest", lambda odd: le.solve(FIGURE_6, lowest=odd)),
        ("lowest", lambda odd: le.solve_batch([[0, 0, 0.5]], [np.eye(3)], lowest=odd)),
        ("clamping", le.solve),
        ("clamping", le.equilibria),
        ("clamping", lambda odd: le.continue_clamping(ROD, odd)),
        ("rod", lambda odd: le.continue_clamping(odd, FIGURE_6)),
        ("rod", lambda odd: le.twist_end(odd, 1.0)),
        ("turns", lambda odd: le.twist_end(ROD, odd)),
        ("stability", lambda odd: le.twist_end(ROD, 0.0, stability=odd)),
        ("natural", lambda odd: le.continue_clamping(ROD, FIGURE_6, natural=odd)),
        ("max_step", lambda odd: le.twist_end(ROD, 0.0, max_step=odd)),
        ("threads", lambda odd: le.solve_batch([[0, 0, 0.5]], [np.eye(3)], threads=odd)),
        ("energy_max", lambda odd: le.equilibria(FIGURE_6, energy_max=odd)),
        ("rounds", lambda odd: le.equilibria(FIGURE_6, rounds=odd)),
        ("turns", lambda odd: le.equilibria(FIGURE_6, turns=odd)),
        ("angle", FIGURE_6.turned),
        ("length", lambda odd: le.PhysicalParameters(0.1, 0.2, 1.0, 0.0, 0.0, odd)),
        ("values", le.Equilibrium.from_dict),
    ],
)
@pytest.mark.parametrize(
    "odd",
    ["yes", 1j, float("nan"), 10**400, [], object()],
    ids=lambda v: "object" if type(v) is object else repr(v),
)
def test_other_kinds_are_refused_by_name(name, call, odd):
    with pytest.raises(ValueError, match=f"`{name}`") as caught:
        call(odd)
    assert "\n" not in str(caught.value)


@pytest.mark.filterwarnings("error")
def test_huge_numbers_are_refused_without_a_warning():
    with pytest.raises(ValueError, match="no rod reaches"):
        le.solve(le.Clamping([1e200, 1e300, 0], np.eye(3)))
    with pytest.raises(ValueError, match="`rotation`"):
        le.Clamping([0, 0, 0.5], 1e300 * np.eye(3))
    batch = le.solve_batch([[1e300, 1e300, 0], [0, 0, 0.5]], [np.eye(3), 1e300 * np.eye(3)])
    assert batch.status.tolist() == [le.Status.UNREACHABLE, le.Status.BAD_INPUT]
    with pytest.raises(ValueError, match="`s_ini`"):
        le.PhysicalParameters(0.1, 0.2, 1.0, 0.0, 1e30, 1.0)


@pytest.mark.parametrize(
    ("name", "odd"),
    [
        *(("loads", None), ("loads", [1, 2]), ("node_s", [[0.0]]), ("node_pose", [1.0])),
        *(("layers", 5), ("layers", [1]), ("method", 3), ("method", None), ("index", -1)),
        *(("torsion_ratio", -1), ("energy", "x"), ("residual", 10**400), ("clamping", 5)),
    ],
)
def test_damaged_dictionaries_are_no_rods(name, odd):
    values = ROD.to_dict()
    assert le.Equilibrium.from_dict(values).energy == ROD.energy
    with pytest.raises(ValueError, match="`"):
        le.Equilibrium.from_dict({**values, name: odd})
