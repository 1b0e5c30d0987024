"""What becomes of one loop: its candidates, or the reason why there are none."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from loopelastica._arrays import Array, Record, read_only
from loopelastica._html import html_line, html_table
from loopelastica.errors import StructureError
from loopelastica.folding.expected import expected_text
from loopelastica.folding.options import FoldOptions
from loopelastica.folding.rank import Candidate
from loopelastica.folding.source import Source
from loopelastica.molecule.ends import StemEnds
from loopelastica.molecule.hairpins import Hairpin
from loopelastica.molecule.nucleotides import Structure
from loopelastica.molecule.setting import Setting, Settings
from loopelastica.rod.clamping import Clamping

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from loopelastica.atoms.model import AtomModel

OUT = "loopelastica-out"
"""Folder for results, unless another one is given."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class LoopFold(Record):
    """The folded loop of one hairpin.

    Attributes
    ----------
    hairpin : Hairpin
        What was folded.
    candidates : tuple of Candidate
        In the order asked for; empty if ``failure`` says why the loop could not be folded.
    options : FoldOptions
        Every option that was in force.
    failure : str or None
        One sentence, or None.
    ends : StemEnds or None
        Frames at both ends of the rod, from stem atoms only (first model).
    clamping : Clamping or None
        The same, dimensionless.
    backbone_A : (n_nt + 2, 3) ndarray or None
        Centroids of the file's own backbone, closing nucleotide to closing nucleotide (first
        model); None where the file has no loop. For comparison only.
    unseen : float
        Estimate of the chance that the search missed an equilibrium (`Equilibria.unseen`).
    remarks : tuple of str
        One sentence for each thing about this loop that a user should be aware of.
    model_failures : tuple of str
        One sentence for each further model that could not be folded.
    source : FileSource, Snapshot or None
        What it was folded in, for `plot`, `view`, `write` and `atoms`: a file, which is read again
        when it is needed, or the atoms of the frame of a Universe, without its water.

    Examples
    --------
    >>> import loopelastica as le
    >>> from loopelastica._files import data_path
    >>> (loop,) = le.fold(data_path("hairpins/2koc.pdb"), all_models=False, shapes="rod")
    >>> loop.hairpin.label, loop.length_A, [len(c.trace) for c in loop.candidates]
    ('A.C5–A.G10', 24.0, [4, 4, 4])
    """

    hairpin: Hairpin
    candidates: tuple[Candidate, ...]
    options: FoldOptions
    failure: str | None = None
    ends: StemEnds | None = None
    clamping: Clamping | None = None
    backbone_A: Array | None = None
    unseen: float = 1.0
    remarks: tuple[str, ...] = ()
    model_failures: tuple[str, ...] = ()
    source: Source | None = field(default=None, repr=False)

    @property
    def length_A(self) -> float:
        """Length of the rod, Å; 0 where the loop was not folded."""
        return 0.0 if self.ends is None else self.ends.length_A

    @property
    def parameters(self) -> dict[str, object]:
        """The options that were in force, by name, JSON-ready."""
        return self.options.to_dict()

    def structure(self) -> Structure:
        """What it was folded in.

        Returns
        -------
        Structure
            Of a file all models; of a Universe the frame that was folded, without its water.

        Raises
        ------
        StructureError
            If the file is gone or has changed since.
        """
        if self.source is None:
            raise StructureError(
                f"{self.hairpin.label}: what it was folded in is not known; loops of"
                " loopelastica.fold know it"
            )
        return self.source.structure(self.options.limits)

    def setting(self) -> Setting:
        """What the loop is seen in: its stem, its own nucleotides, the chains near it.

        Returns
        -------
        Setting
            Of the first model.

        Raises
        ------
        StructureError
            As :meth:`structure`.
        """
        near_A = self.candidates[0].trace if self.candidates else None
        return Settings(self.structure()).of(self.hairpin, near_A)

    def plot(self) -> Figure:
        """Draw the candidates in their stem, with the file's own loop and the curvature.

        Returns
        -------
        matplotlib.figure.Figure
            A notebook shows it; its ``savefig("loop.png")`` writes it.

        Raises
        ------
        StructureError
            If the loop was not folded, or its file is gone or has changed.
        """
        from loopelastica.report.plots import draw_fold

        self.check_folded()
        setting = self.setting()
        title = "" if self.source is None else self.source.name
        return draw_fold(self, setting=setting, title=title)

    def view(self) -> Any:
        """Show the candidates in their structure in a notebook, in 3D; needs the extra `notebook`.

        Returns
        -------
        nglview.NGLWidget

        Raises
        ------
        MissingDependencyError
            If nglview is not installed.
        StructureError
            If the loop was not folded, or its file is gone or has changed.
        """
        from loopelastica.report.notebook import view_fold

        self.check_folded()
        structure = self.structure()
        return view_fold(self, structure)

    def check_folded(self) -> None:
        """Refuse a loop without candidates.

        Raises
        ------
        StructureError
            With the reason why there are none.
        """
        if not self.candidates:
            raise StructureError(
                f"{self.hairpin.label}: it was not folded, so there is nothing to show"
                + (f" ({self.failure})" if self.failure else "")
            )

    def atoms(self, **options: Any) -> list[AtomModel]:
        """Build the atoms of the candidates.

        Parameters
        ----------
        **options
            Those of :func:`loopelastica.build_atoms`, such as ``max_candidates=1``.

        Returns
        -------
        list of AtomModel
            One per candidate.

        Raises
        ------
        StructureError
            As :func:`loopelastica.build_atoms`, and if its file is gone or has changed.
        """
        from loopelastica.atoms.model import build_atoms

        return build_atoms(self.structure(), self, **options)

    def write(
        self,
        folder: str | PathLike[str] = OUT,
        *,
        atoms: bool | Sequence[AtomModel] = False,
        contact: str | None = None,
        hydrogens: bool = False,
        names: str = "pdb",
        no_5_phosphate: bool = False,
        separate: bool = False,
        plot: bool = True,
        report: bool | None = None,
        whole: bool | None = None,
    ) -> Path:
        """Write the loop's folder, with the files that ``loopelastica fold`` writes of it.

        Parameters
        ----------
        folder : path
            Folder for results; the loop's own one in it is called <file>_<chain><first>-<last>,
            such as "2koc_A6-9". Of a Universe <file> is "universe".
        atoms : bool or sequence of AtomModel
            Write the loop's atoms too: build them, or take those given.
        contact : {"sheared", "watson-crick"}, optional
            Contact across the loop to be sought in building the atoms.
        hydrogens : bool
            Give all nucleotides their hydrogens.
        names : {"pdb", "amber", "charmm"}
            Whose names nucleotides and their atoms have.
        no_5_phosphate : bool
            Take off phosphates at 5' ends of chains, which force fields refuse.
        separate : bool
            Write files of their own for each candidate's atoms too.
        plot : bool
            Draw plot.png.
        report : bool, optional
            Write scene.js, from which :func:`loopelastica.write_report` makes a page of the folder
            for results; default: where plotly is installed (extra ``report``).
        whole : bool, optional
            Write whole.pdb, the structure with the first line in it; default: up to 20,000 atoms.

        Returns
        -------
        Path
            The loop's own folder, whole or unchanged.

        Raises
        ------
        StructureError
            If the loop was not folded, its file is gone or has changed, or it gets no atoms.
        ValueError
            If an option is out of range, or needs `atoms`.
        OutputError
            If the folder cannot be written without harm to what is there.
        """
        from loopelastica.batch.results import WriteOptions, write_loop

        return write_loop(
            folder,
            self,
            WriteOptions(
                atoms=atoms,
                contact=contact,
                hydrogens=hydrogens,
                names=names,
                no_5_phosphate=no_5_phosphate,
                separate=separate,
                plot=plot,
                report=report,
                whole=whole,
            ),
        )

    def __repr__(self) -> str:
        about = f"{self.hairpin.name} {self.hairpin.sequence}"
        if self.failure is not None:
            return f"<LoopFold {about}: {self.failure}>"
        shapes = f"{len(self.candidates)} candidate{'s' * (len(self.candidates) != 1)}"
        return f"<LoopFold {about}: {shapes}, first {self.candidates[0].summary}>"

    def _repr_html_(self) -> str:
        """A table of the candidates, for notebooks."""
        title = f"{self.hairpin.name}, {self.hairpin.sequence}, {self.hairpin.label}"
        if self.failure is not None:
            return html_line(f"{title}: {self.failure}")
        names = ("rank", "shape", "expected (Å)", "E/K0 (1/Å)", "by E", "RMSD (Å)", "touches")
        rows = [
            (
                c.rank,
                c.shape,
                expected_text(c.expected_rmsd_A),
                f"{c.energy_per_A:.4f}",
                c.rank_energy,
                None if c.rmsd_A is None else f"{c.rmsd_A:.2f}",
                c.contacts.touched,
            )
            for c in self.candidates
        ]
        return html_table(title, names, rows)


def with_models(models: Sequence[LoopFold]) -> LoopFold:
    """The first model's fold with the RMSDs of all models beside its own.

    Parameters
    ----------
    models : sequence of LoopFold
        One loop, folded in each model in turn.

    Returns
    -------
    LoopFold
        `rmsd_models_A` holds inf where a model has no candidate of this rank, or no loop.
    """
    first = models[0]
    candidates = tuple(
        replace(c, rmsd_models_A=read_only([_rmsd_A(model, c.rank) for model in models]))
        if c.rmsd_A is not None
        else c
        for c in first.candidates
    )
    failures = tuple(
        f"model {number}: {model.failure}"
        for number, model in enumerate(models[1:], start=2)
        if model.failure
    )
    return replace(first, candidates=candidates, model_failures=failures)


def _rmsd_A(model: LoopFold, rank: int) -> float:
    rmsd_A = model.candidates[rank - 1].rmsd_A if len(model.candidates) >= rank else None
    return math.inf if rmsd_A is None else rmsd_A
