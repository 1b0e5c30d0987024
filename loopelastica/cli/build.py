"""``loopelastica build``: a hairpin from its sequence; and atoms with a progress bar."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from loopelastica.cli import options as o

if TYPE_CHECKING:
    from loopelastica._arrays import Array
    from loopelastica.folding.result import LoopFold
    from loopelastica.molecule.nucleotides import Structure
    from loopelastica.report.atoms import LoopAtoms


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


def atoms_of(
    structure: "Structure", loop: "LoopFold", positions: "Array", contact: str | None
) -> "LoopAtoms":
    """Atoms of all candidates, with a progress bar.

    Parameters
    ----------
    structure : Structure
        What was folded.
    loop : LoopFold
        One of its loops.
    positions : (n_atoms, 3) array
        Of all atoms, Å.
    contact : str or None
        As for :func:`build_atoms`.

    Returns
    -------
    LoopAtoms
    """
    from tqdm import tqdm

    from loopelastica.atoms.model import build_atoms
    from loopelastica.report.atoms import LoopAtoms

    with tqdm(total=len(loop.candidates), unit="model", leave=False) as bar:
        models = build_atoms(
            structure,
            loop,
            positions=positions,
            contact=contact,
            progress=lambda done, total: bar.update(),
        )
    return LoopAtoms(structure, loop, tuple(models), positions, contact)
