"""Pairs of oxDNA files, a topology and a configuration: read, and written again.

A nucleotide that has not moved keeps its line of the configuration, byte for byte.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array, Record
from loopelastica._checks import file_name, one_of
from loopelastica._files import TakenError, whole_file
from loopelastica.errors import StructureError
from loopelastica.molecule._source import Limits, kind_of, name_of, pieces
from loopelastica.nanostructures.oxdna.configuration import (
    frame_header,
    nucleotide_lines,
    parse_configuration,
)
from loopelastica.nanostructures.oxdna.pairing import are_bases_given, find_pairs
from loopelastica.nanostructures.oxdna.periodic import nearest_image
from loopelastica.nanostructures.oxdna.topology import (
    Form,
    parse_topology,
    topology_text,
    written_order,
)
from loopelastica.nanostructures.system import System

TOPOLOGY: Final = ".top"
CONFIGURATIONS: Final = (".dat", ".oxdna", ".conf")
"""Suffixes of configurations, in the order in which one is looked for beside a topology."""
_MARGIN: Final = 10.0


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class OxdnaFiles(Record):
    """A pair of oxDNA files.

    Attributes
    ----------
    topology, configuration : Path
        The files.
    form : {"old", "new"}
        Of the topology.
    system : System
        The nucleotides with their partners. What is bonded or paired is in one piece: where it
        crosses the periodic box, it is moved by sides of the box.
    image : (n, 3) array of int
        By how many sides each nucleotide was moved.
    topology_text : str
        The topology as it is.
    header, lines : tuple of str
        Lines of the frame that was read, the last complete one, as they are.
    frame, n_frames : int
        Which frame it is, from 1, and how many the configuration has.
    """

    topology: Path
    configuration: Path
    form: Form
    system: System
    image: NDArray[np.int64]
    topology_text: str
    header: tuple[str, ...]
    lines: tuple[str, ...]
    frame: int
    n_frames: int

    def __repr__(self) -> str:
        return f"<OxdnaFiles {self.topology} {self.configuration}: {self.system!r}>"


def read_oxdna(
    path: str | os.PathLike[str],
    other: str | os.PathLike[str] | None = None,
    *,
    any_bases: bool = False,
) -> OxdnaFiles:
    """Read a topology and its configuration, and find the base pairs.

    Of a configuration with several frames the last complete one is read.

    Parameters
    ----------
    path : path-like
        The topology (.top) or the configuration.
    other : path-like, optional
        The other one; default: beside `path`, of the same stem.
    any_bases : bool, optional
        Find pairs by geometry alone: for designs without sequences, whose bases do not fit. Where
        no two bases of the file are complementary, this is done in any case.

    Returns
    -------
    OxdnaFiles

    Raises
    ------
    StructureError
        Where a file is missing or damaged, or the two do not fit; one sentence names what.
    """
    topology, configuration = find_files(path, other)
    said = _text(topology)
    top = parse_topology(name_of(topology), said)
    n = len(top.base)
    conf = parse_configuration(name_of(configuration), _text(configuration), n)
    system = System(
        name=str(path),
        base=top.base,
        strand=top.strand,
        n3=top.n3,
        n5=top.n5,
        pair=np.full(n, -1, dtype=np.int64),
        placed=np.ones(n, dtype=bool),
        centre=conf.centre,
        a1=conf.a1,
        a3=conf.a3,
        label=tuple(f"nucleotide {i}" for i in range(n)),
        strand_name=top.strand_name,
        colour=("",) * len(top.strand_name),
        rna=top.rna,
        box=conf.box,
    )
    by_geometry = any_bases or not are_bases_given(system.base)
    system = replace(system, pair=find_pairs(system, by_geometry))
    image = _images(system)
    system = replace(system, centre=system.centre + image * system.box)
    return OxdnaFiles(
        topology,
        configuration,
        top.form,
        system,
        image,
        said,
        conf.header,
        conf.lines,
        conf.frame,
        conf.n_frames,
    )


def find_files(
    path: str | os.PathLike[str], other: str | os.PathLike[str] | None = None
) -> tuple[Path, Path]:
    """A topology and its configuration, of which one or both are given.

    Parameters
    ----------
    path, other : path-like
        As for :func:`read_oxdna`.

    Returns
    -------
    topology, configuration : Path

    Raises
    ------
    StructureError
        Where the other one is not beside the one that is given, or both are of one kind.
    """
    given = [Path(file_name("path", path))]
    if other is not None:
        given.append(Path(file_name("other", other)))
    topologies = [p for p in given if kind_of(p) == TOPOLOGY]
    rest = [p for p in given if p not in topologies]
    if len(given) == 2 and len(topologies) != 1:
        kind = "topologies" if topologies else "configurations"
        raise StructureError(
            f"{name_of(given[0])} and {name_of(given[1])}: both are {kind} by their names; one must"
            f" end in {TOPOLOGY}"
        )
    if topologies and rest:
        return topologies[0], rest[0]
    (one,) = given
    suffixes = CONFIGURATIONS if topologies else (TOPOLOGY,)
    beside = [uncompressed(one).with_suffix(suffix) for suffix in suffixes]
    packed = [p.with_name(f"{p.name}.gz") for p in beside]
    found = next((p for p in (*beside, *packed) if p.exists()), None)
    if found is None:
        raise StructureError(
            f"{name_of(one)}: there is no {' or '.join(p.name for p in beside)} beside it; name the"
            f" {'configuration' if topologies else 'topology'} too"
        )
    return (one, found) if topologies else (found, one)


def uncompressed(path: Path) -> Path:
    """A path without the suffix of a compression."""
    return path.with_suffix("") if kind_of(path) != path.suffix.lower() else path


def _text(path: Path) -> str:
    try:
        text = b"".join(pieces(path, Limits())).decode("utf-8-sig")
    except UnicodeDecodeError:
        text = "\0"
    if "\0" in text:
        raise StructureError(f"{name_of(path)}: this is no text, so no file of oxDNA")
    if not text.strip():
        raise StructureError(f"{name_of(path)}: the file is empty")
    return text


def _images(system: System) -> NDArray[np.int64]:
    """Sides of the box (n, 3) that bring together what is bonded or paired."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import breadth_first_order, connected_components

    n = len(system)
    i = np.concatenate([np.flatnonzero(system.n3 >= 0), np.flatnonzero(system.pair >= 0)])
    j = np.concatenate([system.n3[system.n3 >= 0], system.pair[system.pair >= 0]])
    step = system.centre[j] - system.centre[i]
    image = np.zeros((n, 3), dtype=np.int64)
    if (np.abs(step - nearest_image(step, system.box)) < 0.5 * system.box).all():
        return image
    links = coo_array((np.ones(len(i)), (i, j)), shape=(n + 1, n + 1)).tocsr()
    _, part = connected_components(links[:n, :n], directed=False)
    # one more node is linked to the first nucleotide of each part: one tree holds them all
    roots = np.unique(part, return_index=True)[1]
    ends = np.concatenate([i, np.full(len(roots), n)]), np.concatenate([j, roots])
    links = coo_array((np.ones(len(ends[0])), ends), shape=(n + 1, n + 1)).tocsr()
    order, before = breadth_first_order(links, n, directed=False)
    inner = order[(order != n) & (before[order] != n)]
    step = system.centre[inner] - system.centre[before[inner]]
    shift = -np.round(step / system.box).astype(np.int64)
    for k, former, by in zip(inner.tolist(), before[inner].tolist(), shift, strict=True):
        image[k] = image[former] + by
    return image


