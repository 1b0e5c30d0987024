"""The cases of the stress report: clampings that are ordinary, stiff, extreme or impossible.

Each private function is a draw as in ``poses``: a generator and a number n in, positions (n, 3) and
rotations (n, 3, 3) out.
"""

import math
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.spatial.transform import Rotation

from loopelastica._arrays import Array
from loopelastica.rod.kernels.records import Status
from loopelastica.rod.parameters import PhysicalParameters, a_min, forceless
from loopelastica.studies.bench.poses import (
    Draw,
    Poses,
    at_shell,
    cut,
    directions,
    ends_of,
    load_drawn,
    of_length,
    random_rotations,
    shell,
)


def _about(axis: str, angles: Array) -> Array:
    """Rotations (n, 3, 3) about a coordinate axis by angles (n,) in radians."""
    vectors = np.asarray(angles)[:, None] * np.eye(3)["xyz".index(axis)]
    return np.asarray(Rotation.from_rotvec(vectors).as_matrix())


def _end_shortenings(rng: np.random.Generator, n: int) -> Array:
    """1 − |η| of the adversarial poses: 1e-4 to 0.3, log-uniform."""
    return np.asarray(10.0 ** rng.uniform(-4.0, -0.5, n))


def _shortened_by(rng: np.random.Generator, n: int, end_shortening: float) -> Poses:
    """|η| = 1 − end shortening."""
    return directions(rng, n) * (1.0 - end_shortening), random_rotations(rng, n)


