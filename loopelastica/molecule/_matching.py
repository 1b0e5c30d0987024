"""Models of one structure whose atoms differ, or stand in another order, in one table."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array


def matched(identities: Sequence[NDArray[np.intc]], tables: Sequence[Array]) -> Array:
    """Positions of all models in the atom order of the first one.

    Parameters
    ----------
    identities : sequence of (n,) array of int
        For each model, a number for what names each of its atoms. Atoms of one name are told apart
        by their order.
    tables : sequence of (n, 3) array
        Their positions, Å.

    Returns
    -------
    (n_models, n_atoms, 3) array
        NaN where a model lacks an atom of the first one.

    Examples
    --------
    >>> first, second = np.array([4, 7, 7]), np.array([7, 9, 4])
    >>> matched([first, second], [np.zeros((3, 3)), np.eye(3)])[1]
    array([[ 0.,  0.,  1.],
           [ 1.,  0.,  0.],
           [nan, nan, nan]])
    """
    keys = [_keys(codes) for codes in identities]
    order = np.argsort(keys[0])
    sorted_keys = keys[0][order]
    positions = np.full((len(tables), len(keys[0]), 3), np.nan)
    for model, key, table in zip(positions, keys, tables, strict=True):
        place = np.minimum(np.searchsorted(sorted_keys, key), len(order) - 1)
        known = sorted_keys[place] == key
        model[order[place[known]]] = table[known]
    return positions


def _keys(codes: NDArray[np.intc]) -> NDArray[np.int64]:
    """A number for each atom: its name and how often that came before."""
    order = np.argsort(codes, kind="stable")
    in_order = codes[order].astype(np.int64)
    begins = np.flatnonzero(np.diff(in_order, prepend=-1))
    lengths = np.diff(begins, append=len(codes))
    before = np.empty(len(codes), dtype=np.int64)
    before[order] = np.arange(len(codes)) - np.repeat(begins, lengths)
    keys: NDArray[np.int64] = (codes.astype(np.int64) << 32) + before
    return keys
