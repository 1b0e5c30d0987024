"""The file of a scadnano design, read by the package `scadnano`.

Strands and helices are given to the package one by one, so that what it refuses has a name.
"""

from __future__ import annotations

import importlib
import json
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any, Final

from loopelastica._names import printable
from loopelastica.errors import MissingDependencyError, StructureError
from loopelastica.molecule._source import Limits, name_of, pieces
from loopelastica.nanostructures.scadnano.checks import (
    check_domains,
    check_parts,
    check_positions,
    check_version,
    listed,
    title_of,
)

MAX_NUCLEOTIDES: Final = 2_000_000
"""Most nucleotides of a design; the largest of origamis have some 10⁵."""

_MODIFICATIONS = ("5prime_modification", "3prime_modification", "internal_modifications")
_LONGEST = 200


@dataclass(frozen=True, slots=True)
class File:
    """What the package made of a file.

    Attributes
    ----------
    name : str
        What sentences call the file.
    design : scadnano.Design
        Helices, groups and geometry; its list of strands is empty.
    strands : list of scadnano.Strand
        In the order of the file, each with a name.
    colours : tuple of str
        "#rrggbb" of each strand.
    notes : list of str
        Sentences on what was ignored.
    """

    name: str
    design: Any
    strands: list[Any]
    colours: tuple[str, ...]
    notes: list[str]


def load(path: Path) -> File:
    """Read a design, or say in one sentence what is wrong with it.

    Raises
    ------
    MissingDependencyError
        If the package scadnano is not installed.
    StructureError
        If the file cannot be read, or is no design that can be placed.
    """
    where = name_of(path)
    package = _package()
    content = _content(path, where)
    check_version(where, content.get("version"), metadata.version("scadnano"))
    helices, strands = (listed(where, content, key) for key in ("helices", "strands"))
    for index, helix in enumerate(helices):
        with _named(f"{where}: helices[{index}]"):
            package.Helix.from_json(helix)
    check_positions(where, content, helices)
    # without strands, since the package would compare their names in pairs, and without
    # modifications, of which it prints
    frame = {key: value for key, value in content.items() if not key.startswith("modifications")}
    with _named(where):
        design = package.Design.from_scadnano_json_map(
            {**frame, "helices": _numbered(helices), "strands": []}
        )
    titled = {title_of(index, strand): strand for index, strand in enumerate(strands)}
    for title, strand in titled.items():
        check_parts(f"{where}: {title}", strand)
    check_domains(where, titled, design.helices)
    read = [_strand(package, f"{where}: {title}", strand) for title, strand in titled.items()]
    count = sum(strand.dna_length() for strand in read)
    if count > MAX_NUCLEOTIDES:
        raise StructureError(
            f"{where}: the design has {count:,} nucleotides, more than the {MAX_NUCLEOTIDES:,} that"
            " are read"
        )
    return File(
        where, design, read, _colours(package, strands, read), _notes(design, strands, read)
    )


def _numbered(helices: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The helices with their numbers, which files leave out where they rise from 0.

    The package has none for them yet where it compares them with `helices_view_order`, and refuses
    what it has written itself.
    """
    if any("idx" in helix for helix in helices):
        return helices
    return [{**helix, "idx": index} for index, helix in enumerate(helices)]


def _package() -> Any:
    try:
        return importlib.import_module("scadnano")
    except ImportError:
        raise MissingDependencyError(
            "designs of scadnano need the package scadnano; install it with"
            " `pip install loopelastica[origami]`"
        ) from None


@contextmanager
def _named(where: str) -> Iterator[None]:
    """What the package refuses, in one sentence."""
    try:
        yield
    # whatever its code stumbles over in a file of others
    except Exception as error:
        # behind its reason the package prints the whole of a strand or of the JSON
        said = re.split(r"\n\s+strand length|\n\nThis occurred", str(error))[0]
        reason = printable(" ".join(said.split())).rstrip(".:") or type(error).__name__
        reason = reason if len(reason) <= _LONGEST else f"{reason[:_LONGEST]}…"
        if not isinstance(error, ValueError):
            reason = f"a field is missing or of another kind than expected: {reason}"
        raise StructureError(f"{where}: scadnano cannot read it ({reason})") from None


def _content(path: Path, where: str) -> dict[str, Any]:
    data = b"".join(pieces(path, Limits()))
    if not data.strip():
        raise StructureError(f"{where}: the file is empty; no design to read")
    try:
        content = json.loads(data.decode("utf-8-sig"), parse_constant=_no_number)
    except UnicodeDecodeError:
        raise StructureError(
            f"{where}: this is no text in UTF-8, as a scadnano design is"
        ) from None
    except (ValueError, RecursionError) as error:
        reason = "too deep" if isinstance(error, RecursionError) else str(error)
        raise StructureError(
            f"{where}: this is no JSON, as a scadnano design is ({reason})"
        ) from None
    if isinstance(content, dict) and "vstrands" in content:
        raise StructureError(
            f"{where}: this is a design of cadnano; scadnano's `Design.from_cadnano_v2` makes a"
            " scadnano design of it"
        )
    if not isinstance(content, dict):
        raise StructureError(
            f"{where}: this is no scadnano design; the JSON has no helices and strands"
        )
    return content


def _no_number(text: str) -> float:
    raise ValueError(f"{text} is no number of JSON")


def _strand(package: Any, title: str, strand: dict[str, Any]) -> Any:
    strand = dict(strand)
    for key in ("sequence", "dna_sequence"):
        if isinstance(strand.get(key), str):
            # the package counts letters without blanks and then takes them with blanks
            strand[key] = "".join(strand[key].split()).upper()
    with _named(title):
        read = package.Strand.from_json(strand)
        # where no name is given, the one by which scadnano exports a strand, such as ST0[31]1[5]
        read.name = printable(str(read.name)) if read.name else read.default_export_name()
    if read.dna_length() < (3 if read.circular else 1):
        raise StructureError(
            f"{title} has {read.dna_length()} nucleotides, too few for a strand"
            + (" that is circular" if read.circular else "")
        )
    return read


def _colours(package: Any, strands: list[Any], read: list[Any]) -> tuple[str, ...]:
    """Colours of the file; strands without one get those that the package would draw."""
    cycle = package.ColorCycler()
    found = []
    for own, strand in zip(strands, read, strict=True):
        given = own.get("color") is not None or strand.is_scaffold
        colour = strand.color if given else next(cycle)
        found.append(f"#{colour.r:02x}{colour.g:02x}{colour.b:02x}")
    return tuple(found)


def _notes(design: Any, strands: list[Any], read: list[Any]) -> list[str]:
    notes = []
    if any(group.grid == "none" for group in design.groups.values()):
        notes.append("there are helices without a grid; they stand where their positions say")
    modified = [
        strand.name
        for own, strand in zip(strands, read, strict=True)
        if any(own.get(key) for key in _MODIFICATIONS)
    ]
    if modified:
        notes.append(
            f"strands with modifications ({len(modified)}, first {modified[0]}): the model has"
            " none, so they are ignored"
        )
    circular = [strand.name for strand in read if strand.circular]
    if circular:
        notes.append(
            f"circular strands ({len(circular)}, first {circular[0]}): their last nucleotide is"
            " bound to their first"
        )
    return notes
