"""A hairpin from its sequence alone: ideal stem, folded loop, atoms of both.

text → nucleotides, pairs → stem → folded loop → atoms
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array, Record
from loopelastica._checks import file_name, flag, keywords_known, shown, whole
from loopelastica._html import html_table
from loopelastica.atoms.hairpin import CHAIN, FoldedHairpin, fold_sequence, universe_of
from loopelastica.atoms.hydrogens import Hydrogens, add_hydrogens
from loopelastica.atoms.model import AtomModel, build_atoms
from loopelastica.atoms.sequence import read_sequence
from loopelastica.atoms.terminals import chain_bonds
from loopelastica.atoms.turn import check_contact
from loopelastica.errors import StructureError
from loopelastica.folding.expected import expected_text
from loopelastica.folding.result import LoopFold
from loopelastica.molecule.polymer import Monomer


@dataclass(frozen=True, slots=True, eq=False)
class HairpinAtoms(Record):
    """All atoms of a hairpin, 5' to 3'.

    Attributes
    ----------
    names, elements, resnames : tuple of str
        Of each atom; names of the wwPDB.
    resids : (N,) array of int
        Number of its nucleotide, from 1.
    chain : str
    positions_A : (N, 3) array
        Å.
    """

    names: tuple[str, ...]
    elements: tuple[str, ...]
    resnames: tuple[str, ...]
    resids: NDArray[np.int64]
    chain: str
    positions_A: Array


@dataclass(frozen=True, slots=True, eq=False, repr=False, kw_only=True)
class HairpinModel(AtomModel):
    """A built hairpin: what :class:`AtomModel` has of its loop, and the whole of it.

    Attributes
    ----------
    hairpin : FoldedHairpin
        The stem, and the folded loop.
    models : tuple of AtomModel
        The loop's atoms on all lines that were asked for, ranked.
    hydrogens : bool
        Whether the whole of it has hydrogens.

    Examples
    --------
    >>> import loopelastica as le
    >>> model = le.build("GGC(GAA)GCC", rna=False, candidates=2)
    >>> model.sequence, len(model.candidates), model.universe().atoms.n_residues
    ('GGC(GAA)GCC', 2, 9)
    """

    hairpin: FoldedHairpin
    models: tuple[AtomModel, ...]
    hydrogens: bool = False

    def __repr__(self) -> str:
        sound = "sound" if self.checks.sound else "not sound"
        n = len(self.hairpin.sequence.residues)
        return f"<HairpinModel {self.rank}: {self.sequence}, {n} nucleotides, {sound}>"

    def records(self) -> Iterator[dict[str, Any]]:
        """Give a row per candidate, for :func:`loopelastica.to_dataframe`.

        Yields
        ------
        dict
            ``sequence`` and ``shape``, then as of an :class:`AtomModel`.
        """
        from loopelastica.report.atoms import model_row

        shapes = {candidate.rank: candidate.shape for candidate in self.loop.candidates}
        for model in self.models:
            about = {"sequence": self.sequence, "shape": shapes[model.rank]}
            yield {**about, **model_row(model)}

    def _repr_html_(self) -> str:
        """A table of the candidates, for notebooks."""
        rows = [
            (
                one.rank,
                shape.shape,
                expected_text(shape.expected_rmsd_A),
                "sound" if one.checks.sound else "; ".join(one.checks.wrong),
            )
            for one, shape in zip(self.models, self.loop.candidates, strict=False)
        ]
        return html_table(self.sequence, ("rank", "shape", "expected (Å)", "atoms"), rows)

    @property
    def loop(self) -> LoopFold:
        """The folded loop: ``loop.write(folder, atoms=model.models)`` writes its folder."""
        return self.hairpin.fold

    @property
    def candidates(self) -> tuple[HairpinModel, ...]:
        """All that were asked for, ranked; the first is what `build` returns."""
        return tuple(
            _model(self.hairpin, model, self.models, self.hydrogens) for model in self.models
        )

    @property
    def sequence(self) -> str:
        """Such as "GGCAC(UUCG)GUGCC"."""
        return str(self.hairpin.sequence)

    @property
    def atoms(self) -> HairpinAtoms:
        """The atoms of stem and loop, each nucleotide's hydrogens behind its heavy atoms."""
        nucleotides = self._nucleotides()
        if self.hydrogens:
            added = add_hydrogens(nucleotides, chain_bonds(nucleotides), np.empty((0, 3)))
        else:
            added = Hydrogens({} for _ in nucleotides)
        every = [{**one.atoms_A, **more} for one, more in zip(nucleotides, added, strict=True)]
        names = [name for atoms in every for name in atoms]
        of = [one for one, atoms in zip(nucleotides, every, strict=True) for _ in atoms]
        return HairpinAtoms(
            tuple(names),
            tuple(name[0] for name in names),
            tuple(one.resname for one in of),
            np.array([one.number for one in of], dtype=np.int64),
            CHAIN,
            np.array([at for atoms in every for at in atoms.values()]),
        )

    def universe(self) -> Any:
        """The atoms of stem and loop as an MDAnalysis Universe.

        Returns
        -------
        MDAnalysis.Universe
        """
        atoms = self.atoms
        residues = self.hairpin.sequence.residues
        return universe_of(residues, atoms.names, (atoms.resids - 1).tolist(), atoms.positions_A)

    def write(self, path: str | PathLike[str], *, names: str = "pdb") -> None:
        """Write stem and loop of this model, whole or not at all.

        Parameters
        ----------
        path : path
            Its suffix is .pdb, .cif or .mmcif.
        names : {"pdb", "amber", "charmm"}
            Whose names nucleotides and their atoms have.

        Raises
        ------
        ValueError
            If the suffix is another.
        StructureError
            If the model is not sound.
        OSError
            If it cannot be written.
        """
        # upwards, when it is called
        from loopelastica.report.atoms import LoopAtoms, write_cif, write_pdb

        place = Path(file_name("path", path))
        writers = {".pdb": write_pdb, ".cif": write_cif, ".mmcif": write_cif}
        writer = writers.get(place.suffix.lower())
        if writer is None:
            raise ValueError(f"`path` is {shown(str(place))}; it must end in .pdb, .cif or .mmcif")
        if not self.checks.sound:
            raise StructureError(
                f"{self.sequence}, model {self.rank}: {'; '.join(self.checks.wrong)}; a model that"
                " is not sound is not written"
            )
        hairpin = self.hairpin
        atoms = LoopAtoms(
            hairpin.structure,
            hairpin.fold,
            (self,),
            hairpin.positions_A,
            hydrogens=self.hydrogens,
            names=names,
        )
        writer(place, atoms, self.sequence)

    def _nucleotides(self) -> list[Monomer]:
        """Heavy atoms by nucleotide; those of the stem as `hairpin` has them."""
        atoms, first = self.hairpin.structure.universe.atoms, self.hairpin.sequence.pairs
        own: list[dict[str, Array]] = [{} for _ in self.hairpin.sequence.residues]
        for name, number, at in zip(
            atoms.names.tolist(),
            (atoms.resids - 1).tolist(),
            self.hairpin.positions_A,
            strict=True,
        ):
            built = bool(np.isnan(at).any())
            row = self.molecule.index(number - first, name) if built else None
            own[number][name] = at if row is None else self.positions_A[row]
        return [
            Monomer(CHAIN, k, "", one.standard, one.letter, one.is_dna, None, own[k - 1])
            for k, one in enumerate(self.hairpin.sequence.residues, start=1)
        ]


