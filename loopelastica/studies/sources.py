"""The structures of a folder."""

from pathlib import Path

_SUFFIXES = (".pdb", ".ent", ".cif", ".mmcif")


def structure_files(folder: Path) -> list[Path]:
    """PDB and mmCIF files of a folder, compressed or not, by name.

    Parameters
    ----------
    folder : Path
        Its own folders are not looked into.

    Returns
    -------
    list of Path

    Raises
    ------
    ValueError
        If there is none.
    """
    found = sorted(p for p in folder.glob("*") if _is_structure(p)) if folder.is_dir() else []
    if not found:
        why = (
            "" if folder.is_dir() else ": it is a file" if folder.exists() else ": it is not there"
        )
        raise ValueError(f"`folder` {folder} holds no PDB or mmCIF file{why}")
    return found


def _is_structure(path: Path) -> bool:
    suffixes = [s.lower() for s in path.suffixes if s.lower() not in (".gz", ".bz2")]
    return path.is_file() and bool(suffixes) and suffixes[-1] in _SUFFIXES
