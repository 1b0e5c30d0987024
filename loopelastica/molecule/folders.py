"""The structures of a folder, and files each once."""

import os
from collections.abc import Iterable, Iterator
from pathlib import Path

from loopelastica._files import read_manifest

_SUFFIXES = (".pdb", ".ent", ".cif", ".mmcif")
_MANIFESTS = ("ranking.json", "fill.json")


def structure_files(folder: Path, deep: bool = False, argument: str = "folder") -> list[Path]:
    """PDB and mmCIF files of a folder, compressed or not, by name.

    Parameters
    ----------
    folder : Path
        Where to look.
    deep : bool
        Look into the folders in it too, except hidden ones, linked ones and those with results of
        this program.
    argument : str
        What `folder` is called where the user gave it.

    Returns
    -------
    list of Path

    Raises
    ------
    ValueError
        If there is none.
    """
    found = sorted(_deep(folder)) if deep else _inside(folder)
    if not found:
        why = (
            "" if folder.is_dir() else ": it is a file" if folder.exists() else ": it is not there"
        )
        raise ValueError(f"`{argument}` {folder} holds no PDB or mmCIF file{why}")
    return found


def with_folders(sources: Iterable[str]) -> list[str]:
    """Files, and in the place of a folder those that it holds.

    Parameters
    ----------
    sources : iterable of str
        Files and folders. A folder without structures stays: whoever reads it says what it is.

    Returns
    -------
    list of str
    """
    files = []
    for source in sources:
        inside = [] if not os.path.isdir(source) else _inside(Path(source))
        files += list(map(str, inside)) or [source]
    return files


def _inside(folder: Path) -> list[Path]:
    return sorted(filter(_is_structure, folder.glob("*")))


def _deep(top: Path) -> Iterator[Path]:
    for folder, inner, names in os.walk(top):
        place = Path(folder)
        if place != top and any(read_manifest(place / name) for name in _MANIFESTS):
            # its structures are predictions
            inner.clear()
            continue
        inner[:] = [name for name in inner if not name.startswith(".")]
        yield from filter(_is_structure, (place / name for name in names))


def _is_structure(path: Path) -> bool:
    suffixes = [s.lower() for s in path.suffixes if s.lower() not in (".gz", ".bz2")]
    return path.is_file() and bool(suffixes) and suffixes[-1] in _SUFFIXES


def distinct(sources: Iterable[str | Path]) -> tuple[list[str], list[str]]:
    """Each file once, however often and by whatever path it is given.

    Parameters
    ----------
    sources : iterable of str or Path
        Relative or absolute, symbolic links too.

    Returns
    -------
    first : list of str
        The path by which each file was given first, in their order.
    notes : list of str
        One sentence for each that was left out.
    """
    first: dict[str, str] = {}
    notes = []
    for source in map(str, sources):
        place = os.path.realpath(source)
        if place in first:
            known = first[place]
            same = "was given before" if known == source else f"is the same file as {known}"
            notes.append(f"{source} {same}; it counts once")
        else:
            first[place] = source
    return list(first.values()), notes