def _all_shells(rng: np.random.Generator, n: int) -> Poses:
    """A quarter each below 0.5, to 0.95, to 0.99 and to 0.9999."""
    edges = (0.0, 0.5, 0.95, 0.99, 0.9999)
    parts = [shell(rng, (n + k) // 4, edges[k], edges[k + 1]) for k in range(4)]
    return np.concatenate([p for p, _ in parts]), np.concatenate([r for _, r in parts])


def _about_chord(rng: np.random.Generator, n: int, start: float | None, end: float | None) -> Poses:
    """End tangents at the given angles with the chord, else random."""
    shortenings, free = _end_shortenings(rng, n), random_rotations(rng, 2 * n)
    chord, other = free[:n], free[n:]

    def frame(angle: float | None) -> Array:
        azimuth, spin = rng.uniform(-math.pi, math.pi, (2, n))
        tilt = _about("y", np.full(n, angle or 0.0))
        return other if angle is None else chord @ _about("z", azimuth) @ tilt @ _about("z", spin)

    first, last = frame(start), frame(end)
    back = first.transpose(0, 2, 1)
    positions = (back @ chord)[:, :, 2] * (1.0 - shortenings)[:, None]
    return positions, back @ last


def _ring(rng: np.random.Generator, n: int) -> Poses:
    """Both ends at one point with one tangent, any spin; the first one without spin."""
    psi = rng.uniform(-math.pi, math.pi, n)
    psi[0] = 0.0
    return np.zeros((n, 3)), _about("z", psi)


def _near_origin(rng: np.random.Generator, n: int) -> Poses:
    """|η| below 1e-6, a quarter of them exactly 0."""
    positions, rotations = shell(rng, n, 0.0, 1e-6)
    positions[::4] = 0.0
    return positions, rotations


def _on_line(rng: np.random.Generator, n: int) -> Poses:
    """Both end tangents along the line through both ends, either way along it."""
    positions = np.zeros((n, 3))
    positions[:, 2] = rng.uniform(-0.999, 0.999, n)
    return positions, _about("z", rng.uniform(-math.pi, math.pi, n))


def _end_angle(rng: np.random.Generator, n: int, theta: float) -> Poses:
    """Random positions, the end tangent at exactly θ_R = 0 or π with the start's."""
    positions, _ = shell(rng, n, 0.0, 0.95)
    flip = np.diag([1.0, -1.0, -1.0]) if theta else np.eye(3)
    return positions, _about("z", rng.uniform(-math.pi, math.pi, n)) @ flip


def _planar(rng: np.random.Generator, n: int) -> Poses:
    """Position and rotation in one plane; every second one slack, the others tense."""
    tense, slack = 1.0 - _end_shortenings(rng, n), 0.95 * np.sqrt(rng.uniform(size=n))
    radius = np.where(np.arange(n) % 2, tense, slack)
    angle, turn = rng.uniform(-math.pi, math.pi, (2, n))
    positions = np.stack([radius * np.sin(angle), np.zeros(n), radius * np.cos(angle)], axis=1)
    return positions, _about("y", turn)


def _straight(rng: np.random.Generator, n: int) -> Poses:
    """Stretched to full length, with any twist."""
    return np.tile([0.0, 0.0, 1.0], (n, 1)), _about("z", rng.uniform(-math.pi, math.pi, n))


def _misfits(rng: np.random.Generator, n: int) -> Poses:
    """Out of reach, or at full length with tangents that do not fit."""
    positions, rotations = shell(rng, n, 1.0 + 1e-6, 1.5)
    positions[::2] = directions(rng, len(positions[::2]))
    return positions, rotations


def _broken(rng: np.random.Generator, n: int) -> Poses:
    """No numbers, reflections and matrices that are no rotations."""
    positions, rotations = shell(rng, n, 0.0, 0.95)
    positions[::3, 1] = math.nan
    rotations[1::3] *= -1.0
    rotations[2::3] *= 1.1
    return positions, rotations


def _helical(rng: np.random.Generator, n: int) -> Poses:
    """Ends of helices, half of them without force."""
    moments = directions(rng, n - n // 2) * rng.uniform(0.0, 15.0, (n - n // 2, 1))
    free = [forceless(moment, 2) for moment in moments]
    rods = []
    for _ in range(n // 2):
        lam, t_p = rng.uniform(-1.5, 1.5, 2)
        rods.append(cut(rng, lam, t_p, a_min(lam, t_p), rng.uniform(1.0, 12.0)))
    positions, rotations = ends_of(rods) if rods else (np.empty((0, 3)), np.empty((0, 3, 3)))
    return (
        np.concatenate([np.array([line[-1] for line, _ in free]), positions]),
        np.concatenate([np.array([frames[-1] for _, frames in free]), rotations]),
    )


def _homoclinic(rng: np.random.Generator, n: int) -> Poses:
    """Ends of rods next to the homoclinic one (λ = t_P, a = 2): 1 − k² from 1e-2 to 1e-14."""
    rods = []
    for _ in range(n):
        c, sign = rng.uniform(-1.8, 1.8), rng.choice([-1.0, 1.0])
        a = 2.0 + sign * 2.0 * (2.0 - abs(c)) * 10.0 ** rng.uniform(-14.0, -2.0)
        a = max(a, a_min(c, c))
        length = 10.0 ** rng.uniform(0.3, 1.7)
        # with the point of largest ρ inside: elsewhere such a rod is straight to rounding
        start = -length * rng.uniform(0.1, 0.9)
        rods.append(PhysicalParameters(c, c, a, rng.uniform(0.0, math.tau), start, length))
    return ends_of(rods)


def _long(rng: np.random.Generator, n: int) -> Poses:
    """Ends of random rods with L/μ from 20 to 200."""
    return ends_of(of_length(rng, n, 20.0, 200.0))


@dataclass(frozen=True, slots=True)
class Case:
    """One kind of pose: how it is drawn, how many at full size, what the solver should say."""

    name: str
    draw: Draw
    full: int
    torsion_ratio: float = 1.0
    lowest: bool = False
    expected: Status = Status.CONVERGED


def all_cases() -> list[Case]:
    """The cases of the stress report, ordinary ones first."""
    cases = [Case("load-drawn", load_drawn, 20000)]
    for lowest in (False, True):
        for k in (0.7, 1.0, 1.5):
            name = f"pose-drawn below 0.95, {'lowest' if lowest else 'first'}"
            cases.append(Case(name, at_shell(0.0, 0.95), 3000 if lowest else 10000, k, lowest))
    for low, high in ((0.95, 0.99), (0.99, 0.999), (0.999, 0.9999)):
        cases.append(Case(f"shell {low}–{high}", at_shell(low, high), 1000))
    for missing in (1e-5, 1e-6, 1e-7, 1e-8):
        draw: Draw = partial(_shortened_by, end_shortening=missing)
        cases.append(Case(f"η short of 1 by {missing:.0e}", draw, 1000))
    for k in (0.01, 0.03, 0.1, 0.3, 3.0, 10.0, 30.0, 100.0):
        cases.append(Case("all shells", _all_shells, 125, k))
    for label, angle in (
        ("0", 0.0), ("1e-6", 1e-6), ("1e-3", 1e-3), ("0.2", 0.2), ("π − 0.03", math.pi - 0.03),
        ("π − 1e-3", math.pi - 1e-3), ("π − 1e-6", math.pi - 1e-6), ("π", math.pi),
    ):  # fmt: skip
        for which, start, end in (
            ("start", angle, None),
            ("end", None, angle),
            ("both", angle, angle),
        ):
            draw = partial(_about_chord, start=start, end=end)
            cases.append(Case(f"tangent at {label} to the chord, {which}", draw, 100))
    for name, draw in (
        ("closed ring", _ring),
        ("η below 1e-6", _near_origin),
        ("ends on one line", _on_line),
        ("θ_R = 0", partial(_end_angle, theta=0.0)),
        ("θ_R = π", partial(_end_angle, theta=math.pi)),
        ("planar", _planar),
        ("helical", _helical),
        ("nearly homoclinic", _homoclinic),
        ("L/μ = 20–200", _long),
        ("straight", _straight),
    ):
        cases.append(Case(name, draw, 100))
    cases.append(Case("out of reach", _misfits, 100, expected=Status.UNREACHABLE))
    cases.append(Case("no pose", _broken, 100, expected=Status.BAD_INPUT))
    return cases
