"""Colours that people tell apart."""

import itertools

import numpy as np
import pytest

from loopelastica.report.palette import NATIVE, NEIGHBOUR, PALETTE, STEM, colour

# Machado, Oliveira and Fernandes 2009, severity 1
SIGHT = {
    "normal": np.eye(3),
    "protanopia": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
}
XYZ = np.array(
    [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
)  # fmt: skip


def seen(hexes, sight):
    """Colours in CIELAB (D65) as somebody sees them."""
    c = np.array([[int(h[k : k + 2], 16) for k in (1, 3, 5)] for h in hexes]) / 255
    linear = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    xyz = np.clip(linear @ np.transpose(SIGHT[sight]), 0, 1) @ XYZ.T / XYZ.sum(axis=1)
    x, y, z = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116).T
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=1)


@pytest.mark.parametrize("sight", SIGHT)
def test_candidates_and_the_files_loop_differ_for_the_colour_blind(sight):
    colours = seen([*PALETTE, NATIVE], sight)
    assert min(np.linalg.norm(a - b) for a, b in itertools.combinations(colours, 2)) > 17.0


@pytest.mark.parametrize("sight", SIGHT)
def test_candidates_stand_out_from_white_and_the_stem_is_paler_than_the_files_loop(sight):
    lightness = seen([*PALETTE, NATIVE, STEM, NEIGHBOUR, "#ffffff"], sight)[:, 0]
    assert lightness[: len(PALETTE)].max() < 80.0
    assert (np.diff(lightness[len(PALETTE) :]) > 15.0).all()


def test_a_rank_has_one_colour_and_the_eleventh_the_firsts():
    assert len({colour(rank) for rank in range(1, 11)}) == 10
    assert [colour(rank) for rank in range(11, 21)] == list(PALETTE)
