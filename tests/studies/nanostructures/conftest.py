import pytest

from loopelastica.nanostructures.laying.lay import lay
from loopelastica.nanostructures.scadnano.reading import read_design
from loopelastica.studies.nanostructures.designs import FAMILIES, LARGE, drawn


@pytest.fixture
def family():
    """A family by its key."""
    return {one.key: one for one in (*FAMILIES, *LARGE)}.__getitem__


@pytest.fixture
def laid(tmp_path, family):
    """A design of a few strands, and how they are laid."""

    def make(key, number, strands):
        pytest.importorskip("scadnano")
        design = drawn(family(key), number, 7, strands)
        path = tmp_path / f"{key}.sc"
        path.write_text(design.to_json())
        return design, lay(read_design(path).system)

    return make
