"""Does a simulation accept the models? Folded and built ones, natives beside them.

Figures of the force field say nothing of how near a loop is to the native one: they say whether a
simulation can start from it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, TypeVar

import numpy as np

from loopelastica._files import make_folder, write_csv, write_json
from loopelastica._names import printable
from loopelastica.molecule.folders import structure_files
from loopelastica.studies.bench.markdown import markdown_table
from loopelastica.studies.simulation.acceptance import FORCE_FIELDS, accepted, modules
from loopelastica.studies.simulation.cases import BUILT, Case, built_cases, file_cases

_T = TypeVar("_T")
_FEW: Final = 3
_BARE: Final = "without 5' phosphate"
_FIGURES: Final = {
    "force": "first force",
    "force_heavy": "heavy atoms",
    "force_loop": "the loop's",
    "shift_A": "shift",
    "shift_loop_on_stem_A": "loop, on the stem",
}
_COLUMNS: Final = {
    "source": ("models", "s"),
    "kind": ("kind", "s"),
    "force_field": ("force field", "s"),
    "models": ("files", "d"),
    "accepted": ("accepted as they are", "d"),
    "accepted_bare": (_BARE, "d"),
    **{name: (heading, "s") for name, heading in _FIGURES.items()},
    "sound": ("hands and chain kept", "s"),
}


def run(folder: Path, out: Path, *, full: bool = False, progress: bool = False) -> str:
    """Hand models and natives to force fields; write ``simulation.csv`` and ``simulation.json``.

    Parameters
    ----------
    folder : Path
        PDB and mmCIF files, gzipped or not.
    out : Path
        For the tables, and the PDB files in ``models``.
    full : bool
        Every file and all twenty built hairpins; else three of each, evenly spread.
    progress : bool
        Show a bar.

    Returns
    -------
    str
        A table, and who is refused and why.

    Raises
    ------
    ValueError
        If `folder` holds no structure.
    MissingDependencyError
        If OpenMM is not installed.
    """
    from loopelastica._progress import progress_bar

    modules()
    make_folder(out / "models")
    cases = _cases(folder, out / "models", full)
    rows = [row for case in progress_bar(cases, shown=progress, leave=False) for row in _rows(case)]
    write_csv(out / "simulation.csv", rows, list(dict.fromkeys(k for row in rows for k in row)))
    groups = _groups(rows)
    refused = [_refusal(row) for row in rows if row.get("refused")]
    missing = [f"{row['source']} {row['name']}: {row['failure']}" for row in rows if row["failure"]]
    write_json(out / "simulation.json", {"groups": groups, "refused": refused, "no model": missing})
    table = markdown_table([_shown(group) for group in groups], _COLUMNS)
    legend = (
        "first force: largest on any atom, kcal/mol/Å; shift: root mean square over heavy atoms by"
        " the minimization, Å; median (quartiles), most"
    )
    return "\n".join(
        [table, legend, *map(printable, ["refused:", *refused, "no model:", *missing])]
    )


def _cases(folder: Path, models: Path, full: bool) -> Iterator[Case]:
    files, built = structure_files(folder), BUILT
    if not full:
        files = _spread(files)
        built = {kind: tuple(_spread(texts)) for kind, texts in BUILT.items()}
    yield from built_cases(models, built)
    for file in files:
        yield from file_cases(models, file)


def _spread(items: Sequence[_T]) -> list[_T]:
    if len(items) <= _FEW:
        return list(items)
    return [items[round(k * (len(items) - 1) / (_FEW - 1))] for k in range(_FEW)]


def _rows(case: Case) -> Iterator[dict[str, Any]]:
    """A row per force field; a second one without 5' phosphates, where those are refused."""
    if case.path is None:
        yield case.row()
        return
    for field in FORCE_FIELDS:
        if case.kind not in field.kinds:
            continue
        row = {**case.row(), "force_field": field.name, "option": ""}
        figures = accepted(case.path, field, case.loop)
        yield row | figures
        if figures["refused"] and case.bare is not None:
            yield row | {"option": _BARE} | accepted(case.bare, field, case.loop)


def _groups(rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Medians, quartiles and extremes of each source, kind and force field."""
    simulated = [row for row in rows if row["failure"] is None]
    keys = ("source", "kind", "force_field")
    groups = sorted({tuple(row[key] for key in keys) for row in simulated})
    out = []
    for group in groups:
        own = [row for row in simulated if tuple(row[key] for key in keys) == group]
        good = [row for row in own if row["refused"] is None]
        out.append(
            {
                **dict(zip(keys, group, strict=True)),
                "models": sum(row["option"] == "" for row in own),
                "accepted": sum(row["option"] == "" for row in good),
                "accepted_bare": sum(row["option"] == _BARE for row in good),
                **{
                    name: _quartiles([row[name] for row in good if name in row])
                    for name in _FIGURES
                },
                "minimized": sum("energy_after" in row for row in good),
                "sound": sum(row.get("wrong_hands") == 0 and row["chain_kept"] for row in good),
            }
        )
    return out


def _quartiles(values: Sequence[float]) -> dict[str, float] | None:
    if not values:
        return None
    low, median, high, most = np.percentile(values, [25, 50, 75, 100]).tolist()
    return {"median": median, "quartile_1": low, "quartile_3": high, "most": most}


def _shown(group: Mapping[str, Any]) -> dict[str, Any]:
    def text(name: str) -> str | None:
        found = group[name]
        if found is None:
            return None
        form = ".2f" if name.endswith("_A") else ".0f"
        low, median, high, most = (
            format(found[key], form) for key in ("quartile_1", "median", "quartile_3", "most")
        )
        return f"{median} ({low}–{high}), {most}"

    sound = f"{group['sound']} of {group['minimized']}" if group["minimized"] else None
    return {**group, **{name: text(name) for name in _FIGURES}, "sound": sound}


def _refusal(row: Mapping[str, Any]) -> str:
    return (
        f"{row['source']} {row['name']}{row['option'] and ', ' + row['option']}, by"
        f" {row['force_field']}: {row['refused']}"
    )
