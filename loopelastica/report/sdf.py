"""The built loop by itself, with bond orders and charges."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path

from loopelastica._files import write_text
from loopelastica.atoms.model import AtomModel


def write_sdf(path: Path, models: Sequence[AtomModel]) -> None:
    """Write the loop's heavy atoms and those of the stem it is bonded to.

    Parameters
    ----------
    path : Path
        The file.
    models : sequence of AtomModel
        A record each.
    """
    from rdkit import Chem
    from rdkit.Geometry import Point3D

    stream = io.StringIO()
    with Chem.SDWriter(stream) as writer:
        for model in models:
            mol = Chem.Mol(model.molecule.mol)
            conformer = Chem.Conformer(mol.GetNumAtoms())
            for row, at in enumerate(model.positions_A.tolist()):
                conformer.SetAtomPosition(row, Point3D(*at))
            mol.AddConformer(conformer)
            mol.SetProp("_Name", f"candidate {model.rank}")
            mol.SetProp("sequence", "".join(r.letter for r in model.molecule.residues))
            mol.SetProp("status", model.relaxed.message)
            names = (
                f"{residue}:{name}"
                for residue, name in zip(model.molecule.residue, model.molecule.names, strict=True)
            )
            mol.SetProp("atoms", " ".join(names))
            writer.write(mol)
    write_text(path, stream.getvalue())
