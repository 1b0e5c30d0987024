"""The shapes that the stem of a loop allows, on the screen."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from rich.table import Table

from loopelastica._names import printable
from loopelastica.report.screen.console import add_row, new_table

if TYPE_CHECKING:
    from loopelastica.folding.scan import LoopScan


def scan_screen(loop: "LoopScan", shown: int, file: str = "") -> Iterator[Table | str]:
    """The shapes of one scan.

    Parameters
    ----------
    loop : LoopScan
        The scan, with at least one candidate.
    shown : int
        Most rows of the table.
    file : str
        The file it is from, where there are several.

    Yields
    ------
    rich.table.Table or str
        In their order; sentences are strings, to be broken into lines.
    """
    names = (file, loop.hairpin.label, loop.hairpin.sequence, f"{len(loop.hairpin)} nt")
    columns = ("rank", "by\nE·L", "5' 3'\next.", "taper", "free\nnt", "E/K0\n(1/Å)", "E·L/K0")
    known = any(c.candidate.rmsd_A is not None for c in loop.candidates)
    title = "  ".join(printable(name) for name in names if name)
    table = new_table((), (*columns, *["RMSD\n(Å)"] * known, "touches"), title)
    table.columns[-1].justify = "left"
    for c in loop.candidates[:shown]:
        clamp, shape = c.ends.clamp, c.candidate
        add_row(
            table,
            f"{shape.rank}{'*' if c.is_rule else ' '}",
            str(c.rank_by_EL),
            f"{clamp.stem_extend_5} {clamp.stem_extend_3}",
            f"{clamp.taper:g}",
            str(c.ends.n_free),
            f"{shape.energy_per_A:.4f}",
            f"{shape.line.energy:.2f}",
            *["" if shape.rmsd_A is None else f"{shape.rmsd_A:.2f}"] * known,
            shape.contacts.touched,
        )
    yield table
    median, most = loop.expected_rmsd_A
    yield (
        f"{min(shown, len(loop.candidates))} of {len(loop.candidates)} shapes, spread"
        f" {loop.spread_A:.1f} Å. Expected error of the rule's clamp (*) for"
        f" {len(loop.hairpin)} nucleotides: {median} Å (median), {most} Å (90 %)."
    )
    yield ""


SCAN_LEGEND = (
    "Order: least E/K0 first, touching ones last. Energy is no confidence: the least deformed shape"
    " is not the most probable one."
)
"""What the figures of all scans mean."""
