"""A built hairpin measured as one molecule, without what built it."""

import numpy as np
from scipy.spatial import cKDTree

from loopelastica.atoms.chemistry import strand_molecule
from loopelastica.atoms.geometry import ideal_geometry, separations
from loopelastica.atoms.measures import angles_deg, bond_lengths


def measured(model):
    """Worst bond (Å) and angle (°), wrong hands, and the nearest atoms not bonded (Å)."""
    atoms = model.atoms
    residues = model.hairpin.sequence.residues
    place = {
        (int(resid) - 1, name): row
        for row, (resid, name) in enumerate(zip(atoms.resids, atoms.names, strict=True))
    }
    names = {k: [name for number, name in place if number == k] for k in range(len(residues))}
    parts = {k: (residue, names[k]) for k, residue in enumerate(residues)}
    molecule = strand_molecule(parts, len(residues))
    x = atoms.positions_A[[place[key] for key in molecule.rows]]
    assert np.isfinite(x).all()
    geometry = ideal_geometry(molecule)
    bond = np.abs(bond_lengths(x, geometry.bonds) - geometry.length_A)
    angle = np.abs(angles_deg(x, geometry.angles) - geometry.angle_deg)
    a, b, c, d = (x[geometry.chiral[:, column]] for column in range(4))
    volume = ((b - a) * np.cross(c - a, d - a)).sum(axis=1)
    apart = separations(molecule)
    near = cKDTree(x).query_pairs(3.5, output_type="ndarray")
    near = near[apart[near[:, 0], near[:, 1]] >= 3]
    closest = np.linalg.norm(x[near[:, 0]] - x[near[:, 1]], axis=1).min()
    return bond.max(), angle.max(), int((volume < 0.5 * geometry.volume_A3).sum()), closest


def between(model, one, name, other, other_name):
    """Distance of two atoms, by the numbers of their nucleotides from 1, Å."""
    atoms = model.atoms
    here, there = (
        atoms.positions_A[(atoms.resids == number) & (np.array(atoms.names) == atom)][0]
        for number, atom in ((one, name), (other, other_name))
    )
    return float(np.linalg.norm(here - there))
