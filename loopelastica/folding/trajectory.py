"""Fold the loops of a trajectory frame by frame, as an MDAnalysis analysis.

    from loopelastica import LoopElastica
    analysis = LoopElastica(universe).run(backend="multiprocessing", n_workers=2)
    analysis.results.rmsd_A

The hairpins are those of the frame the Universe is at when the analysis is made; each frame has
its own clamp, from its own stem.
"""

from collections.abc import Iterator
from os import PathLike
from typing import Any, Final, NamedTuple

import numpy as np
from MDAnalysis.analysis.base import AnalysisBase
from MDAnalysis.analysis.results import Results, ResultsGroup
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica._checks import known_keywords, shown
from loopelastica.folding.fold import fold_model
from loopelastica.folding.hypotheses import scene_of
from loopelastica.folding.options import FoldOptions, option_names, show_options
from loopelastica.folding.rank import Candidate
from loopelastica.molecule.hairpins import find_hairpins
from loopelastica.molecule.nucleotides import read_structure

_NOT_HERE: Final = {
    "all_models": "each of its frames is folded",
    "max_size_MB": "its atoms have been read",
    "max_atoms": "its atoms have been read",
}
# what a candidate has in each array, how many numbers, and what stands where there is none
_MISSING: Final[dict[str, tuple[tuple[int, ...], Any]]] = {
    "energy_per_A": ((), np.inf),
    "energy_kT": ((), np.inf),
    "rmsd_A": ((), np.inf),
    "expected_rmsd_A": ((3,), np.inf),
    "touching": ((), False),
    "shape": ((), ""),
}


class FrameFailure(NamedTuple):
    """A loop that could not be folded in a frame."""

    frame: int
    loop: str
    reason: str


class LoopElastica(AnalysisBase):  # type: ignore[misc]
    """Elastic lines of every hairpin loop in every frame.

    Rods alone (``shapes="rod"``) take about half of the time of all shapes. Where a loop could not
    be folded in a frame, numbers are inf, ``touching`` is False and ``shape`` is "".

    Parameters
    ----------
    atoms : MDAnalysis.Universe or MDAnalysis.AtomGroup
        With nucleic acid in its present frame, where the hairpins are looked for.
    max_candidates : int
        Most candidates kept per frame and loop, in ``results.candidates``.
    {options}

    Attributes
    ----------
    hairpins : list of Hairpin
        The loops, in file order.
    results.names : tuple of str
        Names of the loops, such as "A6-9".
    results.energy_per_A, results.energy_kT : (n_frames, n_loops) ndarray
        Energy of the first-ranked shape: E/K0 in 1/Å, and in kT.
    results.rmsd_A : (n_frames, n_loops) ndarray
        Its distance from the loop of the frame, Å; inf too where the atoms lack the loop.
    results.expected_rmsd_A : (n_frames, n_loops, 3) ndarray
        10, 50 and 90 % of the error to expect of it, Å.
    results.touching : (n_frames, n_loops) ndarray of bool
        Whether it runs into the stem or itself.
    results.shape : (n_frames, n_loops) ndarray of object
        What it is, such as "straight rod".
    results.traces_A : (n_frames, n_nt, 3) ndarray
        Line points of all loops' nucleotides one after the other, Å.
        :meth:`trace_A` gives those of one loop.
    results.candidates : MDAnalysis.analysis.results.Results
        The same arrays of all candidates that were kept, by the same names, with one axis more
        behind the loops, of length `max_candidates`; ``traces_A`` is (n_frames, n_nt,
        max_candidates, 3).
    results.failures : list of FrameFailure
        ``frame``, ``loop`` (its name) and ``reason``, one sentence, of each that was not folded.

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
    ...     analysis = LoopElastica(universe, shapes="rod", max_candidates=2).run(stop=3)
    >>> analysis.results.names, analysis.results.candidates.energy_kT.shape
    (('A6-9',), (3, 1, 2))
    >>> print(analysis.results.rmsd_A.round(2).ravel())
    [2.12 2.05 1.87]
    """

    _analysis_algorithm_is_parallelizable = True

    @classmethod
    def get_supported_backends(cls) -> tuple[str, ...]:
        """Backends that give equal results.

        Returns
        -------
        tuple of str
        """
        return ("serial", "multiprocessing", "dask")

    def __init__(self, atoms: Any, *, max_candidates: int = 1, **options: Any) -> None:
        for name, reason in _NOT_HERE.items():
            if name in options:
                raise ValueError(f"`{name}` does not apply to a trajectory: {reason}")
        known_keywords("LoopElastica", options, option_names(FoldOptions, without=_NOT_HERE))
        if not hasattr(atoms, "universe"):
            what = f"but {type(atoms).__name__}"
            if isinstance(atoms, str | PathLike):
                what = (
                    f"but a path; make a Universe of it: MDAnalysis.Universe({shown(str(atoms))})"
                )
            raise ValueError(f"`atoms` is neither a Universe nor an AtomGroup {what}")
        self._options = FoldOptions(**options, max_candidates=max_candidates)
        structure = read_structure(atoms)
        self._nucleotides = structure.nucleotides
        self._all_atoms = atoms.universe.atoms
        self.hairpins = find_hairpins(structure, **self._options.selection)
        self._scene = scene_of(structure, self.hairpins, self._options)
        super().__init__(atoms.universe.trajectory)

    def _prepare(self) -> None:
        # of each frame and loop the candidates: arrays are made of them in the end
        self.results.kept = []
        self.results.failures = []

    def _single_frame(self) -> None:
        positions = np.array(self._all_atoms.positions, dtype=np.float64)
        kept = []
        for hairpin in self.hairpins:
            fold = fold_model(self._nucleotides, hairpin, positions, self._options, self._scene)
            if fold.failure is not None:
                failed = FrameFailure(int(self._ts.frame), hairpin.name, fold.failure)
                self.results.failures.append(failed)
            kept.append([(_values(c), np.array(c.trace)) for c in fold.candidates])
        self.results.kept.append(kept)

    def _get_aggregator(self) -> ResultsGroup:
        return ResultsGroup(lookup=dict.fromkeys(("kept", "failures"), _joined))

    def _conclude(self) -> None:
        kept = self.results.pop("kept")
        most = self._options.max_candidates
        every = Results()
        for name, (size, missing) in _MISSING.items():
            array = _filled((self.n_frames, len(self.hairpins), most, *size), missing)
            for place, (values, _) in _numbered(kept):
                array[place] = values[name]
            every[name] = array
        ends = self._ends
        traces = np.full((self.n_frames, ends[-1], most, 3), np.inf)
        for (frame, loop, rank), (_, trace) in _numbered(kept):
            traces[frame, ends[loop] : ends[loop + 1], rank] = trace
        every.traces_A = traces
        for name, array in every.items():
            self.results[name] = array[:, :, 0]
        self.results.candidates = every
        self.results.names = tuple(hairpin.name for hairpin in self.hairpins)

    @property
    def _ends(self) -> NDArray[np.int64]:
        """Where each loop's nucleotides begin among all, and where the last one's end."""
        return np.cumsum([0, *(len(hairpin) for hairpin in self.hairpins)])

    def trace_A(self, loop: int, rank: int = 1) -> Array:
        """Line points of one loop in all frames.

        Parameters
        ----------
        loop : int
            Its place in `hairpins`.
        rank : int
            Which candidate, up to `max_candidates`.

        Returns
        -------
        (n_frames, n_nt, 3) array
            Å; inf where there is no candidate of this rank.
        """
        ends = self._ends
        traces: Array = self.results.candidates.traces_A[:, ends[loop] : ends[loop + 1], rank - 1]
        return traces

    def records(self) -> Iterator[dict[str, Any]]:
        """A row per frame, loop and candidate.

        Yields
        ------
        dict
            ``frame``, ``time_ps``, ``loop``, ``sequence``, ``rank``, ``shape``, numbers as in
            `results`, ``failure``; None where there is none. A loop that could not be folded is one
            row with the reason.

        Raises
        ------
        ValueError
            If the analysis has not run.
        """
        if "candidates" not in self.results:
            raise ValueError("`results` is an analysis that has not run; call its run() first")
        reasons = {(frame, loop): reason for frame, loop, reason in self.results.failures}
        every = self.results.candidates
        for i, (frame, time) in enumerate(zip(self.frames, self.times, strict=True)):
            for k, hairpin in enumerate(self.hairpins):
                about = {
                    "frame": int(frame),
                    "time_ps": float(time),
                    "loop": hairpin.name,
                    "sequence": hairpin.sequence,
                }
                reason = reasons.get((int(frame), hairpin.name))
                found = np.flatnonzero(np.isfinite(every.energy_per_A[i, k]))
                for rank in found.tolist() if reason is None else (None,):
                    yield {**about, **_row(every, i, k, rank), "failure": reason}

    def to_dataframe(self) -> Any:
        """Make a table of these rows; needs the extra ``table``.

        Returns
        -------
        pandas.DataFrame
        """
        from loopelastica.report.dataframe import to_dataframe

        return to_dataframe(self)


