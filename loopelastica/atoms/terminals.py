"""Where chains begin and end: bonds along them, and phosphates at their 5' ends.

Templates of force fields begin a chain with HO5'. A phosphate there, as many files have it, is
refused by Amber's (OL3, OL15); CHARMM36 has a patch for one with a hydrogen, which charged ones
lack (tried in OpenMM 8).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from scipy.spatial import cKDTree

from loopelastica.molecule.nucleotides import LINK_MAX_A
from loopelastica.molecule.polymer import Monomer

PHOSPHATE_5: Final = ("P", "OP1", "OP2", "OP3", "HOP2", "HOP3")
"""Atoms that go with a 5' phosphate."""


def chain_bonds(monomers: Sequence[Monomer]) -> list[tuple[bool, bool]]:
    """Whether P of each nucleotide is bonded to an O3' before, and its O3' to a P after it.

    Parameters
    ----------
    monomers : sequence of Monomer
        All of a model, in any order.

    Returns
    -------
    list of (bool, bool)
        O3' and P of two nucleotides are bonded up to 2.5 Å; a chain may be closed.
    """
    ends = {
        name: {
            k: one.atoms_A[name]
            for k, one in enumerate(monomers)
            if name in one.atoms_A and np.isfinite(one.atoms_A[name]).all()
        }
        for name in ("P", "O3'")
    }
    found: dict[str, set[int]] = {"P": set(), "O3'": set()}
    if all(ends.values()):
        rows = {name: list(of) for name, of in ends.items()}
        trees = {name: cKDTree(np.array(list(of.values()))) for name, of in ends.items()}
        for i, near in enumerate(trees["P"].query_ball_tree(trees["O3'"], LINK_MAX_A)):
            p = rows["P"][i]
            for j in near:
                o3 = rows["O3'"][j]
                # its own O3' is no nucleotide before it
                if o3 != p:
                    found["P"].add(p)
                    found["O3'"].add(o3)
    return [(k in found["P"], k in found["O3'"]) for k in range(len(monomers))]


def phosphates_at_5(
    monomers: Sequence[Monomer], bonded: Sequence[tuple[bool, bool]]
) -> tuple[int, ...]:
    """Which nucleotides begin a chain with a phosphate.

    Parameters
    ----------
    monomers : sequence of Monomer
        With their atoms.
    bonded : sequence of (bool, bool)
        As :func:`chain_bonds` has it.

    Returns
    -------
    tuple of int
        Their places in `monomers`.
    """
    return tuple(
        k
        for k, (one, (before, _)) in enumerate(zip(monomers, bonded, strict=True))
        if "P" in one.atoms_A and not before
    )


def phosphate_remark(monomer: Monomer) -> str:
    """What is said of a nucleotide that begins a chain with a phosphate.

    Parameters
    ----------
    monomer : Monomer
        The nucleotide.

    Returns
    -------
    str
    """
    return (
        f"{monomer.label}: its 5' phosphate is refused by Amber's and CHARMM's templates;"
        " --no-5-phosphate takes it off"
    )


def without_phosphate(monomer: Monomer) -> Monomer:
    """A nucleotide without its phosphate; its O5' is free for a hydrogen.

    Parameters
    ----------
    monomer : Monomer
        With or without one.

    Returns
    -------
    Monomer
    """
    left = {name: at for name, at in monomer.atoms_A.items() if name not in PHOSPHATE_5}
    return replace(monomer, atoms_A=left)
