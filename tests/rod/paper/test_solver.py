"""The printed solver: its parts against independent ones, its printed numbers."""

import math

import numpy as np
import pytest
from draws import loads as random_loads
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from loopelastica.rod.clamping import Clamping
from loopelastica.rod.paper import (
    ERRORS,
    FORWARD,
    PaperSolver,
    bulirsch_stoer,
    continue_angle,
    solve_paper,
)
from loopelastica.rod.paper import errors as kernels
from loopelastica.rod.paper import newton as paper_newton
from loopelastica.rod.paper import path as paper_path
from loopelastica.rod.parameters import PhysicalParameters


def matrix(y):
    return Rotation.from_quat(y[3:], scalar_first=True).as_matrix()


def end(f, torsion_ratio=1.0, forward="printed"):
    y = np.empty(7)
    if forward == "project":
        assert kernels.project_end(f, torsion_ratio, y)
    else:
        assert kernels.end(f, torsion_ratio, FORWARD[forward], y)
    return y


def pose(clamping):
    y = np.empty(7)
    kernels.pose_of_frame(np.array(clamping.position), np.array(clamping.rotation), y)
    return y


def turned_loads(f, angle):
    z = Rotation.from_rotvec([0, 0, angle]).as_matrix()
    return np.concatenate([z @ f[:3], z @ f[3:]])


# --- the mapping q2 --------------------------------------------------------------------------


def test_bulirsch_stoer_agrees_with_dop853(rng):
    def slope(_, y, f):
        frame = y[3:].reshape(3, 3)
        moment = f[3:] + np.cross(f[:3], y[:3])
        return np.concatenate([frame[:, 2], np.cross(moment, frame.T).T.ravel()])

    start = np.concatenate([np.zeros(3), np.eye(3).ravel()])
    for f in random_loads(rng, 12):
        oracle = solve_ivp(slope, (0, 1), start, "DOP853", args=(f,), rtol=1e-12, atol=1e-13)
        y = np.empty(7)
        assert bulirsch_stoer.end_pose(f, 1.0, 1e-12, y) > 0
        assert y[:3] == pytest.approx(oracle.y[:3, -1], abs=1e-9)
        assert matrix(y).ravel() == pytest.approx(oracle.y[3:, -1], abs=1e-9)


def test_bulirsch_stoer_keeps_to_its_tolerance_with_fewer_slopes(rng):
    exact, y = np.empty(7), np.empty(7)
    for f in random_loads(rng, 20):
        bulirsch_stoer.end_pose(f, 1.0, 1e-13, exact)
        counts, errors = [], []
        for tolerance in (1e-5, 1e-8, 1e-11):
            counts.append(bulirsch_stoer.end_pose(f, 1.0, tolerance, y))
            errors.append(np.abs(y - exact).max())
        assert counts == sorted(counts)
        assert errors[1] < 1e-5
        assert errors[2] < 1e-8


def test_bulirsch_stoer_gives_up_on_absurd_loads():
    assert bulirsch_stoer.end_pose(np.full(6, 1e12), 1.0, 1e-10, np.empty(7)) == -1
    assert bulirsch_stoer.end_pose(np.full(6, np.nan), 1.0, 1e-10, np.empty(7)) == -1


@pytest.mark.parametrize("torsion_ratio", [1.0, 0.7])
def test_all_ways_of_q2_agree(rng, torsion_ratio):
    for f in random_loads(rng, 60, force=40, moment=10):
        expected = end(f, torsion_ratio, "project")
        for forward in ("printed", "analytic", "numerical"):
            found = end(f, torsion_ratio, forward)
            assert found[:3] == pytest.approx(expected[:3], abs=1e-9)
            assert matrix(found) == pytest.approx(matrix(expected), abs=1e-9)


