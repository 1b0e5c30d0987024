"""Structures that the tests of the molecule share."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SHARED = ROOT / ".." / "shared" / "hairpins"


@pytest.fixture(scope="session")
def hairpins_folder() -> Path:
    """Folder of real structures beside the checkout."""
    if not SHARED.is_dir():
        pytest.skip("the folder of real structures, ../shared/hairpins, is not here")
    return SHARED


@pytest.fixture
def pdb(tmp_path: Path) -> Callable[..., Path]:
    """Write atom records, one list per model, as a PDB file."""

    def write(*models: list[str], name: str = "some.pdb") -> Path:
        path = tmp_path / name
        text = "".join(
            f"MODEL     {k:4d}\n" + "\n".join(lines) + "\nENDMDL\n"
            for k, lines in enumerate(models, start=1)
        )
        path.write_text(text + "END\n")
        return path

    return write
