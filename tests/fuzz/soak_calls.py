"""The calls that the soak draws from: arguments at random, and what a result must be."""

from __future__ import annotations

import copy
import decimal
import fractions
import functools
import json
import math
import pickle
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

import loopelastica as le
from loopelastica._files import data_path

Rng = np.random.Generator
KOC = data_path("hairpins/2koc.pdb")
CHECKED = 1e-7
"""An end that is given back by other means than the solver's may be off by this (L, radian)."""

JUNK: tuple[Any, ...] = (
    *(None, True, False, "", "1", "abc", "NaN", b"1", "\n", "x" * 10_000),
    *(0, -1, 3, 10**30, 10**400, -(10**400), 0.0, -0.0, 1e308, -1e308, 5e-324, 1e-300),
    *(math.nan, math.inf, -math.inf, 1j, complex(math.nan, 1), fractions.Fraction(1, 3)),
    *(decimal.Decimal("1.5"), np.float32(0.5), np.int8(3), np.bool_(True), np.datetime64("NaT")),
    *((), [], {}, set(), object(), np.nan * np.ones(3), np.ma.masked, np.array(None), range(3)),
    *([[]], [None], ["a"], [1, [2]], np.zeros(0), np.zeros((0, 3)), np.array("1"), np.ones((3, 3))),
    *(lambda: 0, float, KOC, Path("nowhere.pdb"), Path("/dev/zero"), np.random, NotImplemented),
)


def junk(rng: Rng) -> Any:
    return JUNK[rng.integers(len(JUNK))]


def pick(rng: Rng, values: Sequence[Any]) -> Any:
    return values[rng.integers(len(values))]


def some(rng: Rng, value: Any, odds: float = 0.1) -> Any:
    """The value, or with some odds something else altogether."""
    return junk(rng) if rng.random() < odds else value


def positive(rng: Rng) -> float:
    return float(
        pick(rng, (1.0, 0.5, 2.0, float(np.exp(rng.normal(0, 2))), 10.0 ** rng.integers(-300, 300)))
    )


def maybe(rng: Rng, **values: Any) -> dict[str, Any]:
    """Some of the keywords, a few of them with junk."""
    return {name: some(rng, value) for name, value in values.items() if rng.random() < 0.5}


def dressed(rng: Rng, values: Any) -> Any:
    """The same numbers in another dress, or sometimes other numbers."""
    array = np.array(values, dtype=np.float64)
    how = rng.integers(24)
    if how == 0:
        return array.tolist()
    if how == 1:
        array.setflags(write=False)
        return array
    if how == 2:
        return np.asfortranarray(array)
    if how == 3:
        return np.repeat(array, 2, axis=-1)[..., ::2]
    if how == 4:
        return array[..., ::-1][..., ::-1]
    if how == 5:
        return array.astype(object)
    if how == 6:
        with np.errstate(over="ignore"):
            return array.astype(np.float32)
    if how == 7:
        return array.astype(">f8")
    if how == 8:
        return np.matrix(array) if array.ndim == 2 else array
    if how == 9:
        return array + 0j
    if how == 10:
        return array + 1j
    if how == 11:
        return np.ma.masked_array(array, rng.random(array.shape) < 0.3)
    if how == 12:
        return array.astype(str)
    if how == 13:
        return array.astype(object) * decimal.Decimal(1) if not array.size else array.tolist()
    if how == 14 and array.size:
        array.ravel()[rng.integers(array.size)] = pick(
            rng, (math.nan, math.inf, 1e308, -1e308, 1e-320)
        )
        return array
    if how == 15:
        with np.errstate(over="ignore"):
            return array * 10.0 ** rng.integers(-320, 308)
    if how == 16:
        return array[..., :-1]
    if how == 17:
        return array[None]
    if how == 18:
        return np.zeros_like(array)
    if how == 19:
        return junk(rng)
    return array


def rotation(rng: Rng) -> np.ndarray:
    special = (np.eye(3), np.diag([1.0, -1, -1]), np.diag([-1.0, 1, -1]), np.diag([-1.0, -1, 1]))
    if rng.random() < 0.15:
        return np.array(pick(rng, special))
    return Rotation.random(rng=rng).as_matrix()


