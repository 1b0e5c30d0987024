"""Compile now what would be compiled at first use: ``python -m loopelastica.rod.warm``.

Small problems are solved that come to every kernel but those of the printed method; a test sees to
it that none is left out. They need NumPy and numba alone, so that this runs where the package is
built.
"""

import contextlib
import gc
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

from loopelastica.rod.chain import deform_batch
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.continuation import continue_clamping, twist_end
from loopelastica.rod.descent import ways_down
from loopelastica.rod.equilibria import equilibria
from loopelastica.rod.kernels.code_store import shipped_folder, try_writing, user_folder
from loopelastica.rod.kernels.portable import portable_environment
from loopelastica.rod.solve import solve
from loopelastica.rod.stability import assess, conjugate_points
from loopelastica.rod.surrounded import surrounded_rods

# a slack rod, one in boundary layers, one whose layers reach each other, and one in line
_SLACK = (-0.4, -0.1, 0.5, 4.8, 1.4, 2.2)
_TENSE = (0.2, 0.1, 0.974, 0.3, 0.8, 0.4)
_TOUCHING = (0.1, 0.1, 0.9, 0.3, 0.8, 0.4)
_IN_LINE = (0.0, 0.0, 0.8, 0.0, 0.0, 1.0)
# the frame of both ends of a chain
_FRAME = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


def compile_solver() -> None:
    """Compile what `solve`, `solve_batch`, one round of `equilibria` and the folds need."""
    for parameters in (_SLACK, _TENSE, _TOUCHING, _IN_LINE):
        for free_spin in (False, True):
            clamping = Clamping.from_parameters(parameters, free_spin)
            rod = solve(clamping)
            assess(rod)
            conjugate_points(rod)
            rod.centerline(3)
    equilibria(Clamping.from_parameters(_SLACK), energy_max=30.0, rounds=1)
    surrounded_rods((0, 0, 0), (0, 0, 1), (1, 0, 0), (0, 0, -1), 2.5, segments=8)
    deform_batch(((0, 0, 1), (1, 0, 0)), _FRAME, (1, 0.5, 0.5), _FRAME)


def compile_paths() -> None:
    """Compile what more rounds, continuation, barriers, the closed form and the writhe need."""
    equilibria(Clamping.from_parameters(_SLACK), energy_max=30.0)
    rod = solve(Clamping.from_parameters(_SLACK))
    twist_end(rod, 0.1)
    continue_clamping(rod, Clamping.from_parameters((-0.4, -0.1, 0.52, 4.8, 1.4, 2.2)))
    free = solve(Clamping.from_parameters(_SLACK, free_spin=True))
    continue_clamping(free, Clamping.from_parameters(_TOUCHING, free_spin=True))
    tense = solve(Clamping.from_parameters(_TENSE))
    continue_clamping(tense, Clamping.from_parameters((0.2, 0.1, 0.9743, 0.3, 0.8, 0.4)))
    for each in (rod, free):
        # as if it were a saddle
        ways_down(replace(each, index=1))
    assert rod.physical is not None
    rod.physical.clamping()
    rod.physical.loads()
    assert rod.net_winding != rod.periods


def warm(*others: str) -> Path:
    """Compile everything in processes of their own, for any processor of this architecture.

    Parameters
    ----------
    *others : str
        Modules of other rooms that compile their kernels when they are run.

    Returns
    -------
    Path
        The folder of compiled code: inside the package if that can be written, where every user of
        the installation finds it; else the user's own.

    Raises
    ------
    OSError
        If neither can be written.
    RuntimeError
        If compiling fails; the message is the end of what numba said.
    """
    folder = _target()
    environment = {**os.environ, **portable_environment(), "LOOPELASTICA_CACHE": str(folder)}
    processes = [
        subprocess.Popen(
            [sys.executable, "-m", module],
            env=environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        for module in ("loopelastica.rod.warm", *others)
    ]
    said = [process.communicate()[1] for process in processes]
    for process, text in zip(processes, said, strict=True):
        if process.returncode:
            raise RuntimeError(f"compiling failed: {text.strip()[-500:]}")
    return folder


def _target() -> Path:
    chosen = os.environ.get("LOOPELASTICA_CACHE")
    for folder in (user_folder(),) if chosen else (shipped_folder(), user_folder()):
        if folder is None:
            continue
        with contextlib.suppress(OSError):
            try_writing(folder)
            return folder
    raise OSError("no folder for compiled code can be written")


if __name__ == "__main__":
    # numba makes much garbage that is in no circle: collecting it takes a tenth of the time
    gc.disable()
    compile_solver()
    if "--solver-only" not in sys.argv[1:]:
        compile_paths()
