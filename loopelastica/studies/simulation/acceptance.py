"""One PDB file in OpenMM: are its atoms accepted, how strong is the first force, what moves?

OpenMM is no dependency of the package; the extra `md` brings it.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica.atoms.measures import rigid_fit
from loopelastica.errors import MissingDependencyError
from loopelastica.studies.hands import wrong_hands

KCAL_PER_MOL_A: Final = 1.0 / 41.84
"""What one kJ/mol/nm is in kcal/mol/Å."""
KCAL: Final = 1.0 / 4.184
CHAIN_A: Final = 0.1
"""A bond O3'–P that is off 1.607 Å by more, after minimization, is a broken chain."""
_O3_P_A: Final = 1.607
_MAX_ITERATIONS: Final = 20_000


@dataclass(frozen=True, slots=True)
class ForceField:
    """A force field of OpenMM.

    Attributes
    ----------
    name : str
        As the tables call it.
    files : tuple of str
        That OpenMM reads.
    dna, rna : bool
        What it is asked for.
    """

    name: str
    files: tuple[str, ...]
    dna: bool = True
    rna: bool = True


_AMBER: Final = ("amber14/RNA.OL3.xml", "amber14/DNA.OL15.xml")
FORCE_FIELDS: Final = (
    ForceField("amber", (*_AMBER, "implicit/gbn2.xml")),
    ForceField("amber_vacuum", _AMBER),
    ForceField("charmm36", ("charmm36_2024.xml",), dna=False),
)
"""Amber OL3 and OL15 in GBn2, the same in vacuum, CHARMM36 in vacuum; no cutoff, no constraints."""


def accepted(
    path: Path,
    field: ForceField,
    loop: Collection[tuple[str, str]],
    *,
    hydrogens: bool = False,
    minimize: bool = True,
) -> dict[str, Any]:
    """Hand a file to a force field and minimize what it holds.

    Parameters
    ----------
    path : Path
        PDB file; its first model counts.
    field : ForceField
    loop : collection of (str, str)
        Chain and number of the loop's nucleotides.
    hydrogens : bool
        Let OpenMM's Modeller add them; else the file is taken as it is.
    minimize : bool
        Whether to minimize too.

    Returns
    -------
    dict
        ``refused`` (why, or None), and where it is accepted: atoms, largest first force over heavy
        and over all atoms (kcal/mol/Å) and where, energies (kcal/mol), shifts of heavy atoms by the
        minimization (root mean square, Å): of all as they are, of all and of the loop after
        superposition on the stem; whether hands and chain are kept.

    Raises
    ------
    MissingDependencyError
        If OpenMM is not installed.
    """
    app, openmm = _openmm()
    refusal = _Refusal(field.name)
    read = refusal.of(lambda: app.PDBFile(str(path)))
    if read is None:
        return refusal.row
    forces = app.ForceField(*field.files)
    topology, positions = read.topology, read.getPositions(frame=0)
    if hydrogens:
        modeller = app.Modeller(topology, positions)
        if refusal.of(lambda: modeller.addHydrogens(forces) or True) is None:
            return refusal.row
        topology, positions = modeller.topology, modeller.positions
    system = refusal.of(lambda: forces.createSystem(topology, nonbondedMethod=app.NoCutoff))
    if system is None:
        unmatched = forces.getUnmatchedResidues(topology)
        return {**refusal.row, "unmatched": " ".join(_label(r) for r in unmatched)}
    context = openmm.Context(system, openmm.VerletIntegrator(0.001), *platform())
    context.setPositions(positions)
    atoms = list(topology.atoms())
    heavy = np.array([a.element is not None and a.element.symbol != "H" for a in atoms])
    before, energy, force = _state(context)
    size = np.linalg.norm(force, axis=1)
    most, most_heavy = int(size.argmax()), int(np.where(heavy, size, -1.0).argmax())
    row: dict[str, Any] = {
        "refused": None,
        "atoms": len(atoms),
        "force": float(size[most]),
        "force_at": _atom(atoms[most]),
        "force_heavy": float(size[most_heavy]),
        "force_heavy_at": _atom(atoms[most_heavy]),
        "energy_before": energy,
    }
    if minimize:
        openmm.LocalEnergyMinimizer.minimize(context, maxIterations=_MAX_ITERATIONS)
        after, energy, _ = _state(context)
        own = np.array([(a.residue.chain.id, _number(a.residue)) in loop for a in atoms])
        row |= {"energy_after": energy, **_shifts(before, after, heavy, own)}
        residues = [
            {a.name: after[a.index] for a in residue.atoms()} for residue in topology.residues()
        ]
        first = [
            {a.name: before[a.index] for a in residue.atoms()} for residue in topology.residues()
        ]
        chain = _linked(first)
        row["hands_kept"] = sum(map(wrong_hands, residues)) == 0
        row["chain_kept"] = all(_o3_p(residues, k) <= CHAIN_A for k in chain)
    return row


