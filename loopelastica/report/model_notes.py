"""What the files of a loop's models say of themselves: titles, remarks, figures of each model."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from loopelastica._files import PROGRAM, sha256
from loopelastica._names import printable
from loopelastica._version import __version__
from loopelastica.atoms.checks import HYDROGEN_BOND_A
from loopelastica.atoms.model import AtomModel
from loopelastica.report.pdb import pdb_name

if TYPE_CHECKING:
    from loopelastica.folding.rank import Candidate
    from loopelastica.report.atoms import LoopAtoms

Source = Path | str | None
"""The file, or the sequence, that a structure is from; None for a Universe."""


_SIGNS: Final = {"Å": "A", "°": " DEG", "–": "-", "′": "'", "×": "x", "…": "..."}
# what a REMARK record holds after its number
_NOTE: Final = 68


def title(atoms: LoopAtoms, source: Source) -> str:
    """What the files show, visible ASCII.

    Parameters
    ----------
    atoms : LoopAtoms
    source : Path, str or None

    Returns
    -------
    str
    """
    hairpin = atoms.fold.hairpin
    what = f"{hairpin.kind} LOOP {_span(atoms)} ({_loop(atoms)}) OF {_input(atoms, source)}"
    return _plain(f"{what}, BY {PROGRAM} {__version__}")


def notes(atoms: LoopAtoms, models: Sequence[AtomModel], source: Source) -> list[str]:
    """Remarks on the whole and on each model, lines of visible ASCII that fit a record.

    Parameters
    ----------
    atoms : LoopAtoms
    models : sequence of AtomModel
        In the order of the file.
    source : Path, str or None

    Returns
    -------
    list of str
    """
    out = []
    for line in (*_on_all(atoms, source), *_on_models(atoms, models)):
        indent = "  " if line.startswith(" ") else ""
        out += textwrap.wrap(
            _plain(line), _NOTE, initial_indent=indent, subsequent_indent=f"{indent}  "
        )
    return out


def _on_all(atoms: LoopAtoms, source: Source) -> Iterator[str]:
    hairpin = atoms.fold.hairpin
    yield f"{PROGRAM} {__version__} BUILT THE ATOMS OF A LOOP"
    digest = _digest(source) if isinstance(source, Path) else ""
    yield f"INPUT: {_input(atoms, source)}{', SHA-256:' if digest else ''}"
    if digest:
        yield f" {digest}"
    yield f"MODELLED: {_span(atoms)}, SEQUENCE {_loop(atoms)}, IN THE PAIR {hairpin.label}"
    yield (
        f"ALL OTHER ATOMS: AN IDEAL STEM OF {'B-DNA' if hairpin.is_dna else 'A-RNA'}"
        if isinstance(source, str)
        else "ALL OTHER ATOMS ARE THOSE OF THE INPUT, FIRST MODEL"
    )
    yield "B FACTOR OF THE LOOP: 8 PI^2/3 OF THE EXPECTED ERROR SQUARED"
    yield "HYDROGENS: " + (
        "NONE"
        if not atoms.hydrogens
        else "ALL"
        if isinstance(source, str)
        else "ALL THE INPUT HAS, AND THOSE OF NUCLEOTIDES WITHOUT"
    )
    if atoms.names != "pdb":
        yield f"NAMES OF NUCLEOTIDES AND THEIR ATOMS: {atoms.names.upper()}"
    yield from (f"NOTE: {sentence}" for sentence in atoms.remarks)


def _on_models(atoms: LoopAtoms, models: Sequence[AtomModel]) -> Iterator[str]:
    for number, model in enumerate(models, start=1):
        candidate, checks = candidate_of(atoms, model), model.checks
        low, middle, high = candidate.expected_rmsd_A
        yield f"MODEL {number}: CANDIDATE {model.rank}: {candidate.shape}"
        yield f" ENERGY {candidate.energy_per_A:.4f} 1/A (E/K0), {candidate.energy_kT:.3f} KT"
        yield f" EXPECTED ERROR {middle:.1f} A (80 % BETWEEN {low:.1f} AND {high:.1f})"
        yield (
            f" {'SOUND' if checks.sound else 'NOT SOUND'}: {checks.status}, WORST BOND OFF BY"
            f" {checks.worst_bond_A:.3f} A, WORST ANGLE BY {checks.worst_angle_deg:.1f} DEG,"
            f" CLOSEST CONTACT {checks.closest_A:.2f} A"
        )
        if model.rmsd_A is not None:
            yield f" BACKBONE RMSD TO THE LOOP OF THE INPUT {model.rmsd_A:.2f} A"
    for model in atoms.models:
        if not model.checks.sound:
            yield f"CANDIDATE {model.rank} IS NOT SOUND AND LEFT OUT: {because(model)}"


def sentences(atoms: LoopAtoms) -> Iterator[str]:
    """What a user should be aware of: unsound candidates, names that change, contacts not reached.

    Parameters
    ----------
    atoms : LoopAtoms
    """
    if not atoms.written:
        yield "no candidate has sound atoms; atoms.json says why, and no structure is written"
    for model in atoms.models:
        if model.checks.contact_reached is False:
            yield (
                f"candidate {model.rank} did not reach the {atoms.contact} pair: its hydrogen bonds"
                f" are up to {model.checks.contact_A:.1f} Å long, not {HYDROGEN_BOND_A} Å"
            )
    if not atoms.models:
        return
    table, residues = atoms.structure.nucleotides, atoms.models[0].molecule.residues
    for row, built in zip(atoms.fold.hairpin.loop, residues, strict=True):
        if built.renamed:
            yield f"{table.label(int(row))} cannot be built and is written as {built.standard}"
    if atoms.contact is not None and atoms.models[0].checks.contact_A is None:
        first, *_, last = residues
        yield (
            f"{first.letter} and {last.letter} at the ends of the loop make no {atoms.contact}"
            " pair; none was sought"
        )


def because(model: AtomModel) -> str:
    """Why a model is not sound; "" for a sound one."""
    return "; ".join(model.checks.wrong)


def candidate_of(atoms: LoopAtoms, model: AtomModel) -> Candidate:
    """The candidate that a model was built on."""
    return next(c for c in atoms.fold.candidates if c.rank == model.rank)


MODEL_COLUMNS: Final = (
    *("model_num", "rank", "shape", "energy_per_A", "energy_kT", "sound", "status"),
    *("worst_bond_A", "worst_angle_deg", "closest_contact_A"),
    *("expected_10_A", "expected_rmsd_A", "expected_90_A", "rmsd_A"),
)
"""Columns of the category _loopelastica_model."""


def model_values(atoms: LoopAtoms, model: AtomModel, number: int) -> list[str | None]:
    """A row of the category _loopelastica_model; None where nothing is known.

    Parameters
    ----------
    atoms : LoopAtoms
    model : AtomModel
    number : int
        Of the model in the file.

    Returns
    -------
    list of str or None
    """
    candidate, checks = candidate_of(atoms, model), model.checks
    figures: list[float | None] = [
        *(checks.worst_bond_A, checks.worst_angle_deg, checks.closest_A),
        *(float(value) for value in candidate.expected_rmsd_A),
        model.rmsd_A,
    ]
    return [
        *(str(number), str(model.rank), _plain(candidate.shape)),
        *(f"{candidate.energy_per_A:.6g}", f"{candidate.energy_kT:.6g}"),
        *("yes" if checks.sound else "no", checks.status),
        *(None if value is None else f"{value:.4g}" for value in figures),
    ]


def _input(atoms: LoopAtoms, source: Source) -> str:
    if source is None:
        return atoms.structure.name
    return source.name if isinstance(source, Path) else f"SEQUENCE {source}"


def _span(atoms: LoopAtoms) -> str:
    residues = atoms.fold.hairpin.residues
    return residues[0] if len(residues) == 1 else f"{residues[0]} TO {residues[-1]}"


def _loop(atoms: LoopAtoms) -> str:
    return atoms.fold.hairpin.sequence[1:-1]


def _digest(path: Path) -> str:
    try:
        return sha256(path)
    # a file may be gone since it was read
    except OSError:
        return ""


def _plain(text: str) -> str:
    """Visible ASCII and blanks."""
    for sign, plain in _SIGNS.items():
        text = text.replace(sign, plain)
    return " ".join(pdb_name(word) for word in printable(text).split())
