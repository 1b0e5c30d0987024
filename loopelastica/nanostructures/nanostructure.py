"""From a design to all of its nucleotides in space.

    files ─read→ system, partners ─single_strands→ ends ─lay→ rods → centres and axes

Reading places what is paired and leaves it there; laying gives the single strands between helices
and at ends their places, or refuses them by name.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from loopelastica._arrays import Record
from loopelastica._files import sha256
from loopelastica.folding.options import keywords
from loopelastica.nanostructures.design import Design
from loopelastica.nanostructures.inputs import read_input
from loopelastica.nanostructures.options import NanostructureOptions
from loopelastica.nanostructures.oxdna.checks import StartCheck, check_start
from loopelastica.nanostructures.oxdna.files import OxdnaFiles
from loopelastica.nanostructures.oxdna.model import UNIT_NM
from loopelastica.nanostructures.singles import Single
from loopelastica.nanostructures.system import System

if TYPE_CHECKING:
    from loopelastica.nanostructures.laying.laid import Conflict, LaidStrand, Sample
    from loopelastica.nanostructures.oxdna.topology import Form

STRAND_COLUMNS = (
    *("strand", "kind", "drawn", "before", "after", "sequence", "nucleotides"),
    *("status", "reason", "shape", "distance_nm", "length_nm", "spacing_nm"),
    *("energy_per_nm", "energy", "nearest_nm", "conflicts"),
)
"""Columns of tables that have a row per single strand."""


@keywords(NanostructureOptions)
def nanostructure(path: Any, options: NanostructureOptions) -> Nanostructure:
    """Give every single strand of a DNA nanostructure its place between the helices.

    Loopouts, hairpins, linkers and unpaired domains become elastic rods clamped to the helices at
    both of their ends, tails rods clamped at one. What is paired stays where the file has it, or
    where the design draws it, in the geometry of oxDNA2.

    Parameters
    ----------
    path : path-like
        A design of scadnano (``.sc``), or a topology (``.top``) or a configuration of oxDNA
        (``.dat``, ``.oxdna``, ``.conf``), whose other file is beside it.
    {options}

    Returns
    -------
    Nanostructure
        Its ``write(folder)`` writes files of oxDNA and a coarse trace.

    Raises
    ------
    StructureError
        If a file cannot be read or is no design; one sentence that names what. A strand that cannot
        be laid raises nothing: it is ``refused``.
    MissingDependencyError
        If the package scadnano is needed and not installed (extra ``origami``).
    ValueError
        If an option is out of range.

    Examples
    --------
    A hairpin: a stem of twelve pairs and a loop of five.

    >>> import json, tempfile
    >>> from pathlib import Path
    >>> stem = {"helix": 0, "start": 0, "end": 12}
    >>> parts = [{**stem, "forward": True}, {"loopout": 5}, {**stem, "forward": False}]
    >>> content = {"grid": "square", "helices": [{}], "strands": [{"domains": parts}]}
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "hairpin.sc"
    ...     _ = file.write_text(json.dumps(content))
    ...     found = nanostructure(file)
    >>> len(found.system), [f"{strand.kind}: {strand.status}" for strand in found.strands]
    (29, ['hairpin: laid'])
    """
    # here, since it brings the compiled solver
    from loopelastica.nanostructures.laying.lay import lay

    read = read_input(path, options)
    laid = lay(read.system, **options.laying)
    return Nanostructure(
        name=read.system.name,
        system=laid.system,
        strands=laid.strands,
        samples=laid.samples,
        options=options,
        persistence_length_nm=laid.persistence_length_nm,
        remarks=read.notes,
        paths=read.paths,
        sha256=tuple(sha256(file) for file in read.paths),
        design=read.design,
        files=read.files,
    )


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Nanostructure(Record):
    """A nanostructure with its single strands in place.

    Attributes
    ----------
    name : str
        What sentences call it: the path as given.
    system : System
        All nucleotides; those of refused strands may have no place.
    strands : tuple of LaidStrand
        Every single strand: its nucleotides, status "laid" or "refused", the reason, its shape.
    samples : tuple of Sample
        Worm-like chains in the place of the rods, as many as `sample` asked for.
    options : NanostructureOptions
        Every option that was in force.
    persistence_length_nm : float
        Of single strands.
    remarks : tuple of str
        Sentences of reading.
    paths, sha256 : tuple of Path, tuple of str
        The files that were read, and their digests.
    design : Design or None
        What scadnano says beside the system: helices, offsets, axes.
    files : OxdnaFiles or None
        The pair of oxDNA files.

    Examples
    --------
    Two helices that are too far apart for their linker.

    >>> import json, tempfile
    >>> from pathlib import Path
    >>> def domain(helix, forward):
    ...     return {"helix": helix, "start": 0, "end": 12, "forward": forward}
    >>> linked = [domain(0, True), {"loopout": 2}, domain(2, False)]
    >>> parts = [linked, [domain(0, False)], [domain(2, True)]]
    >>> strands = [{"domains": domains} for domains in parts]
    >>> content = {"grid": "square", "helices": [{}, {}, {}], "strands": strands}
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "far.sc"
    ...     _ = file.write_text(json.dumps(content))
    ...     found = nanostructure(file)
    >>> found.refused[0].reason.rpartition("; ")[2]
    '9 nucleotides would suffice'
    """

    name: str
    system: System
    strands: tuple[LaidStrand, ...]
    samples: tuple[Sample, ...]
    options: NanostructureOptions
    persistence_length_nm: float
    remarks: tuple[str, ...]
    paths: tuple[Path, ...]
    sha256: tuple[str, ...]
    design: Design | None = field(repr=False, default=None)
    files: OxdnaFiles | None = field(repr=False, default=None)

    @property
    def refused(self) -> tuple[LaidStrand, ...]:
        """The strands that cannot be laid; their ``reason`` says why."""
        return tuple(strand for strand in self.strands if strand.status == "refused")

    @property
    def notes(self) -> Iterator[str]:
        """One sentence for each thing that a user should be aware of; of many alike, the first."""
        alike: dict[str, list[LaidStrand]] = {}
        for strand in self.strands:
            if strand.remark:
                # what differs between strands of one kind comes behind the colon
                alike.setdefault(strand.remark.partition(":")[0], []).append(strand)
        clashes = _sentences(one for strand in self.strands for one in strand.conflicts)
        if clashes:
            first, *more = clashes
            yield f"{len(more) + 1} conflicts; the first: {first}" if more else first
        crowded = {
            k: _sentences(sample.conflicts)
            for k, sample in enumerate(self.samples, 1)
            if sample.conflicts
        }
        if crowded:
            number, (first, *_) = next(iter(crowded.items()))
            yield (
                f"{len(crowded)} of {len(self.samples)} samples with conflicts; the first, of"
                f" sample {number}: {first}"
            )
        for kind, strands in alike.items():
            name, remark = strands[0].label, strands[0].remark
            if len(strands) == 1:
                yield f"{name}: {remark}"
            else:
                rest = remark.removeprefix(kind).removeprefix(": ")
                yield f"{len(strands)} single strands, {kind}; the first, {name}: {rest}"
        yield from dict.fromkeys((*self.remarks, *self.check().notes()))
        if not self.strands:
            yield "no single strand; every nucleotide has a partner"

    def check(self) -> StartCheck:
        """Whether a simulation can start from it.

        Returns
        -------
        StartCheck
            Bonds out of the window of the model, centres too near each other, axes that are none.
        """
        return check_start(self.system)

    def records(self) -> Iterator[dict[str, Any]]:
        """A row per single strand, for :func:`loopelastica.to_dataframe`.

        Yields
        ------
        dict
            ``file``, then by `STRAND_COLUMNS`; lengths in nm.
        """
        for strand in self.strands:
            yield {"file": self.name, **self.row(strand)}

    def row(self, strand: LaidStrand) -> dict[str, Any]:
        """The row of one of its strands, by `STRAND_COLUMNS`; None where there is nothing to say.

        Parameters
        ----------
        strand : LaidStrand

        Returns
        -------
        dict
        """
        system = self.system
        ends = [None if i < 0 else system.label[i] for i in (strand.before, strand.after)]
        single = Single(strand.kind, strand.nucleotides, strand.before, strand.after)
        return {
            "strand": system.strand_name[int(system.strand[strand.nucleotides[0]])],
            "kind": str(strand.kind),
            "drawn": None if self.design is None else self.design.why(single),
            "before": ends[0],
            "after": ends[1],
            "sequence": "".join(system.base[strand.nucleotides].tolist()),
            "nucleotides": len(strand),
            "status": strand.status,
            "reason": strand.reason or None,
            "shape": strand.shape or None,
            "distance_nm": _in_nm(strand.distance),
            "length_nm": _in_nm(strand.length),
            "spacing_nm": _in_nm(strand.spacing),
            "energy_per_nm": strand.energy_per_nm,
            "energy": strand.energy,
            "nearest_nm": _in_nm(strand.nearest),
            "conflicts": len(strand.conflicts),
        }

    def write(self, path: str | Path, form: Form = "old") -> Path:
        """Write it for oxDNA and for viewers.

        Parameters
        ----------
        path : str or Path
            A name that ends in .top, .dat, .oxdna or .conf is that of a topology and a
            configuration of one stem, one in .pdb, .cif or .mmcif that of a trace of backbone
            sites, one in .oxview a file for oxView; anything else is a folder, which gets all of
            these, samples, <stem>.json and a script for PyMOL.
        form : {"old", "new"}, optional
            Of the topology: four columns, or a line per strand.

        Returns
        -------
        Path
            What was written.

        Raises
        ------
        ValueError
            If the name or the form is none.
        StructureError
            If a strand was refused: nothing is written then.
        OutputError
            If it cannot be written, or an input would be written over.
        """
        from loopelastica.report.nanostructure import write_nanostructure

        return write_nanostructure(path, self, form)

    def __repr__(self) -> str:
        laid = len(self.strands) - len(self.refused)
        return (
            f"<Nanostructure {self.name}: {len(self.system)} nucleotides, {laid} single strands"
            f" laid, {len(self.refused)} refused>"
        )

    def _repr_html_(self) -> str:
        """A table of the strands, for notebooks."""
        names = ("kind", "before", "after", "nucleotides", "distance_nm", "status")
        rows = [self.row(strand) for strand in self.strands[:_SHOWN]]
        head = "".join(f"<th>{name}</th>" for name in names)
        body = "".join(
            f"<tr>{''.join(f'<td>{escape(_cell(row[name]))}</td>' for name in names)}</tr>"
            for row in rows
        )
        more = len(self.strands) - len(rows)
        rest = f"<p>and {more} more</p>" if more else ""
        return f"<table><caption>{escape(repr(self))}</caption><tr>{head}</tr>{body}</table>{rest}"


_SHOWN = 50


def _sentences(conflicts: Iterable[Conflict]) -> list[str]:
    """One for each pair of nucleotides, though both of their strands name it."""
    return list({frozenset((one.first, one.second)): one.sentence for one in conflicts}.values())


def _cell(value: Any) -> str:
    if value is None:
        return ""
    return f"{value:.2f}" if isinstance(value, float) else str(value)


def _in_nm(length: float | None) -> float | None:
    return None if length is None else round(float(length) * UNIT_NM, 4)
