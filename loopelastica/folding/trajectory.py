"""Fold the loops of a trajectory frame by frame, as an MDAnalysis analysis.

    from loopelastica import LoopElastica
    analysis = LoopElastica(universe).run(backend="multiprocessing", n_workers=2)
    analysis.results.rmsd_A

The hairpins are those of the frame the Universe is at when the analysis is made; each frame has
its own clamp, from its own stem.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
from MDAnalysis.analysis.base import AnalysisBase
from MDAnalysis.analysis.results import ResultsGroup

from loopelastica._arrays import Array
from loopelastica.folding.fold import fold_model
from loopelastica.folding.hypotheses import scene_of
from loopelastica.folding.options import FoldOptions, show_options
from loopelastica.molecule.hairpins import find_hairpins
from loopelastica.molecule.nucleotides import read_structure

_NOT_HERE = {
    "all_models": "each of its frames is folded",
    "max_candidates": "the first-ranked shape of each frame is kept",
    "max_size_MB": "its atoms have been read",
    "max_atoms": "its atoms have been read",
    "persistence_length_A": "its energies are E/K0, 1/Å",
}


class LoopElastica(AnalysisBase):  # type: ignore[misc]
    """First-ranked elastic line of every hairpin loop in every frame.

    Rods alone (``shapes="rod"``) take about half of the time of all shapes.

    Parameters
    ----------
    atoms : MDAnalysis.Universe or MDAnalysis.AtomGroup
        With nucleic acid in its present frame, where the hairpins are looked for.
    {options}

    Attributes
    ----------
    hairpins : list of Hairpin
        The loops, in file order.
    results.energy_per_A : (n_frames, n_loops) ndarray
        E/K0 of the first-ranked shape, 1/Å; inf where the loop could not be folded.
    results.rmsd_A : (n_frames, n_loops) ndarray
        Its distance from the loop of the frame, Å; inf where either is missing.
    results.touching : (n_frames, n_loops) ndarray of bool
        Whether it runs into the stem or itself.
    results.traces_A : (n_frames, n_nt, 3) ndarray
        Line points of all loops' nucleotides one after the other, Å; inf where not folded.
        :meth:`trace_A` gives those of one loop.
    results.failures : list of (int, str)
        Frame and one sentence, for each loop that could not be folded.

    Raises
    ------
    StructureError
        If there is no nucleic acid, or no nucleotide that `pair` or `loop` name.
    ValueError
        If `atoms` is a path, an option is out of range, or is one of :func:`fold` that does not
        apply to a trajectory; TypeError if there is no option of that name.

    Examples
    --------
    >>> import MDAnalysis as mda
    >>> from loopelastica._files import data_path
    >>> from loopelastica.molecule.reading import quiet
    >>> with quiet():
    ...     universe = mda.Universe(data_path("hairpins/2koc.pdb"))
    ...     analysis = LoopElastica(universe, shapes="rod").run(stop=3)
    >>> print(analysis.results.rmsd_A.round(2).ravel())
    [2.12 2.05 1.87]
    """

    _analysis_algorithm_is_parallelizable = True

    @classmethod
    def get_supported_backends(cls) -> tuple[str, ...]:
        """Backends that give equal results."""
        return ("serial", "multiprocessing", "dask")

    def __init__(self, atoms: Any, **options: Any) -> None:
        for name, reason in _NOT_HERE.items():
            if name in options:
                raise ValueError(f"`{name}` does not apply to a trajectory: {reason}")
        if not hasattr(atoms, "universe"):
            raise ValueError(
                f"`atoms` is neither a Universe nor an AtomGroup but {type(atoms).__name__}"
            )
        self._options = FoldOptions(**options, max_candidates=1)
        structure = read_structure(atoms)
        self._nucleotides = structure.nucleotides
        self._all_atoms = atoms.universe.atoms
        self.hairpins = find_hairpins(structure, **self._options.selection)
        self._scene = scene_of(structure, self.hairpins, self._options)
        super().__init__(atoms.universe.trajectory)

    def _prepare(self) -> None:
        self.results.energy_per_A = []
        self.results.rmsd_A = []
        self.results.touching = []
        self.results.traces_A = []
        self.results.failures = []

    def _single_frame(self) -> None:
        positions = np.array(self._all_atoms.positions, dtype=np.float64)
        energies, rmsds, touching, traces = [], [], [], []
        for hairpin in self.hairpins:
            fold = fold_model(self._nucleotides, hairpin, positions, self._options, self._scene)
            if fold.failure:
                self.results.failures.append((int(self._ts.frame), fold.failure))
            first = fold.candidates[0] if fold.candidates else None
            energies.append(np.inf if first is None else first.energy_per_A)
            rmsds.append(np.inf if first is None or first.rmsd_A is None else first.rmsd_A)
            touching.append(first is not None and first.contacts.touching)
            traces.append(np.full((len(hairpin), 3), np.inf) if first is None else first.trace)
        self.results.energy_per_A.append(energies)
        self.results.rmsd_A.append(rmsds)
        self.results.touching.append(touching)
        self.results.traces_A.append(np.concatenate([np.zeros((0, 3)), *traces]))

    def _get_aggregator(self) -> ResultsGroup:
        names = ("energy_per_A", "rmsd_A", "touching", "traces_A", "failures")
        return ResultsGroup(lookup=dict.fromkeys(names, _joined))

    def _conclude(self) -> None:
        shape = (-1, len(self.hairpins))
        n = self.n_frames
        for name, kind in (("energy_per_A", float), ("rmsd_A", float), ("touching", bool)):
            self.results[name] = np.array(self.results[name], dtype=kind).reshape(n, shape[1])
        total = sum(len(hairpin) for hairpin in self.hairpins)
        self.results.traces_A = np.array(self.results.traces_A, dtype=float).reshape(n, total, 3)

    def trace_A(self, loop: int) -> Array:
        """Line points (n_frames, n_nt, 3) of one loop, by its place in `hairpins`, Å."""
        ends = np.cumsum([0, *(len(hairpin) for hairpin in self.hairpins)])
        traces: Array = self.results.traces_A[:, ends[loop] : ends[loop + 1]]
        return traces

    def records(self) -> Iterator[dict[str, Any]]:
        """A row per frame and loop, None where it was not folded."""
        for i, frame in enumerate(self.frames):
            for k, hairpin in enumerate(self.hairpins):
                row = {name: self.results[name][i, k] for name in ("energy_per_A", "rmsd_A")}
                known = {n: float(v) if np.isfinite(v) else None for n, v in row.items()}
                touching = bool(self.results.touching[i, k])
                yield {"frame": int(frame), "loop": hairpin.name, **known, "touching": touching}

    def to_dataframe(self) -> Any:
        """These rows as a table of pandas; needs the extra ``table``."""
        from loopelastica.report.dataframe import to_dataframe

        return to_dataframe(self)


show_options(LoopElastica, FoldOptions, without=_NOT_HERE)


def _joined(parts: list[list[Any]]) -> list[Any]:
    """Frames of all workers, in order."""
    return [value for part in parts for value in part]