@keywords_known
def build(
    sequence: str,
    rna: bool | None = None,
    *,
    structure: str | None = None,
    candidates: int = 1,
    hydrogens: bool = False,
    phosphate: bool = False,
    mismatches: bool = False,
    contact: str | None = None,
) -> HairpinModel:
    """Build a hairpin from its sequence: ideal stem, folded loop, atoms of both.

    Parameters
    ----------
    sequence : str
        Such as "GGCAC(UUCG)GUGCC", or with its dot-bracket, "GGCACUUCGGUGCC (((((....)))))";
        spaces and lower case mean nothing. Modified nucleotides stand in square brackets by their
        wwPDB names, "GG[5MC]A(UUCG)UGCC".
    rna : bool, optional
        True: A-RNA, False: B-DNA; by default T and U decide.
    structure : str, optional
        The dot-bracket, where it is not in `sequence`.
    candidates : int
        Most shapes of the loop.
    hydrogens : bool
        Give all nucleotides their hydrogens.
    phosphate : bool
        Put a phosphate at the 5' end.
    mismatches : bool
        Take nucleotides that do not pair into the stem; they stand where they find room.
    contact : {"sheared", "watson-crick"}, optional
        Contact across the loop to be sought.

    Returns
    -------
    HairpinModel
        The first of its :attr:`~HairpinModel.candidates`. Its checks say whether it is sound.

    Raises
    ------
    ValueError
        If `sequence` is no hairpin, or an option is out of range; the sentence says where.
    StructureError
        If the stem does not get sound, or the loop cannot be folded.

    Examples
    --------
    >>> model = build("GGC(GAA)GCC", rna=False)
    >>> model
    <HairpinModel 1: GGC(GAA)GCC, 9 nucleotides, sound>
    >>> len(model.atoms.names), model.atoms.resnames[-1]
    (184, 'DC')
    """
    candidates, hydrogens = whole(1)("candidates", candidates), flag("hydrogens", hydrogens)
    phosphate = flag("phosphate", phosphate)
    check_contact(contact)
    read = read_sequence(sequence, structure, rna=rna, mismatches=mismatches)
    hairpin = fold_sequence(read, max_candidates=candidates, phosphate=phosphate)
    models = build_atoms(
        hairpin.structure, hairpin.fold, positions=hairpin.positions_A, contact=contact
    )
    return _model(hairpin, models[0], tuple(models), hydrogens)


def _model(
    hairpin: FoldedHairpin, model: AtomModel, models: tuple[AtomModel, ...], hydrogens: bool
) -> HairpinModel:
    values = {item.name: getattr(model, item.name) for item in fields(AtomModel)}
    return HairpinModel(**values, hairpin=hairpin, models=models, hydrogens=hydrogens)
