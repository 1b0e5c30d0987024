"""Strands of another structure as templates: their shape, and the atoms that travel with it.

A template of n nucleotides is a chain of n + 1 steps, from the nucleotide before it to the one
after (:mod:`.shapes`). Deformed onto other ends each nucleotide moves as a rigid body: with its
node, and with the mean turn of the two steps that meet there.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array, Record, read_only
from loopelastica.errors import StructureError
from loopelastica.molecule._topology import ATOM_NAMES
from loopelastica.molecule.clamp_rule import plain_clamp
from loopelastica.molecule.ends import ClosingPoses
from loopelastica.molecule.hairpins import Hairpin
from loopelastica.molecule.nucleotides import Nucleotides, centroids_at, linked
from loopelastica.molecule.polymer import Monomer
from loopelastica.molecule.shapes import LoopShape, loop_shape, shape_between
from loopelastica.molecule.strand_ends import flank_poses


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Template(Record):
    """A strand of another structure.

    Attributes
    ----------
    shape : LoopShape
        From the nucleotide before it to the one after.
    nucleotides : tuple of Monomer
        Its own ones, with their atoms in the frame of the shape's first node, Å; empty where the
        shape was respaced for another number.
    made_from : int
        How many nucleotides the strand has in its own structure.
    """

    shape: LoopShape
    nucleotides: tuple[Monomer, ...]
    made_from: int

    def __len__(self) -> int:
        return len(self.shape)

    @property
    def name(self) -> str:
        """What it is called, such as "like 1zih A.4-A.9"."""
        n = len(self)
        respaced = "" if n == self.made_from else f", {self.made_from} → {counted(n)}"
        return f"like {self.shape.source}{respaced}"

    def __repr__(self) -> str:
        return f"<Template {self.name}: {self.shape.sequence}>"

    def respaced(self, n: int) -> Template:
        """The same line for another number of nucleotides; no atom goes with it.

        A cubic spline over the nodes, counted from one end to the other, is read at n + 2 equal
        parts of the count.
        """
        from scipy.interpolate import CubicSpline

        count = np.arange(len(self) + 2)
        line = CubicSpline(count, self.shape.nodes_A, bc_type="natural")
        steps = np.diff(line(np.linspace(0.0, count[-1], n + 2)), axis=0)
        return Template(replace(self.shape, steps_A=read_only(steps)), (), self.made_from)

    def carried(self, nodes_A: Array, turns: Array, poses: ClosingPoses) -> tuple[Monomer, ...]:
        """Its nucleotides where the deformed chain takes them.

        Parameters
        ----------
        nodes_A : (n + 2, 3) array
            Nodes of the deformed chain in the frame of its start, Å.
        turns : (n + 1, 3, 3) array
            Turn of each step against its rest.
        poses : ClosingPoses
            The ends that it was deformed onto.

        Returns
        -------
        tuple of Monomer
            In the coordinates of those ends; empty where the template has no atoms.
        """
        rest_A = self.shape.nodes_A
        moved = []
        for k, one in enumerate(self.nucleotides, start=1):
            turn = _mean_turn(turns[k - 1], turns[k])
            names = list(one.atoms_A)
            local = np.array([one.atoms_A[name] for name in names]) - rest_A[k]
            at = poses.to_file(nodes_A[k] + local @ turn.T)
            moved.append(replace(one, atoms_A=dict(zip(names, at, strict=True))))
        return tuple(moved)


def _mean_turn(a: Array, b: Array) -> Array:
    """The rotation nearest to the mean of two."""
    u, _, vt = np.linalg.svd(a + b)
    return np.asarray(u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ vt)


def hairpin_template(
    nucleotides: Nucleotides, hairpin: Hairpin, positions: Array, file: str
) -> Template:
    """The loop of a hairpin as a template, its ends by the stem.

    Parameters
    ----------
    nucleotides : Nucleotides
        The table the hairpin was found in.
    hairpin : Hairpin
        Which loop.
    positions : (n_atoms, 3) array
        All atoms of one model, Å.
    file : str
        What its structure is called.

    Returns
    -------
    Template

    Raises
    ------
    StructureError
        If backbone atoms are missing, or the stem is no A or B helix.
    """
    ends = int(hairpin.stem_5[0]), int(hairpin.stem_3[0])
    source = _source(nucleotides, *ends, file)
    found = loop_shape(nucleotides, hairpin, positions, source)
    if found is None:
        raise StructureError(f"{hairpin.label}: {_LACKING}")
    shape, stem = found
    clamped = stem.ends(plain_clamp(hairpin.is_dna))
    if not clamped.regular:
        raise StructureError(f"{hairpin.label}: {clamped.misfit}; its loop is no template")
    carried = _carried(nucleotides, hairpin.loop, positions, stem.closing())
    return Template(shape, carried, len(shape))


def strand_template(
    nucleotides: Nucleotides, i: int, j: int, positions: Array, file: str
) -> Template:
    """The strand between two nucleotides of a chain as a template, its ends by these two.

    Parameters
    ----------
    nucleotides : Nucleotides
        Table of a structure.
    i, j : int
        Rows of the nucleotides before and after it.
    positions : (n_atoms, 3) array
        All atoms of one model, Å.
    file : str
        What the structure is called.

    Returns
    -------
    Template

    Raises
    ------
    StructureError
        If backbone atoms are missing.
    """
    rows = np.arange(i, j + 1)
    label = f"{nucleotides.label(i)}–{nucleotides.label(j)}"
    if not (linked(nucleotides, positions)[i:j].all() and j - i > 1):
        raise StructureError(f"{label}: no unbroken strand lies between; there is no template")
    centroids_A = centroids_at(nucleotides, positions, rows[1:-1])
    if not np.isfinite(centroids_A).all():
        raise StructureError(f"{label}: {_LACKING}")
    before, after = (monomer_of(nucleotides, row, positions) for row in (i, j))
    poses = flank_poses(before, after)
    sequence = "".join(nucleotides.letter[rows]).replace("T", "U")
    shape = shape_between(
        centroids_A, poses, sequence, before.is_dna, _source(nucleotides, i, j, file)
    )
    return Template(shape, _carried(nucleotides, rows[1:-1], positions, poses), len(shape))


def monomer_of(nucleotides: Nucleotides, row: int, positions: Array) -> Monomer:
    """A nucleotide of a table with its atoms.

    Parameters
    ----------
    nucleotides : Nucleotides
        The table.
    row : int
        Which nucleotide.
    positions : (n_atoms, 3) array
        All atoms of one model, Å.

    Returns
    -------
    Monomer
    """
    index = nucleotides.atom_index[row]
    atoms_A = {
        name: np.asarray(positions[atom], dtype=np.float64)
        for name, atom in zip(ATOM_NAMES, index, strict=True)
        if atom >= 0 and np.isfinite(positions[atom]).all()
    }
    return Monomer(
        str(nucleotides.chain[row]),
        int(nucleotides.resid[row]),
        str(nucleotides.icode[row]),
        str(nucleotides.resname[row]),
        str(nucleotides.letter[row]),
        bool(nucleotides.is_dna[row]),
        atoms_A=atoms_A,
    )


def counted(*lengths: int) -> str:
    """Numbers of nucleotides.

    >>> counted(1), counted(3, 4)
    ('1 nucleotide', '3, 4 nucleotides')
    """
    return f"{', '.join(map(str, lengths))} nucleotide{'s' * (lengths[-1] != 1)}"


def pair_name(nucleotides: Nucleotides, i: int, j: int) -> str:
    """Two nucleotides as a user writes them, such as "A.4-A.9"."""
    chain = f"{nucleotides.chain[i]}." if nucleotides.chain[i] else ""
    return f"{chain}{nucleotides.number(i)}-{chain}{nucleotides.number(j)}"


_LACKING = "backbone atoms of the loop are missing; it is no template"


def _carried(
    nucleotides: Nucleotides, rows: NDArray[np.int64], positions: Array, poses: ClosingPoses
) -> tuple[Monomer, ...]:
    """Nucleotides with their atoms in the frame of the start."""
    local = (np.asarray(positions, dtype=np.float64) - poses.start_origin_A) @ poses.start_frame
    return tuple(monomer_of(nucleotides, int(row), local) for row in rows)


def _source(nucleotides: Nucleotides, i: int, j: int, file: str) -> str:
    return f"{file} {pair_name(nucleotides, i, j)}"
