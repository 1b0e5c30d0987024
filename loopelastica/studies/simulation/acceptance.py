"""One PDB file in OpenMM: whether it is accepted, its first force, and what minimization moves.

OpenMM is no dependency of the package; the extra `md` brings it.
"""

from __future__ import annotations

import importlib
import itertools
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica.atoms.measures import rigid_fit
from loopelastica.errors import MissingDependencyError
from loopelastica.studies.hands import wrong_hands

_KCAL: Final = 1.0 / 4.184
_KCAL_A: Final = 1.0 / 41.84
"""What one kJ/mol/nm is in kcal/mol/Å."""
_O3_P_A: Final = 1.607
_BROKEN_A: Final = 0.2
"""A bond O3'–P that is off by more is a broken chain; minimized ones are off by 0.02 Å."""
_MOST_STEPS: Final = 250
"""Of a minimization: those that were let go on moved their atoms by 0.01 Å more."""


@dataclass(frozen=True, slots=True)
class ForceField:
    """A force field of OpenMM, and what is asked of it.

    Attributes
    ----------
    name : str
        As the tables call it.
    files : tuple of str
        That OpenMM reads.
    kinds : tuple of str
        "RNA" and "DNA", what it is asked for.
    minimized : bool
        Whether models are minimized in it; else the first force is all.
    """

    name: str
    files: tuple[str, ...]
    kinds: tuple[str, ...] = ("RNA", "DNA")
    minimized: bool = False


_AMBER: Final = ("amber14/RNA.OL3.xml", "amber14/DNA.OL15.xml")
FORCE_FIELDS: Final = (
    ForceField("Amber OL3/OL15, GBn2", (*_AMBER, "implicit/gbn2.xml"), minimized=True),
    ForceField("Amber OL3/OL15, vacuum", _AMBER),
    # charmm36.xml of OpenMM has no templates for chains of RNA, nor for their ends
    ForceField("CHARMM36 (2024), vacuum", ("charmm36_2024.xml",), ("RNA",)),
)


def accepted(path: Path, field: ForceField, loop: Collection[tuple[str, str]]) -> dict[str, Any]:
    """Hand a file to a force field, without cutoff or constraints, and minimize what it holds.

    Parameters
    ----------
    path : Path
        PDB file, taken as it is; its first model counts.
    field : ForceField
    loop : collection of (str, str)
        Chain and number of the loop's nucleotides.

    Returns
    -------
    dict
        ``refused`` says why, or is None; then there are ``atoms``, ``force`` and ``force_heavy``,
        the largest first force over all and over heavy atoms (kcal/mol/Å), and where;
        ``force_loop``, that on atoms of the loop; ``energy_before`` (kcal/mol). Where it is
        minimized there are ``energy_after`` and root mean square shifts of heavy atoms (Å):
        ``shift_A`` of all, ``shift_loop_A`` of the loop's, ``shift_on_stem_A`` and
        ``shift_loop_on_stem_A`` the same after superposition on the stem; ``wrong_hands`` and
        ``chain_kept`` afterwards.

    Raises
    ------
    MissingDependencyError
        If OpenMM is not installed.
    """
    openmm, app = modules()
    forces = _force_field(field.files)
    try:
        with path.open(encoding="utf-8") as stream:
            read = app.PDBFile(stream)
        system = forces.createSystem(read.topology, nonbondedMethod=app.NoCutoff)
    except Exception as error:  # OpenMM raises whatever its readers meet
        return {"refused": _sentence(error)}
    context = openmm.Context(system, openmm.VerletIntegrator(0.001), *platform())
    context.setPositions(read.getPositions(frame=0))
    atoms = list(read.topology.atoms())
    heavy = np.array([atom.element is not None and atom.element.symbol != "H" for atom in atoms])
    own = np.array([_place(atom.residue) in loop for atom in atoms])
    before, energy, force = _state(context)
    if not np.isfinite(force).all():
        return {"refused": "its energy is infinite: atoms lie on one another"}
    most, most_heavy = int(force.argmax()), int(np.where(heavy, force, -1.0).argmax())
    row: dict[str, Any] = {
        "refused": None,
        "atoms": len(atoms),
        "force": float(force[most]),
        "force_at": _label(atoms[most]),
        "force_heavy": float(force[most_heavy]),
        "force_heavy_at": _label(atoms[most_heavy]),
        "force_loop": float(force[own].max(initial=0.0)),
        "energy_before": energy,
    }
    if not field.minimized:
        return row
    openmm.LocalEnergyMinimizer.minimize(context, maxIterations=_MOST_STEPS)
    after, energy, _ = _state(context)
    return {
        **row,
        "energy_after": energy,
        **_shifts(before, after, heavy & ~own, heavy & own),
        "wrong_hands": sum(map(wrong_hands, _residues(read.topology, after))),
        "chain_kept": bool(
            set(_breaks(read.topology, after)) <= set(_breaks(read.topology, before))
        ),
    }


