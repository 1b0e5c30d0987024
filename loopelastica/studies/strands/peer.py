"""The same strands by PDBFixer, judged by the same rules; it is no dependency of the package."""

from __future__ import annotations

import io
import itertools
import time
from typing import Any, Final

import numpy as np

from loopelastica._arrays import Array
from loopelastica.errors import MissingDependencyError
from loopelastica.molecule.nucleotides import BACKBONE
from loopelastica.molecule.polymer import Gap, HeavyAtoms
from loopelastica.molecule.trace import rmsd_A
from loopelastica.studies.hands import wrong_hands

AROUND_A: Final = 12.0
"""How much of the structure it is given around the strand: the whole takes it minutes."""
_SEED: Final = 1


def filled_by_pdbfixer(gap: Gap, atoms: HeavyAtoms) -> dict[str, Any]:
    """Fill a strand with PDBFixer.

    Parameters
    ----------
    gap : Gap
        A strand that is there (`replaces`), as a gap.
    atoms : HeavyAtoms
        What is around, without it.

    Returns
    -------
    dict
        Error, hands, bonds, nearest contact, processor time; or why it failed.

    Raises
    ------
    MissingDependencyError
        If PDBFixer is not installed.
    """
    try:
        from pdbfixer import PDBFixer
    except ImportError:
        raise MissingDependencyError(
            "comparing with PDBFixer needs it; install it with `pip install openmm pdbfixer`"
        ) from None
    text, shown = _cropped(gap, atoms)
    names = [("D" if m.is_dna else "") + m.letter for m in gap.monomers]
    begin = time.process_time()
    try:
        fixer = PDBFixer(pdbfile=io.StringIO(text))
        chain = next(c for c in fixer.topology.chains() if c.id == "A")
        at = 1 + next(k for k, residue in enumerate(chain.residues()) if residue.id == str(shown))
        fixer.missingResidues = {(chain.index, at): names}
        fixer.findMissingAtoms()
        fixer.missingAtoms, fixer.missingTerminals = {}, {}
        fixer.addMissingAtoms(seed=_SEED)
    except Exception as error:
        return {"pdbfixer_failure": repr(error)[:100]}
    spent = time.process_time() - begin
    positions = 10.0 * np.array([[p.x, p.y, p.z] for p in fixer.positions])
    chain = next(c for c in fixer.topology.chains() if c.id == "A")
    built = [
        {atom.name: positions[atom.index] for atom in residue.atoms()}
        for residue in itertools.islice(chain.residues(), at, at + len(names))
    ]
    native = np.array([monomer.backbone_A.mean(axis=0) for monomer in gap.replaces])
    own = np.array([[one[name] for name in BACKBONE] for one in built]).mean(axis=1)
    return {
        "pdbfixer_rmsd_A": rmsd_A(own, native),
        "pdbfixer_wrong_hands": sum(map(wrong_hands, built)),
        "pdbfixer_worst_bond_A": _worst_bond(gap, built),
        "pdbfixer_closest_A": _closest(gap, built, atoms),
        "pdbfixer_s": spent,
    }


def _cropped(gap: Gap, atoms: HeavyAtoms) -> tuple[str, int]:
    """What is near the strand as a PDB file, and the number in it of the nucleotide before it."""
    native = np.concatenate([np.array(list(m.atoms_A.values())) for m in gap.replaces])
    near = np.linalg.norm(atoms.positions_A[:, None] - native[None], axis=2).min(axis=1) < AROUND_A
    own = [atoms.labels.index(m.label) for m in (gap.before, gap.after)]
    kept = set(atoms.residue[near & ~atoms.water].tolist()) | set(own)
    single = np.bincount(atoms.residue, minlength=len(atoms.labels)) == 1
    rest = [r for r in sorted(kept) if r not in own and not single[r]]
    lines: list[str] = []
    # the strand's own neighbours are chain A; everything else is one residue after another in B
    for chain, residues in (("A", own), ("B", rest)):
        for number, residue in enumerate(residues, start=1):
            name = atoms.places[residue][3][:3]
            for row in np.flatnonzero(atoms.residue == residue):
                x, y, z = atoms.positions_A[row]
                lines.append(
                    f"ATOM  {len(lines) % 99999 + 1:5d} {_padded(atoms.name[row]):4s} {name:>3s}"
                    f" {chain}{number:4d}    {x:8.3f}{y:8.3f}{z:8.3f}  1.00  0.00          "
                    f"{atoms.element[row]:>2s}"
                )
        lines.append("TER")
    return "\n".join([*lines, "END", ""]), 1


def _padded(name: str) -> str:
    return name if len(name) > 3 else f" {name}"


def _worst_bond(gap: Gap, built: list[dict[str, Array]]) -> float:
    """Largest deviation of an O3'–P bond from 1.607 Å."""
    chain = [gap.before.atoms_A, *built, gap.after.atoms_A]
    bonds = [
        float(np.linalg.norm(one["O3'"] - other["P"]))
        for one, other in itertools.pairwise(chain)
        if "O3'" in one and "P" in other
    ]
    return max(abs(bond - 1.607) for bond in bonds)


def _closest(gap: Gap, built: list[dict[str, Array]], atoms: HeavyAtoms) -> float:
    """Smallest distance of a built atom from anything it is not bonded to by up to three bonds."""
    flanks = {gap.before.label, gap.after.label}
    far = ~np.isin(atoms.residue, [k for k, lab in enumerate(atoms.labels) if lab in flanks])
    others = atoms.positions_A[far & ~atoms.water]
    points = [np.array([at for name, at in one.items() if name[0] != "H"]) for one in built]
    closest = [float(np.linalg.norm(own[:, None] - others[None], axis=2).min()) for own in points]
    closest += [
        float(np.linalg.norm(one[:, None] - other[None], axis=2).min())
        for k, one in enumerate(points)
        for other in points[k + 2 :]
    ]
    return min(closest)
