"""Fresh Python processes that measure themselves: what the package costs before it is warm."""

import json
import os
import subprocess
import sys
from pathlib import Path

# the package that is running, wherever it is installed or checked out
_ROOT = Path(__file__).resolve().parents[2]


def seconds_of(code: str, *arguments: str, numba_cache: Path | None = None) -> list[float]:
    """Run ``code`` in a fresh process and return the numbers of the list that it prints.

    Parameters
    ----------
    code : str
        Prints a JSON list; finds ``arguments`` in ``sys.argv[1:]``.
    numba_cache : Path, optional
        Folder for numba's compiled code in place of the usual one.

    Raises
    ------
    RuntimeError
        If the process fails; the message is the end of what it wrote to standard error.
    """
    environment = dict(os.environ)
    known = environment.get("PYTHONPATH")
    environment["PYTHONPATH"] = os.pathsep.join([str(_ROOT), *([known] if known else [])])
    if numba_cache is not None:
        environment["NUMBA_CACHE_DIR"] = str(numba_cache)
    run = subprocess.run(
        [sys.executable, "-c", code, *arguments],
        capture_output=True, text=True, env=environment, check=False,
    )  # fmt: skip
    if run.returncode:
        raise RuntimeError(f"a process of the benchmark failed: {run.stderr.strip()[-500:]}")
    return [float(value) for value in json.loads(run.stdout.splitlines()[-1])]
