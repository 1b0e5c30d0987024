"""What a user would write with SciPy."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from loopelastica.studies.bench import inverse, peers

NONE = np.zeros((0, 6))


@pytest.mark.parametrize(
    "method", [peers.by_collocation(NONE), peers.by_shooting(NONE)], ids=["bvp", "shooting"]
)
def test_peers_solve_an_easy_clamping(method, arch):
    rod = method(arch)
    assert rod is not None
    assert inverse.error_of(rod) < 1e-6


def test_a_peer_that_has_no_guess_left_has_no_answer(arch, monkeypatch):
    monkeypatch.setattr(peers, "_MAX_NODES", 22)
    monkeypatch.setattr(peers, "_FEWER_NODES", 22)
    guesses = peers.random_guesses(np.random.default_rng(0), 1)
    assert peers.by_collocation(guesses, 1e-12)(arch) is None
    monkeypatch.setattr(peers, "_EVALUATIONS", 1)
    assert peers.by_shooting(guesses)(arch) is None


def test_the_hermite_guess_meets_both_clamps(arch):
    poses, _ = peers._hermite(arch, np.linspace(0.0, 1.0, 101))
    assert np.abs(poses[:3, -1] - arch.position).max() < 1e-12
    frames = Rotation.from_quat(poses[3:].T, scalar_first=True).as_matrix()
    assert np.abs(frames[0] - np.eye(3)).max() < 1e-12
    assert np.abs(frames[-1] - arch.rotation).max() < 1e-9
    # the frames' tangents are the line's
    slope = np.gradient(poses[:3], axis=1)[:, 1:-1]
    slope /= np.linalg.norm(slope, axis=0)
    assert np.abs(slope.T - frames[1:-1, :, 2]).max() < 0.02
