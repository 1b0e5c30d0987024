"""Room beside lines against all distances."""

from dataclasses import replace

import numpy as np
import pytest
from chained import crowd

from loopelastica.nanostructures.laying.bases import REACH
from loopelastica.nanostructures.laying.tails import Tail, _Crowd, lay_tails, straight


@pytest.mark.parametrize("box", [0.0, 6.0])
def test_the_room_of_lines_is_that_of_all_distances(rng, box):
    chains = crowd(rng, n=60, side=6.0, box=box)
    chains.placed[30:] = False
    found = _Crowd(chains)
    for rows in np.split(np.arange(30, 60), 6):
        chains.placed[rows] = True
        found.add(rows)
    assert len(found.parts) < 6
    lines = 6 * rng.random((8, 4, 3))
    room = np.zeros(8)
    for k, line in enumerate(lines):
        for share, least in ((0.0, 0.73), (REACH, 0.55)):
            apart = line[:, None] - (chains.sites + share * chains.direction)
            if box:
                apart -= box * np.round(apart / box)
            room[k] = min(room[k], np.linalg.norm(apart, axis=2).min() - least)
    np.testing.assert_allclose(found.room(lines, -5), room, atol=1e-12)
    assert room.min() < 0


def test_a_tail_turns_out_of_the_way_of_another_and_no_further_than_it_must(rng):
    chains = crowd(rng, n=9)
    chains = replace(chains, placed=np.zeros(9, dtype=bool))
    chains.sites[0], chains.placed[0] = 0.0, True
    chains.direction[0] = [1.0, 0, 0]
    up, out = np.array([0.0, 0, 1]), np.array([0.0, 1, 0])
    tail = Tail(np.arange(1, 5), 0, up, out)
    lay_tails(chains, [tail], turn=True)
    np.testing.assert_allclose(chains.sites[1:5], straight(np.zeros(3), up, 4), atol=1e-12)
    # what stands there already
    chains.sites[5:9] = chains.sites[1:5]
    chains.placed[5:9], chains.placed[1:5] = True, False
    lay_tails(chains, [tail], turn=True)
    apart = np.linalg.norm(chains.sites[1:5, None] - chains.sites[None, 5:9], axis=2)
    assert apart.min() > 0.73 - 1e-9
    lay_tails(chains, [tail], turn=False)
    np.testing.assert_allclose(chains.sites[1:5], chains.sites[5:9], atol=1e-12)
