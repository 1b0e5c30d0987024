"""What a scene does not need is left out: what that saves, and that the answer is the same.

Each row does one thing with and without something on the same targets, one after the other, in
processor time; imports are wall time in fresh processes, the least of several. "Same" is the share
of targets with the same answer, None where there is no answer to compare.
"""

import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from loopelastica._arrays import Array
from loopelastica._files import data_path
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.equilibria import equilibria
from loopelastica.rod.equilibrium import Equilibrium
from loopelastica.rod.solve import solve
from loopelastica.rod.stability import assess
from loopelastica.studies.bench import _poses as poses
from loopelastica.studies.bench._processes import seconds_of

Row = dict[str, Any]
Call = Callable[[], Any]

# poses, those of them whose equilibria are listed, and repeats of an import: default and full
_POSES, _LISTED, _IMPORTS = (30, 300), (3, 20), (3, 10)
# two energies, or points of two lines, are one if they differ by less
_SAME = 1e-6
_NEAR = 0.95
_POINTS = 200
# calls of a compiled kernel between two looks at the clock
_KERNEL = 50

NOTE = (
    "The time with and without something, processor time but for imports and `fold`, which are wall"
    " time in fresh processes. “Same answer” counts the targets where both give the same energy or"
    " line: any equilibrium is not always the lowest."
)

_IMPORT = """
import json, sys, time
began = time.perf_counter()
for name in sys.argv[1:]:
    __import__(name)
print(json.dumps([time.perf_counter() - began]))
"""
_FOLD = """
import contextlib, io, json, sys, tempfile, time
from loopelastica.cli.app import app
began = time.perf_counter()
with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
    app(["fold", sys.argv[1], "-o", folder, "--first-model", sys.argv[2]], standalone_mode=False)
print(json.dumps([time.perf_counter() - began]))
"""


def _spent(call: Call, repeats: int = 1) -> tuple[Any, float]:
    started = time.thread_time()
    for _ in range(repeats):
        result = call()
    return result, (time.thread_time() - started) / repeats


def _compare(
    name: str, pairs: Sequence[tuple[Call, Call]], same: Callable[[Any, Any], bool],
    repeats: int = 1,
) -> Row:  # fmt: skip
    """The row of calls (with, without) on some targets."""
    for call in pairs[0]:
        call()  # compiled before the clock starts
    seconds, agree = np.zeros(2), 0
    for pair in pairs:
        (one, with_it), (other, without) = (_spent(call, repeats) for call in pair)
        seconds += with_it, without
        agree += same(one, other)
    with_ms, without_ms = 1e3 * seconds / len(pairs)
    return _row(name, len(pairs), with_ms, without_ms, agree)


def _row(name: str, sample: int, with_it: float, without: float, agree: int | None) -> Row:
    return {
        "omitted": name,
        "sample": sample,
        "with_ms": round(float(with_it), 5),
        "without_ms": round(float(without), 5),
        "ratio": round(float(with_it / without), 3),
        "same": agree,
    }


def _same_energy(one: Equilibrium, other: Equilibrium) -> bool:
    both = one.converged and other.converged
    return both and abs(one.energy - other.energy) < _SAME * (1.0 + abs(one.energy))


def _clampings(draw: poses.Draw, rng: np.random.Generator, n: int) -> list[Clamping]:
    return [Clamping(p, r) for p, r in zip(*draw(rng, n), strict=True)]


def _at_own_spin(free: Clamping) -> Clamping:
    """The same end with the spin clamped to what the lowest free rod takes."""
    return Clamping(free.position, solve(free).frames(2)[1])


def _turned(clamping: Clamping, angle: float) -> Clamping:
    """The same problem with its start frame turned about the tangent, out of the plane."""
    turn = Rotation.from_rotvec([0.0, 0.0, angle]).as_matrix()
    return Clamping(turn @ clamping.position, turn @ clamping.rotation @ turn.T)


