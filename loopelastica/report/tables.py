"""Tables on the screen, by rich."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rich.console import Console
from rich.table import Table

from loopelastica._names import printable

if TYPE_CHECKING:
    from loopelastica.atoms.model import AtomModel
    from loopelastica.folding.library import Library
    from loopelastica.folding.result import LoopFold
    from loopelastica.folding.scan import LoopScan
    from loopelastica.report.atoms import LoopAtoms
    from loopelastica.rod.equilibria import Equilibria


def console() -> Console:
    """Where tables go."""
    # brackets and colons in a name are no markup
    terminal = Console(markup=False, emoji=False)
    # a file or a pipe has no width: leave the numbers whole
    if not terminal.is_terminal:
        terminal.width = 170
    return terminal


def _add_row(table: Table, *texts: str) -> None:
    table.add_row(*(printable(text) for text in texts))


def fold_table(results: "list[tuple[str, LoopFold | str, Path | None]]") -> Table:
    """Folded loops, a row per candidate."""
    from loopelastica.folding.expected import expected_text
    from loopelastica.report.records import rmsd_summary

    order = {r.options.rank for _, r, _ in results if not isinstance(r, str)}
    best = "least energy" if order == {"energy"} else "those that were measured to be nearest"
    table = Table(
        title=f"Loops folded: {best} first, rods that touch last. Expected error: median (80 %"
        " of cases) of the RMSD, which is without superposition, where the file has the loop."
        " Energy is no confidence.",
        title_justify="left",
    )
    for name in ("file", "closing pair", "sequence"):
        table.add_column(name, overflow="fold")
    table.add_column("rank", justify="right")
    table.add_column("shape", overflow="fold", min_width=16)
    table.add_column("expected (Å)", justify="right", no_wrap=True)
    for name in ("E/K0 (1/Å)", "by E", "touches", "RMSD (Å)", "models (Å)"):
        table.add_column(name, justify="right")
    table.add_column("folder", overflow="fold")
    for name, result, folder in results:
        if isinstance(result, str):
            _add_row(table, name, "not folded: see below")
            continue
        pair = result.hairpin.label
        if result.failure:
            _add_row(table, name, pair, result.hairpin.sequence, "not folded: see below")
        for c in result.candidates:
            mean, deviation, count = rmsd_summary(c)
            models = "" if mean is None or count < 2 else f"{mean:.2f} ± {deviation:.2f} ({count})"
            first = c.rank == 1
            _add_row(
                table,
                name if first else "",
                pair if first else "",
                result.hairpin.sequence if first else "",
                str(c.rank),
                c.shape,
                expected_text(c.expected_rmsd_A),
                f"{c.energy_per_A:.4f}",
                str(c.rank_energy),
                c.contacts.touched,
                "" if c.rmsd_A is None else f"{c.rmsd_A:.2f}",
                models,
                str(folder) if first else "",
            )
        table.add_section()
    return table


class LoopModels(NamedTuple):
    """What the table of atoms shows of a loop; without its structure, for many can be kept."""

    fold: "LoopFold"
    models: "tuple[AtomModel, ...]"


def atoms_table(results: "Sequence[tuple[str, LoopModels | LoopAtoms]]") -> Table:
    """Atoms that were built, a row per candidate.

    Parameters
    ----------
    results : sequence of (str, LoopModels or LoopAtoms)
        Name of the file, and what was built in it.

    Returns
    -------
    rich.table.Table
    """
    table = Table(
        title="Atoms: largest deviation of a bond and of an angle from ideal, closest contact."
        " Candidates that are not sound are not written. Nucleotides in reasons count from 1 in"
        " the loop. RMSD: backbone, without superposition, where the file has the loop.",
        title_justify="left",
    )
    for name in ("file", "closing pair"):
        table.add_column(name, overflow="fold")
    table.add_column("rank", justify="right")
    table.add_column("sound", overflow="fold", min_width=16)
    for name in ("bond (Å)", "angle (°)", "contact (Å)", "RMSD (Å)"):
        table.add_column(name, justify="right")
    for name, built in results:
        for k, model in enumerate(built.models):
            checks = model.checks
            _add_row(
                table,
                "" if k else name,
                "" if k else built.fold.hairpin.label,
                str(model.rank),
                "yes" if checks.sound else f"no: {'; '.join(checks.wrong)}",
                f"{checks.worst_bond_A:.3f}",
                f"{checks.worst_angle_deg:.1f}",
                f"{checks.closest_A:.2f}",
                "" if model.rmsd_A is None else f"{model.rmsd_A:.2f}",
            )
        table.add_section()
    return table


def fill_table(rows: "Iterable[Mapping[str, Any]]", out: Path) -> Table:
    """Strands that were filled or refused, a row each; that of several models is one.

    Parameters
    ----------
    rows : iterable of mapping
        Those of a run's table.
    out : Path
        Folder of the run.

    Returns
    -------
    rich.table.Table
    """
    from loopelastica.folding.expected import expected_text

    title = (
        f"Strands, with the error to expect (80 % of cases); structures in {printable(str(out))}"
    )
    table = Table(title=title, title_justify="left")
    for name in ("folder", "strand", "sequence", "shape"):
        table.add_column(name, overflow="fold")
    for name in ("expected (Å)", "sound"):
        table.add_column(name, justify="right")
    strands: dict[tuple[str, str, str, str], list[Mapping[str, Any]]] = {}
    for row in rows:
        key = row["folder"], row["chain"], row["first"], row["last"]
        strands.setdefault(key, []).append(row)
    shown = None
    for (folder, _, first, last), models in strands.items():
        # the figures are those of the first model that could be filled
        row = next((r for r in models if r["expected_rmsd_A"] is not None), models[0])
        name = first if first == last else f"{first}-{last}"
        expected = "refused"
        if row["expected_rmsd_A"] is not None:
            quantiles = ("expected_10_A", "expected_rmsd_A", "expected_90_A")
            expected = expected_text([row[name] for name in quantiles])
        sound = {True: "yes", False: "no", None: ""}[row["sound"]]
        if len(models) > 1:
            sound = f"{sum(r['sound'] is True for r in models)} of {len(models)} models"
        _add_row(
            table,
            "" if folder == shown else folder,
            f"{row['chain']}.{name}" if row["chain"] else name,
            row["sequence"],
            row["shape"] or "",
            expected,
            sound,
        )
        shown = folder
    return table


def scan_table(loop: "LoopScan", shown: int) -> Table:
    """The shapes of one scan.

    Parameters
    ----------
    loop : LoopScan
        The scan, with at least one candidate.
    shown : int
        Most rows of the table.

    Returns
    -------
    rich.table.Table
    """
    median, most = loop.expected_rmsd_A
    table = Table(
        title=printable(f"{loop.hairpin.label} {loop.hairpin.sequence}, by E/K0, touching last"),
        caption=f"{min(shown, len(loop.candidates))} of {len(loop.candidates)} shapes, spread"
        f" {loop.spread_A:.1f} Å. Energy is no confidence: the least deformed shape is not the most"
        f" probable one. Error to expect of the rule (*) for {len(loop.hairpin)} nucleotides:"
        f" {median} Å (median), {most} Å (90 %).",
        title_justify="left",
        caption_justify="left",
    )
    for name in ("rank", "by E·L", "5' 3' ext.", "taper", "free", "E/K0 (1/Å)", "E·L/K0"):
        table.add_column(name, justify="right")
    table.add_column("touches")
    table.add_column("RMSD (Å)", justify="right")
    for c in loop.candidates[:shown]:
        clamp, shape = c.ends.clamp, c.candidate
        _add_row(
            table,
            f"{shape.rank}{'*' if c.is_rule else ' '}",
            str(c.rank_by_EL),
            f"{clamp.stem_extend_5} {clamp.stem_extend_3}",
            f"{clamp.taper:g}",
            str(c.ends.n_free),
            f"{shape.energy_per_A:.4f}",
            f"{shape.line.energy:.2f}",
            shape.contacts.touched,
            "" if shape.rmsd_A is None else f"{shape.rmsd_A:.2f}",
        )
    return table


def hairpins_table(found: "list[dict[str, Any]]") -> Table:
    """Hairpins as `listing` describes them."""
    table = Table()
    for name in ("chain", "closing pair", "sequence", "loop", "kind", "stem pairs"):
        table.add_column(name, overflow="fold")
    table.add_column("stem fit (Å)", justify="right")
    for name in ("contacts", "kisses"):
        table.add_column(name, overflow="fold")
    for hairpin in found:
        rms_A, absent = hairpin["stem_rms_A"], hairpin["absent"]
        fit = "none" if rms_A is None else f"{rms_A:.2f}"
        _add_row(
            table,
            hairpin["chain"] or "_",
            "–".join(hairpin["closing_pair"]),
            hairpin["sequence"],
            f"{hairpin['nucleotides']} nt" + (f", {absent} absent" if absent else ""),
            hairpin["kind"],
            str(hairpin["stem_pairs"]),
            fit if hairpin["regular"] else f"{fit}, irregular",
            ", ".join("–".join(pair) for pair in hairpin["contacts"]),
            ", ".join(hairpin["kissing"]),
        )
    return table


def library_table(library: "Library") -> Table:
    """What a library holds, a row per kind and length."""
    import numpy as np

    shown = "1 loop shape" if len(library) == 1 else f"{len(library)} loop shapes"
    table = Table(title=shown, title_justify="left")
    for name in ("kind", "nucleotides", "loops", "sequences", "entries", "most frequent"):
        table.add_column(name, justify="left" if name in ("kind", "most frequent") else "right")
    for kind, shapes in library.tables():
        first = int(np.argmax(shapes.copies))
        _add_row(
            table,
            "DNA" if kind.is_dna else "RNA",
            str(kind.nucleotides),
            str(len(shapes)),
            # each sequence is counted once over its copies
            str(round((1.0 / shapes.copies).sum())),
            str(len(np.unique(shapes.entries))),
            f"{shapes.sequence(first)[1:-1]} ({shapes.copies[first]})",
        )
    return table


def equilibria_table(rods: "Equilibria") -> Table:
    """Equilibria of a dimensionless rod."""
    table = Table()
    for name in ("energy", "index", "F (start frame)", "M (start frame)", "twist", "residual"):
        table.add_column(name, justify="right", no_wrap=True)
    for rod in rods:
        _add_row(
            table,
            f"{rod.energy:.6g}",
            str(rod.index),
            " ".join(f"{v:9.4g}" for v in rod.loads[:3]),
            " ".join(f"{v:9.4g}" for v in rod.loads[3:]),
            f"{rod.twist:.4f}",
            f"{rod.residual:.0e}",
        )
    return table
