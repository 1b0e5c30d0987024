"""Folds as a table of pandas, which is loaded when the first one is made."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from loopelastica.folding.fold import LoopFold
from loopelastica.report.folder import loop_record, record
from loopelastica.report.pandas import pandas

if TYPE_CHECKING:
    from pandas import DataFrame


def to_dataframe(folds: Iterable[LoopFold]) -> DataFrame:
    """Candidates of folded loops as a pandas table, a row each, in the columns of ranking.csv.

    Parameters
    ----------
    folds : iterable of LoopFold
        What :func:`fold` returns, of one structure or of several.

    Returns
    -------
    pandas.DataFrame
        Lengths in Å, energies as in :class:`Candidate`; the last column, ``failure``, is the reason
        where a loop could not be folded, which is a row without candidate. What is not there is
        missing (``None`` or ``NaN``).

    Raises
    ------
    MissingDependencyError
        If pandas is not installed.

    Examples
    --------
    >>> import loopelastica as le
    >>> from loopelastica._files import data_path
    >>> table = to_dataframe(le.fold(data_path("hairpins/2koc.pdb"), all_models=False))
    >>> print(table.loc[0, "sequence"], round(table.loc[0, "rmsd_A"], 2))
    CUUCGG 2.12
    """
    module = pandas()
    rows = []
    for fold in folds:
        rows += [{**record(fold, candidate), "failure": None} for candidate in fold.candidates]
        if fold.failure is not None:
            rows.append({**loop_record(fold), "failure": fold.failure})
    table: DataFrame = module.DataFrame(rows)
    return table
