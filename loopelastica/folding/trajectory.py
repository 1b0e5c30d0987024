"""Fold the loops of a trajectory frame by frame, as an MDAnalysis analysis.

    from loopelastica import LoopElastica
    analysis = LoopElastica(universe).run(backend="multiprocessing", n_workers=2)
    analysis.results.rmsd_A

The hairpins are those of the frame the Universe is at when the analysis is made; each frame has
its own clamp, from its own stem.
"""

from typing import Any

import numpy as np
from MDAnalysis.analysis.base import AnalysisBase
from MDAnalysis.analysis.results import ResultsGroup

from loopelastica.folding.fold import checked_parameters, fold_positions
from loopelastica.molecule.hairpins import hairpins_of
from loopelastica.molecule.nucleotides import read_structure
from loopelastica.report.pandas import pandas


class LoopElastica(AnalysisBase):  # type: ignore[misc]
    """First-ranked elastic rod of every hairpin loop in every frame.

    Parameters
    ----------
    universe : MDAnalysis.Universe
        With nucleic acid in its present frame.
    **options
        Those of :func:`loopelastica.fold` (``free_spin``, ``taper``, …), the same meaning.

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
        If the Universe holds no nucleic acid.
    ValueError
        If an option is out of range; TypeError if it is unknown.

    Examples
    --------
    >>> import MDAnalysis as mda
    >>> from loopelastica._files import data_path
    >>> from loopelastica.molecule.reading import quiet
    >>> with quiet():
    ...     universe = mda.Universe(data_path("hairpins/2koc.pdb"))
    ...     analysis = LoopElastica(universe).run(stop=3)
    >>> print(analysis.results.rmsd_A.round(2).ravel())
    [2.12 2.05 1.87]
    """

    _analysis_algorithm_is_parallelizable = True

    @classmethod
    def get_supported_backends(cls) -> tuple[str, ...]:
        """Backends that give equal results."""
        return ("serial", "multiprocessing", "dask")

    def __init__(self, universe: Any, **options: Any) -> None:
        self._parameters = checked_parameters(**options)
        structure = read_structure(universe)
        self._nucleotides = structure.nucleotides
        self._atoms = universe.atoms
        positions = np.array(universe.atoms.positions, dtype=np.float64)
        self.hairpins = hairpins_of(self._nucleotides, positions)
        super().__init__(universe.trajectory)

    def _prepare(self) -> None:
        self.results.energy_per_A = []
        self.results.rmsd_A = []
        self.results.touching = []
        self.results.traces_A = []
        self.results.failures = []

    def _single_frame(self) -> None:
        positions = np.array(self._atoms.positions, dtype=np.float64)
        energies, rmsds, touching, traces = [], [], [], []
        for hairpin in self.hairpins:
            fold = fold_positions(self._nucleotides, hairpin, positions, **self._parameters)
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

    def trace_A(self, loop: int) -> Any:
        """Line points (n_frames, n_nt, 3) of one loop, Å."""
        ends = np.cumsum([0, *(len(hairpin) for hairpin in self.hairpins)])
        return self.results.traces_A[:, ends[loop] : ends[loop + 1]]

    def to_dataframe(self) -> Any:
        """One line per frame and loop, None where not folded; needs the extra ``table``."""
        frames = np.repeat(self.frames, len(self.hairpins))
        names = [hairpin.name for hairpin in self.hairpins] * self.n_frames
        columns = {"frame": frames, "loop": names}
        for name in ("energy_per_A", "rmsd_A"):
            values = self.results[name].ravel()
            columns[name] = [float(v) if np.isfinite(v) else None for v in values]
        columns["touching"] = self.results.touching.ravel()
        return pandas().DataFrame(columns)


def _joined(parts: list[list[Any]]) -> list[Any]:
    """Frames of all workers, in order."""
    return [value for part in parts for value in part]