def write_oxdna(
    system: System,
    topology: Path,
    configuration: Path,
    *,
    form: Form = "old",
    files: OxdnaFiles | None = None,
) -> None:
    """Write a system as a pair of oxDNA files, both whole or none of them.

    Parameters
    ----------
    system : System
        Nucleotides that all have a place.
    topology, configuration : Path
        Where to.
    form, files
        As for :func:`oxdna_texts`.

    Raises
    ------
    ValueError, StructureError
        As :func:`oxdna_texts` does.
    OutputError
        If a file cannot be written, or is one of `files`.
    """
    texts = oxdna_texts(system, form, files)
    for path in (topology, configuration):
        refuse_input(path, () if files is None else (files.topology, files.configuration))
        if path.is_dir():
            raise TakenError(
                errno.EISDIR, "this is a folder, so no file is written there", str(path)
            )
    with whole_file(topology) as one, whole_file(configuration) as other:
        for path, text in zip((one, other), texts, strict=True):
            path.write_text(text, encoding="utf-8", newline="\n")


def oxdna_texts(
    system: System, form: Form = "old", files: OxdnaFiles | None = None
) -> tuple[str, str]:
    """The content of a topology and of a configuration.

    Parameters
    ----------
    system : System
        Nucleotides that all have a place.
    form : {"old", "new"}, optional
        Of the topology. The new one lists each strand from 5' to 3', the old one from 3' to 5', and
        so does the configuration.
    files : OxdnaFiles, optional
        Where the system is from. A nucleotide at the same place keeps its line to the byte, one
        that has moved its velocities; a topology of the same form is copied, whatever its order.

    Returns
    -------
    topology, configuration : str

    Raises
    ------
    ValueError
        If a nucleotide has no place, or no finite one.
    StructureError
        If the form cannot say what the system is.
    """
    one_of("old", "new")("form", form)
    lost = ~(system.placed & np.isfinite(_rows(system)).all(axis=1))
    if lost.any():
        label = system.label[int(np.argmax(lost))]
        raise ValueError(f"`system`: {label} has no place, so no configuration can be written")
    same_form = files is not None and files.form == form
    text = files.topology_text if files and same_form else topology_text(system, form)
    order = line_order(system, form, files)
    header, lines = _frame(system, files)
    return text, "\n".join([*header, *(lines[i] for i in order.tolist()), ""])


