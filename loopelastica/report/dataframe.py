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
    """What an analysis that ran and a filling have: a record per frame and loop, per strand."""

    def records(self) -> Iterator[dict[str, Any]]: ...


def to_dataframe(results: Iterable[LoopFold | _Records] | _Records) -> DataFrame:
    """Folded loops or filled strands as a pandas table, or an analysis that ran.

    Parameters
    ----------
    results : iterable of LoopFold, Filling, iterable of Filling, or LoopElastica
        What :func:`fold` returns, of one structure or of several: a row per candidate. What
        :func:`fill` returns, or several of these: a row per strand, filled or refused. Or an
        analysis of a trajectory that ran: a row per frame and loop.

    Returns
    -------
    pandas.DataFrame
        Of folds in the columns of ranking.csv: lengths in Å, energies as in :class:`Candidate`; the
        last column, ``failure``, is the reason where a loop could not be folded, which is a row
        without candidate. Of fillings in the columns of summary.csv. What is not there is missing
        (``None`` or ``NaN``).

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
    >>> folds = le.fold(data_path("hairpins/2koc.pdb"), all_models=False, shapes="rod")
    >>> table = to_dataframe(folds)
    >>> print(table.loc[0, "sequence"], round(table.loc[0, "rmsd_A"], 2))
    CUUCGG 2.12
    """
    given: Any = results
    try:
        rows = _rows([given] if _has_records(given) else iter(given))
    except TypeError:
        raise ValueError(
            f"`results` is {shown(given)}; it must be what fold or fill gives, or an analysis"
        ) from None
    table: DataFrame = _pandas().DataFrame(list(rows))
    return table


def _has_records(given: Any) -> bool:
    return callable(getattr(given, "records", None))


def _rows(results: Iterable[Any]) -> Iterator[dict[str, Any]]:
    for one in results:
        if _has_records(one):
            yield from one.records()
        elif isinstance(one, LoopFold):
            yield from _fold_rows(one)
        else:
            raise ValueError(f"`results` holds {shown(one)}; it must hold what fold or fill gives")


def _fold_rows(fold: LoopFold) -> Iterator[dict[str, Any]]:
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
