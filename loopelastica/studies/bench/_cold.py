"""The first call after an installation, and later ones."""

import tempfile
from pathlib import Path
from typing import Any

from loopelastica._files import data_path
from loopelastica.studies.bench._processes import seconds_of

Row = dict[str, Any]

NOTE = (
    "Wall time in fresh processes. “Fresh” has no compiled code on disk, as after an installation;"
    " “again” is the next process. “First call” includes the imports that it causes, “later” is the"
    " same call once more."
)

_TIMED = """
import json, sys, time
began = time.perf_counter()
import loopelastica as le
{prepare}
imported = time.perf_counter()
{call}
first = time.perf_counter()
{call}
print(json.dumps([imported - began, first - imported, time.perf_counter() - first]))
"""
_SOLVE = _TIMED.format(
    prepare="q = le.Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])", call="le.solve(q)"
)
_FOLD = _TIMED.format(prepare="fold = le.fold", call="fold(sys.argv[1])")
_HELP = """
import json, subprocess, sys, time
began = time.perf_counter()
subprocess.run([sys.executable, "-m", "loopelastica.cli.app", "--help"], stdout=subprocess.DEVNULL,
               check=True)
print(json.dumps([time.perf_counter() - began]))
"""


def measure() -> list[Row]:
    """Rows of ``solve`` and ``fold``, each from an empty cache of its own, and of ``--help``."""
    rows = []
    for name, code, arguments in (
        ("solve", _SOLVE, ()),
        ("fold 2koc.pdb", _FOLD, (str(data_path("hairpins/2koc.pdb")),)),
    ):
        with tempfile.TemporaryDirectory(prefix="loopelastica-bench-") as folder:
            for process in ("fresh", "again"):
                seconds = seconds_of(code, *arguments, numba_cache=Path(folder))
                rows.append(_row(name, process, *seconds))
    whole = seconds_of(_HELP)[0]
    return [*rows, _row("loopelastica --help", "again", None, whole, None)]


def _row(
    call: str, process: str, imported: float | None, first: float | None, later: float | None
) -> Row:
    return {
        "call": call,
        "process": process,
        "import_s": None if imported is None else round(imported, 4),
        "first_s": None if first is None else round(first, 4),
        "later_s": None if later is None else round(later, 4),
    }


COLUMNS = {
    "call": ("call", ""),
    "process": ("process", ""),
    "import_s": ("import / s", ".3f"),
    "first_s": ("first call / s", ".3f"),
    "later_s": ("later / s", ".4f"),
}
