"""``loopelastica build``: a hairpin from its sequence."""

from pathlib import Path
from typing import Annotated

import typer

from loopelastica.cli import options as o


def build(
    sequence: Annotated[
        str, typer.Argument(help='Stem and loop, such as "GGCAC(UUCG)GUGCC".', show_default=False)
    ],
    is_dna: Annotated[
        bool, typer.Option("--dna/--rna", help="B-DNA or A-RNA stem.", show_default=False)
    ],
    out: o.Out = o.OUT,
    candidates: o.Candidates = 10,
    plot: o.Plot = True,
    contact: o.Contact = None,
) -> None:
    """Build a hairpin from its sequence alone: ideal stem, folded loop, atoms."""
    from loopelastica._files import make_folder
    from loopelastica.atoms.sequence import fold_sequence
    from loopelastica.atoms.turn import check_contact
    from loopelastica.cli.atoms import atoms_of
    from loopelastica.report.folder import Folders, write_fold
    from loopelastica.report.tables import console, fold_table

    with o.usage():
        check_contact(contact)
        structure, loop, positions = fold_sequence(sequence, is_dna, max_candidates=candidates)
    if loop.failure is not None:
        o.fail([loop.failure])
    make_folder(out)
    built = atoms_of(structure, loop, positions, contact)
    name = "".join(letter for letter in sequence.upper() if letter.isalpha())
    folder = Folders(out).claim(Path(name), loop)
    write_fold(folder, sequence, loop, structure, plot, atoms=built)
    console().print(fold_table([(name, loop, folder)]))
