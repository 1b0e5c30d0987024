"""What is a design: a file of scadnano, or two of oxDNA; and the designs of a folder."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from typing import Any, Final, NamedTuple

from loopelastica._checks import file_name, shown
from loopelastica._files import read_manifest
from loopelastica.errors import StructureError
from loopelastica.molecule._source import kind_of, name_of
from loopelastica.molecule.folders import distinct
from loopelastica.nanostructures.design import Design
from loopelastica.nanostructures.options import NanostructureOptions
from loopelastica.nanostructures.oxdna.files import (
    CONFIGURATIONS,
    TOPOLOGY,
    OxdnaFiles,
    find_files,
    read_oxdna,
    uncompressed,
)
from loopelastica.nanostructures.oxdna.pairing import are_bases_given
from loopelastica.nanostructures.scadnano.reading import read_design
from loopelastica.nanostructures.system import System

DESIGN: Final = ".sc"
_OXDNA: Final = (TOPOLOGY, *CONFIGURATIONS)


class Input(NamedTuple):
    """What was read.

    Attributes
    ----------
    system : System
        The nucleotides.
    design : Design or None
        Where the system is from, if from scadnano.
    files : OxdnaFiles or None
        Where it is from, if from oxDNA.
    paths : tuple of Path
        The files.
    notes : tuple of str
        Sentences.
    """

    system: System
    design: Design | None
    files: OxdnaFiles | None
    paths: tuple[Path, ...]
    notes: tuple[str, ...]


def read_input(path: Any, options: NanostructureOptions) -> Input:
    """Read a design of scadnano or a pair of oxDNA files, which its name tells.

    Parameters
    ----------
    path : path-like
        The design, or one of the two files.
    options : NanostructureOptions
        `other`, `pairs` and `seed` of them.

    Returns
    -------
    Input

    Raises
    ------
    StructureError
        If a file cannot be used; one sentence that names it.
    """
    place = Path(file_name("path", path))
    kind = kind_of(place)
    if not (kind in _OXDNA or place.exists()):  # of a pair either file may be missing
        raise StructureError(f"{name_of(place)}: there is no such file")
    if place.is_dir():
        raise StructureError(f"{name_of(place)}: {_folder(place)}")
    if kind not in (DESIGN, *_OXDNA):
        raise StructureError(
            f"{name_of(place)}: the name ends in {kind!r}; a design of scadnano ({DESIGN}) or a"
            f" file of oxDNA ({', '.join(_OXDNA)}) is needed"
        )
    if kind == DESIGN:
        if options.other is not None:
            raise ValueError(
                f"`other` is {shown(options.other)}, but {name_of(place)} is a design of scadnano,"
                " which is one file"
            )
        design = read_design(place, options.seed, fit=options.helices == "fitted")
        return Input(design.system, design, None, (place,), design.notes)
    if options.helices == "fitted":
        raise ValueError(
            f"`helices` is 'fitted', but {name_of(place)} is of oxDNA, whose paired nucleotides"
            " stay where they are"
        )
    files = read_oxdna(path, options.other, any_bases=options.pairs == "geometry")
    paths = (files.topology, files.configuration)
    return Input(files.system, None, files, paths, tuple(_notes(files, options)))


def _folder(place: Path) -> str:
    if _files_of(str(place)) == [str(place)]:
        return (
            f"this folder has no design of scadnano ({DESIGN}) and no topology of oxDNA"
            f" ({TOPOLOGY}) but what this program has written"
        )
    return "this is a folder; one of the designs in it is needed"


def _notes(files: OxdnaFiles, options: NanostructureOptions) -> Iterator[str]:
    if files.n_frames > 1:
        name = name_of(files.configuration)
        yield f"{name} has {files.n_frames} frames; frame {files.frame} was read"
    by_energy = options.pairs == "energy"
    given = are_bases_given(files.system.base)
    if (files.system.pair < 0).all():
        remedy = "; the option pairs=geometry would take any bases" if by_energy and given else ""
        yield f"no base pair was found, so every nucleotide stays where it is{remedy}"
    elif by_energy and not given:
        yield (
            "no two bases of the file are complementary, as in exports without sequences, so its"
            " pairs were found by geometry"
        )


def designs_of(sources: Iterable[str]) -> tuple[list[tuple[str, str | None]], list[str]]:
    """Designs among files and folders: each once, files of oxDNA in pairs.

    A topology and a configuration of one folder and stem belong together; so do others that are
    given one after the other. What is left alone has its other file beside it.

    Parameters
    ----------
    sources : iterable of str
        Paths as they were given. Of a folder, its designs and topologies count, but not what this
        program has written.

    Returns
    -------
    designs : list of (str, str or None)
        A file, the topology of a pair first, and the other one where it was given.
    notes : list of str
        One sentence for each that was left out.
    """
    files, notes = distinct(file for source in sources for file in _files_of(source))
    other = _partners(files)
    paired = set(other.values())
    return [(file, other.get(file)) for file in files if file not in paired], notes


def input_paths(design: str, other: str | None) -> list[str]:
    """Absolute paths of the files of a design, those that are found beside it too."""
    given = [design] if other is None else [design, other]
    if other is None and kind_of(Path(design)) != DESIGN:
        with suppress(StructureError):  # reading it says so
            given = list(map(str, find_files(design)))
    return [os.path.abspath(path) for path in given]


def _files_of(source: str) -> Sequence[str]:
    if not os.path.isdir(source):
        return [source]
    written = {
        name
        for path in Path(source).glob("*.json")
        for name in read_manifest(path).get("files", ())
    }
    found = [
        str(path)
        for path in sorted(Path(source).iterdir())
        if kind_of(path) in (DESIGN, TOPOLOGY) and path.is_file() and path.name not in written
    ]
    # an empty one stays: reading it says what it is
    return found or [source]


def _partners(files: Sequence[str]) -> dict[str, str]:
    """Configurations by their topologies, of those that are given."""
    stem = {file: uncompressed(Path(os.path.realpath(file))).with_suffix("") for file in files}
    tops = [file for file in files if kind_of(Path(file)) == TOPOLOGY]
    confs = [file for file in files if kind_of(Path(file)) in CONFIGURATIONS]
    by_stem = {stem[conf]: conf for conf in reversed(confs)}
    other = {top: by_stem[stem[top]] for top in tops if stem[top] in by_stem}
    left = {*tops, *confs} - {*other, *other.values()}
    for one, two in pairwise(files):
        if one in left and two in left and (one in tops) != (two in tops):
            top, conf = (one, two) if one in tops else (two, one)
            other[top] = conf
            left -= {one, two}
    return other
