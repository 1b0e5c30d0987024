"""The states of one nucleotide on a line: turn Ω about it, χ, and the pucker of its sugar.

Every nucleotide has the same few states: Ω in steps round the circle, C3'-endo or C2'-endo (as the
strands of A-RNA and B-DNA have them), χ at that of the strand, two others that are anti, and syn.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from loopelastica._arrays import Array, read_only
from loopelastica.atoms.carry import Curve
from loopelastica.atoms.fibre import fibre_nucleotide, in_line_frame
from loopelastica.atoms.measures import chi_torsion, torsion_deg
from loopelastica.molecule.nucleotides import RING
from loopelastica.molecule.strands import ideal_strand

OMEGA_STEPS: Final = 24
CHI_CHANGES_DEG: Final = {False: (0.0, -30.0, 30.0), True: (0.0, -25.0, -50.0)}
"""From the strand's own χ, −166° of C3'-endo (False) and −98° of C2'-endo (True) nucleotides."""
SYN: Final = 3
SYN_CHI_DEG: Final = 60.0
_PHOSPHATE: Final = ("P", "OP1", "OP2")


@dataclass(frozen=True, slots=True, eq=False)
class States:
    """Some states of a nucleotide and where their atoms are.

    Attributes
    ----------
    omega_deg : (s,) array
        Ω.
    chi_class : (s,) array of int
        Which of `CHI_CHANGES_DEG`, or `SYN`.
    c2_endo : (s,) array of bool
    names : tuple of str
    atoms : (s, a, 3) array
        Å.
    """

    omega_deg: Array
    chi_class: NDArray[np.int64]
    c2_endo: NDArray[np.bool_]
    names: tuple[str, ...]
    atoms: Array

    def __len__(self) -> int:
        return len(self.omega_deg)

    @property
    def syn(self) -> NDArray[np.bool_]:
        """Which are syn."""
        return np.asarray(self.chi_class == SYN)

    def atom(self, name: str) -> Array:
        """Where one atom is in each state (s, 3)."""
        return self.atoms[:, self.names.index(name)]

    @property
    def ring(self) -> tuple[Array, Array]:
        """Centres (s, 3) and normals (s, 3) of the six-membered ring."""
        return ring_plane(self.atoms[:, [self.names.index(name) for name in RING]])

    def take(self, which: NDArray[np.int64]) -> States:
        """Those at some indices."""
        return States(self.omega_deg[which], self.chi_class[which], self.c2_endo[which],
                      self.names, self.atoms[which])  # fmt: skip


def states_on(letter: str, is_dna: bool, line: Curve, k: int) -> States:
    """All states of nucleotide k on a line.

    Parameters
    ----------
    letter, is_dna
        Parent base and sugar.
    line : Curve
        What it is turned about.
    k : int
        Its number in the strand, from 1.

    Returns
    -------
    States
        192 of them; χ varies fastest, then Ω.
    """
    omega = np.arange(OMEGA_STEPS) * (360.0 / OMEGA_STEPS)
    n_chi = SYN + 1
    turns, chi = np.repeat(omega, n_chi), np.tile(np.arange(n_chi), OMEGA_STEPS)
    point, frame = line.at([float(k)])
    atoms = []
    for c2_endo in (is_dna, not is_dna):
        names, local = _local(letter, is_dna, c2_endo, chi_changes(letter, is_dna, c2_endo))
        atoms.append(_about_line(local[chi], turns) @ frame[0].T + point[0])
    return States(
        np.tile(turns, 2), np.tile(chi, 2), np.repeat([is_dna, not is_dna], len(turns)), names,
        np.concatenate(atoms),
    )  # fmt: skip


def place(
    letter: str,
    is_dna: bool,
    line: Curve,
    k: int,
    omega: float,
    chi: float,
    c2_endo: bool | None = None,
) -> dict[str, Array]:
    """Atoms of one nucleotide without its phosphate.

    Parameters
    ----------
    letter, is_dna
        Parent base and sugar.
    line : Curve
        Where it lies.
    k : int
        Its number in the strand, from 1.
    omega, chi : float
        Ω and change of χ, degrees.
    c2_endo : bool, optional
        Pucker; default that of the strand of its own sugar.

    Returns
    -------
    dict of str to (3,) array
        Å.
    """
    names, local = _local(letter, is_dna, is_dna if c2_endo is None else c2_endo, np.array([chi]))
    point, frame = line.at([float(k)])
    at = _about_line(local[0][None], np.array([omega])) @ frame[0].T + point[0]
    return dict(zip(names, at[0], strict=True))


@lru_cache
def chi_changes(letter: str, is_dna: bool, c2_endo: bool) -> Array:
    """Change of χ of each class, degrees; :data:`SYN` is the last."""
    atoms = fibre_nucleotide(letter, is_dna, c2_endo)
    fibre = torsion_deg(*(atoms[name] for name in chi_torsion(letter)))
    return read_only([*CHI_CHANGES_DEG[c2_endo], SYN_CHI_DEG - fibre])


def ring_plane(rings: Array) -> tuple[Array, Array]:
    """Centres (…, 3) and unit normals (…, 3) of six-membered rings (…, 6, 3)."""
    centre = rings.mean(axis=-2)
    normal = np.cross(rings[..., 0, :] - rings[..., 2, :], rings[..., 1, :] - rings[..., 3, :])
    # a ring whose atoms are one point has no plane, and nothing stacks on it
    size = np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-12)
    return centre, normal / size


def _local(
    letter: str, is_dna: bool, c2_endo: bool, chi_deg: Array
) -> tuple[tuple[str, ...], Array]:
    """Names and places (c, a, 3) in the line's frame for each change of χ, phosphate left out."""
    names, local, c1, n, base = _unturned(letter, is_dna, c2_endo)
    axis = (local[n] - local[c1]) / np.linalg.norm(local[n] - local[c1])
    out = np.repeat(local[None], len(chi_deg), axis=0)
    for row, angle in enumerate(chi_deg):
        turn = Rotation.from_rotvec(np.deg2rad(angle) * axis)
        out[row, base] = turn.apply(local[base] - local[c1]) + local[c1]
    return names, out


@lru_cache
def _unturned(
    letter: str, is_dna: bool, c2_endo: bool
) -> tuple[tuple[str, ...], Array, int, int, list[int]]:
    """Names, places (a, 3), rows of C1' and of the base's atom next to it, and of the base."""
    fibre = fibre_nucleotide(letter, is_dna, c2_endo)
    atoms = {k: v for k, v in fibre.items() if k not in _PHOSPHATE}
    names = tuple(atoms)
    local = in_line_frame(ideal_strand(c2_endo), np.array(list(atoms.values())))
    base = [row for row, name in enumerate(names) if "'" not in name]
    return names, local, names.index("C1'"), names.index(chi_torsion(letter)[2]), base


def _about_line(local: Array, omega_deg: Array) -> Array:
    c, s = np.cos(np.deg2rad(omega_deg))[:, None], np.sin(np.deg2rad(omega_deg))[:, None]
    x, y, z = np.moveaxis(local, -1, 0)
    return np.stack([c * x - s * y, s * x + c * y, z], axis=-1)