def test_q2_is_integrated_near_the_singular_rods(monkeypatch):
    p = PhysicalParameters(0.6, 0.6 + 5e-3, 1.5, 0.3, 0.4, 2.0).loads()
    q = PhysicalParameters(0.6, 0.6 + 5e-2, 1.5, 0.3, 0.4, 2.0).loads()
    assert np.array_equal(end(p), end(p, forward="numerical"))
    assert not np.array_equal(end(p), end(p, forward="analytic"))
    assert np.array_equal(end(q), end(q, forward="analytic"))
    # and where there is no force at all
    none = np.array([0, 0, 0, 1.0, 2.0, 0.5])
    assert matrix(end(none)) == pytest.approx(Rotation.from_rotvec(none[3:]).as_matrix(), abs=1e-10)


# --- the errors ------------------------------------------------------------------------------


def signed_angle(first, second, axis):
    """From `first` to the projection of `second` across `axis`, about `axis`."""
    across = second - axis * (axis @ second)
    return math.atan2(axis @ np.cross(first, across), first @ across)


def test_errors_are_those_of_equations_30_to_32(rng):
    for a, b in zip(Rotation.random(40, rng), Rotation.random(40, rng), strict=True):
        bar = Clamping(rng.uniform(-0.5, 0.5, 3), a.as_matrix())
        target = Clamping(rng.uniform(-0.5, 0.5, 3), b.as_matrix())
        e = {name: np.empty(6) for name in ERRORS}
        for name, kind in ERRORS.items():
            kernels.error(kind, pose(bar), pose(target), e[name])
            assert e[name][:3] == pytest.approx(target.position - bar.position)
        assert e["eps1"] == pytest.approx(target.parameters - bar.parameters, abs=1e-12)
        d, d_bar = target.rotation.T, bar.rotation.T
        expected = [signed_angle(d_bar[j], d[j], d_bar[i]) for i, j in ((0, 1), (1, 2), (2, 0))]
        assert e["eps2"][3:] == pytest.approx(expected, abs=1e-12)
        vector = Rotation.from_matrix(target.rotation @ bar.rotation.T).as_rotvec()
        angle = np.linalg.norm(vector)
        v = math.sin(angle / 2) * vector / angle
        assert e["eps3"][3:] == pytest.approx(d_bar @ v, abs=1e-12)


def test_reduced_parameters_ignore_a_turn_of_the_start(rng):
    for turn in Rotation.random(20, rng):
        clamping = Clamping(rng.uniform(-0.5, 0.5, 3), turn.as_matrix())
        first, second = np.empty(5), np.empty(5)
        kernels.reduced_parameters(pose(clamping), first)
        kernels.reduced_parameters(pose(clamping.turned(rng.uniform(-3, 3))), second)
        assert second == pytest.approx(first, abs=1e-12)
        expected = clamping.reduced()[0].parameters[[0, 2, 3, 4, 5]]
        assert first == pytest.approx(expected, abs=1e-12)


# --- Algorithms 1 and 2 ----------------------------------------------------------------------


@pytest.mark.parametrize("error", ["eps2", "eps3"])
def test_both_jacobians_are_that_of_the_error(rng, error):
    f = random_loads(rng, 1, force=20, moment=6)[0]
    target, y = pose(Clamping.from_parameters([0.3, 0, 0.4, 1, 1.2, 2])), np.empty(7)
    central, fine = np.empty((6, 6)), np.empty((6, 6))
    args = (f, target, ERRORS[error], 1.0, FORWARD["numerical"], y)
    assert paper_newton.central_jacobian(*args, central)
    assert paper_newton.ridders_jacobian(*args, fine)
    # an independent difference of fourth order
    h, exact = 1e-3, np.empty((6, 6))
    for c in range(6):
        values = {}
        for k in (-2, -1, 1, 2):
            moved, e = f.copy(), np.empty(6)
            moved[c] += k * h
            kernels.error(ERRORS[error], end(moved, forward="numerical"), target, e)
            values[k] = e
        exact[:, c] = (8 * (values[1] - values[-1]) - values[2] + values[-2]) / (12 * h)
    assert fine == pytest.approx(exact, abs=1e-7)
    assert central == pytest.approx(exact, abs=1e-5)