def modules() -> tuple[Any, Any]:
    """``openmm`` and ``openmm.app``.

    Raises
    ------
    MissingDependencyError
        If OpenMM is not installed.
    """
    try:
        return importlib.import_module("openmm"), importlib.import_module("openmm.app")
    except ImportError:
        raise MissingDependencyError(
            "a simulation needs OpenMM; install it with `pip install 'loopelastica[md]'`"
        ) from None


def platform() -> tuple[Any, Mapping[str, str]]:
    """Where all is computed: processors, one thread, forces summed in one order."""
    openmm, _ = modules()
    settings = {"Threads": "1", "DeterministicForces": "true"}
    return openmm.Platform.getPlatformByName("CPU"), settings


@cache
def _force_field(files: tuple[str, ...]) -> Any:
    """CHARMM36 takes ten seconds to read."""
    return modules()[1].ForceField(*files)


def _state(context: Any) -> tuple[Array, float, Array]:
    """Positions (Å), energy (kcal/mol) and sizes of the forces (kcal/mol/Å)."""
    state = context.getState(positions=True, energy=True, forces=True)
    forces = np.array(state.getForces(asNumpy=True)._value)
    return (
        10.0 * np.array(state.getPositions(asNumpy=True)._value),
        float(state.getPotentialEnergy()._value) * _KCAL,
        np.linalg.norm(forces, axis=1) * _KCAL_A,
    )


def _shifts(
    before: Array, after: Array, stem: NDArray[np.bool_], loop: NDArray[np.bool_]
) -> dict[str, float]:
    rotation, shift = rigid_fit(after[stem], before[stem])
    laid = after @ rotation.T + shift

    def rms(away: Array) -> float:
        return float(np.sqrt((away**2).sum(axis=1).mean()))

    return {
        "shift_A": rms((after - before)[stem | loop]),
        "shift_loop_A": rms((after - before)[loop]),
        "shift_on_stem_A": rms((laid - before)[stem | loop]),
        "shift_loop_on_stem_A": rms((laid - before)[loop]),
    }


def _residues(topology: Any, positions: Array) -> list[dict[str, Array]]:
    return [
        {atom.name: positions[atom.index] for atom in residue.atoms()}
        for residue in topology.residues()
    ]


def _breaks(topology: Any, positions: Array) -> list[int]:
    """First residue of each pair in one chain whose O3' and P are no bond apart."""
    chains = [residue.chain.index for residue in topology.residues()]
    residues = _residues(topology, positions)
    return [
        k
        for k, (one, other) in enumerate(itertools.pairwise(residues))
        if chains[k] == chains[k + 1]
        and "O3'" in one
        and "P" in other
        and abs(np.linalg.norm(one["O3'"] - other["P"]) - _O3_P_A) > _BROKEN_A
    ]


def _sentence(error: Exception) -> str:
    """What OpenMM says, without where to read more."""
    return " ".join(str(error).split()).split(" For more information")[0][:300]


def _place(residue: Any) -> tuple[str, str]:
    return residue.chain.id.strip(), f"{residue.id}{residue.insertionCode}".strip()


def _label(atom: Any) -> str:
    chain, number = _place(atom.residue)
    return f"{chain}.{atom.residue.name}{number} {atom.name}"
