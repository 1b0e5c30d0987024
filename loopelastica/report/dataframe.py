"""Results as tables of pandas, which is loaded when the first one is made."""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

from loopelastica._checks import shown
from loopelastica.errors import MissingDependencyError
from loopelastica.folding.result import LoopFold
from loopelastica.folding.scan import LoopScan
from loopelastica.molecule.hairpins import Hairpin
from loopelastica.report.records import candidate_row, hairpin_row, loop_row, scan_rows

if TYPE_CHECKING:
    from pandas import DataFrame


def to_dataframe(results: Any) -> DataFrame:
    """Results of this package as a pandas table.

    Parameters
    ----------
    results : LoopFold, LoopScan, Filling, Hairpin, AtomModel, LoopElastica or iterable of these
        Or Equilibria, Barriers, Nanostructure.
        One of these or several of one kind, of one structure or of many: what :func:`fold`,
        :func:`scan`, :func:`fill`, :func:`find_hairpins`, :func:`build_atoms` and :func:`build`
        give, or an analysis of a trajectory that ran.

    Returns
    -------
    pandas.DataFrame
        Lengths in Å where their names say nothing else; what is not there is missing (``None``
        or ``NaN``).

        - Of folds a row per candidate: ``file``, then the columns of ranking.csv, then ``failure``.
          A loop that could not be folded is one row with the reason.
        - Of scans a row per shape in the columns of scan.csv, then ``failure``.
        - Of fillings a row per strand, filled or refused, in the columns of summary.csv.
        - Of hairpins a row each: closing pair, sequence, kind, stem, what the loop pairs with.
        - Of models a row each: whether its atoms are sound, what is wrong, what was measured on
          them. Of a hairpin that was built all its candidates.
        - Of equilibria and of barriers a row each.
        - Of nanostructures a row per single strand, laid or refused: ``file``, then the columns of
          their summary.csv up to ``conflicts``; lengths in nm where their names say so.
        - Of an analysis a row per frame, loop and candidate.

    Raises
    ------
    MissingDependencyError
        If pandas is not installed.
    ValueError
        If `results` is none of these, holds two kinds, or is an analysis that did not run.

    Examples
    --------
    >>> import loopelastica as le
    >>> from loopelastica._files import data_path
    >>> path = data_path("hairpins/2koc.pdb")
    >>> table = to_dataframe(le.fold(path, all_models=False, shapes="rod"))
    >>> print(table.loc[0, "sequence"], round(table.loc[0, "rmsd_A"], 2))
    CUUCGG 2.12
    >>> table = to_dataframe(le.find_hairpins(path))
    >>> print(table[["loop", "closing_pair", "sequence", "stem_pairs"]].to_string(index=False))
    loop closing_pair sequence  stem_pairs
    A6-9   A.C5–A.G10   CUUCGG           5
    """
    given = [results] if _is_one(results) else results
    try:
        several = [*given]
    except TypeError:
        raise ValueError(f"`results` is {shown(results)}; {_KINDS}") from None
    kinds = dict.fromkeys(_kind(one) for one in several)
    if len(kinds) > 1:
        raise ValueError(f"`results` holds {' and '.join(kinds)}; a table is of one kind")
    table: DataFrame = _pandas().DataFrame([row for one in several for row in _rows(one)])
    return table


_KINDS = (
    "it must be what fold, scan, fill, find_hairpins, build or nanostructure gives, or an analysis"
    " that ran"
)


def _is_one(given: Any) -> bool:
    """Whether this is a single result, not an iterable of them; a hairpin has a length too."""
    return isinstance(given, LoopFold | LoopScan | Hairpin) or _has_records(given)


def _has_records(given: Any) -> bool:
    """Whether it has rows of its own: models load late, fillings lie above this room."""
    return not isinstance(given, type) and callable(getattr(given, "records", None))


def _kind(one: Any) -> str:
    if not _is_one(one):
        raise ValueError(f"`results` holds {shown(one)}; {_KINDS}")
    return type(one).__name__


def _rows(one: Any) -> Iterable[dict[str, Any]]:
    if isinstance(one, LoopFold):
        return _fold_rows(one)
    if isinstance(one, LoopScan):
        failed = [{**hairpin_row(one.hairpin), "failure": one.failure}] if one.failure else []
        return [*({**row, "failure": None} for row in scan_rows(one)), *failed]
    if isinstance(one, Hairpin):
        return [hairpin_row(one)]
    rows: Iterable[dict[str, Any]] = one.records()
    return rows


def _fold_rows(fold: LoopFold) -> Iterator[dict[str, Any]]:
    about = {"file": None if fold.source is None else fold.source.file, **loop_row(fold)}
    for candidate in fold.candidates:
        yield {**about, **candidate_row(candidate), "failure": None}
    if fold.failure is not None:
        yield {**about, "failure": fold.failure}


def _pandas() -> Any:
    try:
        return importlib.import_module("pandas")
    except ImportError:
        raise MissingDependencyError(
            "tables need pandas; install it with `pip install loopelastica[table]`"
        ) from None
