"""Arrays of results."""

import numpy as np
import pytest

from loopelastica._arrays import read_only


def test_what_a_result_holds_is_a_copy_that_nobody_writes_to():
    given = np.array([1.0, 2.0])
    kept = read_only(given)
    given[0] = 5.0
    assert kept.tolist() == [1.0, 2.0]
    with pytest.raises(ValueError, match="read-only"):
        kept[0] = 5.0
    assert read_only([1, 2]).dtype == np.float64
