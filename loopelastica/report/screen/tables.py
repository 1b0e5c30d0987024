"""Tables of hairpins, of a library and of a rod's equilibria."""

import sys
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rich.table import Table

from loopelastica._names import printable
from loopelastica.report.screen.console import add_row, new_table, width

if TYPE_CHECKING:
    from loopelastica.rod.equilibria import Equilibria


def hairpins_table(found: Sequence[dict[str, Any]]) -> Table:
    """Hairpins as `listing` describes them.

    Parameters
    ----------
    found : sequence of dict
        Entries of its ``hairpins``.

    Returns
    -------
    rich.table.Table
    """
    left = ["closing pair", "sequence", "loop", "stem"]
    paired = any(hairpin["contacts"] or hairpin["kissing"] for hairpin in found)
    table = new_table([*left, *["pairs with"] * paired], ["stem fit\n(Å)"])
    for column in table.columns[:2]:
        column.no_wrap, column.overflow = False, "fold"
    for hairpin in found:
        rms_A, absent = hairpin["stem_rms_A"], hairpin["absent"]
        fit = "none" if rms_A is None else f"{rms_A:.2f}"
        pairs = [printable("–".join(pair)) for pair in hairpin["contacts"]]
        pairs += [f"kisses {printable(name)}" for name in hairpin["kissing"]]
        count = hairpin["stem_pairs"]
        add_row(
            table,
            printable("–".join(hairpin["closing_pair"])),
            hairpin["sequence"],
            f"{hairpin['nucleotides']} nt {hairpin['kind']}"
            + (f", {absent} absent" if absent else ""),
            f"{count} pair{'s' * (count != 1)}",
            *[", ".join(pairs)] * paired,
            fit if hairpin["regular"] else f"{fit}, irregular",
        )
    return table


def chain_lines(chain: Mapping[str, str]) -> list[str]:
    """Name, sequence and dot-bracket of a chain.

    On a terminal a longer chain comes in blocks, brackets below letters; in a pipe each is one
    line, for other programs.

    Parameters
    ----------
    chain : mapping
        An entry of ``chains`` of `listing`.

    Returns
    -------
    list of str
    """
    head = f">{chain['chain'] or '_'} {chain['first']}-{chain['last']}"
    texts = chain["sequence"], chain["dot_bracket"]
    columns = width()
    if len(texts[0]) <= columns or not sys.stdout.isatty():
        return [head, *texts]
    step = columns - columns % 10
    blocks = range(0, len(texts[0]), step)
    return [head, *(text[at : at + step] for at in blocks for text in texts)]


def library_table(rows: Sequence[dict[str, Any]]) -> Table:
    """What a library holds, a row per kind and length.

    Parameters
    ----------
    rows : sequence of dict
        As :func:`loopelastica.report.documents.library_rows` makes them.

    Returns
    -------
    rich.table.Table
    """
    total = sum(row["loops"] for row in rows)
    title = "1 loop shape" if total == 1 else f"{total} loop shapes"
    table = new_table(
        ["kind"], ["nucleotides", "loops", "sequences", "entries", "most frequent"], title
    )
    for row in rows:
        names = ("kind", "nucleotides", "loops", "sequences", "entries")
        frequent = f"{row['most_frequent']} ({row['copies']})"
        add_row(table, *(str(row[name]) for name in names), frequent)
    return table


def equilibria_table(rods: "Equilibria") -> Table:
    """Equilibria of a dimensionless rod.

    Parameters
    ----------
    rods : Equilibria

    Returns
    -------
    rich.table.Table
    """
    names = ["energy", "index", "F\n(start frame)", "M\n(start frame)", "twist", "residual"]
    table = new_table([], names)
    loads = [[f"{v:.3g}" for v in rod.loads] for rod in rods]
    widths = [max(map(len, texts)) for texts in zip(*loads, strict=True)]
    for rod, texts in zip(rods, loads, strict=True):
        aligned = [text.rjust(wide) for text, wide in zip(texts, widths, strict=True)]
        add_row(
            table,
            f"{rod.energy:.6g}",
            str(rod.index),
            " ".join(aligned[:3]),
            " ".join(aligned[3:]),
            f"{rod.twist:.4f}",
            f"{rod.residual:.0e}",
        )
    return table
