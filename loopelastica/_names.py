"""Names that others chose, made harmless: as part of a path, in a table, in a sentence.

File names may hold anything but a slash, and the names of chains and residues in an mmCIF file
anything at all. Wherever such a text leaves the program it passes one of these functions.
"""

import re
import unicodedata
from pathlib import Path
from typing import Final

# A file name has at most 255 bytes. Folders are <stem>_<loop>, perhaps with a number, and a hidden
# name beside them is longer still.
_STEM_BYTES: Final = 150
_LOOP_BYTES: Final = 60
_SIGNS: Final = "._-+"


def safe_name(text: str, most: int = _LOOP_BYTES) -> str:
    """A text as part of a file name: letters, digits and ``._-+``, all else as ``_``.

    Parameters
    ----------
    text : str
        Any text.
    most : int
        Bytes in UTF-8; of a longer text the beginning and the end are kept.

    Returns
    -------
    str
        Never empty, without a dot or a minus sign in front and without two dots in a row. Different
        texts may have one safe name.

    Examples
    --------
    >>> safe_name("A6-9"), safe_name("/../../6-9"), safe_name("..")
    ('A6-9', '_____6-9', '_')
    """
    harmless = "".join(c if c in _SIGNS or _is_letter(c) else "_" for c in text)
    harmless = re.sub(r"^[.-]+", "_", re.sub(r"\.{2,}", "_", harmless))
    data = harmless.encode()
    if len(data) > most:
        ends = data[: (most - 1) // 2], data[-((most - 1) // 2) :]
        harmless = "_".join(end.decode(errors="ignore") for end in ends)
    return harmless or "_"


def safe_stem(path: Path) -> str:
    """What the folders of an input file begin with: its name without suffixes, made safe.

    Parameters
    ----------
    path : Path

    Returns
    -------
    str

    Examples
    --------
    >>> safe_stem(Path("2koc.pdb.gz")), safe_stem(Path("a;b.pdb"))
    ('2koc', 'a_b')
    """
    name = path.name.removesuffix(".gz").removesuffix(".bz2")
    stem = name.rsplit(".", 1)[0] or path.name
    return safe_name(stem, _STEM_BYTES)


def printable(text: str) -> str:
    r"""A text in one line: what cannot be seen becomes an escape.

    Line feeds and other control characters, signs that turn the direction of writing, and bytes of
    file names that are no UTF-8.

    Parameters
    ----------
    text : str
        Any text.

    Returns
    -------
    str

    Examples
    --------
    >>> print(printable("two\nlines\udcff"))
    two\nlines\udcff
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def _is_letter(character: str) -> bool:
    # a combining mark is part of a letter
    return character.isalnum() or unicodedata.category(character).startswith("M")
