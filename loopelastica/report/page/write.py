"""A page from folders of results.

    summary.csv, failures.csv ─┐
    a scene.js per folder ─────┴→ rows, provenance ─┬→ report.html
    plotly's script, style, template ───────────────┘

Scenes of few loops stand in the page; those of many stay where they are, and the page loads one
when its loop is chosen. Plotly's script is compressed in the page; the browser unpacks it.
"""

from __future__ import annotations

import base64
import csv
import gzip
import importlib.util
import math
import os
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from datetime import datetime
from html import escape
from pathlib import Path
from typing import Any, Final

from loopelastica._files import PROGRAM, refuse_other, write_text
from loopelastica._names import printable
from loopelastica._version import __version__
from loopelastica.errors import LoopelasticaError, MissingDependencyError
from loopelastica.report.page.scene import SCENE, read_scene, script_json
from loopelastica.report.palette import NATIVE, NEIGHBOUR, PALETTE, STEM

PAGE: Final = "report.html"
"""Name of the page."""

_TABLE: Final = "summary.csv"

_INSIDE: Final = 20
"""Most folders whose scenes stand in the page."""
_INSIDE_BYTES: Final = 3_000_000
"""Most bytes of these."""
_BEGIN: Final = "<!DOCTYPE html><!-- loopelastica report -->"
_HERE: Final = Path(__file__).parent

_FIRST: Final = (
    *("shape", "energy_kT", "expected_10_A", "expected_rmsd_A", "expected_90_A", "rmsd_A"),
    "touching",
)
"""What a row of the page has of the first candidate."""


def is_available() -> bool:
    """Whether plotly is installed, without loading it."""
    return importlib.util.find_spec("plotly") is not None


def check_available() -> None:
    """MissingDependencyError where plotly is not installed."""
    if not is_available():
        raise MissingDependencyError(
            "report.html needs plotly; install it with `pip install loopelastica[report]`"
        )


def write_report(folder: str | os.PathLike[str]) -> Path:
    """Make report.html from a folder of results: every loop in 3D, tables, failures, provenance.

    The page opens without a network. What it shows is read from the folder, whichever runs have
    filled it: summary.csv says which loops and in which order (without it, every folder with a
    scene counts), failures.csv what failed, and scene.js of each loop's folder what is drawn.

    Parameters
    ----------
    folder : path
        What ``-o`` of `fold`, `fill` or `build` was; or the folder of one loop.

    Returns
    -------
    Path
        The page.

    Raises
    ------
    MissingDependencyError
        If plotly is not installed.
    LoopelasticaError
        If there are no results in the folder.
    OutputError
        If the page cannot be written, or its name is taken by somebody else's.

    Examples
    --------
    >>> import tempfile
    >>> import loopelastica as le
    >>> try:
    ...     write_report(tempfile.gettempdir() + "/nothing-here")
    ... except le.LoopelasticaError as error:
    ...     print(str(error).split(": ")[-1])
    no folder of results; there is nothing to report
    """
    check_available()
    root = Path(folder)
    if not root.is_dir():
        raise LoopelasticaError(f"{root}: no folder of results; there is nothing to report")
    page = root / PAGE
    refuse_other(page, _BEGIN.encode())
    gathered = _Gathered(root)
    if not (gathered.rows or gathered.failures or (root / _TABLE).is_file()):
        raise LoopelasticaError(
            f"{root}: neither {_TABLE} nor a folder with {SCENE}; there is nothing to report"
        )
    title = f"{printable(root.resolve().name)} · {PROGRAM}"
    parts = {
        "begin": _BEGIN,
        "title": escape(title),
        "style": _part("page.css"),
        "report": script_json(gathered.content()),
        "code": _part("table.js") + _part("view.js") + _part("page.js"),
        "plotly": _plotly(),
    }
    write_text(page, re.sub(r"\{\{(\w+)\}\}", lambda m: parts[m[1]], _part("page.html")))
    return page


def renew_report(folder: Path, wanted: bool) -> Path | None:
    """The page of a run that has ended; without one, that of an earlier run goes.

    Parameters
    ----------
    folder : Path
        Of the run.
    wanted : bool
        Whether the run has a page.

    Returns
    -------
    Path or None
    """
    if wanted:
        return write_report(folder)
    with suppress(OSError):
        page = folder / PAGE
        refuse_other(page, _BEGIN.encode())
        page.unlink()
    return None