def position(rng: Rng) -> np.ndarray:
    direction = rng.normal(size=3)
    direction /= np.linalg.norm(direction)
    if rng.random() < 0.1:
        direction = np.array(pick(rng, ([0.0, 0, 1], [0, 0, -1.0], [1.0, 0, 0])))
    special = (0.0, 1.0, 1.0 - 1e-9, 1.0 + 1e-12, 1e-12, 0.999999, 1.5, 1e200)
    reach = pick(rng, special) if rng.random() < 0.25 else rng.random()
    return np.asarray(direction * reach)


def clamping(rng: Rng) -> le.Clamping:
    """A clamping that is one, most of them in reach."""
    return le.Clamping(position(rng), rotation(rng), bool(rng.random() < 0.4))


# --- results --------------------------------------------------------------------------------------


def must(fact: Any, sentence: str) -> None:
    if not fact:
        raise AssertionError(sentence)


def read_only(array: Any, name: str) -> None:
    must(isinstance(array, np.ndarray), f"{name} is {type(array).__name__}")
    must(not array.flags.writeable, f"{name} can be written to")


def again(result: Any, same: Callable[[Any, Any], None]) -> None:
    """Copies and pickles are as the original."""
    for other in (copy.copy(result), copy.deepcopy(result), pickle.loads(pickle.dumps(result))):
        same(result, other)


def same_rod(a: le.Equilibrium, b: le.Equilibrium) -> None:
    must(np.array_equal(a.loads, b.loads) and a.energy == b.energy, "a copied rod differs")
    for name in ("loads", "node_s", "node_pose", "layers"):
        read_only(getattr(b, name), f"{name} of a copy")


def check_rod(rng: Rng, rod: Any, tolerance: float = 1e-9) -> None:
    must(isinstance(rod, le.Equilibrium), f"{type(rod).__name__} in place of an Equilibrium")
    must(isinstance(rod.status, le.Status), "the status is no Status")
    must(np.isfinite(rod.loads).all(), "loads are not finite")
    must("\n" not in repr(rod) and "\n" not in rod.message, "more than one line")
    for name in ("loads", "node_s", "node_pose"):
        read_only(getattr(rod, name), name)
    again(rod, same_rod)
    back = le.Equilibrium.from_dict(json.loads(json.dumps(rod.to_dict(), allow_nan=False)))
    same_rod(rod, back)
    if not rod.converged:
        must(rod.energy == math.inf and rod.residual == math.inf, "no solution, but numbers of one")
        return
    must(math.isfinite(rod.energy) and rod.energy >= 0.0, f"energy {rod.energy}")
    must(0.0 <= rod.residual <= tolerance, f"residual {rod.residual}, tolerance {tolerance}")
    poses = rod.poses(pick(rng, (2, 3, 17)))
    must(np.isfinite(poses).all(), "poses are not finite")
    allowed = max(CHECKED, 10.0 * rod.residual)
    off = np.abs(poses[-1, :3] - rod.clamping.position).max()
    must(off <= allowed, f"the end is off by {off}")
    end = rod.frames(2)[-1]
    if rod.clamping.free_spin:
        turn = np.abs(end[:, 2] - rod.clamping.rotation[:, 2]).max()
    else:
        turn = np.abs(end - rod.clamping.rotation).max()
    must(turn <= allowed, f"the end is turned by {turn}")
    for value in (rod.twist, rod.periods):
        must(math.isfinite(value), "a scalar is not finite")
    must(np.isfinite(rod.curvature(5)).all() and np.isfinite(rod.moment(5)).all(), "not finite")


# --- the rod --------------------------------------------------------------------------------------


def make_clamping(rng: Rng) -> None:
    made = le.Clamping(
        dressed(rng, position(rng)), dressed(rng, rotation(rng)), some(rng, bool(rng.integers(2)))
    )
    read_only(made.position, "position")
    read_only(made.rotation, "rotation")
    must(np.isfinite(made.position).all() and np.isfinite(made.rotation).all(), "not finite")
    off = np.abs(made.rotation.T @ made.rotation - np.eye(3)).max()
    must(off < 1e-9, f"no rotation, by {off}")
    must(np.isfinite(made.parameters).all() and "\n" not in repr(made), "its parameters")
    again(made, lambda a, b: must(a == b, "a copy differs"))
    values = json.loads(json.dumps(made.to_dict(), allow_nan=False))
    must(le.Clamping.from_dict(values) == made, "from_dict differs")