def test_the_line_search_stops_at_the_first_step_with_armijos_decrease():
    """Along a step that overshoots, j is the least exponent that passes line 7."""
    f = PhysicalParameters(0.5, 0.3, 1.0, 0.0, 0.4, 2.5).loads()
    target = end(1.15 * f)
    y, e = np.empty(7), np.empty(6)
    j, a, d = np.empty((6, 6)), np.empty((6, 6)), np.empty(6)
    kind = ERRORS["eps3"]
    paper_newton.error_at(f, target, kind, 1.0, 0, y, e)
    paper_newton.central_jacobian(f, target, kind, 1.0, 0, y, j)
    assert paper_newton.eliminate(j, e, a, d)
    assert d == pytest.approx(-np.linalg.solve(j, e))
    cost, trial = 0.5 * e @ e, np.empty(6)

    def exponent():
        """The least j that passes."""
        for k in range(51):
            kernels.error(kind, end(f + 0.45**k * d), target, trial)
            if 0.5 * trial @ trial - cost < 1e-4 * 0.45**k * decrease:
                return k
        return None

    decrease = (j.T @ e) @ d
    while not (passed := exponent()):  # until it is far too long, in the right direction
        d *= 2.0
        decrease *= 2.0
    moved = f.copy()
    assert paper_newton.line_search(
        moved, d, decrease, cost, target, kind, 1.0, 0, y, np.empty(6), e
    )
    assert moved == pytest.approx(f + 0.45**passed * d, rel=1e-14)
    # uphill no step passes, and the loads stay
    stay = f.copy()
    assert not paper_newton.line_search(
        stay, -d, decrease, cost, target, kind, 1.0, 0, y, np.empty(6), e
    )
    assert np.array_equal(stay, f)


def test_a_hopeless_target_is_given_up_after_nine_restarts():
    target = pose(Clamping.from_parameters([1.2, 0, 0.4, 1, 1.2, 2]))  # longer than the rod
    guess = np.array([0.5, 0.3, 1.0, 0.4, 2.5])
    status, iterations, restarts, ridders = paper_newton.invert(
        guess, target, 2, 1.0, FORWARD["analytic"], 1e-7, 9, np.empty(6)
    )
    assert status != paper_newton.CONVERGED
    assert restarts == 9
    assert ridders == 10
    assert iterations <= 20 * 41


def test_guesses_enter_newton_with_eta_2_zero(rng):
    for _ in range(20):
        p = np.array([*rng.uniform(-2, 2, 2), 4.5, rng.uniform(0, 3), rng.uniform(0.2, 4)])
        f = np.empty(6)
        paper_newton.reduced_loads(p, p[3], 0.7, f)
        y = end(f, 0.7)
        assert y[1] == pytest.approx(0, abs=1e-10)
        assert y[0] >= 0
        back = PhysicalParameters.from_loads(f, 0.7)
        assert [back.lam, back.t_p, back.a, back.length] == pytest.approx(p[[0, 1, 2, 4]])


# --- symmetries ------------------------------------------------------------------------------


