"""Hands of the sugars' centres, from names alone: for models of any origin."""

from collections.abc import Mapping
from typing import Final

import numpy as np

from loopelastica._arrays import Array

_HANDS: Final = (
    ("C1'", ("O4'", "C2'", "base")),
    ("C2'", ("C3'", "C1'", "O2'")),
    ("C3'", ("C4'", "C2'", "O3'")),
    ("C4'", ("C5'", "C3'", "O4'")),
)


def wrong_hands(atoms: Mapping[str, Array]) -> int:
    """Number of a nucleotide's centres that have the wrong hand, or none.

    Parameters
    ----------
    atoms : mapping of str to (3,) array
        By wwPDB names, Å. A centre without all of its neighbours is not counted.

    Returns
    -------
    int
    """
    base = "N9" if "N9" in atoms else "N1"
    wrong = 0
    for centre, around in _HANDS:
        names = [centre, *(base if name == "base" else name for name in around)]
        if all(name in atoms for name in names):
            a, b, c = (atoms[name] - atoms[centre] for name in names[1:])
            # half the volume is already a flattened centre
            wrong += bool(a @ np.cross(b, c) < 0.5)
    return wrong
