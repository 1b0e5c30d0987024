"""Clampings that are hard, and those that are not, drawn at random.

Each function takes a generator and a number and returns positions (n, 3) and rotations (n, 3, 3):
the end's pose in the start frame, in units of the rod's length.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.spatial.transform import Rotation

from loopelastica._arrays import Array
from loopelastica.rod.kernels.records import Status
from loopelastica.rod.parameters import PhysicalParameters, a_min, forceless

Poses = tuple[Array, Array]
Draw = Callable[[np.random.Generator, int], Poses]

# largest load and moment of load-drawn rods (K0/L², K0/L), those of the stored ones
_FORCE, _MOMENT = 60.0, 12.0


def _directions(rng: np.random.Generator, n: int) -> Array:
    v = rng.normal(size=(n, 3))
    return np.asarray(v / np.linalg.norm(v, axis=1, keepdims=True))


def _rotations(rng: np.random.Generator, n: int) -> Array:
    return np.asarray(Rotation.random(n, random_state=rng).as_matrix())


def _about(axis: str, angles: Array) -> Array:
    vectors = np.asarray(angles)[:, None] * np.eye(3)["xyz".index(axis)]
    return np.asarray(Rotation.from_rotvec(vectors).as_matrix())


def _gaps(rng: np.random.Generator, n: int) -> Array:
    """1 − |η| of the adversarial poses: 1e-4 to 0.3, log-uniform."""
    return np.asarray(10.0 ** rng.uniform(-4.0, -0.5, n))


def random_loads(rng: np.random.Generator, n: int) -> Array:
    """Loads (n, 6): |F| and |M| uniform, directions uniform."""
    force = _directions(rng, n) * rng.uniform(0.0, _FORCE, (n, 1))
    moment = _directions(rng, n) * rng.uniform(0.0, _MOMENT, (n, 1))
    return np.hstack([force, moment])


def load_drawn(rng: np.random.Generator, n: int) -> Poses:
    """Ends of rods (K30 = 1) with `random_loads`."""
    from loopelastica.rod.kernels.shooting import ends

    positions, quaternions = ends(random_loads(rng, n), 1.0, 4.0)
    return positions, Rotation.from_quat(quaternions, scalar_first=True).as_matrix()


def shell(rng: np.random.Generator, n: int, low: float, high: float) -> Poses:
    """Positions uniform in the shell low < |η| < high, rotations uniform."""
    radius = np.cbrt(rng.uniform(low**3, high**3, (n, 1)))
    return _directions(rng, n) * radius, _rotations(rng, n)


def at_gap(rng: np.random.Generator, n: int, gap: float) -> Poses:
    """|η| = 1 − gap."""
    return _directions(rng, n) * (1.0 - gap), _rotations(rng, n)


def all_shells(rng: np.random.Generator, n: int) -> Poses:
    """A quarter each below 0.5, to 0.95, to 0.99 and to 0.9999."""
    edges = (0.0, 0.5, 0.95, 0.99, 0.9999)
    parts = [shell(rng, (n + k) // 4, edges[k], edges[k + 1]) for k in range(4)]
    return np.concatenate([p for p, _ in parts]), np.concatenate([r for _, r in parts])


def about_chord(rng: np.random.Generator, n: int, start: float | None, end: float | None) -> Poses:
    """End tangents at the given angles with the chord, else random."""
    gaps, free = _gaps(rng, n), _rotations(rng, 2 * n)
    chord, other = free[:n], free[n:]

    def frame(angle: float | None) -> Array:
        azimuth, spin = rng.uniform(-math.pi, math.pi, (2, n))
        tilt = _about("y", np.full(n, angle or 0.0))
        return other if angle is None else chord @ _about("z", azimuth) @ tilt @ _about("z", spin)

    first, last = frame(start), frame(end)
    back = first.transpose(0, 2, 1)
    positions = (back @ chord)[:, :, 2] * (1.0 - gaps)[:, None]
    return positions, back @ last


def ring(rng: np.random.Generator, n: int) -> Poses:
    """Both ends at one point with one tangent, any spin; the first one without spin."""
    psi = rng.uniform(-math.pi, math.pi, n)
    psi[0] = 0.0
    return np.zeros((n, 3)), _about("z", psi)


def near_origin(rng: np.random.Generator, n: int) -> Poses:
    """|η| below 1e-6, a quarter of them exactly 0."""
    positions, rotations = shell(rng, n, 0.0, 1e-6)
    positions[::4] = 0.0
    return positions, rotations


def on_line(rng: np.random.Generator, n: int) -> Poses:
    """Both end tangents along the line through both ends, either way along it."""
    positions = np.zeros((n, 3))
    positions[:, 2] = rng.uniform(-0.999, 0.999, n)
    return positions, _about("z", rng.uniform(-math.pi, math.pi, n))


def end_angle(rng: np.random.Generator, n: int, theta: float) -> Poses:
    """Random positions, the end tangent at exactly θ_R = 0 or π with the start's."""
    positions, _ = shell(rng, n, 0.0, 0.95)
    flip = np.diag([1.0, -1.0, -1.0]) if theta else np.eye(3)
    return positions, _about("z", rng.uniform(-math.pi, math.pi, n)) @ flip