def test_rotation_mirror_and_reversal(rng):
    """Eq. 15–16 and 34–35 and the rod run backwards, on loads and poses of random rods."""
    for f in random_loads(rng, 25, force=30, moment=8):
        there = end(f, 0.7)
        q = Clamping(there[:3], matrix(there))
        angle = rng.uniform(-3, 3)
        y = end(turned_loads(f, angle), 0.7)
        assert y[:3] == pytest.approx(q.turned(angle).position, abs=1e-9)
        assert matrix(y) == pytest.approx(q.turned(angle).rotation, abs=1e-9)
        y = end(f * [1, -1, 1, -1, 1, -1], 0.7)
        assert y[:3] == pytest.approx(q.mirrored().position, abs=1e-9)
        assert matrix(y) == pytest.approx(q.mirrored().rotation, abs=1e-9)
        p, flipped = PhysicalParameters.from_loads(f, 0.7), np.empty(7)
        kernels.physical_pose(-p.lam, -p.t_p, p.a, p.s_ini, p.length, 0.7, flipped)
        first, second = np.empty(5), np.empty(5)
        kernels.reduced_parameters(there, first)
        kernels.reduced_parameters(flipped, second)
        assert second[[0, 1, 3]] == pytest.approx(first[[0, 1, 3]], abs=1e-8)
        for k in (2, 4):
            assert math.remainder(first[k] + second[k], math.tau) == pytest.approx(0, abs=1e-7)
        moment = f[3:] + np.cross(f[:3], there[:3])
        turn = np.diag([1.0, -1.0, -1.0]) @ q.rotation.T
        # force and moment act from the other side
        back = np.concatenate([-turn @ f[:3], -turn @ moment])
        y = end(back, 0.7)
        assert y[:3] == pytest.approx(q.reversed().position, abs=1e-8)
        assert matrix(y) == pytest.approx(q.reversed().rotation, abs=1e-8)


@pytest.mark.parametrize("symmetry", [True, False])
def test_the_solver_undoes_its_turn_and_mirror(rng, symmetry):
    solver = PaperSolver(l=2, delta=1, symmetry=symmetry)
    mirrored = 0
    for _ in range(12):
        p = PhysicalParameters(*rng.uniform(-1.5, 1.5, 2), 3.0, 0.0, *rng.uniform(0.2, 2.2, 2))
        clamping = p.clamping().turned(rng.uniform(-3, 3))
        mirrored += solver._reduced(clamping)[2]
        found = solver.solve(clamping)
        assert found.converged
        assert found.residual < 1e-6
        y = end(found.loads, forward="project")
        assert y[:3] == pytest.approx(clamping.position, abs=1e-6)
        assert matrix(y) == pytest.approx(clamping.rotation, abs=1e-6)
        back = found.physical.clamping()
        assert back.rotation == pytest.approx(clamping.rotation, abs=1e-6)
    assert (mirrored > 0) == symmetry


# --- the printed numbers ---------------------------------------------------------------------


@pytest.mark.parametrize("error", list(ERRORS))
def test_tested_rods_are_reached_as_often_as_printed(error):
    """99.9 % at δ = 0.5 (section 4.4): 200 of the set's rods, at most one missed."""
    from loopelastica.rod.paper.grid import spacing, trial_points

    rods = trial_points(2, 0.5, spacing(2, 0.5) / 2)
    rods = rods[np.random.default_rng(4).permutation(len(rods))[:200]]
    solver, out = PaperSolver(error=error), np.empty((200, 5))
    paper_path.paths(
        rods, solver.grid.points, solver.grid.images, True, 1, ERRORS[error], 1.0, 0, 1e-7, 9, out
    )
    assert (out[:, 0] < 1e-5).sum() >= 199
    assert out[:, 1].mean() < 9


def test_the_grid_can_be_scanned_by_another_error():
    """Section 4.4 does so once, with ε3."""
    solver = PaperSolver(l=2, delta=1, scan="eps3")
    clamping = Clamping.from_parameters([0.3, 0.1, 0.5, 6.2, 0.9, 0.1])
    q = solver._reduced(clamping)[0]
    expected = []
    for image in solver.grid.images:
        e, first, second = np.empty(6), np.empty(7), np.empty(7)
        kernels.pose_of_parameters(image, first)
        kernels.pose_of_parameters(q, second)
        kernels.error(kernels.EPS3, first, second, e)
        expected.append(np.linalg.norm(e))
    assert list(solver._nearest(q, 5)) == list(np.argsort(expected, kind="stable")[:5])
    assert solver.solve(clamping).converged
    # ε1 tears angles at 2π, ε3 does not
    printed, q = PaperSolver(l=2, delta=1), np.array([0.6, 0.3, 0.0, 1.2, 3.0])
    chosen = {"eps1": set(), "eps3": set()}
    for q[2] in (1e-6, math.tau - 1e-6):
        chosen["eps1"].add(int(printed._nearest(q, 1)[0]))
        chosen["eps3"].add(int(solver._nearest(q, 1)[0]))
    assert len(chosen["eps1"]) == 2
    assert len(chosen["eps3"]) == 1