def platform() -> tuple[Any, dict[str, str]]:
    """The platform and its settings on which every figure is computed: one thread, reproducible."""
    _, openmm = _openmm()
    return openmm.Platform.getPlatformByName("CPU"), {"Threads": "1", "DeterministicForces": "true"}


class _Refusal:
    """The first thing that OpenMM says no to, as a row."""

    def __init__(self, name: str):
        self.name, self.row = name, dict[str, Any]()

    def of(self, call: Callable[[], Any]) -> Any:
        try:
            return call()
        except Exception as error:
            self.row = {"refused": " ".join(str(error).split())[:200]}
            return None


def _openmm() -> tuple[Any, Any]:
    try:
        import openmm
        from openmm import app
    except ImportError:
        raise MissingDependencyError(
            "a simulation needs OpenMM; install it with `pip install 'loopelastica[md]'`"
        ) from None
    return app, openmm


def _state(context: Any) -> tuple[Array, float, Array]:
    """Positions (Å), energy (kcal/mol) and forces (kcal/mol/Å)."""
    state = context.getState(getPositions=True, getEnergy=True, getForces=True)
    return (
        10.0 * np.array(state.getPositions(asNumpy=True)._value),
        float(state.getPotentialEnergy()._value) * KCAL,
        np.array(state.getForces(asNumpy=True)._value) * KCAL_PER_MOL_A,
    )


def _shifts(
    before: Array, after: Array, heavy: NDArray[np.bool_], loop: NDArray[np.bool_]
) -> dict[str, float]:
    stem = heavy & ~loop
    rotation, shift = rigid_fit(after[stem], before[stem])
    laid = after @ rotation.T + shift
    return {
        "shift_A": _rms(after - before, heavy),
        "shift_fitted_A": _rms(laid - before, heavy),
        "shift_loop_A": _rms(laid - before, heavy & loop),
        "shift_loop_unfitted_A": _rms(after - before, heavy & loop),
    }


def _rms(away: Array, rows: NDArray[np.bool_]) -> float:
    return float(np.sqrt((away[rows] ** 2).sum(axis=1).mean()))


def _linked(residues: list[dict[str, Array]]) -> list[int]:
    """Residues whose O3' is bonded to the P of the next one."""
    return [k for k in range(len(residues) - 1) if _o3_p(residues, k) < 1.0]


def _o3_p(residues: list[dict[str, Array]], k: int) -> float:
    one, other = residues[k].get("O3'"), residues[k + 1].get("P")
    if one is None or other is None:
        return float("inf")
    return abs(float(np.linalg.norm(one - other)) - _O3_P_A)


def _number(residue: Any) -> str:
    return f"{residue.id}{residue.insertionCode}".strip()


def _label(residue: Any) -> str:
    return f"{residue.chain.id}.{residue.name}{_number(residue)}"


def _atom(atom: Any) -> str:
    return f"{_label(atom.residue)} {atom.name}"
