"""What is wrong with a scadnano design, each in one sentence that names strand, helix and offset.

The package says where a strand fails by printing the whole of it, and some faults it does not see.
So its JSON is looked through before the package reads it.
"""

from __future__ import annotations

import itertools
import re
from collections import defaultdict
from typing import Any

from loopelastica._checks import shown
from loopelastica._names import printable
from loopelastica.errors import StructureError

# what has one of these is no domain, whatever else it has
_SINGLE = {"loopout": "loopout", "extension_num_bases": "extension"}

_VERSION = re.compile(r"(\d{1,6})\.(\d{1,6})(\.\d{1,6})?([-+][\w.+-]*)?")


def check_version(where: str, version: Any, known: str) -> None:
    """StructureError for a version after the installed one, or one that is none."""
    if version is None:  # the package's first designs had none
        return
    match = _VERSION.fullmatch(version) if isinstance(version, str) else None
    if match is None:
        raise StructureError(
            f"{where}: the version is {shown(version)}, which is none of scadnano; the design"
            " cannot be understood"
        )
    newest = tuple(map(int, known.split(".")[:2]))
    if tuple(map(int, match.group(1, 2))) > newest:
        raise StructureError(
            f"{where}: the version is {shown(version)}, unknown to the installed scadnano {known};"
            " a newer scadnano may know it"
        )


def listed(where: str, content: dict[str, Any], key: str) -> list[Any]:
    """The helices or the strands of a design: one or more objects."""
    found = content.get(key)
    if not isinstance(found, list) or not found:
        raise StructureError(f"{where}: the design has no {key}, so there is nothing to place")
    for index, item in enumerate(found):
        if not isinstance(item, dict):
            raise StructureError(
                f"{where}: {key}[{index}] is {shown(item)}; it must be an object with fields"
            )
    return found


def check_positions(where: str, content: dict[str, Any], helices: list[Any]) -> None:
    """Without a grid each helix must say where it is; the package would put them in a row."""
    groups = content.get("groups")
    for place, helix in enumerate(helices):
        name = helix.get("group", "default_group")
        group: Any = content
        if isinstance(groups, dict):
            group = groups.get(name) if isinstance(name, str) else None
        if not isinstance(group, dict):
            continue  # the package says that there is no such group
        if (
            group.get("grid", "none") == "none"
            and helix.get("position", helix.get("origin")) is None
        ):
            raise StructureError(
                f"{where}: the grid is none and helix {helix.get('idx', place)} has no position,"
                " so it has no place in space; give each helix a position, or the design a grid"
            )


def title_of(index: int, strand: dict[str, Any]) -> str:
    """What sentences call a strand before it is read: its place in the JSON, and its name."""
    name = strand.get("name")
    own = f" ({printable(name)[:60]})" if isinstance(name, str) else ""
    return f"strands[{index}]{own}"


def check_parts(title: str, strand: dict[str, Any]) -> None:
    """StructureError unless a strand's domains, loopouts and extensions are sound and in order."""
    parts = parts_of(strand)
    if not isinstance(parts, list) or not parts:
        raise StructureError(f"{title} has no domains, so it has no nucleotide")
    kinds = [_check_part(f"{title}, domains[{i}]", part) for i, part in enumerate(parts)]
    if "domain" not in kinds:
        raise StructureError(f"{title} has no domain on a helix, so it has no place in space")
    ring = strand.get("circular")
    if not (ring is None or isinstance(ring, bool)):
        raise StructureError(f"{title}: circular is {shown(ring)}; it must be true or false")
    for end, kind in (("5'", kinds[0]), ("3'", kinds[-1])):
        if kind == "loopout":
            remedy = (
                "so list the parts of this circular strand from a domain on"
                if ring
                else "and a single strand at an end is an extension"
            )
            raise StructureError(
                f"{title} has a loopout at its {end} end; a loopout joins two domains, {remedy}"
            )
    for i, pair in enumerate(itertools.pairwise(kinds)):
        if pair == ("loopout", "loopout"):
            raise StructureError(
                f"{title} has two loopouts in a row, domains[{i}] and domains[{i + 1}]; a loopout"
                " joins two domains"
            )