FIG_6 = Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])
FIG_6_FIRST = (-0.3112, -0.2178, -0.7406, 4.7988)
FIG_6_SECOND = (1.0462, 1.5606, 3.2264, 3.1601)


def rod(p):
    return [p.lam, p.t_p, p.a, p.length]


def newton_from(printed, clamping, torsion_ratio=1.0):
    """Algorithm 1 from the six printed physical parameters."""
    f, target = PhysicalParameters(*printed).loads(torsion_ratio), pose(clamping)
    status, _ = paper_newton.newton(f, target, kernels.EPS3, torsion_ratio, 0, 1e-10, False)
    assert status == paper_newton.CONVERGED
    return f


def test_figure_6_both_solutions_and_the_way_between_them():
    from loopelastica.rod.writhe import net_winding

    first = newton_from((-0.3, -0.2, -0.7, 3.4, 0.5, 4.8), FIG_6)
    second = newton_from((1.1, 1.5, 3.1, 0.64, 1.8, 3.3), FIG_6)
    assert rod(PhysicalParameters.from_loads(first)) == pytest.approx(FIG_6_FIRST, abs=6e-5)
    assert rod(PhysicalParameters.from_loads(second)) == pytest.approx(FIG_6_SECOND, abs=6e-5)

    branch = continue_angle(first, FIG_6, which="phi", turns=1.0)
    assert branch.converged
    assert branch.angles[-1] - branch.angles[0] == pytest.approx(math.tau, abs=1e-14)
    assert branch.loads[-1] == pytest.approx(second, abs=1e-6)
    windings = []
    for f in (branch.loads[0], branch.loads[-1]):
        p = PhysicalParameters.from_loads(f)
        windings.append(net_winding(p.centerline(300), p.frames(300), turns=f[5] / math.tau))
    assert [round(w, 1) for w in windings] == [0.1, 1.1]
    assert windings[1] - windings[0] == pytest.approx(1, abs=1e-8)
    # and back again
    home = continue_angle(branch.loads[-1], FIG_6, which="phi", turns=-1.0)
    assert home.loads[-1] == pytest.approx(branch.loads[0], abs=1e-6)


def test_continuation_adapts_its_step_and_says_where_a_branch_ends():
    first = newton_from((-0.3, -0.2, -0.7, 3.4, 0.5, 4.8), FIG_6)
    branch = continue_angle(first, FIG_6, which="theta", turns=-2.0)
    steps = np.abs(np.diff(branch.angles))
    assert steps.min() < 0.5 * steps.max()
    if not branch.converged:
        assert abs(branch.angles[-1] - branch.angles[0]) < 2 * math.tau
    for f, angle in zip(branch.loads[::9], branch.angles[::9], strict=True):
        q = FIG_6.parameters
        q[4] = angle
        assert matrix(end(f)) == pytest.approx(Clamping.from_parameters(q).rotation, abs=1e-7)


def test_the_solver_finds_an_equilibrium_of_figure_6():
    for error in ERRORS:
        found = solve_paper(FIG_6, error=error)
        assert found.converged
        assert rod(found.physical) == pytest.approx(FIG_6_SECOND, abs=6e-5)
        assert round(found.net_winding, 1) == 1.1


FIG_7 = Clamping.from_parameters([0.0, 0.0, 0.7, 2 * math.pi * 0.42, 0.0, 0.0])
# λ, t_P, a, L/μ; a of the first is −0.84, the print has lost its sign
FIG_7_RODS = {
    "IG 6": ((-0.406, 0.159, -0.840, 6.426), 0.42),
    "IG 25": ((-0.0902, 0.2088, -0.7700, 9.7339), 0.42),
    "IG 51": ((0.5900, -1.3469, 2.9949, 4.0924), -1.58),
    "IG 175": ((-0.215, -0.215, 2.0001, 13.25), -1.58),
}


