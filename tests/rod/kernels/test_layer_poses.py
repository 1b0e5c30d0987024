import numpy as np
import pytest
from draws import pose_drawn
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import loopelastica as le
from loopelastica.rod.kernels.boundary_layers import solve_layers
from loopelastica.rod.kernels.layer_poses import (
    check_layers,
    layers_apart,
    layers_energy,
    layers_loads,
    sample_layers,
)

# kernels that Python does not call otherwise are compiled one by one
pytestmark = pytest.mark.slow


@pytest.fixture
def layered(problem, start, room):
    """Random poses that two boundary layers solve: (problem, record, loads)."""

    def drawn(rng, n, low, high, torsion_ratio):
        for position, rotation in zip(*pose_drawn(rng, n, low, high), strict=True):
            here = problem(le.Clamping(position, rotation), torsion_ratio)
            layers, f = room().layers[0], np.empty(6)
            if solve_layers(here, start(), layers) and layers_apart(layers):
                layers_loads(layers, f)
                yield here, layers, f

    return drawn


def test_the_closed_form_follows_the_equations_of_the_rod(rng, layered):
    # from the start, over as many decay lengths as the growth of errors allows
    for _, layers, f in layered(rng, 10, 0.99, 0.995, 1.0):
        far = 12.0 / np.sqrt(np.linalg.norm(f[:3]))

        def slope(_, y, f=f):
            t = y[3:]
            return np.concatenate([t, np.cross(f[3:] + np.cross(f[:3], y[:3]), t)])

        s = np.linspace(0, far, 9)
        exact = solve_ivp(slope, (0, far), [0, 0, 0, 0, 0, 1], "DOP853", s, rtol=1e-13, atol=1e-13)
        poses = sample_layers(layers, 1.0, s)
        np.testing.assert_allclose(poses[:, :3], exact.y[:3].T, atol=2e-8)


def test_energy_of_the_layers_is_the_integral(rng, layered):
    for _, layers, f in layered(rng, 10, 0.99, 0.999, 0.7):
        decay = 1 / np.sqrt(np.linalg.norm(f[:3]))
        x, w = np.polynomial.legendre.leggauss(300)
        half = 0.5 * (x + 1)
        energy = 0.0
        for a, b in ((0, 12 * decay), (12 * decay, 1 - 12 * decay), (1 - 12 * decay, 1)):
            poses = sample_layers(layers, 0.7, a + (b - a) * half)
            t = Rotation.from_quat(poses[:, 3:], scalar_first=True).as_matrix()[:, :, 2]
            moment = f[3:] + np.cross(f[:3], poses[:, :3])
            bending = np.linalg.norm(np.cross(moment, t), axis=1) ** 2
            energy += (b - a) * (0.5 * w) @ (0.5 * bending)
        assert layers_energy(layers, 0.7) == pytest.approx(energy + 0.5 * f[5] ** 2 / 0.7, rel=1e-7)


@pytest.mark.parametrize("field", ["root", "beta", "phi_0", "x_0", "x_1", "chi_1", "end_x"])
def test_a_wrong_field_shows_in_the_error(rng, layered, field):
    here, layers, _ = next(layered(rng, 5, 0.995, 0.999, 0.7))
    assert check_layers(here, layers) < 1e-10
    layers[field] += 1e-4
    assert check_layers(here, layers) > 1e-7


def test_layers_that_reach_each_other_are_not_taken_for_exact(rng, layered):
    _, layers, _ = next(layered(rng, 5, 0.995, 0.999, 1.0))
    for meeting, apart in ((1e-13, True), (1e-11, False), (np.nan, False)):
        layers.meeting = meeting
        assert layers_apart(layers) == apart