def from_parameters(rng: Rng) -> None:
    q = np.concatenate([position(rng), rng.uniform(-10, 10, 3)])
    made = le.Clamping.from_parameters(dressed(rng, q), some(rng, False))
    must(np.isfinite(made.position).all() and np.isfinite(made.rotation).all(), "not finite")


def limits(rng: Rng) -> dict[str, Any]:
    tolerance = pick(rng, (1e-9, 1e-6, 1e-11, 1e-3))
    return {"time_limit_s": 2.0} | maybe(
        rng, tolerance=tolerance, time_limit_s=pick(rng, (0.01, 1.0, 1e-9))
    )


def solve(rng: Rng) -> None:
    given = limits(rng) | maybe(rng, lowest=bool(rng.integers(2)))
    if rng.random() < 0.3:
        given["guess"] = (
            dressed(rng, rng.normal(size=6) * 10.0 ** rng.integers(-2, 4))
            if rng.random() < 0.6
            else le.solve(clamping(rng), time_limit_s=1.0)
        )
    rod = le.solve(some(rng, clamping(rng), 0.05), some(rng, positive(rng), 0.1), **given)
    check_rod(rng, rod, given.get("tolerance", 1e-9))


def equilibria(rng: Rng) -> None:
    given = limits(rng) | maybe(
        rng,
        energy_max=pick(rng, (10.0, 100.0, 300.0, 1e-9)),
        rounds=1,
        turns=int(rng.integers(-2, 3)),
    )
    given.setdefault("rounds", 1)
    ratio = float(pick(rng, (1.0, 0.7, 1.5, 0.01, 100.0)))
    found = le.equilibria(clamping(rng), some(rng, ratio), **given)
    energies = [rod.energy for rod in found]
    must(energies == sorted(energies), "not in the order of energy")
    must(all(energy <= found.energy_max for energy in energies), "above energy_max")
    must(0.0 <= found.unseen <= 1.0, f"unseen {found.unseen}")
    must(len(found.hits) == len(found), "hits")
    for rod in found[:3]:
        check_rod(rng, rod, given.get("tolerance", 1e-9))


def solve_batch(rng: Rng) -> None:
    n = int(pick(rng, (0, 1, 2, 5)))
    positions = np.array([position(rng) for _ in range(n)]).reshape(n, 3)
    rotations = np.array([rotation(rng) for _ in range(n)]).reshape(n, 3, 3)
    given = limits(rng) | maybe(rng, lowest=True, threads=2, free_spin=bool(rng.integers(2)))
    ratio = pick(rng, (1.0, 0.8, np.full(n, 1.0), rng.uniform(0.5, 2, n)))
    batch = le.solve_batch(
        dressed(rng, positions), dressed(rng, rotations), some(rng, ratio, 0.1), **given
    )
    tolerance = given.get("tolerance", 1e-9)
    for name in ("positions", "rotations", "loads", "energy", "residual", "status", "method"):
        read_only(getattr(batch, name), name)
        must(not np.isnan(getattr(batch, name)).any() or name in ("positions", "rotations"), name)
    must((batch.residual[batch.converged] <= tolerance).all(), "residuals")
    must(np.isinf(batch.energy[~batch.converged]).all(), "energy of a row that failed")
    must(np.isinf(batch.residual[~batch.converged]).all(), "residual of a row that failed")
    for k in range(len(batch)):
        if batch.status[k] == le.Status.BAD_INPUT:
            continue
        rod = batch[k]
        check_rod(rng, rod, tolerance)
        must(rod.energy == batch.energy[k] and rod.residual == batch.residual[k], f"row {k}")
    again(batch, lambda a, b: must(np.array_equal(a.loads, b.loads), "a copied batch differs"))


def sampled(rng: Rng) -> None:
    """Points of one rod, at places good and bad."""
    rod = le.solve(le.Clamping(position(rng) * 0.5, rotation(rng)), time_limit_s=1.0)
    method = pick(rng, ("centerline", "frames", "poses", "moment", "curvature"))
    n = some(rng, dressed(rng, rng.random(4)) if rng.random() < 0.5 else 7, 0.3)
    out = getattr(rod, method)(n)
    must(np.isfinite(out).all(), f"{method} is not finite")


