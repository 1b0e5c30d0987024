"""Nucleotides while they are laid: backbone sites and directions to bases, who is next to whom."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array

Index = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Chains:
    """All nucleotides as backbone sites and directions to bases; arrays over N of them.

    Attributes
    ----------
    sites, direction : (N, 3) array
        Backbone sites and unit vectors from there to the bases; changed in place.
    placed : (N,) array of bool
        Which of them mean something.
    n3, n5 : (N,) array of int
        Neighbours, −1 for none.
    strand : (N,) array of int
        Which single strand a nucleotide is laid in, −1 for none.
    order : (n,) array of int
        The nucleotides that are laid, strand by strand from 5' to 3'.
    tangent : (N, 3) array
        Of helices at their ends; zero for other nucleotides.
    bond : (N,) array
        Length of the bonds of the nucleotide's strand.
    cores : (p, 3) array
        Middles of base pairs, on the axes of helices.
    box : (3,) array
        Sides of the periodic box; 0 where there is none.
    """

    sites: Array
    direction: Array
    placed: NDArray[np.bool_]
    n3: Index
    n5: Index
    strand: Index
    order: Index
    tangent: Array
    bond: Array
    cores: Array
    box: Array
