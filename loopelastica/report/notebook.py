"""A folded loop to turn, in a notebook: candidates as tubes on their stem, by nglview."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from loopelastica._arrays import Array
from loopelastica.errors import MissingDependencyError
from loopelastica.folding.result import LoopFold
from loopelastica.molecule.nucleotides import Structure, quiet
from loopelastica.molecule.setting import Setting, Settings
from loopelastica.report.palette import NATIVE, NEIGHBOUR, STEM, colour
from loopelastica.report.scene import names_of, short_shape, smooth_strand, tube, view_of

if TYPE_CHECKING:
    from nglview import NGLWidget

# how near to a candidate's line the structure is shown, Å
_NEAR_A: Final = 25.0
# radii of what is drawn, Å
_FIRST_A: Final = 0.5
_OTHER_A: Final = 0.15
_STRAND_A: Final = 0.4
_BOND_A: Final = 0.08
_POINT_A: Final = 0.9
_TEXT_A: Final = 2.0
_POINTS: Final = 81


def view_fold(
    fold: LoopFold, structure: Structure | None = None, setting: Setting | None = None
) -> NGLWidget:
    """Show the candidates of a loop, their stem and the file's own loop.

    Each candidate is a component of its own, named after rank, shape and expected error; those that
    run into something are hidden at first.

    Parameters
    ----------
    fold : LoopFold
        With at least one candidate.
    structure : Structure, optional
        What the loop was found in; its atoms within 25 Å of the first line are shown.
    setting : Setting, optional
        Stem and neighbours; by default those of the structure. Without both there are lines only.

    Returns
    -------
    nglview.NGLWidget

    Raises
    ------
    ValueError
        If `fold` has no candidates.
    MissingDependencyError
        If nglview is not installed.
    """
    if not fold.candidates:
        raise ValueError(f"`fold` has no candidates to show: {fold.failure}")
    try:
        import nglview
    except ImportError:
        raise MissingDependencyError(
            "nglview is needed to show a loop in a notebook; install loopelastica[notebook]"
        ) from None
    if structure is not None and setting is None:
        setting = Settings(structure).of(fold.hairpin, fold.candidates[0].trace)
    view = nglview.NGLWidget()
    if structure is not None:
        near = nglview.TextStructure(_pdb_text(structure, fold.candidates[0].trace))
        view.add_component(near, default_representation=False, name="structure")
        view[0].add_representation("cartoon", color=NEIGHBOUR, opacity=0.6)
        view[0].add_representation("line", color=STEM)
    for name, shapes, hidden in _components(fold, setting):
        component = view._add_shape(shapes, name=name)
        if hidden:
            component.hide()
    seen = view_of(fold, setting).broadside(fold.candidates[0].trace)
    # the camera's matrix by columns; its lengths are the distance of the eye
    turned = 70.0 * np.column_stack([seen.across, seen.up, seen.towards]).T
    matrix = np.eye(4)
    matrix[:3, :3] = turned
    matrix[3, :3] = -seen.middle_A
    view._set_camera_orientation(matrix.ravel().tolist())
    return view


def _components(
    fold: LoopFold, setting: Setting | None
) -> list[tuple[str, list[tuple[Any, ...]], bool]]:
    """Name, shapes, and whether it is hidden at first."""
    found: list[tuple[str, list[tuple[Any, ...]], bool]] = []
    for candidate in fold.candidates:
        first = candidate.rank == 1
        radius = _FIRST_A if first else _OTHER_A
        line = tube(fold, candidate, setting, _POINTS)
        shapes = _cylinders(line, colour(candidate.rank), radius)
        if first:
            shapes += _spheres(candidate.trace, colour(1), _POINT_A)
        name = f"{candidate.rank} {short_shape(candidate, 32)}"
        name += f", {candidate.expected_rmsd_A[1]:.1f} Å expected"
        found.append((name, shapes, candidate.contacts.touching and not first))
    if fold.backbone_A is not None:
        own = _cylinders(smooth_strand(fold.backbone_A), NATIVE, _OTHER_A)
        own += _spheres(fold.backbone_A[1:-1], NATIVE, 2.0 * _OTHER_A)
        found.append(("file's loop", own, False))
    if setting is not None:
        stem = [
            *_cylinders(smooth_strand(setting.strand_5_A), STEM, _STRAND_A),
            *_cylinders(smooth_strand(setting.strand_3_A), STEM, _STRAND_A),
        ]
        for pair in zip(setting.strand_5_A[::-1], setting.strand_3_A, strict=True):
            stem += _cylinders(np.stack(pair), STEM, _OTHER_A)
        for bond in setting.stem_bonds_A:
            stem += _cylinders(bond, NEIGHBOUR, _BOND_A)
        found.append(("stem", stem, False))
        others = [
            cylinder
            for chain in setting.neighbours
            for cylinder in _cylinders(chain.points_A, NEIGHBOUR, _OTHER_A)
        ]
        if others:
            found.append(("other chains", others, False))
    found.append(("names", _names(fold, setting), False))
    return found


def _names(fold: LoopFold, setting: Setting | None) -> list[tuple[Any, ...]]:
    first, last = tube(fold, fold.candidates[0], setting, 2)
    places = np.concatenate([[first], fold.candidates[0].trace, [last]])
    black = [0.0, 0.0, 0.0]
    return [
        ("text", place, black, _TEXT_A, name)
        for place, name in zip(places.tolist(), names_of(fold, setting), strict=True)
    ]


def _cylinders(points: Array, shade: str, radius: float) -> list[tuple[Any, ...]]:
    points = points[np.isfinite(points).all(axis=1)]
    rgb = _rgb(shade)
    return [
        ("cylinder", a, b, rgb, radius)
        for a, b in zip(points[:-1].tolist(), points[1:].tolist(), strict=True)
    ]


def _spheres(points: Array, shade: str, radius: float) -> list[tuple[Any, ...]]:
    rgb = _rgb(shade)
    return [("sphere", point, rgb, radius) for point in points.tolist()]


def _rgb(shade: str) -> list[float]:
    return [int(shade[k : k + 2], 16) / 255.0 for k in (1, 3, 5)]


def _pdb_text(structure: Structure, points_A: Array) -> str:
    """The residues of a structure near some points, first model, as a PDB file."""
    import MDAnalysis as mda
    from scipy.spatial import KDTree

    positions, atoms = structure.positions(0), structure.universe.atoms
    known = np.asarray(np.isfinite(positions).all(axis=1))
    distance, _ = KDTree(points_A).query(
        np.where(known[:, None], positions, 1e9), distance_upper_bound=_NEAR_A
    )
    near = atoms[np.isfinite(distance)].residues.atoms
    near = near[known[near.indices]]
    with tempfile.TemporaryDirectory() as folder, quiet():
        path = Path(folder) / "near.pdb"
        part = mda.Merge(near)
        part.atoms.positions = positions[near.indices]
        part.atoms.write(str(path), bonds=None)
        return path.read_text(encoding="utf-8")
