"""The solver on every kind of pose; each result is judged by what the user is given."""

import json
import math

import numpy as np
import pytest
from draws import pose_drawn
from scipy.spatial.transform import Rotation

import loopelastica as le
from loopelastica.rod.kernels.records import Method


def independent_residual(rod):
    """End misfit and equilibrium between close nodes, by scipy, of center line and frames."""
    from scipy.integrate import solve_ivp

    clamping, f, k3 = rod.clamping, rod.loads, rod.torsion_ratio
    root = math.sqrt(np.linalg.norm(f[:3]))
    layer = min(0.5, 25.0 / max(root, 1e-9))
    s = np.concatenate(
        [np.linspace(0, layer, 26), np.linspace(layer, 1 - layer, 4), np.linspace(1 - layer, 1, 26)]
    )
    s = np.unique(s)
    r, frames = rod.centerline(s), rod.frames(s)
    target = clamping.rotation[:, 2] if clamping.free_spin else clamping.rotation
    last = frames[-1][:, 2] if clamping.free_spin else frames[-1]
    worst = max(np.abs(r[0]).max(), np.abs(frames[0] - np.eye(3)).max())
    worst = max(worst, np.abs(r[-1] - clamping.position).max(), np.abs(last - target).max())
    for i in range(len(s) - 1):
        if root * (s[i + 1] - s[i]) > 3:
            continue
        moment = f[3:] + np.cross(f[:3], r[i])

        def slope(_, y, moment=moment):
            t = y[3:].reshape(3, 3)[:, 2]
            m = moment + np.cross(f[:3], y[:3])
            omega = m + (1 / k3 - 1) * (m @ t) * t
            return np.concatenate([t, np.cross(omega, y[3:].reshape(3, 3).T).T.ravel()])

        y0 = np.concatenate([np.zeros(3), frames[i].ravel()])
        y = solve_ivp(slope, (0, s[i + 1] - s[i]), y0, "DOP853", rtol=1e-11, atol=1e-12).y[:, -1]
        worst = max(worst, np.abs(r[i] + y[:3] - r[i + 1]).max())
        worst = max(worst, np.abs(y[3:] - frames[i + 1].ravel()).max())
    return worst


SHELLS = [(0, 0.5), (0.5, 0.8), (0.8, 0.95), (0.95, 0.99), (0.99, 0.999), (0.999, 0.9999)]


@pytest.mark.parametrize("lowest", [False, True])
@pytest.mark.parametrize("torsion_ratio", [0.7, 1.0, 1.5])
def test_every_pose_in_every_shell_is_solved(rng, torsion_ratio, lowest):
    for low, high in SHELLS:
        batch = le.solve_batch(*pose_drawn(rng, 40, low, high), torsion_ratio, lowest=lowest)
        assert batch.converged.all()
        assert batch.residual.max() < 1e-9
        assert np.isfinite(batch.energy).all()


def test_one_rod_of_every_other_shell_is_in_equilibrium_by_another_integrator(rng):
    for low, high in SHELLS[::2]:
        position, rotation = (a[0] for a in pose_drawn(rng, 1, low, high))
        rod = le.solve(le.Clamping(position, rotation), 0.7)
        assert independent_residual(rod) < 2e-9, rod.method


@pytest.mark.slow
@pytest.mark.parametrize("free_spin", [False, True])
def test_what_is_returned_is_in_equilibrium_by_another_integrator(rng, free_spin):
    for low, high in SHELLS:
        for position, rotation in zip(*pose_drawn(rng, 2, low, high), strict=True):
            rod = le.solve(le.Clamping(position, rotation, free_spin), 0.7)
            assert rod.converged
            assert independent_residual(rod) < 2e-9, rod.method


@pytest.mark.parametrize("shortening", [1e-5, 1e-6, 1e-7, 1e-8])
def test_the_stiffest_rods(rng, shortening):
    positions, rotations = pose_drawn(rng, 40, 0.5, 0.6)
    positions *= (1 - shortening) / np.linalg.norm(positions, axis=1, keepdims=True)
    batch = le.solve_batch(positions, rotations, lowest=False)
    assert batch.converged.all()
    assert batch.residual.max() < 1e-9


