"""Where the files that ship with the package are."""

from pathlib import Path


def data_path(name: str) -> Path:
    """Path of a shipped file: inside an installed package, else in the checkout beside it."""
    here = Path(__file__).resolve().parent
    inside = here / "data"
    return (inside if inside.is_dir() else here.parent / "data") / name