show_options(LoopElastica, FoldOptions, without=(*_NOT_HERE, "max_candidates"))


def _values(candidate: Candidate) -> dict[str, Any]:
    """What of a candidate goes into the arrays."""
    rmsd_A = candidate.rmsd_A
    return {
        "energy_per_A": candidate.energy_per_A,
        "energy_kT": candidate.energy_kT,
        "rmsd_A": np.inf if rmsd_A is None else rmsd_A,
        "expected_rmsd_A": np.array(candidate.expected_rmsd_A),
        "touching": candidate.contacts.touching,
        "shape": candidate.shape,
    }


def _filled(shape: tuple[int, ...], value: Any) -> NDArray[Any]:
    kind = object if isinstance(value, str) else type(value)
    return np.full(shape, value, dtype=kind)


def _numbered(kept: list[list[list[Any]]]) -> Iterator[tuple[tuple[int, int, int], Any]]:
    """Candidates with their frame, loop and rank, from 0."""
    for frame, loops in enumerate(kept):
        for loop, candidates in enumerate(loops):
            for rank, candidate in enumerate(candidates):
                yield (frame, loop, rank), candidate


def _row(every: Results, frame: int, loop: int, rank: int | None) -> dict[str, Any]:
    """The columns of one candidate; of none they are empty."""
    names = ("expected_10_A", "expected_rmsd_A", "expected_90_A")
    if rank is None:
        columns = ("rank", "shape", *names, "energy_per_A", "energy_kT", "rmsd_A", "touching")
        return dict.fromkeys(columns)
    at = frame, loop, rank
    expected = dict(zip(names, every.expected_rmsd_A[at].tolist(), strict=True))
    rmsd_A = float(every.rmsd_A[at])
    return {
        "rank": rank + 1,
        "shape": every["shape"][at],
        **expected,
        "energy_per_A": float(every.energy_per_A[at]),
        "energy_kT": float(every.energy_kT[at]),
        "rmsd_A": rmsd_A if np.isfinite(rmsd_A) else None,
        "touching": bool(every.touching[at]),
    }


def _joined(parts: list[list[Any]]) -> list[Any]:
    """Frames of all workers, in order."""
    return [value for part in parts for value in part]