def planar(rng: np.random.Generator, n: int) -> Poses:
    """Position and rotation in one plane; every second one slack, the others tense."""
    radius = np.where(np.arange(n) % 2, 1.0 - _gaps(rng, n), 0.95 * np.sqrt(rng.uniform(size=n)))
    angle, turn = rng.uniform(-math.pi, math.pi, (2, n))
    positions = np.stack([radius * np.sin(angle), np.zeros(n), radius * np.cos(angle)], axis=1)
    return positions, _about("y", turn)


def straight(rng: np.random.Generator, n: int) -> Poses:
    """Stretched to full length, with any twist."""
    return np.tile([0.0, 0.0, 1.0], (n, 1)), _about("z", rng.uniform(-math.pi, math.pi, n))


def misfits(rng: np.random.Generator, n: int) -> Poses:
    """Out of reach, or at full length with tangents that do not fit."""
    positions, rotations = shell(rng, n, 1.0 + 1e-6, 1.5)
    positions[::2] = _directions(rng, len(positions[::2]))
    return positions, rotations


def broken(rng: np.random.Generator, n: int) -> Poses:
    """No numbers, reflections and matrices that are no rotations."""
    positions, rotations = shell(rng, n, 0.0, 0.95)
    positions[::3, 1] = math.nan
    rotations[1::3] *= -1.0
    rotations[2::3] *= 1.1
    return positions, rotations


def ends_of(rods: list[PhysicalParameters]) -> Poses:
    clampings = [rod.clamping() for rod in rods]
    return np.array([c.position for c in clampings]), np.array([c.rotation for c in clampings])


def _cut(
    rng: np.random.Generator, lam: float, t_p: float, a: float, length: float
) -> PhysicalParameters:
    rod = PhysicalParameters(lam, t_p, a, rng.uniform(0.0, math.tau), 0.0, length)
    window = rod.period if math.isfinite(rod.period) else length
    return PhysicalParameters(lam, t_p, a, rod.phi0, rng.uniform(0.0, window), length)


def helical(rng: np.random.Generator, n: int) -> Poses:
    """Ends of helices, half of them without force."""
    moments = _directions(rng, n - n // 2) * rng.uniform(0.0, 15.0, (n - n // 2, 1))
    free = [forceless(moment, 2) for moment in moments]
    rods = []
    for _ in range(n // 2):
        lam, t_p = rng.uniform(-1.5, 1.5, 2)
        rods.append(_cut(rng, lam, t_p, a_min(lam, t_p), rng.uniform(1.0, 12.0)))
    positions, rotations = ends_of(rods) if rods else (np.empty((0, 3)), np.empty((0, 3, 3)))
    return (
        np.concatenate([np.array([line[-1] for line, _ in free]), positions]),
        np.concatenate([np.array([frames[-1] for _, frames in free]), rotations]),
    )


def homoclinic(rng: np.random.Generator, n: int) -> Poses:
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


def of_length(
    rng: np.random.Generator, n: int, shortest: float, longest: float
) -> list[PhysicalParameters]:
    """Random rods with L/μ between two bounds, log-uniform."""
    rods = []
    for _ in range(n):
        lam, t_p = rng.uniform(-2.0, 2.0, 2)
        a = a_min(lam, t_p) + 10.0 ** rng.uniform(-3.0, 0.5)
        length = 10.0 ** rng.uniform(math.log10(shortest), math.log10(longest))
        rods.append(_cut(rng, lam, t_p, a, length))
    return rods


def long(rng: np.random.Generator, n: int) -> Poses:
    """Ends of random rods with L/μ from 20 to 200."""
    return ends_of(of_length(rng, n, 20.0, 200.0))


def at_shell(low: float, high: float) -> Draw:
    """`shell` of given bounds."""
    return partial(shell, low=low, high=high)


@dataclass(frozen=True, slots=True)
class Case:
    """One kind of pose: how it is drawn, how many at full size, what is asked of the solver."""

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
    for gap in (1e-5, 1e-6, 1e-7, 1e-8):
        cases.append(Case(f"η short of 1 by {gap:.0e}", partial(at_gap, gap=gap), 1000))
    for k in (0.01, 0.03, 0.1, 0.3, 3.0, 10.0, 30.0, 100.0):
        cases.append(Case("all shells", all_shells, 125, k))
    for label, angle in (
        ("0", 0.0), ("1e-6", 1e-6), ("1e-3", 1e-3), ("0.2", 0.2), ("π − 0.03", math.pi - 0.03),
        ("π − 1e-3", math.pi - 1e-3), ("π − 1e-6", math.pi - 1e-6), ("π", math.pi),
    ):  # fmt: skip
        for which, start, end in (
            ("start", angle, None),
            ("end", None, angle),
            ("both", angle, angle),
        ):
            draw: Draw = partial(about_chord, start=start, end=end)
            cases.append(Case(f"tangent at {label} to the chord, {which}", draw, 100))
    for name, draw in (
        ("closed ring", ring),
        ("η below 1e-6", near_origin),
        ("ends on one line", on_line),
        ("θ_R = 0", partial(end_angle, theta=0.0)),
        ("θ_R = π", partial(end_angle, theta=math.pi)),
        ("planar", planar),
        ("helical", helical),
        ("nearly homoclinic", homoclinic),
        ("L/μ = 20–200", long),
        ("straight", straight),
    ):
        cases.append(Case(name, draw, 100))
    cases.append(Case("out of reach", misfits, 100, expected=Status.UNREACHABLE))
    cases.append(Case("no pose", broken, 100, expected=Status.BAD_INPUT))
    return cases