@pytest.mark.parametrize("torsion_ratio", [0.01, 0.1, 10.0, 100.0])
def test_other_torsion_ratios(rng, torsion_ratio):
    for low, high in ((0, 0.5), (0.5, 0.95), (0.95, 0.99), (0.99, 0.9999)):
        batch = le.solve_batch(*pose_drawn(rng, 15, low, high), torsion_ratio, lowest=False)
        assert batch.converged.all()


def about_chord(rng, n, start, end):
    """Clampings whose end tangents make the given angles with the chord, else random."""
    shortenings = 10 ** rng.uniform(-4, -0.5, n)
    turns = Rotation.random(2 * n, random_state=rng)
    for shortening, first, second in zip(shortenings, turns[:n], turns[n:], strict=True):
        spin = Rotation.from_euler("z", rng.uniform(-np.pi, np.pi))
        across = Rotation.from_euler("z", rng.uniform(-np.pi, np.pi))
        begin = first * spin * Rotation.from_euler("y", start) if start is not None else second
        stop = first * across * Rotation.from_euler("y", end) * spin if end is not None else second
        chord = first.apply([0, 0, 1 - shortening])
        yield le.Clamping.from_frames(np.zeros(3), begin.as_matrix(), chord, stop.as_matrix(), 1.0)


ANGLES = [0.0, 1e-6, 1e-3, 0.2, np.pi - 0.03, np.pi - 1e-3, np.pi - 1e-6, np.pi]


@pytest.mark.parametrize("angle", ANGLES)
def test_end_tangents_along_and_against_the_chord(rng, angle):
    for start, end in ((angle, angle), (angle, None), (None, angle)):
        for clamping in about_chord(rng, 8, start, end):
            rod = le.solve(clamping)
            assert rod.converged
            assert rod.residual < 1e-9


@pytest.mark.parametrize("distance", [0.0, 1e-6, 0.3, -0.3, 0.9, -0.9])
@pytest.mark.parametrize("psi", [0.0, 1.0, 3.0])
def test_both_ends_on_one_line(distance, psi):
    for theta in (0.0, np.pi):
        rod = le.solve(le.Clamping.from_parameters([0, 0, distance, psi, theta, 0]))
        assert rod.converged
        assert independent_residual(rod) < 2e-9


def test_a_closed_ring_is_a_circle():
    rod = le.solve(le.Clamping([0, 0, 0], np.eye(3)))
    assert rod.energy == pytest.approx(0.5 * (2 * np.pi) ** 2, rel=1e-9)
    assert np.ptp(rod.curvature(20)) < 1e-6


def test_a_tense_rod_survives_json_and_has_the_energy_of_its_curvature(rng):
    position, rotation = (a[0] for a in pose_drawn(rng, 1, 0.9995, 0.9999))
    rod = le.solve(le.Clamping(position, rotation))
    assert rod.method == Method.BOUNDARY_LAYERS
    again = le.Equilibrium.from_dict(json.loads(json.dumps(rod.to_dict())))
    np.testing.assert_array_equal(again.frames(9), rod.frames(9))
    x, w = np.polynomial.legendre.leggauss(400)
    layer = 20 / math.sqrt(np.linalg.norm(rod.loads[:3]))
    total = 0.5 * (2 * np.pi * rod.twist) ** 2
    for a, b in ((0, layer), (1 - layer, 1)):
        s = a + (b - a) * (x + 1) / 2
        total += (b - a) * (w / 2) @ (0.5 * rod.curvature(s) ** 2)
    assert rod.energy == pytest.approx(total, rel=1e-8)


def test_solve_finds_the_lowest_of_the_reference_poses(rod_folder):
    for pose in json.loads((rod_folder / "equilibria.json").read_text()):
        clamping = le.Clamping(pose["position"], pose["rotation"])
        rod = le.solve(clamping, pose["torsion_ratio"])
        assert rod.energy <= pose["energies"][0] + 1e-6


def test_equilibria_finds_the_listed_energies_of_reference_poses(rod_folder):
    # the list's own energies are good to 1e-4 at its stiffest pose (Gauss quadrature of ours
    # agrees with ours to 1e-9)
    for pose in json.loads((rod_folder / "equilibria.json").read_text())[::6]:
        clamping = le.Clamping(pose["position"], pose["rotation"])
        rods = le.equilibria(clamping, pose["torsion_ratio"], max(pose["energies"]) + 1)
        energies = np.array([rod.energy for rod in rods])
        for listed in pose["energies"]:
            assert np.abs(energies - listed).min() < 1e-4