def line_order(system: System, form: Form, files: OxdnaFiles | None = None) -> NDArray[np.int64]:
    """Nucleotides (n,) in the order of the lines that :func:`oxdna_texts` makes of them."""
    same_form = files is not None and files.form == form
    return np.arange(len(system)) if same_form else written_order(system, form)


def _frame(system: System, files: OxdnaFiles | None) -> tuple[list[str], list[str]]:
    if files is None:
        box = system.box if (system.box > 0).all() else box_of(system)
        return frame_header(box), nucleotide_lines(system.centre, system.a1, system.a3)
    header, lines = list(files.header), list(files.lines)
    moved = np.flatnonzero((_rows(system) != _rows(files.system)).any(axis=1))
    if len(moved):
        centre = system.centre[moved] - files.image[moved] * files.system.box
        new = nucleotide_lines(
            centre, system.a1[moved], system.a3[moved], [lines[i] for i in moved.tolist()]
        )
        for i, line in zip(moved.tolist(), new, strict=True):
            lines[i] = line
        # the energy was that of the former places
        header[2] = "E = 0 0 0" + ("\r" if header[2].endswith("\r") else "")
    return header, lines


def _rows(system: System) -> Array:
    return np.concatenate([system.centre, system.a1, system.a3], axis=1)


def box_of(system: System) -> Array:
    """Sides (3,) of a cubic box that holds a system with room around it, oxDNA's units.

    No two periodic images come as near as interactions reach, however the system turns.
    """
    if not len(system):
        return np.full(3, 2 * _MARGIN)
    extent = float(np.linalg.norm(np.ptp(system.centre, axis=0)))
    return np.full(3, np.ceil(extent + 2 * _MARGIN))


def refuse_input(path: Path, inputs: Iterable[Path]) -> None:
    """TakenError where a path is one of the files that were read."""
    for source in inputs:
        if path.exists() and source.exists() and path.samefile(source):
            sentence = "this is the input, which is not written over"
            raise TakenError(errno.EEXIST, sentence, str(path))
