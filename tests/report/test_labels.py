"""Places of labels."""

import numpy as np
import pytest

from loopelastica.report.labels import label_places

BOX = np.zeros(2), np.array([300.0, 300.0])


def overlaps(places, sizes):
    apart = np.abs(places[:, None] - places)
    room = 0.5 * (sizes[:, None] + sizes)
    return ((apart < room).all(axis=2) & ~np.eye(len(places), dtype=bool)).any()


@pytest.mark.parametrize("n", [3, 10, 30])
def test_labels_of_a_ring_are_outside_and_apart(n):
    angles = np.linspace(0.0, 2.0 * np.pi, n, endpoint=False)
    out = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    points, sizes = 150.0 + 90.0 * out, np.tile([22.0, 8.0], (n, 1))
    places = label_places(points, sizes, out, points, BOX)
    assert not overlaps(places, sizes)
    assert ((places - points) * out).sum(axis=1).min() > 0.0


def test_labels_of_one_point_do_not_cover_each_other_nor_it():
    points, sizes = np.full((12, 2), 150.0), np.tile([30.0, 8.0], (12, 1))
    out = np.tile([1.0, 0.0], (12, 1))
    places = label_places(points, sizes, out, points[:1], BOX)
    assert not overlaps(places, sizes)
    assert not (np.abs(places - 150.0) < 0.5 * sizes).all(axis=1).any()


def test_labels_stay_in_the_box_and_off_lines():
    line = np.stack([np.linspace(0.0, 300.0, 200), np.full(200, 290.0)], axis=1)
    points, sizes = np.array([[298.0, 285.0], [2.0, 285.0]]), np.tile([30.0, 8.0], (2, 1))
    places = label_places(points, sizes, np.array([[0.0, 1.0], [0.0, 1.0]]), line, BOX)
    assert (places - 0.5 * sizes >= 0.0).all()
    assert (places + 0.5 * sizes <= 300.0).all()
    assert (places[:, 1] + 4.0 < 290.0).all()
