"""Configurations of oxDNA: where the nucleotides are, in one frame or many.

A frame is three lines, "t = …", "b = …", "E = …", and a line per nucleotide: centre, a1, a3, and
perhaps velocity and angular velocity (docs/source/configurations.md of lorenzo-rovigatti/oxDNA).
Texts in, texts out.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from loopelastica._arrays import Array, Record
from loopelastica._checks import shown
from loopelastica._vectors import dot, perpendicular
from loopelastica.errors import StructureError

_HEADER: Final = 3
_COLUMNS: Final = (9, 15)
_AXES: Final = 9
# Files of the program have six digits and more. What is off by less than 0.6 degrees or 1 % is made
# orthonormal, as the program does; more is no frame of a nucleotide.
_TOLERANCE: Final = 0.01
_NUMBER: Final = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
# beyond this a double cannot tell places in a box apart
_LARGEST: Final = 1e12
# a nucleotide would be its own neighbour
_NARROWEST: Final = 2.0


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Configuration(Record):
    """One frame of a configuration.

    Attributes
    ----------
    header : tuple of str
        Its first three lines, as they are.
    lines : tuple of str
        The line of each nucleotide, as it is.
    box : (3,) array
        Sides of the periodic box.
    centre, a1, a3 : (n, 3) array
        As in :class:`System`.
    frame, n_frames : int
        Which frame of the file this is, from 1, and how many there are.
    """

    header: tuple[str, ...]
    lines: tuple[str, ...]
    box: Array
    centre: Array
    a1: Array
    a3: Array
    frame: int
    n_frames: int


def parse_configuration(name: str, text: str, n: int) -> Configuration:
    """Read the last complete frame of a configuration.

    A simulation that was stopped leaves an incomplete frame: the one before it is read.

    Parameters
    ----------
    name : str
        What sentences call the file.
    text : str
        Its content.
    n : int
        Nucleotides by its topology.

    Returns
    -------
    Configuration

    Raises
    ------
    StructureError
        Where the frame does not fit the topology, or is no configuration.
    """
    lines = text.split("\n")
    starts = [k for k, line in enumerate(lines) if line.startswith("t")]
    if not starts or any(line.strip() for line in lines[: starts[0]]):
        first = next((line for line in lines if line.strip()), "")
        raise StructureError(
            f'{name}: the file begins with {shown(first)} instead of "t = …", so this is no oxDNA'
            " configuration"
        )
    frame = len(starts)
    block = _block(lines, starts, frame)
    if frame > 1 and not _is_complete(block, n):
        frame -= 1
        block = _block(lines, starts, frame)
    offset = starts[frame - 1] + 1
    box = _box(name, block, offset)
    rows = block[_HEADER:]
    if len(rows) != n:
        where = f"frame {frame} of {name}" if len(starts) > 1 else name
        raise StructureError(
            f"{where}: there are lines of {len(rows)} nucleotides, but the topology has {n}"
        )
    values = _values(name, rows, offset + _HEADER)
    a1, a3 = _axes(name, values[:, 3:6], values[:, 6:9])
    return Configuration(
        tuple(block[:_HEADER]), tuple(rows), box, values[:, :3].copy(), a1, a3, frame, len(starts)
    )


def _block(lines: list[str], starts: list[int], frame: int) -> list[str]:
    """Lines of a frame, from 1, without empty ones at its end."""
    block = lines[starts[frame - 1] : starts[frame] if frame < len(starts) else len(lines)]
    while block and not block[-1].strip():
        block.pop()
    return block


def _is_complete(block: list[str], n: int) -> bool:
    rows = block[_HEADER:]
    # more lines than nucleotides is a fault, not an end too early
    return len(rows) > n or (len(rows) == n and len(rows[-1].split()) == len(rows[0].split()))


def _box(name: str, block: list[str], offset: int) -> Array:
    sides = block[1].partition("=") if len(block) >= _HEADER else ("", "", "")
    try:
        box = np.array([float(word) for word in sides[2].split()])
    except ValueError:
        box = np.empty(0)
    # also false for what is no number
    if (
        sides[0].strip() != "b"
        or len(box) != 3
        or not ((box > _NARROWEST) & (box < _LARGEST)).all()
    ):
        line = block[1] if len(block) > 1 else ""
        raise StructureError(
            f'{name}, line {offset + 1}: {shown(line)} is not "b = …" with three sides of a box,'
            f" each above {_NARROWEST:g}"
        )
    if not block[2].startswith("E"):
        raise StructureError(f'{name}, line {offset + 2}: {shown(block[2])} is not "E = …"')
    return box


def _values(name: str, rows: list[str], offset: int) -> Array:
    try:
        values = np.loadtxt(rows, comments=None, ndmin=2)
    except ValueError:
        values = np.empty((0, 0))
    fits = values.shape[0] == len(rows) and values.shape[1] in _COLUMNS
    # also false for what is no number
    if fits and (np.abs(values) < _LARGEST).all():
        return values
    width = len(rows[0].split())
    for k, row in enumerate(rows):
        words = row.split()
        place = f"{name}, line {offset + k}"
        if len(words) not in _COLUMNS or len(words) != width:
            raise StructureError(
                f"{place}: nucleotide {k} has {len(words)} numbers; 9 are needed, or 15 with"
                " velocities, and as many in all lines"
            )
        wrong = next((word for word in words if not _is_number(word)), None)
        if wrong is not None:
            raise StructureError(
                f"{place}: {shown(wrong)} of nucleotide {k} is not a number, or too large a one"
            )
    raise StructureError(f"{name}: the lines of nucleotides cannot be read")


def _is_number(word: str) -> bool:
    return _NUMBER.fullmatch(word) is not None and abs(float(word)) < _LARGEST


def _axes(name: str, a1: Array, a3: Array) -> tuple[Array, Array]:
    norms = np.linalg.norm(a1, axis=1), np.linalg.norm(a3, axis=1)
    lean = dot(a1, a3)
    off = np.max([np.abs(norms[0] - 1), np.abs(norms[1] - 1), np.abs(lean)], axis=0)
    if (off > _TOLERANCE).any():
        k = int(np.argmax(off))
        raise StructureError(
            f"{name}: the axes of nucleotide {k} have lengths {norms[0][k]:.4g} and"
            f" {norms[1][k]:.4g} and the product {lean[k]:.4g}, so they are not two perpendicular"
            " unit vectors"
        )
    a3 = a3 / norms[1][:, None]
    a1 = perpendicular(a1, a3)
    return a1 / np.linalg.norm(a1, axis=1)[:, None], a3


def nucleotide_lines(
    centre: Array, a1: Array, a3: Array, former: Sequence[str] | None = None
) -> list[str]:
    """Lines of nucleotides.

    Parameters
    ----------
    centre, a1, a3 : (n, 3) array
        Where they are.
    former : sequence of str, optional
        Lines that they replace, whose velocities, if any, stay. Default: velocities of zero.

    Returns
    -------
    list of str
    """
    rows = np.concatenate([centre, a1, a3], axis=1).tolist()
    tails = [" 0 0 0 0 0 0"] * len(rows) if former is None else [_tail(line) for line in former]
    return [
        " ".join([f"{x:.12g}" for x in row]) + tail for row, tail in zip(rows, tails, strict=True)
    ]


def _tail(line: str) -> str:
    words = line.split()[_AXES:]
    return (" " + " ".join(words) if words else "") + ("\r" if line.endswith("\r") else "")


def frame_header(box: Array) -> list[str]:
    """The first three lines of a frame of no time and no energy yet."""
    return ["t = 0", "b = " + " ".join(f"{side:.12g}" for side in box.tolist()), "E = 0 0 0"]
