"""Sentences that say the same of many models, loops or files, as one."""

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Final

_MODEL: Final = re.compile(r"\bmodel (\d+): ")
# "A.C5–A.G10", "A.40-42": a word with a number in it
_PLACE: Final = re.compile(r"(?=[^\s:]*\d)[^\s:]+")
_LENGTH: Final = re.compile(r"\d+(\.\d+)?(?= [Å°])")
# names of places or files that are given before the others are counted
_NAMED: Final = 3


def gathered(sentences: Iterable[str]) -> list[str]:
    """Sentences, those that differ only in the model, the loop or the file as one.

    Parameters
    ----------
    sentences : iterable of str
        Such as "file: model 2: A.C5–A.G10: why"; the parts in front may be absent.

    Returns
    -------
    list of str
        In the order in which they came first.

    Examples
    --------
    >>> gathered(["a.pdb: model 2: no ring", "a.pdb: model 3: no ring", "a.pdb: model 5: no ring"])
    ['a.pdb: models 2-3, 5: no ring']
    >>> gathered(["a.pdb: model 2: 3.1 Å is too far", "a.pdb: model 3: 3.4 Å is too far"])
    ['a.pdb: model 2: 3.1 Å is too far (and 1 more model)']
    >>> gathered(["a.pdb: A.6-9: far", "a.pdb: B.6-9: far", "b.pdb: odd", "c.pdb: odd"])
    ['a.pdb: A.6-9, B.6-9: far', 'b.pdb, c.pdb: odd']
    """
    found = list(_alike_models(list(dict.fromkeys(sentences))))
    for split, kind in ((_of_model, None), (_of_place, "places"), (_of_file, "files")):
        found = list(_joined(found, split, kind))
    return found


def _alike_models(sentences: Sequence[str]) -> Iterator[str]:
    """Sentences; of those on models that differ in their lengths the first, and how many more."""
    keys = [_but_for_lengths(sentence) for sentence in sentences]
    alike: dict[str, list[str]] = {}
    for sentence, key in zip(sentences, keys, strict=True):
        if key is not None:
            alike.setdefault(key, []).append(sentence)
    for sentence, key in zip(sentences, keys, strict=True):
        same = [] if key is None else alike[key]
        if len({_MODEL.sub("", one) for one in same}) < 2:
            yield sentence
        elif sentence == same[0]:
            more = len(same) - 1
            yield f"{sentence} (and {more} more model{'s' * (more > 1)})"


def _but_for_lengths(sentence: str) -> str | None:
    """A sentence on a model without what differs between models; None for another one."""
    return _LENGTH.sub("", _MODEL.sub("", sentence)) if _MODEL.search(sentence) else None


_Split = Callable[[str], tuple[str, str, str] | None]


def _joined(sentences: Sequence[str], split: _Split, kind: str | None) -> Iterator[str]:
    """Sentences; those that are alike but for their middle part as one."""
    parts = [split(sentence) for sentence in sentences]
    alike: dict[tuple[str, str], list[str]] = {}
    for part in parts:
        if part is not None:
            before, name, after = part
            alike.setdefault((before, after), []).append(name)
    for sentence, part in zip(sentences, parts, strict=True):
        if part is None:
            yield sentence
        elif same := alike.pop((part[0], part[2]), None):
            names = _models(same) if kind is None else _some(same, kind)
            yield sentence if len(same) == 1 else f"{part[0]}{names}{part[2]}"


def _of_model(sentence: str) -> tuple[str, str, str] | None:
    found = _MODEL.search(sentence)
    if found is None:
        return None
    return sentence[: found.start()], found[1], sentence[found.end() - 2 :]


def _of_place(sentence: str) -> tuple[str, str, str] | None:
    file, _, rest = sentence.partition(": ")
    place, colon, said = rest.partition(": ")
    if not colon or _PLACE.fullmatch(place) is None:
        return None
    return f"{file}: ", place, f": {said}"


def _of_file(sentence: str) -> tuple[str, str, str] | None:
    file, colon, said = sentence.partition(": ")
    return ("", file, f": {said}") if colon else None


def _models(numbers: list[str]) -> str:
    """Numbers of models, those in a row as a range."""
    runs: list[list[int]] = []
    for number in sorted(map(int, numbers)):
        if runs and number == runs[-1][-1] + 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    spans = [f"{run[0]}-{run[-1]}" if len(run) > 1 else str(run[0]) for run in runs]
    more = len(spans) - 2 * _NAMED
    if more > 1:
        spans = [*spans[: 2 * _NAMED], f"and {sum(map(len, runs[2 * _NAMED :]))} more"]
    return f"models {', '.join(spans)}"


def _some(names: list[str], kind: str) -> str:
    """The first names, and how many more there are."""
    more = len(names) - _NAMED
    if more < 2:
        return ", ".join(names)
    return f"{', '.join(names[:_NAMED])} and {more} more {kind}"