def parameters(rng: Rng) -> None:
    lam, t_p = rng.normal(size=2)
    a = abs(rng.normal()) * 3 + pick(rng, (-2.0, 0.0, 2.0))
    values = [lam, t_p, a, rng.uniform(-7, 7), rng.normal(), positive(rng)]
    made = le.PhysicalParameters(*(some(rng, value, 0.05) for value in values))
    must(np.isfinite(made.loads(1.0)).all() if callable(made.loads) else True, "loads")
    if made.length < 1e3:
        q = made.clamping(some(rng, 1.0))
        must(np.isfinite(q.position).all() and np.isfinite(q.rotation).all(), "clamping")
        must(np.isfinite(made.centerline(some(rng, 5))).all(), "centerline")
    again(made, lambda one, two: must(one == two, "a copy differs"))


def paths(rng: Rng) -> None:
    rod = le.solve(le.Clamping(position(rng) * 0.6, rotation(rng)), time_limit_s=1.0)
    given = maybe(rng, steps=20, max_step=0.5, stability=False)
    given.setdefault("steps", 20)
    if rng.random() < 0.5:
        goal = le.Clamping(position(rng) * 0.6, rotation(rng))
        if rng.random() < 0.3:
            given["natural"] = some(rng, True)
        path = le.continue_clamping(some(rng, rod, 0.05), some(rng, goal, 0.05), **given)
    else:
        path = le.twist_end(some(rng, rod, 0.05), some(rng, float(rng.normal())), **given)
    read_only(path.parameter, "parameter")
    must(np.isfinite(path.parameter).all(), "parameter is not finite")
    must(len(path.rods) == len(path.parameter), "rods and parameters")
    must(path.converged == (path.end is not None), "end")
    if path.end is not None:
        check_rod(rng, path.end)
    again(path, lambda a, b: must(np.array_equal(a.parameter, b.parameter), "a copy differs"))


def from_dict(rng: Rng) -> None:
    """What is not as it was written is refused, in a documented way."""
    values = le.solve(le.Clamping(position(rng) * 0.5, rotation(rng)), time_limit_s=1.0).to_dict()
    name = pick(rng, list(values))
    values[name] = junk(rng)
    try:
        le.Equilibrium.from_dict(values)
    except (KeyError, ValueError, TypeError):
        raise ValueError("`values` was refused") from None


# --- the molecule ---------------------------------------------------------------------------------


@functools.cache
def universe() -> Any:
    from loopelastica.molecule.nucleotides import read_structure

    return read_structure(KOC).universe


def sources(rng: Rng) -> Any:
    return some(
        rng, pick(rng, (KOC, str(KOC), universe(), universe().atoms, universe().atoms[50:400])), 0.1
    )


def loop_options(rng: Rng) -> dict[str, Any]:
    given = maybe(
        rng,
        free_spin=bool(rng.integers(2)),
        torsion_ratio=float(pick(rng, (1.0, 0.5, 3.0))),
        length_per_nucleotide_A=float(rng.uniform(3, 9)),
        persistence_length_A=positive(rng),
        irregular=True,
        max_size_MB=500.0,
        max_atoms=10**6,
    )
    if rng.random() < 0.2:
        given["pair"] = some(rng, pick(rng, ("A.5-10", "A.4-A.11", ["A.1-14"], "5-10", "A.6-9")))
    if rng.random() < 0.2:
        given["loop"] = some(
            rng, pick(rng, ("A.6-9", "A.5-10", "A.2-13", "A.7-8", "A.1-14", "A6-9"))
        )
    if rng.random() < 0.2:
        brackets = "".join(rng.choice(list("().[]Aa"), size=14).tolist())
        given["dot_bracket"] = some(rng, pick(rng, ("(((((....)))))", "((((......))))", brackets)))
    return given


def find_hairpins(rng: Rng) -> None:
    given = loop_options(rng)
    for name in (
        *("free_spin", "torsion_ratio", "length_per_nucleotide_A"),
        *("persistence_length_A", "irregular"),
    ):
        given.pop(name, None)
    found = le.find_hairpins(sources(rng), **given, **maybe(rng, min_loop=3, max_loop=30))
    for hairpin in found:
        must(len(hairpin.residues) == len(hairpin), "residues")
        read_only(hairpin.loop, "loop")
        must("\n" not in repr(hairpin), "more than one line")
    again(found, lambda a, b: must([h.name for h in a] == [h.name for h in b], "a copy differs"))


