from pathlib import Path

import numpy as np
import pytest

SHARED = Path(__file__).resolve().parents[2] / "shared"


@pytest.fixture(scope="session")
def hairpin_folder():
    folder = SHARED / "hairpins"
    if not folder.is_dir():
        pytest.skip("the reference structures are not beside this checkout (../shared/hairpins)")
    return folder


@pytest.fixture(scope="session")
def rod_folder():
    folder = SHARED / "rods"
    if not folder.is_dir():
        pytest.skip("the reference equilibria are not beside this checkout (../shared/rods)")
    return folder


@pytest.fixture
def rng():
    return np.random.default_rng(20181115)
