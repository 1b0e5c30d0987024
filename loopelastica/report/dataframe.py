"""Results as tables of pandas, which is loaded when the first one is made."""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any, Protocol

from loopelastica._checks import shown
from loopelastica.errors import MissingDependencyError
from loopelastica.folding.result import LoopFold
from loopelastica.report.records import candidate_row, loop_row

if TYPE_CHECKING:
    from pandas import DataFrame


class _Records(Protocol):
    """What an analysis that ran has: a record per frame and loop."""

    def records(self) -> Iterator[dict[str, Any]]: ...


def to_dataframe(results: Iterable[LoopFold] | _Records) -> DataFrame:
    """Folded loops as a pandas table, or an analysis that ran.

    Parameters
    ----------
    results : iterable of LoopFold, or LoopElastica
        What :func:`fold` returns, of one structure or of several: a row per candidate. Or an
        analysis of a trajectory that ran: a row per frame and loop.

    Returns
    -------
    pandas.DataFrame
        Of folds in the columns of ranking.csv: lengths in Å, energies as in :class:`Candidate`; the
        last column, ``failure``, is the reason where a loop could not be folded, which is a row
        without candidate. What is not there is missing (``None`` or ``NaN``).

    Raises
    ------
    MissingDependencyError
        If pandas is not installed.
    ValueError
        If `results` is neither.

    Examples
    --------
    >>> import loopelastica as le
    >>> from loopelastica._files import data_path
    >>> table = to_dataframe(le.fold(data_path("hairpins/2koc.pdb"), all_models=False))
    >>> print(table.loc[0, "sequence"], round(table.loc[0, "rmsd_A"], 2))
    CUUCGG 2.12
    """
    given: Any = results
    try:
        own = callable(getattr(given, "records", None))
        rows = given.records() if own else _fold_rows(iter(given))
    except TypeError:
        raise ValueError(
            f"`results` is {shown(given)}; it must be what fold gives, or an analysis"
        ) from None
    table: DataFrame = _pandas().DataFrame(list(rows))
    return table


def _fold_rows(folds: Iterable[LoopFold]) -> Iterator[dict[str, Any]]:
    for fold in folds:
        if not isinstance(fold, LoopFold):
            raise ValueError(f"`results` holds {shown(fold)}; it must hold what fold gives")
        for candidate in fold.candidates:
            yield {**loop_row(fold), **candidate_row(candidate), "failure": None}
        if fold.failure is not None:
            yield {**loop_row(fold), "failure": fold.failure}


def _pandas() -> Any:
    try:
        return importlib.import_module("pandas")
    except ImportError:
        raise MissingDependencyError(
            "tables need pandas; install it with `pip install loopelastica[table]`"
        ) from None
