"""The folded loops of a structure: a list that is a table, and is written as the command does."""

from __future__ import annotations

from collections.abc import Iterable
from os import PathLike
from typing import TYPE_CHECKING, Any

from loopelastica._html import html_line
from loopelastica.folding.result import OUT, LoopFold

if TYPE_CHECKING:
    from pathlib import Path

    from pandas import DataFrame


class Folds(list[LoopFold]):
    """The folded loops of a structure, or of several.

    Parameters
    ----------
    folds : iterable of LoopFold
        Such as ``[*le.fold(one), *le.fold(other)]``.
    remarks : iterable of str
        What a user should be aware of.

    Attributes
    ----------
    remarks : tuple of str
        One sentence for each thing about the structure that a user should be aware of, such as
        loops that were left out.

    Examples
    --------
    >>> import loopelastica as le
    >>> from loopelastica._files import data_path
    >>> folds = le.fold(data_path("hairpins/2koc.pdb"), all_models=False, shapes="rod")
    >>> print(folds.to_dataframe()[["loop", "rank", "rmsd_A"]].round(2).to_string(index=False))
    loop  rank  rmsd_A
    A6-9     1    2.12
    A6-9     2    5.99
    A6-9     3    6.79
    """

    __slots__ = ("remarks",)

    def __init__(self, folds: Iterable[LoopFold] = (), remarks: Iterable[str] = ()) -> None:
        super().__init__(folds)
        self.remarks = tuple(remarks)

    @property
    def failures(self) -> tuple[str, ...]:
        """One sentence for each loop, and each further model, that could not be folded."""
        return tuple(
            sentence
            for loop in self
            for sentence in (*loop.model_failures, loop.failure)
            if sentence is not None
        )

    def to_dataframe(self) -> DataFrame:
        """Make a table of them, a row per candidate; needs the extra `table`.

        Returns
        -------
        pandas.DataFrame
            As :func:`loopelastica.to_dataframe`.
        """
        from loopelastica.report.dataframe import to_dataframe

        return to_dataframe(self)

    def write(self, folder: str | PathLike[str] = OUT, **options: Any) -> Path:
        """Write a folder per loop, summary.csv and failures.csv, as ``loopelastica fold`` does.

        Parameters
        ----------
        folder : path
            Folder for results.
        **options
            Those of :meth:`LoopFold.write`, such as ``atoms=True``. The atoms of each loop are
            built: models that are there already cannot be given. With ``report``, the default where
            plotly is installed, report.html shows all loops.

        Returns
        -------
        Path
            The folder for results. A loop that cannot be written is a row of failures.csv, and the
            others are written.

        Raises
        ------
        ValueError
            If an option is out of range, or needs `atoms`; TypeError if there is none of that name.
        OutputError
            If the folder cannot be written, or another run is at work in it.
        """
        from loopelastica.batch.results import WriteOptions, write_folds

        return write_folds(folder, self, WriteOptions.given(options))

    def _repr_html_(self) -> str:
        """Their tables one after the other, for notebooks."""
        return "".join(loop._repr_html_() for loop in self) or html_line("no hairpin loop")

    def __reduce__(self) -> tuple[Any, ...]:
        return Folds, ([*self], self.remarks)