def _part(name: str) -> str:
    return (_HERE / name).read_text(encoding="utf-8")


def _plotly() -> str:
    """Plotly's script as it stands in the page."""
    from plotly.offline import get_plotlyjs

    packed = gzip.compress(get_plotlyjs().encode(), compresslevel=6, mtime=0)
    return base64.b64encode(packed).decode()


class _Gathered:
    """What the folders of a run have for its page."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.rows: list[dict[str, Any]] = []
        self.failures = [_printable(row) for row in _table(root / "failures.csv")]
        self._scenes: dict[str, dict[str, Any]] | None = {}
        self._bytes = 0
        self._inputs: dict[str, str] = {}
        self._options: dict[str, Any] | None = None
        self._versions: dict[str, None] = {}
        for name, rows in self._folders():
            self._add(name, rows)

    def content(self) -> dict[str, Any]:
        """All that the page's script reads, JSON-ready."""
        return {
            "folder": printable(str(self.root.resolve().name)),
            "written": datetime.now().astimezone().strftime("%Y-%m-%d %H:%M %Z"),
            "program": f"{PROGRAM} {__version__}",
            "versions": list(self._versions),
            "colours": {
                "ranks": PALETTE, "native": NATIVE, "stem": STEM, "neighbour": NEIGHBOUR,
            },
            "scene": SCENE,
            "rows": self.rows,
            "failures": self.failures,
            "scenes": self._scenes or {},
            "inputs": [{"file": f, "sha256": digest} for f, digest in self._inputs.items()],
            "options": {k: v for k, v in (self._options or {}).items() if v is not None},
        }  # fmt: skip

    def _folders(self) -> Iterator[tuple[str, list[dict[str, Any]]]]:
        """Names of the loops' folders in the order of the run, with their rows of its table."""
        rows: dict[str, list[dict[str, Any]]] = {}
        for row in _table(self.root / _TABLE):
            # of a fold's candidates the first; a filled strand has no rank
            if row.get("folder") and row.get("rank", "1") == "1":
                rows.setdefault(row["folder"], []).append(row)
        if rows:
            yield from rows.items()
        elif (self.root / SCENE).is_file():
            yield "", []
        else:
            names = sorted(entry.name for entry in os.scandir(self.root) if entry.is_dir())
            yield from ((name, []) for name in names if (self.root / name / SCENE).is_file())

    def _add(self, name: str, rows: list[dict[str, Any]]) -> None:
        path = self.root / name / SCENE
        scene = read_scene(path)
        if scene is None:
            # written without a report: the table alone
            self.rows += [{**_numbers(row), "place": None} for row in rows]
            return
        source = rows[0]["file"] if rows else None
        for place, item in enumerate(scene["items"]):
            first = item["candidates"][0] if item["candidates"] else {}
            row = {**{key: first.get(key) for key in (*_FIRST, "sound")}, **item["row"]}
            row |= {"folder": name, "place": place, "candidates": len(item["candidates"])}
            self.rows.append(row | ({} if source is None else {"file": printable(source)}))
        digest = scene.get("sha256")
        if digest:
            self._inputs.setdefault(self.rows[-1]["file"] if scene["items"] else name, digest)
        self._versions.setdefault(scene.get("version", ""))
        options = scene.get("parameters", {})
        self._options = (
            options
            if self._options is None
            else {k: v for k, v in self._options.items() if k in options and options[k] == v}
        )
        if self._scenes is not None:
            self._bytes += path.stat().st_size
            self._scenes[name] = scene
            if len(self._scenes) > _INSIDE or self._bytes > _INSIDE_BYTES:
                self._scenes = None


def _table(path: Path) -> Iterator[dict[str, Any]]:
    """Rows of a table of the run; none where there is no table."""
    if not path.is_file():
        return
    with path.open(encoding="utf-8", newline="") as file:
        yield from csv.DictReader(file)


def _printable(row: Mapping[str, Any]) -> dict[str, str]:
    return {key: printable(row.get(key) or "") for key in ("file", "failure")}


def _numbers(row: Mapping[str, str]) -> dict[str, Any]:
    """A row of a CSV file with its numbers as such, and without its empty cells."""
    kept: Iterable[tuple[str, str]] = ((k, v) for k, v in row.items() if k and v)
    return {key: _number(value) for key, value in kept}


def _number(text: str) -> float | str:
    try:
        value = float(text)
    except ValueError:
        return text
    return value if math.isfinite(value) else text
