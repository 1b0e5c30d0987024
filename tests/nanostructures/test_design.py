"""What a design says beside its system."""

import copy

import helix_designs as designs
import numpy as np
import pytest

from loopelastica.nanostructures.scadnano.reading import read_design
from loopelastica.nanostructures.singles import single_strands


@pytest.fixture
def design(tmp_path):
    return read_design(designs.write(designs.linker(7), tmp_path))


def test_each_nucleotide_knows_where_it_is_drawn(design):
    assert design.drawn[18:29].tolist() == ["domain"] * 2 + ["loopout"] * 7 + ["domain"] * 2
    assert design.helix[18:29].tolist() == [0] * 2 + [-1] * 7 + [1] * 2
    assert design.offset[18:29].tolist() == [18, 19] + [0] * 7 + [19, 18]


def test_a_single_strand_is_explained_by_what_is_drawn(design):
    (single,) = single_strands(design.system)
    assert design.why(single) == "loopout"


def test_axes_run_along_rising_offsets_at_the_designs_distance(design):
    first, second = design.axes
    assert (first.index, second.index) == (0, 1)
    for axis in design.axes:
        along = axis.end - axis.begin
        np.testing.assert_allclose(along / np.linalg.norm(along), axis.direction)
    # scadnano's default: radii of 1 nm and a gap of 1 nm
    assert np.linalg.norm(second.begin - first.begin) == pytest.approx(3 / 0.8518)


def test_copies_are_as_unchangeable_as_what_they_are_of(design):
    with pytest.raises(ValueError, match="read-only"):
        copy.deepcopy(design).helix[0] = 5
    with pytest.raises(ValueError, match="read-only"):
        design.axes[0].begin[0] = 5
