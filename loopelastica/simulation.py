"""A folded loop as restraints in OpenMM, as firm as the error to expect allows."""

from __future__ import annotations

import importlib
from typing import Any, Final

from loopelastica._checks import optional, positive, shown, whole
from loopelastica.errors import MissingDependencyError, StructureError
from loopelastica.folding.result import LoopFold
from loopelastica.molecule.nucleotides import BACKBONE

_K_B: Final = 0.0083144626
"""Boltzmann's constant, kJ/mol/K."""


def restraints(
    loop: Any, topology: Any, *, rank: int | None = None, temperature_K: float = 300.0
) -> Any:
    """Hold the backbone of a loop near one of its candidates, as an OpenMM force.

    The centroid of P, O5', C5', C4', C3', O3' of each loop nucleotide is held to the candidate's
    trace with ½ k d², k = 3 kT/e², where e is the error to expect, ``expected_rmsd_A[1]``. So a
    loop that nothing else holds fluctuates by e about the trace.

    Parameters
    ----------
    loop : LoopFold or HairpinModel
        From :func:`loopelastica.fold` or :func:`loopelastica.build`.
    topology : openmm.app.Topology
        Of the simulation; chains and numbers as in the structure that was folded. It is restrained
        in that structure's coordinates.
    rank : int, optional
        Which candidate; default the first one, of a built hairpin its own.
    temperature_K : float
        Of the simulation.

    Returns
    -------
    openmm.CustomCentroidBondForce
        For ``system.addForce``.

    Raises
    ------
    StructureError
        If the loop was not folded, or a backbone atom is not in the topology.
    ValueError
        If there is no candidate of that rank, or an argument is out of range.
    MissingDependencyError
        If OpenMM is not installed.

    Examples
    --------
    >>> import loopelastica as le
    >>> from openmm.app import PDBFile
    >>> from loopelastica._files import data_path
    >>> path = str(data_path("hairpins/2koc.pdb"))
    >>> (loop,) = le.fold(path, all_models=False, shapes="rod")
    >>> force = restraints(loop, PDBFile(path).topology)
    >>> force.getNumBonds(), force.getBondParameters(0)[1][0] > 0.0
    (4, True)
    """
    try:
        openmm = importlib.import_module("openmm")
    except ImportError:
        raise MissingDependencyError(
            "restraints need OpenMM; install it with `pip install 'loopelastica[md]'`"
        ) from None
    fold = loop if isinstance(loop, LoopFold) else getattr(getattr(loop, "hairpin", 0), "fold", 0)
    if not isinstance(fold, LoopFold):
        raise ValueError(f"`loop` is {shown(loop)}; it must be a folded loop or a built hairpin")
    rank = optional(whole(1))("rank", rank) or (1 if loop is fold else loop.rank)
    temperature_K = positive("temperature_K", temperature_K)
    found = {candidate.rank: candidate for candidate in fold.candidates}
    if not found:
        raise StructureError(fold.failure or "the loop was not folded; it cannot be restrained")
    if rank not in found:
        raise ValueError(f"`rank` is {rank}; the loop has {len(found)} candidates")
    hairpin, candidate = fold.hairpin, found[rank]
    rows = {
        (
            residue.chain.id.strip(),
            f"{residue.id}{residue.insertionCode}".strip(),
            atom.name,
        ): atom.index
        for residue in topology.residues()
        for atom in residue.atoms()
    }
    force = openmm.CustomCentroidBondForce(1, "k/2 * ((x1 - x0)^2 + (y1 - y0)^2 + (z1 - z0)^2)")
    for name in ("k", "x0", "y0", "z0"):
        force.addPerBondParameter(name)
    error_nm = 0.1 * float(candidate.expected_rmsd_A[1])
    stiffness = 3.0 * _K_B * temperature_K / error_nm**2
    for k, place_A in enumerate(candidate.trace):
        number = f"{hairpin.resid[k]}{hairpin.icode[k]}".strip()
        own = [rows.get((hairpin.chain, number, name)) for name in BACKBONE]
        if None in own:
            name = BACKBONE[own.index(None)]
            raise StructureError(
                f"{hairpin.residues[k]}: no atom {name} of that chain and number in the topology;"
                " the loop cannot be restrained"
            )
        group = force.addGroup(own, [1.0] * len(own))
        force.addBond([group], [stiffness, *(0.1 * place_A).tolist()])
    return force
