"""What becomes of one loop: its candidates, or the reason why there are none."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from html import escape

from loopelastica._arrays import Array, Record, read_only
from loopelastica.folding.expected import expected_text
from loopelastica.folding.options import FoldOptions
from loopelastica.folding.rank import Candidate
from loopelastica.molecule.ends import StemEnds
from loopelastica.molecule.hairpins import Hairpin
from loopelastica.rod.clamping import Clamping


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

    @property
    def length_A(self) -> float:
        """Length of the rod, Å; 0 where the loop was not folded."""
        return 0.0 if self.ends is None else self.ends.length_A

    @property
    def parameters(self) -> dict[str, object]:
        """The options that were in force, by name, JSON-ready."""
        return self.options.to_dict()

    def __repr__(self) -> str:
        about = f"{self.hairpin.name} {self.hairpin.sequence}"
        if self.failure is not None:
            return f"<LoopFold {about}: {self.failure}>"
        shapes = f"{len(self.candidates)} candidate{'s' * (len(self.candidates) != 1)}"
        return f"<LoopFold {about}: {shapes}, first {self.candidates[0].summary}>"

    def _repr_html_(self) -> str:
        """A table of the candidates, for notebooks."""
        title = escape(f"{self.hairpin.name}, {self.hairpin.sequence}, {self.hairpin.label}")
        if self.failure is not None:
            return f"<p>{title}: {escape(self.failure)}</p>"
        names = ("rank", "shape", "expected (Å)", "E/K0 (1/Å)", "by E", "RMSD (Å)", "touches")
        rows = [
            (
                str(c.rank),
                escape(c.shape),
                expected_text(c.expected_rmsd_A),
                f"{c.energy_per_A:.4f}",
                str(c.rank_energy),
                "" if c.rmsd_A is None else f"{c.rmsd_A:.2f}",
                c.contacts.touched,
            )
            for c in self.candidates
        ]
        head = "".join(f"<th>{name}</th>" for name in names)
        body = "".join(f"<tr>{''.join(f'<td>{cell}</td>' for cell in row)}</tr>" for row in rows)
        return f"<table><caption>{title}</caption><tr>{head}</tr>{body}</table>"


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