@pytest.fixture(scope="module")
def several():
    return PaperSolver(torsion_ratio=0.7).several(FIG_7, k=180)


@pytest.mark.parametrize("name", FIG_7_RODS)
def test_figure_7_finds_the_rod(several, name):
    values, winding = FIG_7_RODS[name]
    found = [s for s in several if np.abs(np.subtract(rod(s.physical), values)).max() < 6e-3]
    assert len(found) == 1
    assert found[0].net_winding == pytest.approx(winding, abs=1e-6)
    assert found[0].residual < 1e-6
    # not only K30 of the shape: the frame too
    back = found[0].physical.clamping(0.7)
    assert back.rotation == pytest.approx(FIG_7.rotation, abs=1e-6)


def test_figure_7_without_duplicates(several):
    """32 solutions in the paper, ten of them shorter than three periods."""
    assert 20 <= len(several) <= 40
    assert 8 <= sum(s.physical.length < 3 * s.physical.period for s in several) <= 14
    assert [s.guess for s in several] == sorted(s.guess for s in several)
    for i, one in enumerate(several):
        for other in several[:i]:
            p, q = one.physical, other.physical
            start = math.remainder(p.s_ini - q.s_ini, p.period)
            apart = np.abs([*np.subtract(rod(p), rod(q)), start]).max()
            assert apart >= 0.1


def test_circles_of_solutions_count_once(several):
    """Aligned ends: the rod turned about the common axis is the same solution."""
    from loopelastica.rod.paper.solutions import end_residual, same

    one = several[0]
    turned = turned_loads(one.loads, 1.0)
    assert end_residual(turned, FIG_7, 0.7) < 1e-6
    physical = PhysicalParameters.from_loads(turned, 0.7)
    other = type(one)(FIG_7, 0.7, turned, physical, True, 0.0, 0, 0)
    assert same(one, other)


# --- what a user can get wrong ---------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "name"),
    [
        ({"error": "eps4"}, "error"),
        ({"forward": "magic"}, "forward"),
        ({"scan": "eps0"}, "scan"),
        ({"l": -1.0}, "l"),
        ({"delta": 0.0}, "delta"),
        ({"torsion_ratio": math.nan}, "torsion_ratio"),
        ({"tolerance": 0.0}, "tolerance"),
    ],
)
def test_bad_options_are_named(options, name):
    with pytest.raises(ValueError, match=f"`{name}`"):
        PaperSolver(**options)


def test_a_free_spin_is_not_the_papers_problem():
    free = Clamping([0.1, 0.2, 0.3], np.eye(3), free_spin=True)
    with pytest.raises(ValueError, match="free end spin"):
        PaperSolver().solve(free)
    with pytest.raises(ValueError, match="free end spin"):
        continue_angle(np.ones(6), free)


def test_continuation_names_bad_arguments():
    with pytest.raises(ValueError, match="`which`"):
        continue_angle(np.ones(6), FIG_6, which="chi")
    with pytest.raises(ValueError, match="`error`"):
        continue_angle(np.ones(6), FIG_6, error="eps0")
    with pytest.raises(ValueError, match="`loads`"):
        continue_angle(np.ones(5), FIG_6)


def test_failure_is_a_value():
    out_of_reach = Clamping.from_parameters([0.9, 0.3, 0.6, 1.0, 1.0, 1.0])
    found = PaperSolver(l=1, delta=1).solve(out_of_reach)
    assert not found.converged
    assert found.physical is None
    assert found.residual == math.inf
    assert np.isfinite(found.loads).all()
    with pytest.raises(ValueError, match="net winding"):
        found.net_winding  # noqa: B018
