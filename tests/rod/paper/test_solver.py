"""The printed solver: its symmetries, its printed numbers."""

import doctest
import math

import numpy as np
import pytest
from paper_rods import FIG_6, FIG_6_SECOND, end, matrix, rod, turned_loads

from loopelastica.rod.clamping import Clamping
from loopelastica.rod.paper import ERRORS, PaperSolver, continue_angle, solve_paper
from loopelastica.rod.paper import errors as kernels
from loopelastica.rod.paper import solver as solver_module
from loopelastica.rod.parameters import PhysicalParameters

# the printed method is compiled for its tests alone
pytestmark = pytest.mark.slow


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


def test_failure_is_a_value():
    out_of_reach = Clamping.from_parameters([0.9, 0.3, 0.6, 1.0, 1.0, 1.0])
    found = PaperSolver(l=1, delta=1).solve(out_of_reach)
    assert not found.converged
    assert found.physical is None
    assert found.residual == math.inf
    assert np.isfinite(found.loads).all()
    with pytest.raises(ValueError, match="net winding"):
        found.net_winding  # noqa: B018


def test_the_examples_that_quick_tests_skip_are_true():
    ran = 0
    for example in doctest.DocTestFinder().find(solver_module):
        for line in example.examples:
            line.options.pop(doctest.SKIP, None)
        found = doctest.DocTestRunner().run(example)
        assert found.failed == 0
        ran += found.attempted
    assert ran == 5