def check_candidate(candidate: Any) -> None:
    must(np.isfinite(candidate.trace).all(), "a trace is not finite")
    read_only(candidate.trace, "trace")
    for name in ("energy_per_A", "energy_kT", "residual", "length_A", "rmsd_A"):
        value = getattr(candidate, name)
        must(value is None or math.isfinite(value), f"{name} is {value}")
    must(np.isfinite(candidate.rmsd_models_A).all(), "rmsd_models_A")
    read_only(candidate.expected_rmsd_A, "expected_rmsd_A")
    low, middle, high = candidate.expected_rmsd_A
    must(0.0 <= low <= middle <= high < math.inf, "expected_rmsd_A")
    json.dumps(candidate.line.to_dict(), allow_nan=False)


def fold(rng: Rng) -> None:
    given = loop_options(rng) | maybe(
        rng,
        stem_extend_5=int(rng.integers(3)),
        stem_extend_3=int(rng.integers(3)),
        taper=float(rng.uniform(0, 0.3)),
        energy_max=float(pick(rng, (10.0, 100.0))),
        max_candidates=2,
        rank="energy",
        shapes="rod",
        exclude_relatives=True,
        surroundings=False,
    )
    folds = le.fold(sources(rng), **given, all_models=some(rng, False))
    for loop in folds:
        must((loop.failure is None) == bool(loop.candidates), "failure or candidates")
        must(loop.failure is None or "\n" not in loop.failure, "failure of two lines")
        json.dumps(loop.parameters, allow_nan=False)
        for candidate in loop.candidates:
            check_candidate(candidate)
        again(loop, lambda a, b: must(len(a.candidates) == len(b.candidates), "a copy differs"))
    if folds and rng.random() < 0.3:
        table = le.to_dataframe(some(rng, folds))
        must(len(table) >= len(folds), "rows of the table")


def scan(rng: Rng) -> None:
    given = loop_options(rng) | {"extend_5_max": 0, "extend_3_max": 0, "tapers": (0.0,)}
    given |= maybe(rng, extend_5_max=1, extend_3_max=0, tapers=[0.1])
    for loop in le.scan(sources(rng), **given):
        must(loop.failure is None or "\n" not in loop.failure, "failure of two lines")
        must(math.isfinite(loop.spread_A), "spread")
        for scanned in loop.candidates:
            check_candidate(scanned.candidate)


def trajectory(rng: Rng) -> None:
    given = loop_options(rng)
    for name in ("persistence_length_A", "max_size_MB", "max_atoms"):
        if rng.random() < 0.9:
            given.pop(name, None)
    analysis = le.LoopElastica(sources(rng), **given).run(stop=2)
    shape = (2, len(analysis.hairpins))
    must(analysis.results.energy_per_A.shape == shape, "shape")
    for name in ("energy_per_A", "rmsd_A", "traces_A"):
        must(not np.isnan(analysis.results[name]).any(), f"{name} is NaN")


@functools.cache
def folded() -> Any:
    (loop,) = le.fold(KOC, all_models=False)
    return loop


def build_atoms(rng: Rng) -> None:
    given = {"max_candidates": 1, "tries": 1, "max_seconds": 2.0, "max_steps": 20} | maybe(
        rng,
        model=int(rng.integers(20)),
        contact=pick(rng, ("sheared", "watson-crick")),
        tries=1,
        max_steps=10,
        max_candidates=1,
    )
    if rng.random() < 0.1:
        given["positions"] = dressed(rng, universe().atoms.positions)
    for model in le.build_atoms(some(rng, KOC), some(rng, folded(), 0.05), **given):
        must(np.isfinite(model.positions_A).all(), "positions are not finite")
        must(model.rmsd_A is None or math.isfinite(model.rmsd_A), "rmsd_A")


_CALLS: dict[Callable[[Rng], None], float] = {
    make_clamping: 15,
    from_parameters: 5,
    solve: 20,
    equilibria: 8,
    solve_batch: 15,
    sampled: 8,
    parameters: 10,
    paths: 5,
    from_dict: 3,
    find_hairpins: 5,
    fold: 4,
    scan: 2,
    trajectory: 1,
    build_atoms: 1,
}
_ODDS = np.array(list(_CALLS.values())) / sum(_CALLS.values())


def chosen(rng: Rng) -> tuple[str, Callable[[Rng], None]]:
    """One of the calls, by its odds."""
    call = list(_CALLS)[rng.choice(len(_CALLS), p=_ODDS)]
    return call.__name__, call