def _check_part(title: str, part: Any) -> str:
    """Kind of a domain; StructureError where a number of it is none."""
    if not isinstance(part, dict):
        raise StructureError(f"{title} is {shown(part)}; it must be an object with fields")
    key = _single_key(part)
    if key is not None:
        if not _is_whole(part[key]) or part[key] < 1:
            raise StructureError(
                f"{title}: {key} is {shown(part[key])}; it must be a whole number, 1 or more and"
                " below 10⁹"
            )
        return _SINGLE[key]
    for key in ("helix", "start", "end"):
        if not _is_whole(part.get(key)):
            raise StructureError(
                f"{title}: {key} is {shown(part.get(key))}; it must be a whole number below 10⁹"
            )
    forward = _forward(part)
    if not isinstance(forward, bool):
        raise StructureError(f"{title}: forward is {shown(forward)}; it must be true or false")
    if part["start"] >= part["end"]:
        raise StructureError(
            f"{title} on helix {part['helix']} begins at offset {part['start']} and ends before"
            f" offset {part['end']}, so it has no base"
        )
    deletions, insertions = part.get("deletions", []), part.get("insertions", [])
    if not (isinstance(deletions, list) and all(map(_is_whole, deletions))):
        raise StructureError(f"{title}: deletions are {shown(deletions)}; they must be offsets")
    if not (isinstance(insertions, list) and all(map(_is_insertion, insertions))):
        raise StructureError(
            f"{title}: insertions are {shown(insertions)}; they must be pairs of an offset and a"
            " number, 1 or more"
        )
    changed = [*deletions, *(offset for offset, _ in insertions)]
    for offset in changed:
        if not part["start"] <= offset < part["end"]:
            raise StructureError(
                f"{title}: the insertion or deletion at offset {offset} is outside of the domain,"
                f" which has offsets {part['start']} to {part['end'] - 1} of helix {part['helix']}"
            )
    if len(set(changed)) < len(changed):
        raise StructureError(
            f"{title} on helix {part['helix']} has two insertions or deletions at one offset"
        )
    return "domain"


def _is_whole(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and abs(value) < 10**9


def _is_insertion(value: Any) -> bool:
    pair = isinstance(value, list) and len(value) == 2 and all(map(_is_whole, value))
    return pair and value[1] >= 1


def check_domains(where: str, strands: dict[str, dict[str, Any]], helices: dict[int, Any]) -> None:
    """StructureError unless all domains have room on their helices.

    Parameters
    ----------
    where : str
        What sentences call the file.
    strands : dict
        What sentences call each strand, and its JSON, whose parts are sound.
    helices : dict of scadnano.Helix
        By their numbers.
    """
    lanes: dict[tuple[int, bool], list[tuple[int, int, str]]] = defaultdict(list)
    for title, strand in strands.items():
        for part in parts_of(strand):
            if _single_key(part) is not None:
                continue
            index, start, end = part["helix"], part["start"], part["end"]
            domain = (
                f"{where}: {title} has a domain at offsets {start} to {end - 1} of helix {index}"
            )
            if index not in helices:
                raise StructureError(f"{domain}, which the design does not have")
            least, most = helices[index].min_offset, helices[index].max_offset
            if not (_is_whole(least) and (most is None or _is_whole(most))):
                raise StructureError(
                    f"{where}: helix {index} has offsets from {shown(least)} to before"
                    f" {shown(most)}; they must be whole numbers below 10⁹"
                )
            if start < least or (most is not None and end > most):
                room = f"{least} and above" if most is None else f"{least} to {most - 1}"
                raise StructureError(f"{domain}, which has offsets {room}")
            lanes[index, _forward(part)].append((start, end, title))
    for (index, forward), lane in lanes.items():
        for (_, end, title), (start, _, other) in itertools.pairwise(sorted(lane)):
            if start < end:
                raise StructureError(
                    f"{where}: {title} and {other} overlap on helix {index} at offset"
                    f" {start}, both {'forward' if forward else 'reverse'}; two strands cannot be"
                    " in one place"
                )


def parts_of(strand: dict[str, Any]) -> Any:
    """Domains, loopouts and extensions of a strand, by either name that scadnano had for them."""
    return strand.get("domains", strand.get("substrands"))


def _single_key(part: dict[str, Any]) -> str | None:
    """What makes a part a loopout or an extension; None for a domain."""
    return next((key for key in _SINGLE if key in part), None)


def _forward(part: dict[str, Any]) -> Any:
    return part.get("forward", part.get("right"))