def _solver_rows(full: bool, rng: np.random.Generator) -> list[Row]:
    near = _clampings(poses.at_shell(0.0, _NEAR), rng, _POSES[full])
    listed = near[: _LISTED[full]]
    free = [Clamping(c.position, c.rotation, free_spin=True) for c in near]
    own = [_at_own_spin(c) for c in free]
    planar = _clampings(poses.planar, rng, _POSES[full])
    angles = rng.uniform(0.3, 1.2, len(planar))
    first = partial(solve, lowest=False)
    return [
        _compare(
            "end spin clamped, where the scene leaves it free",
            [(partial(solve, c), partial(solve, f)) for c, f in zip(own, free, strict=True)],
            _same_energy,
        ),
        _compare(
            "the lowest, where any equilibrium will do",
            [(partial(solve, c), partial(first, c)) for c in near],
            _same_energy,
        ),
        _compare(
            "all equilibria, where the lowest will do",
            [(partial(equilibria, c), partial(solve, c)) for c in listed],
            lambda found, one: _same_energy(found[0], one),
        ),
        _compare(
            "stability test, unless asked",
            [(partial(lambda c: assess(solve(c)), c), partial(solve, c)) for c in near],
            _same_energy,
        ),
        _compare(
            "directions out of the plane, for a planar problem",
            [
                (partial(solve, _turned(c, angle)), partial(solve, c))
                for c, angle in zip(planar, angles, strict=True)
            ],
            _same_energy,
        ),
    ]


def _line_rows(full: bool, rng: np.random.Generator) -> list[Row]:
    from loopelastica.rod.kernels import shooting as kernel

    near = _clampings(poses.at_shell(0.0, _NEAR), rng, _POSES[full])
    rods = [solve(c, lowest=False) for c in near]
    loads = poses.random_loads(rng, _POSES[full])

    def end(f: Array, torsion_ratio: float) -> Array:
        y = np.empty(kernel.WITH_JACOBIAN)
        kernel.shoot(f, torsion_ratio, 24, kernel.WITH_JACOBIAN, y, k, z)
        return y

    z, k = np.empty(kernel.WITH_JACOBIAN), np.empty(12 * kernel.WITH_JACOBIAN)
    return [
        _compare(
            "frames, where the center line will do",
            [
                (
                    partial(lambda r: (r.centerline(_POINTS), r.frames(_POINTS))[0], rod),
                    partial(rod.centerline, _POINTS),
                )
                for rod in rods
            ],
            lambda one, other: bool(np.abs(one - other).max() < _SAME),
        ),
        _compare(
            "twist offset (K30 = 0.7), where K30 = 1",
            [(partial(end, f, 0.7), partial(end, f, 1.0)) for f in loads],
            # the center line does not depend on K30
            lambda one, other: bool(np.abs(one[:3] - other[:3]).max() < _SAME),
            _KERNEL,
        ),
    ]


def _least(code: str, *arguments: str, repeats: int) -> float:
    return 1e3 * min(seconds_of(code, *arguments)[0] for _ in range(repeats))


def _process_rows(full: bool) -> list[Row]:
    n = _IMPORTS[full]
    alone = _least(_IMPORT, "loopelastica", repeats=n)
    rows = [
        _row(
            f"import of {what}, unless used", n,
            _least(_IMPORT, "loopelastica", *modules, repeats=n), alone, None,
        )
        for what, modules in (
            ("the compiled rod", ("loopelastica.rod.kernels.multistart",)),
            ("MDAnalysis", ("MDAnalysis",)),
            ("rdkit", ("rdkit.Chem",)),
            ("matplotlib", ("matplotlib.figure",)),
        )
    ]  # fmt: skip
    file = str(data_path("hairpins/2koc.pdb"))
    drawn, undrawn = (_least(_FOLD, file, f"--{no}plot", repeats=n) for no in ("", "no-"))
    return [*rows, _row("plot.png of `fold`, with --no-plot", n, drawn, undrawn, None)]


def measure(full: bool, rng: np.random.Generator) -> list[Row]:
    """All rows; the full sample is ten times the default one."""
    return [*_solver_rows(full, rng), *_line_rows(full, rng), *_process_rows(full)]


COLUMNS = {
    "omitted": ("what", ""),
    "sample": ("sample", ",d"),
    "with_ms": ("with / ms", ".4g"),
    "without_ms": ("without / ms", ".4g"),
    "ratio": ("ratio", ".3g"),
    "same": ("same answer", "d"),
}
