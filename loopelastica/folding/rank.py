"""Candidates: the possible lines of one loop, put into the molecule and ranked.

Two orders stand beside each other. The default one is that of the hypotheses, by what was measured
to be nearest to real loops; rods of one clamp follow each other by energy. The other is least
deformation energy per length. Rods that run into the stem or themselves come after all others in
both, for no backbone can take them; what is known of other loops keeps its place in the default
order (of 274 loops two means touched, and the rods that took their place were worse). The energy is
not a confidence: it says which shape costs least, not how near that shape is to the loop in nature.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from loopelastica._arrays import Array, Record, read_only
from loopelastica.folding.hypotheses import Hypothesis
from loopelastica.folding.lines import CandidateLine, Rod, RodLine
from loopelastica.molecule.contacts import Contacts, contacts
from loopelastica.molecule.polymer import Monomer
from loopelastica.molecule.trace import rmsd_A


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Candidate(Record):
    """One possible shape of a loop.

    Attributes
    ----------
    rank : int
        Its place in the order asked for, from 1.
    rank_energy : int
        Its place by `energy_per_A` among all that were found, those that touch something last.
    shape : str
        What it is: "straight rod", "rod in its surroundings", "motif GNRA", "like 1zih A.4-A.9" …
    line : RodLine or ChainLine
        The line itself, in the coordinates of the file.
    energy_per_A : float
        Deformation energy over the bending rigidity, E/K0, in 1/Å.
    energy_kT : float
        The same in kT, for the persistence length in the options (K0 = kT·lp).
    contacts : Contacts
        Nearest approaches to the stem and to itself; ``contacts.touching`` marks what no backbone
        can do.
    trace : (n_nt, 3) ndarray
        Line point of each loop nucleotide in the file's coordinates, Å.
    expected_rmsd_A : (3,) ndarray
        10, 50 and 90 % of the error to expect of it, Å: its `rmsd_A`, were it known.
    rmsd_A : float or None
        Trace against the centroids of P O5' C5' C4' C3' O3' of the loop nucleotides, first model,
        without superposition; None where the file has no loop.
    rmsd_models_A : (n_models,) ndarray
        The same for each model: its own clamp, its own prediction of this rank, its own loop;
        inf where the model has none. Empty where the file has no loop.
    carried : tuple of Monomer
        Nucleotides of a template with their atoms, where the line takes them, Å; empty where it is
        no template of equal length.

    Examples
    --------
    >>> import loopelastica as le
    >>> from loopelastica._files import data_path
    >>> (loop,) = le.fold(data_path("hairpins/2koc.pdb"), all_models=False, shapes="rod")
    >>> first = loop.candidates[0]
    >>> print(first.rank, first.shape, round(first.energy_kT, 2), round(first.rmsd_A, 2))
    1 straight rod 3.02 2.12
    """

    rank: int
    rank_energy: int
    shape: str
    line: CandidateLine
    energy_per_A: float
    energy_kT: float
    contacts: Contacts
    trace: Array
    expected_rmsd_A: Array
    rmsd_A: float | None
    rmsd_models_A: Array
    carried: tuple[Monomer, ...] = ()

    @property
    def rod(self) -> Rod | None:
        """The dimensionless rod; None for a chain."""
        return self.line.rod if isinstance(self.line, RodLine) else None

    @property
    def length_A(self) -> float:
        """Length of the elastic line, Å."""
        return self.line.length_A

    @property
    def stable(self) -> bool | None:
        """Whether it is a local minimum of the energy; None until that is computed."""
        return self.line.stable

    @property
    def residual(self) -> float:
        """Error of the solution, by an evaluation that the solver did not use."""
        return self.line.residual

    @property
    def summary(self) -> str:
        """Shape, energy, RMSD and contacts in a few words."""
        rmsd = "" if self.rmsd_A is None else f", RMSD {self.rmsd_A:.2f} Å"
        touches = f", touches {self.contacts.touched}" if self.contacts.touching else ""
        return f"{self.shape}, E/K0 {self.energy_per_A:.3g} 1/Å{rmsd}{touches}"

    def __repr__(self) -> str:
        return f"<Candidate {self.rank}: {self.summary}>"


def rank(
    hypotheses: Sequence[Hypothesis],
    persistence_length_A: float,
    stem: tuple[Array, Array],
    backbone_A: Array | None,
    order: str = "default",
) -> tuple[Candidate, ...]:
    """Candidates of one model in the order asked for.

    Parameters
    ----------
    hypotheses : sequence of Hypothesis
        What there is to rank.
    persistence_length_A : float
        Scale of ``energy_kT``, Å.
    stem : (m, 3), (m,) array
        Atoms of the stem and their phases (:func:`stem_atoms`).
    backbone_A : (n_nt + 2, 3) array or None
        Centroids of the file's own loop, closing nucleotide to closing nucleotide, Å;
        `rmsd_models_A` then holds this model only.
    order : {"default", "energy"}
        By the place of each hypothesis, rods that touch something last; or by energy per length,
        whatever touches last.

    Returns
    -------
    tuple of Candidate
        Each with its rank, from 1.
    """
    near = [contacts(*one.line.sampled(), *stem) for one in hypotheses]
    energies = [one.line.energy / one.line.length_A for one in hypotheses]
    rows = range(len(hypotheses))
    by_energy = sorted(rows, key=lambda i: (near[i].touching, energies[i]))
    # a rod that touches is no backbone; shapes of real loops and their means are told, not moved
    last = [near[i].touching and isinstance(hypotheses[i].line, RodLine) for i in rows]
    by_place = sorted(by_energy, key=lambda i: (last[i], hypotheses[i].place))
    place_by_energy = {i: place for place, i in enumerate(by_energy, start=1)}
    candidates = []
    for place, i in enumerate(by_energy if order == "energy" else by_place, start=1):
        one = hypotheses[i]
        trace = one.line.trace
        rmsd = None if backbone_A is None else rmsd_A(trace, backbone_A[1:-1])
        candidates.append(
            Candidate(
                place,
                place_by_energy[i],
                one.shape,
                one.line,
                energies[i],
                energies[i] * persistence_length_A,
                near[i],
                read_only(trace),
                read_only(one.expected_rmsd_A),
                rmsd,
                read_only([] if rmsd is None else [rmsd]),
                one.carried,
            )
        )
    return tuple(candidates)
