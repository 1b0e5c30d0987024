import math
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

from loopelastica.folding.expected import CLASSES, TABLE, expected_rmsd, length_class, signs


@dataclass
class Line:
    n: int
    energy: float = 4.0
    distance_A: float = 12.0
    length_A: float = 22.0
    is_dna: bool = False

    @property
    def rod(self):
        return SimpleNamespace(energy=self.energy)

    @property
    def ends(self):
        return SimpleNamespace(
            n=self.n, distance_A=self.distance_A, length_A=self.length_A, is_dna=self.is_dna
        )


def test_every_class_has_its_row():
    assert list(TABLE) == [name for _, name in CLASSES]
    assert all(len(b) == 6 and q[0] < q[1] < q[2] for b, q in TABLE.values())


def test_classes_reach_from_one_to_any_number():
    assert [length_class(n) for n in (1, 2, 3, 4, 5, 9, 10, 30)] == [
        *("1", "2", "3-4", "3-4", "5-9", "5-9", "10-12", "10-12"),
    ]


@pytest.mark.parametrize("n", [1, 2, 3, 4, 6, 9, 12, 30])
@pytest.mark.parametrize("crowding", [0.0, 30.0, 1e4])
@pytest.mark.parametrize("energy", [0.0, 5.0, 1e4])
def test_quantiles_are_finite_and_in_order(n, crowding, energy):
    low, middle, high = expected_rmsd(Line(n, energy), crowding)
    assert 0.0 <= low < middle < high < math.inf


def test_longer_strands_are_more_uncertain():
    middles = [expected_rmsd(Line(n), 30.0)[1] for n in (1, 2, 3, 5, 9, 12)]
    assert middles == sorted(middles)


def test_crowded_long_strands_are_better_placed_than_those_in_the_open():
    assert expected_rmsd(Line(7), 90.0)[1] < expected_rmsd(Line(7), 10.0)[1]


def test_signs_are_what_the_table_was_fitted_to():
    found = signs(Line(3, energy=math.e - 1.0, is_dna=True), 25.0)
    np.testing.assert_allclose(found, [1.0, math.log(3), 1.0, 0.5, 12 / 22, 1.0])
