"""What becomes of a structure's gaps: models, or the reasons why there are none."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from loopelastica._arrays import Array, Record
from loopelastica._checks import whole
from loopelastica._html import html_table
from loopelastica.folding.line import StrandLine
from loopelastica.folding.shape_line import ShapeLine
from loopelastica.molecule.nucleotides import enumerated

if TYPE_CHECKING:
    from loopelastica.atoms.strand import BuiltResidue, StrandModel
    from loopelastica.filling.options import FillOptions
    from loopelastica.molecule.entry import Entry
    from loopelastica.molecule.faults import Fault
    from loopelastica.molecule.polymer import HeavyAtoms, Monomer
    from loopelastica.report.compose import Removed

Status = Literal["filled", "refused"]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class FilledCandidate(Record):
    """One model of a strand.

    Attributes
    ----------
    rank : int
        1 for the one that is expected to be nearest.
    line : StrandLine or ShapeLine
        The line it was built on: energy, contacts, nearest atom.
    atoms : StrandModel
        Its atoms and what was measured on them.
    expected_rmsd_A : (3,) array
        10, 50 and 90 % of the error to expect of its backbone centroids.
    waters : tuple of Removed
        Waters that are nearer than 2.5 Å and give way.
    """

    rank: int
    line: StrandLine | ShapeLine
    atoms: StrandModel
    expected_rmsd_A: Array
    waters: tuple[Removed, ...] = ()

    @property
    def sound(self) -> bool:
        """Whether its chemistry is right: see :class:`loopelastica.atoms.checks.Checks`."""
        return self.atoms.checks.sound

    @property
    def shape(self) -> str:
        """What its line is, such as "like 1zih A.4-A.9"."""
        return self.line.shape

    @property
    def trace(self) -> Array:
        """Line point (n, 3) of each nucleotide in the coordinates of the file, Å."""
        return self.line.trace

    def __repr__(self) -> str:
        sound = "sound" if self.sound else "not sound"
        return f"<FilledCandidate {self.rank}: {self.shape}, {sound}>"


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class FilledStrand(Record):
    """One gap of one model, and what became of it.

    Attributes
    ----------
    chain : str
        The author's name of the chain.
    first, last : str
        The author's numbers of the first and the last nucleotide, with insertion codes.
    sequence : str
        Parent bases, 5' to 3'; "" where it is unknown.
    status : {"filled", "refused"}
    reason : str or None
        Why it was refused, in one sentence.
    candidates : tuple of FilledCandidate
        Best first.
    model : int
        Model of the file, from 1.
    kind : str
        "RNA", "DNA", "DNA/RNA"; "" where it was refused.
    distance_A, length_A : float or None
        Of the ends of the line, and of the line.
    crowding : float or None
        Atoms within 10 Å of the chord, per nucleotide.
    remarks : tuple of str
        One sentence for each thing that a user should be aware of.
    nucleotides : int
        How many are missing.
    mate_A : float or None
        How near what was built comes to a mate in the crystal, where that is under 3 Å.

    Examples
    --------
    >>> import MDAnalysis as mda
    >>> import loopelastica as le
    >>> from loopelastica._files import data_path
    >>> from loopelastica.molecule.reading import quiet
    >>> with quiet():
    ...     universe = mda.Universe(data_path("hairpins/2koc.pdb"))
    ...     filling = le.fill(universe, strands="A.7")
    >>> (strand,) = filling.strands
    >>> strand.name, strand.sequence, strand.status, strand.sound, strand.candidates[0].trace.shape
    ('A.7', 'U', 'filled', True, (1, 3))
    """

    chain: str
    first: str
    last: str
    sequence: str
    status: Status
    reason: str | None = None
    candidates: tuple[FilledCandidate, ...] = ()
    model: int = 1
    kind: str = ""
    distance_A: float | None = None
    length_A: float | None = None
    crowding: float | None = None
    remarks: tuple[str, ...] = ()
    nucleotides: int = 0
    mate_A: float | None = None

    @property
    def name(self) -> str:
        """Name such as "A.6-9"."""
        numbers = self.first if self.first == self.last else f"{self.first}-{self.last}"
        return f"{self.chain}.{numbers}" if self.chain else numbers

    @property
    def sound(self) -> bool | None:
        """Whether the first candidate is sound; None where there is none."""
        return self.candidates[0].sound if self.candidates else None

    @property
    def shape(self) -> str | None:
        """Of the first candidate; None where there is none."""
        return self.candidates[0].shape if self.candidates else None

    @property
    def expected_rmsd_A(self) -> Array | None:
        """Of the first candidate; None where there is none."""
        return self.candidates[0].expected_rmsd_A if self.candidates else None

    @property
    def outcome(self) -> str:
        """What became of it, in a few words."""
        if self.expected_rmsd_A is None:
            return f"refused, {self.reason}"
        sound = "sound" if self.sound else "not sound"
        return f"{sound}, {self.expected_rmsd_A[1]:.1f} Å to expect"

    def __repr__(self) -> str:
        return f"<FilledStrand {self.name} {self.sequence}: {self.outcome}>"


@dataclass(frozen=True, slots=True, eq=False)
class Completion(Record):
    """A nucleotide beside no gap that got its missing atoms, in one model (from 1)."""

    model: int
    atoms: StrandModel
    waters: tuple[Removed, ...] = ()


def waters_of(model: StrandModel, atoms: HeavyAtoms, index: int) -> tuple[Removed, ...]:
    """The waters that give way to a model.

    Parameters
    ----------
    model : StrandModel
        What was built.
    atoms : HeavyAtoms
        Those it was built among.
    index : int
        Model of the file, from 0.

    Returns
    -------
    tuple of Removed
    """
    from loopelastica.report.changes import Removed

    out = []
    for row in model.waters:
        chain, number, icode, name = atoms.places[atoms.residue[row]]
        x, y, z = (float(value) for value in atoms.positions_A[row])
        out.append(Removed(index, chain, number, icode, name, at_A=(x, y, z)))
    return tuple(out)


@dataclass(frozen=True, slots=True, eq=False)
class Repair(Record):
    """A stretch of one model that was there, was broken, and was built anew.

    Attributes
    ----------
    model : int
        Model of the file, from 1.
    faults : tuple of Fault
        What was wrong, such as "A.G12–A.C13: O3'–P 3.4 Å".
    atoms : StrandModel
        The stretch as it is now; a base that was right stays where it was.
    original : tuple of Monomer
        Its nucleotides as they were.
    waters : tuple of Removed
        Waters that are nearer than 2.5 Å and give way.
    hydrogens : tuple of Removed
        Hydrogens on atoms that have moved.
    """

    model: int
    faults: tuple[Fault, ...]
    atoms: StrandModel
    original: tuple[Monomer, ...]
    waters: tuple[Removed, ...] = ()
    hydrogens: tuple[Removed, ...] = ()

    @property
    def residues(self) -> Iterator[BuiltResidue]:
        """Every nucleotide's atoms that are new or in another place."""
        carried = {
            one.label: {x: at for x, at in one.atoms_A.items() if at is not was.atoms_A[x]}
            for one, was in zip(self.atoms.gap.monomers, self.original, strict=True)
        }
        for residue in self.atoms.residues:
            more = carried.get(residue.monomer.label)
            if not more:
                yield residue
                continue
            yield replace(
                residue,
                names=(*residue.names, *more),
                elements=(*residue.elements, *(name[0] for name in more)),
                positions_A=np.concatenate([residue.positions_A, list(more.values())]),
            )

    @property
    def now(self) -> Iterator[Monomer]:
        """Every nucleotide that has changed, with its atoms as they are now."""
        before = {one.label: one for one in self.original}
        for residue in self.residues:
            one = before.get(residue.monomer.label, residue.monomer)
            new = dict(zip(residue.names, residue.positions_A, strict=True))
            yield replace(one, atoms_A={**one.atoms_A, **new})

    @property
    def labels(self) -> tuple[str, ...]:
        """The nucleotides that were built anew."""
        return tuple(monomer.label for monomer in self.original)

    def __str__(self) -> str:
        """Return it as a sentence."""
        return f"{', '.join(map(str, self.faults))}; rebuilt {', '.join(self.labels)}"


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Filling(Record):
    """A structure with its gaps filled.

    Attributes
    ----------
    name : str
        File name, or "universe".
    strands : tuple of FilledStrand
        In the order of the file; of several models one after the other.
    options : FillOptions
        Every option that was in force.
    completed : tuple of str
        Nucleotides that were there in part and got their missing atoms.
    repaired : tuple of str
        One sentence for each stretch that was built anew, with what was wrong.
    remarks : tuple of str
        One sentence for each thing that a user should be aware of; missing ends among them.
    entry : Entry
        What was read.
    completions : tuple of Completion
        The models of what was completed.
    repairs : tuple of Repair
        The models of what was repaired.
    unrepaired : tuple of str
        One sentence for each thing that is broken and could not be mended.
    sha256 : str or None
        Digest of the input file when it was read; None where there was none.

    Examples
    --------
    >>> import MDAnalysis as mda
    >>> import loopelastica as le
    >>> from loopelastica._files import data_path
    >>> universe = mda.Universe(data_path("hairpins/2koc.pdb"), to_guess=())
    >>> filling = le.fill(universe, strands="A.7")
    >>> [strand.name for strand in filling.filled]
    ['A.7']
    """

    name: str
    strands: tuple[FilledStrand, ...]
    options: FillOptions
    completed: tuple[str, ...]
    repaired: tuple[str, ...]
    remarks: tuple[str, ...]
    entry: Entry = field(repr=False)
    completions: tuple[Completion, ...] = field(repr=False, default=())
    repairs: tuple[Repair, ...] = field(repr=False, default=())
    unrepaired: tuple[str, ...] = ()
    sha256: str | None = None

    @property
    def filled(self) -> tuple[FilledStrand, ...]:
        """The strands that were filled."""
        return tuple(strand for strand in self.strands if strand.status == "filled")

    @property
    def failures(self) -> Iterator[str]:
        """One sentence for each strand that was refused or could not be repaired."""
        many = len({strand.model for strand in self.strands}) > 1
        for strand in self.strands:
            if strand.reason is not None:
                yield f"model {strand.model}: {strand.reason}" if many else strand.reason
        yield from self.unrepaired

    @property
    def notes(self) -> Iterator[str]:
        """One sentence for each thing that a user should be aware of, of strands too."""
        many = len({strand.model for strand in self.strands}) > 1
        models: dict[str, list[int]] = {}
        for strand in self.strands:
            for sentence in strand.remarks:
                models.setdefault(sentence, []).append(strand.model)
        for sentence, own in models.items():
            which = f"model {own[0]}" if len(own) == 1 else f"{len(own)} models"
            yield f"{which}: {sentence}" if many else sentence
        if self.completed:
            yield f"missing atoms were added to {enumerated(self.completed)}"
        yield from self.repaired
        yield from self.remarks
        if not (self.strands or self.completed or self.repaired):
            yield "no internal gap; nothing to fill"

    def records(self) -> Iterator[dict[str, Any]]:
        """Give a row per strand, for :func:`loopelastica.to_dataframe`.

        Yields
        ------
        dict
            ``file``, then the columns of summary.csv.
        """
        from loopelastica.filling.folder import strand_row

        for strand in self.strands:
            yield {"file": self.name, **strand_row(strand)}

    def text(self, rank: int = 1) -> str:
        """The filled structure in the format of the input, mmCIF where PDB does not hold it.

        Parameters
        ----------
        rank : int
            Which candidate of each strand; the last one where a strand has fewer.

        Returns
        -------
        str

        Raises
        ------
        ValueError
            If `rank` is not 1 or more.
        """
        from loopelastica.filling.compose import composed

        return composed(self, whole(1)("rank", rank)).text

    def write(self, path: str | Path) -> Path:
        """Write the filled structure: into a file, or with tables into a folder.

        Parameters
        ----------
        path : str or Path
            A name that ends in .pdb, .ent, .cif or .mmcif is a file; anything else is a folder,
            which gets filled.cif or filled.pdb, further candidates, and fill.json.

        Returns
        -------
        Path
            What was written.

        Raises
        ------
        OutputError
            If it cannot be written.
        ValueError
            If the name is of another format, of a compressed file, or that of the input.
        """
        from loopelastica.filling.folder import write_filling

        return write_filling(Path(path), self)

    def __repr__(self) -> str:
        refused = len(self.strands) - len(self.filled)
        return f"<Filling of {self.name}: {len(self.filled)} strands filled, {refused} refused>"

    def _repr_html_(self) -> str:
        """A table of the strands, for notebooks."""
        head = ("strand", "sequence", "shape", "what became of it")
        rows = ((s.name, s.sequence, s.shape, s.outcome) for s in self.strands)
        return html_table(self.name, head, rows)
