"""Folded and built loops on the screen, from the rows of a run's table."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import groupby, islice
from typing import Any, Final

from rich.cells import cell_len
from rich.table import Table
from rich.text import Text

from loopelastica._names import printable
from loopelastica.folding.expected import expected_text
from loopelastica.molecule.contacts import SELF_CONTACT_A, STEM_CONTACT_A
from loopelastica.report.screen.console import add_row, new_table, width

Row = Mapping[str, Any]

IN_FULL: Final = 3
"""Loops of a run up to which all candidates of each are shown."""
SHOWN: Final = 30
"""Loops that are shown of a longer run, with the first candidate of each."""

_EXPECTED: Final = "expected\nerror (Å)"
_ENERGY: Final = "E/K0\n(1/Å)"
_QUANTILES: Final = ("expected_10_A", "expected_rmsd_A", "expected_90_A")


def fold_screen(
    rows: Iterable[Row], place: str, order: str = "default"
) -> Iterator[Table | Text | str]:
    """What was folded, how, how good it may be, and where it is.

    Up to three loops are shown with all their candidates, of more the first candidate of each, of
    many the first thirty.

    Parameters
    ----------
    rows : iterable of mapping
        Those of summary.csv, with their ``folder``; taken one by one.
    place : str
        Folder of the run.
    order : {"default", "energy"}
        In which order candidates are.

    Yields
    ------
    rich.table.Table, rich.text.Text or str
        In their order; sentences are strings, to be broken into lines.
    """
    loops = (list(own) for _, own in groupby(rows, key=lambda row: row["folder"]))
    first = list(islice(loops, SHOWN))
    more = sum(1 for _ in loops)
    if not first:
        return
    if len(first) <= IN_FULL:
        for candidates in first:
            yield from _in_full(candidates, place)
    else:
        yield _in_short(first)
        if more:
            yield f"and {more} more loops: {printable(place)}/summary.csv has all of them"
        yield ""
    yield legend(first, order)


def legend(loops: Sequence[Sequence[Row]], order: str) -> str:
    """What the figures mean, in plain words.

    Parameters
    ----------
    loops : sequence of sequence of mapping
        What is shown.
    order : {"default", "energy"}
        As for :func:`fold_screen`.

    Returns
    -------
    str
    """
    rows = [row for loop in loops for row in loop]
    first = "least energy first" if order == "energy" else "measured to be nearest first"
    said = [
        f"Order: {first}, touching ones last. Expected error: half of such answers are nearer"
        " than the first figure, 80 % lie in the interval. E/K0 is the energy of deformation,"
        " and no confidence."
    ]
    if any(row["rmsd_A"] is not None for row in rows):
        said.append(
            "RMSD: to the file's own loop, backbone centroids, without superposition; expected"
            " errors are of the same kind."
        )
    if any(row.get("atoms_sound") is False for row in rows):
        said.append("Atoms that are not sound are not written.")
    return " ".join(said)


def _in_full(rows: Sequence[Row], place: str) -> Iterator[Table | Text | str]:
    """A head line, and a table of all candidates of one loop."""
    first = rows[0]
    models = max(row["n_models"] for row in rows)
    about = f"{first['nucleotides']} nt {first['kind']}" + (f", {models} models" * (models > 1))
    names = (first["file"], first["closing_pair"], first["sequence"], about)
    head = Text("  ".join(printable(str(name)) for name in names), style="bold")
    folder = f"in {printable(place)}/{printable(first['folder'])}"
    if cell_len(folder) > width():
        folder = f"in {printable(first['folder'])}"
    yield head.append(f"\n{folder}", style="not bold")
    known = any(row["rmsd_A"] is not None for row in rows)
    built = any(row.get("atoms_sound") is not None for row in rows)
    # with atoms there is no room for what other models say
    many = known and models > 1 and not built
    right = [_EXPECTED, _ENERGY]
    right += ["RMSD\n(Å)"] * known + [f"{models} models\n(Å)"] * many
    right += ["atoms\n"] * built + ["RMSD of\natoms"] * (built and known)
    table = new_table(["", "shape"], right)
    table.columns[0].justify, table.columns[0].no_wrap = "right", True
    for row in rows:
        cells = [str(row["rank"]), _shape(row), _expected(row), f"{row['energy_per_A']:.4f}"]
        cells += [_number(row["rmsd_A"])] * known
        cells += [_of_models(row, models)] * many
        cells += [_sound(row)] * built + [_number(row.get("atoms_rmsd_A"))] * (built and known)
        add_row(table, *cells)
    yield table
    yield from _of_atoms(rows)
    yield ""


def _in_short(loops: Sequence[Sequence[Row]]) -> Table:
    """A table with the first candidate of each loop."""
    rows = [loop[0] for loop in loops]
    known = any(row["rmsd_A"] is not None for row in rows)
    built = any(row.get("atoms_sound") is not None for row in rows)
    right = [_EXPECTED, _ENERGY] + ["RMSD\n(Å)"] * known + ["atoms\n"] * built
    table = new_table(["loop, its first candidate\nand its folder"], right)
    for row in rows:
        about = (str(row[name]) for name in ("file", "closing_pair", "sequence"))
        name = printable("  ".join(about))
        cells = [f"{name}\n  {_shape(row)}, in {printable(row['folder'])}", _expected(row)]
        cells += [f"{row['energy_per_A']:.4f}"] + [_number(row["rmsd_A"])] * known
        add_row(table, *cells, *[_sound(row)] * built)
    return table


def _shape(row: Row) -> str:
    touched = [
        name
        for name, distance_A, near_A in (
            ("stem", row["stem_contact_A"], STEM_CONTACT_A),
            ("itself", row["self_contact_A"], SELF_CONTACT_A),
        )
        if distance_A is not None and distance_A < near_A
    ]
    return printable(row["shape"]) + (f", touches {' and '.join(touched)}" if touched else "")


def _expected(row: Row) -> str:
    return expected_text([row[name] for name in _QUANTILES])


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.2f}"


def _of_models(row: Row, models: int) -> str:
    """Mean and deviation over the models, and their number where it is not that of all."""
    mean, deviation, count = (
        row[name] for name in ("rmsd_models_mean_A", "rmsd_models_sd_A", "n_models")
    )
    if mean is None or deviation is None:
        return ""
    return f"{mean:.2f} ± {deviation:.2f}" + ("" if count == models else f" ({count})")


def _sound(row: Row) -> str:
    return {True: "sound", False: "not sound"}.get(row.get("atoms_sound"), "")  # type: ignore[arg-type]


def _of_atoms(rows: Sequence[Row]) -> Iterator[str]:
    """How sound the atoms of one loop are, and why some are not."""
    built = [row for row in rows if row.get("atoms_sound") is not None]
    sound = [row for row in built if row["atoms_sound"]]
    for row in built:
        if not row["atoms_sound"]:
            why = printable(row.get("atoms_not_sound_because") or "see atoms.json")
            yield f"Atoms of {row['rank']} are not sound: {why}"
    if sound:
        bond_A, angle_deg = (
            max(row[name] for row in sound)
            for name in ("atoms_worst_bond_A", "atoms_worst_angle_deg")
        )
        closest_A = min(row["atoms_closest_A"] for row in sound)
        yield (
            f"Atoms of {len(sound)} of {len(built)} are sound: no bond is off by more than"
            f" {bond_A:.3f} Å, no angle by more than {angle_deg:.1f}°; closest contact"
            f" {closest_A:.2f} Å"
        )
