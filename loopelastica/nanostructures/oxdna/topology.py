"""Topologies of oxDNA: the bases of strands and who is next to whom, in both of their forms.

The old form has a line per nucleotide: strand, base, 3' neighbour, 5' neighbour; the new one a line
per strand: its sequence from 5' to 3' and key=value pairs (docs/source/configurations.md,
src/Utilities/TopologyParser.cpp and Utils.cpp there, and DNAInteraction.cpp of
lorenzo-rovigatti/oxDNA). Texts in, texts out.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final, Literal, NoReturn

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Record
from loopelastica._checks import shown
from loopelastica.errors import StructureError
from loopelastica.nanostructures.system import System

Form = Literal["old", "new"]
Index = NDArray[np.int64]

NEW_HEADER: Final = "5->3"
_LETTERS: Final = "ACGTUD"
# the program's numbers of the letters, which the new form may write in parentheses
_NUMBERED: Final = "AGCT"
_TRUE: Final = ("true", "yes", "1")
_FALSE: Final = ("false", "no", "0")


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Topology(Record):
    """What a topology says; the fields are those of :class:`System`.

    Attributes
    ----------
    form : {"old", "new"}
        Which form it has.
    text : str
        The whole of it.
    """

    form: Form
    text: str
    base: NDArray[np.str_]
    strand: Index
    n3: Index
    n5: Index
    strand_name: tuple[str, ...]
    rna: NDArray[np.bool_]


def parse_topology(name: str, text: str) -> Topology:
    """Read a topology of either form.

    Parameters
    ----------
    name : str
        What sentences call the file.
    text : str
        Its content.

    Returns
    -------
    Topology

    Raises
    ------
    StructureError
        Where the program would refuse it, or it holds something else than DNA and RNA.
    """
    lines = text.split("\n")
    head = lines[0].split()
    # two numbers more, of nucleotides and of residues, and one of strands of residues
    if len(head) == 5 and all(re.fullmatch(r"[0-9]+", word) for word in head):
        raise StructureError(
            f"{name}: the first line has five numbers, as in topologies with proteins; only strands"
            " of DNA and RNA can be read"
        )
    sizes = [word for word in head[:2] if re.fullmatch(r"[0-9]{1,9}", word)]
    if len(sizes) < 2 or head[2:] not in ([], [NEW_HEADER]):
        raise StructureError(
            f"{name}: the first line is {shown(lines[0].strip())}, not the numbers of"
            " nucleotides and strands, so this is no oxDNA topology"
        )
    n, n_strands = (int(word) for word in sizes)
    if not n:
        raise StructureError(
            f"{name}: the first line says 0 nucleotides, so there is nothing to do"
        )
    # the program passes over comments and empty lines too
    rows = [
        (number, line)
        for number, line in enumerate(lines[1:], 2)
        if line.strip() and not line.startswith("#")
    ]
    read = _read_new if head[2:] else _read_old
    topology = read(name, text, rows, n)
    found = len(topology.strand_name)
    if found != n_strands:
        raise StructureError(f"{name}: the first line says {n_strands} strands, but {found} follow")
    return topology


def _read_old(name: str, text: str, rows: list[tuple[int, str]], n: int) -> Topology:
    _check_count(name, n, len(rows))
    cells = [line.split() for _, line in rows]
    for (number, line), words in zip(rows, cells, strict=True):
        if len(words) < 4:
            raise StructureError(
                f"{name}, line {number}: {shown(line)} is not a strand, a base and its neighbours"
                " towards 3' and 5'"
            )
    names, bases, three, five = (
        list(column) for column in zip(*(words[:4] for words in cells), strict=True)
    )
    strand, n3, n5 = (_whole(name, rows, column) for column in (names, three, five))
    if (strand < 1).any():
        k = int(np.argmax(strand < 1))
        raise StructureError(
            f"{name}, line {rows[k][0]}: strand {strand[k]}; strands are numbered from 1, and"
            " negative ones are proteins, which cannot be read"
        )
    base = np.char.upper(np.array(bases))
    for word in np.unique(base).tolist():
        if not _is_old_base(word):
            number, _ = rows[int(np.argmax(base == word))]
            _refuse_base(f"{name}, line {number}", word)
    numbers, which = np.unique(strand, return_inverse=True)
    n3, n5 = np.maximum(n3, -1), np.maximum(n5, -1)
    _check_neighbours(name, which, n3, n5)
    titles = tuple(f"strand {number}" for number in numbers.tolist())
    return Topology("old", text, base, which, n3, n5, titles, _is_rna(base, which, len(titles)))


def _read_new(name: str, text: str, rows: list[tuple[int, str]], n: int) -> Topology:
    strands, titles, kinds, circular = [], [], [], []
    for k, (number, line) in enumerate(rows, 1):
        sequence, *words = line.split()
        place = f"{name}, line {number}"
        entries = dict(_entry(place, word) for word in words)
        kind = entries.get("type", "").upper()
        if kind not in ("", "DNA", "RNA"):
            raise StructureError(
                f"{place}: the type is {shown(entries['type'])}; only strands of DNA and RNA can be"
                " read"
            )
        ring = entries.get("circular", "false").lower()
        if ring not in _TRUE + _FALSE:
            raise StructureError(f"{place}: circular is {shown(ring)}; it must be true or false")
        strands.append(_bases(place, sequence))
        own = entries.get("id") or str(k)
        titles.append(f"strand {own}" if own.isdecimal() else own)
        kinds.append(kind)
        circular.append(ring in _TRUE)
    _check_count(name, n, sum(map(len, strands)))
    base = np.array([word for bases in strands for word in bases])
    strand = np.repeat(np.arange(len(strands)), [len(bases) for bases in strands])
    n3, n5 = np.arange(1, n + 1), np.arange(-1, n - 1)
    first = 0
    for bases, closed in zip(strands, circular, strict=True):
        last = first + len(bases) - 1
        n5[first], n3[last] = (last, first) if closed else (-1, -1)
        first = last + 1
    _check_neighbours(name, strand, n3, n5)
    said = np.array([kind == "RNA" for kind in kinds])
    unsaid = np.array([kind == "" for kind in kinds])
    rna = said | (unsaid & _is_rna(base, strand, len(strands)))
    return Topology("new", text, base, strand, n3, n5, tuple(titles), rna)


def _entry(place: str, word: str) -> tuple[str, str]:
    key, is_entry, value = word.partition("=")
    if not is_entry:
        raise StructureError(
            f"{place}: {shown(word)} after the sequence is not of the form key=value"
        )
    return key, value


def _bases(place: str, sequence: str) -> list[str]:
    words = re.findall(r"\([^()]*\)|.", sequence)
    found = []
    for word in words:
        if word.upper() in _LETTERS:
            found.append(word.upper())
        elif re.fullmatch(r"\([+-]?[0-9]{1,9}\)", word):
            number = int(word[1:-1])
            if 3 < number < 10:
                _refuse_base(place, str(number))
            found.append(_NUMBERED[number] if 0 <= number <= 3 else str(number))
        else:
            _refuse_base(place, word)
    return found


def _is_old_base(word: str) -> bool:
    # one sign is a letter to the program, never a number
    return word in _LETTERS if len(word) == 1 else _is_special(word)


def _is_special(word: str) -> bool:
    return re.fullmatch(r"[+-]?[0-9]{1,9}", word) is not None and not 0 <= int(word) < 10


def _refuse_base(place: str, word: str) -> NoReturn:
    raise StructureError(
        f"{place}: the base {shown(word)} is unknown; bases are A, C, G, T, U, or the number of a"
        " special one, below 0 or above 9"
    )


def _whole(name: str, rows: list[tuple[int, str]], column: list[str]) -> Index:
    try:
        return np.array(column).astype(np.int64)
    except (ValueError, OverflowError):
        pass
    for (number, line), word in zip(rows, column, strict=True):
        if not re.fullmatch(r"[+-]?[0-9]{1,9}", word):
            raise StructureError(
                f"{name}, line {number}: {shown(word)} in {shown(line)} is no whole number"
            )
    raise StructureError(f"{name}: the lines of nucleotides cannot be read")


def _is_rna(base: NDArray[np.str_], strand: Index, n_strands: int) -> NDArray[np.bool_]:
    """Strands with U and without T."""
    has_u, has_t = (np.bincount(strand[base == b], minlength=n_strands) > 0 for b in "UT")
    return has_u & ~has_t


def _check_count(name: str, n: int, found: int) -> None:
    if found != n:
        raise StructureError(f"{name}: the first line says {n} nucleotides, but {found} follow")


def _check_neighbours(name: str, strand: Index, n3: Index, n5: Index) -> None:
    n = len(strand)
    for there, back, end, other in ((n3, n5, "3'", "5'"), (n5, n3, "5'", "3'")):
        i = np.flatnonzero(there >= 0)
        outside = i[there[i] >= n]
        if len(outside):
            k = outside[0]
            raise StructureError(
                f"{name}: nucleotide {k} has {there[k]} as its {end} neighbour, but the last of the"
                f" {n} nucleotides is {n - 1}"
            )
        other_way = f"nucleotide {{}}, whose {other} neighbour is another one"
        for wrong, why in (
            (i[there[i] == i], "itself"),
            (i[back[there[i]] != i], other_way),
            (i[strand[there[i]] != strand[i]], "nucleotide {} of another strand"),
        ):
            if len(wrong):
                k = wrong[0]
                raise StructureError(
                    f"{name}: nucleotide {k} has as its {end} neighbour {why.format(there[k])}"
                )


def written_order(system: System, form: Form) -> Index:
    """Nucleotides in the order of a file of a form.

    The new form lists each strand from 5' to 3', the old one from 3' to 5': the program would take
    any order there, but this is its convention (docs/source/configurations.md), and other programs
    rely on it.

    Parameters
    ----------
    system : System
        The nucleotides.
    form : {"old", "new"}
        Of the topology; the lines of the configuration have the same order.

    Returns
    -------
    (n,) array of int

    Raises
    ------
    StructureError
        For the new form, where a strand is in pieces.
    """
    n3 = system.n3.tolist()
    by_strand = np.argsort(system.strand, kind="stable")
    sizes = np.bincount(system.strand, minlength=len(system.strand_name))
    order: list[int] = []
    for name, members in zip(
        system.strand_name, np.split(by_strand, np.cumsum(sizes)[:-1]), strict=True
    ):
        ends = members[system.n5[members] < 0]
        # a ring begins with its first nucleotide in the file
        i = first = int(ends[0] if len(ends) else members[0])
        walk = [i]
        while (i := n3[i]) >= 0 and i != first:
            walk.append(i)
        whole = len(walk) == len(members)
        if form == "new" and not whole:
            raise StructureError(
                f"{system.name}: {name} is in pieces, which the new form of topologies cannot say;"
                " the old form can"
            )
        if form == "new":
            order += walk
        elif not whole:
            order += members.tolist()
        else:
            order += walk[::-1] if len(ends) else [first, *walk[:0:-1]]
    return np.array(order, dtype=np.int64)


def topology_text(system: System, form: Form = "old") -> str:
    """The topology of a system.

    Parameters
    ----------
    system : System
        The nucleotides.
    form : {"old", "new"}, optional
        Four columns, or a line per strand.

    Returns
    -------
    str

    Raises
    ------
    StructureError
        For the new form, where a strand is in pieces.
    """
    n, n_strands = len(system), len(system.strand_name)
    order = written_order(system, form)
    if form == "old":
        line = np.append(np.argsort(order), -1)  # of each nucleotide, and −1 for none
        columns = (system.strand + 1, system.base, line[system.n3], line[system.n5])
        rows = zip(*(column[order].tolist() for column in columns), strict=True)
        return f"{n} {n_strands}\n" + "".join(f"{s} {b} {p} {q}\n" for s, b, p, q in rows)
    words = [b if b.isalpha() else f"({b})" for b in system.base[order].tolist()]
    lines, first = [f"{n} {n_strands} {NEW_HEADER}\n"], 0
    for strand, size in enumerate(np.bincount(system.strand, minlength=n_strands).tolist()):
        kind = "RNA" if system.rna[strand] else "DNA"
        ring = " circular=true" if system.n5[order[first]] >= 0 else ""
        lines.append(f"{''.join(words[first : first + size])} type={kind}{ring}\n")
        first += size
    return "".join(lines)
