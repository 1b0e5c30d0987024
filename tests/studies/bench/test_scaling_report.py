"""What is said about measured growth."""

import pytest

from loopelastica.studies.bench.scaling_report import slope


def test_slope_is_the_power():
    x = [1.0, 10.0, 100.0]
    assert slope(x, [3.0 * v**1.5 for v in x]) == pytest.approx(1.5)
    assert slope([4.0, 4.0], [1.0, 2.0]) is None
    assert slope([], []) is None
