"""Atoms on the lines of a folded loop, with a progress bar, and what is said of them."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from loopelastica._arrays import Array
    from loopelastica.folding.result import LoopFold
    from loopelastica.molecule.nucleotides import Structure
    from loopelastica.report.atoms import LoopAtoms


def atoms_of(
    structure: "Structure",
    loop: "LoopFold",
    positions: "Array | None" = None,
    *,
    contact: str | None = None,
    progress: bool = True,
    **written: Any,
) -> "LoopAtoms":
    """Atoms of all candidates, with a progress bar.

    Parameters
    ----------
    structure : Structure
        What was folded.
    loop : LoopFold
        One of its loops.
    positions : (n_atoms, 3) array, optional
        Of all atoms, Å; default those of the first model.
    contact : str or None
        As for :func:`build_atoms`.
    progress : bool
        Whether there is a bar, on a terminal.
    **written
        What is written of them: fields of ``LoopAtoms``, such as ``hydrogens``.

    Returns
    -------
    LoopAtoms
    """
    from loopelastica._progress import progress_bar
    from loopelastica.atoms.model import build_atoms
    from loopelastica.report.atoms import LoopAtoms

    if positions is None:
        positions = structure.positions(0)
    total = len(loop.candidates)
    with progress_bar(total=total, shown=progress, unit="model", leave=False) as bar:
        models = build_atoms(
            structure,
            loop,
            positions=positions,
            contact=contact,
            progress=lambda done, total: bar.update(),
        )
    return LoopAtoms(structure, loop, tuple(models), positions, contact, **written)
