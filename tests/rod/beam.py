"""A slightly bent, twisted rod by finite elements: shares nothing with the solver.

Linear in the small complex angle θ between tangent and chord. Under a tension T and a twisting
moment m the energy ½∫|θ'|² + ½ m ∫Im(θ* θ') + ½ T ∫|θ|² is least under ∫θ = 0 and given end
angles. T is found from the shortening, above the tension at which the constrained form loses its
definiteness; m from the turn of the end.
"""

import numpy as np
from scipy.linalg import solve_banded
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation


class Beam:
    """End tilts and end turn of a nearly straight clamping; energies of its rods."""

    def __init__(self, clamping, torsion_ratio, elements=3000):
        self.ratio, self.free = torsion_ratio, clamping.free_spin
        length = np.linalg.norm(clamping.position)
        self.shortening = (1 - clamping.position @ clamping.position) / (1 + length)
        chord = clamping.position / length
        axis = np.cross([0, 0, 1], chord)
        sine = np.linalg.norm(axis)
        to_chord = Rotation.from_rotvec(axis * (np.arcsin(sine) / sine if sine else 0.0))
        first = to_chord.inv()
        last = first * Rotation.from_matrix(clamping.rotation)
        self.tilts, spins = [], []
        for frame in (first, last):
            t = frame.as_matrix()[:, 2]
            across = np.cross([0, 0, 1], t)
            size = np.linalg.norm(across)
            angle = np.arctan2(size, t[2])
            self.tilts.append((t[0] + 1j * t[1]) / size * angle if size else 0j)
            lean = Rotation.from_rotvec(across / size * angle if size else np.zeros(3))
            spins.append((lean.inv() * frame).as_rotvec()[2])
        self.turn = (spins[1] - spins[0] + np.pi) % (2 * np.pi) - np.pi
        self.elements = elements

    def mesh(self, root, moment=0.0):
        stretch = np.log(max(root, 2.0)) + 1.0
        # a wave has some 60 elements where they are longest
        elements = max(self.elements, int(10 * abs(moment) * stretch))
        x = np.linspace(0, 1, elements // 2 + 1)
        half = 0.5 * np.sinh(stretch * x) / np.sinh(stretch)
        return np.concatenate([half, 1 - half[-2::-1]])

    def matrix(self, s, tension, moment):
        h = np.diff(s)
        n = len(s)
        band = np.zeros((3, n), complex)
        band[1, :-1] += 1 / h + tension * h / 3
        band[1, 1:] += 1 / h + tension * h / 3
        coupling = -1 / h + tension * h / 6
        band[0, 1:] = coupling + 0.5j * moment
        band[2, :-1] = coupling - 0.5j * moment
        return band

    def definite(self, s, tension, moment):
        """Whether the form is positive where θ vanishes at the ends and ∫θ = 0."""
        band = self.matrix(s, tension, moment)
        diagonal, off = band[1, 1:-1].real, np.abs(band[0, 2:-1]) ** 2
        negative, pivot = 0, np.inf
        for d, o in zip(diagonal, [0.0, *off], strict=True):
            pivot = d - o / pivot
            negative += pivot < 0
        if negative == 0:
            return True
        if negative > 1:
            return False
        weight = 0.5 * (np.diff(s)[:-1] + np.diff(s)[1:])
        inner = solve_banded((1, 1), band[:, 1:-1], weight)
        return bool((weight @ inner).real < 0)

    def bend(self, s, tension, moment):
        """Angles θ at the nodes."""
        band = self.matrix(s, tension, moment)
        h = np.diff(s)
        weight = np.zeros(len(s))
        weight[:-1] += h / 2
        weight[1:] += h / 2
        right = np.zeros((len(s), 2), complex)
        right[1, 0] -= band[2, 0] * self.tilts[0]
        right[-2, 0] -= band[0, -1] * self.tilts[1]
        right[:, 1] = weight
        inner = solve_banded((1, 1), band[:, 1:-1], right[1:-1])
        theta = np.concatenate([[self.tilts[0]], inner[:, 0], [self.tilts[1]]])
        theta[1:-1] -= (weight @ theta) / (weight[1:-1] @ inner[:, 1]) * inner[:, 1]
        return theta

    def shortened(self, s, theta):
        a, b = theta[:-1], theta[1:]
        return float(np.diff(s) @ (abs(a) ** 2 + abs(b) ** 2 + (a * b.conj()).real)) / 6

    def energy(self, turns=0):
        """Least energy of the rods with this many whole turns more."""
        moment, area = 0.0, 0.0
        turned = 0.0 if self.free else self.turn + 2 * np.pi * turns
        for _ in range(8):
            moment = self.ratio * (turned - area)
            s, theta = self.solved(moment)
            change = 0.5 * float((theta[:-1].conj() * theta[1:]).imag.sum()) - area
            area += change
            if self.free or abs(change) < 1e-9:
                break
        bending = 0.5 * float((abs(np.diff(theta)) ** 2 / np.diff(s)).sum())
        return bending, 0.0 if self.free else 0.5 * moment**2 / self.ratio

    def solved(self, moment):
        tilt = max(map(abs, self.tilts))
        root = max(tilt**2 / self.shortening, 6.0)
        s = self.mesh(root, moment)
        high = 100.0 + 0.25 * moment**2
        low = 0.25 * moment**2 - 45.0
        for _ in range(60):  # the buckling tension
            middle = 0.5 * (low + high)
            if self.definite(s, middle, moment):
                high = middle
            else:
                low = middle
            if high - low < 1e-9 * (1 + abs(high)):
                break
        limit = high

        def excess(log):
            theta = self.bend(s, limit + np.exp(log), moment)
            return np.log(max(self.shortened(s, theta), 1e-300) / self.shortening)

        lowest = np.log(1e-7 * (1 + abs(limit)))
        straight = self.tilts[1]
        for size in (1e-3, 3e-3, 1e-2, 3e-2):
            if excess(lowest) > 0:
                break
            # buckled: the direction is free, and so is a tilt that chooses one
            self.tilts[1] = straight + size * np.sqrt(self.shortening)
        log = brentq(excess, lowest, 60.0, xtol=1e-10)
        theta = self.bend(s, limit + np.exp(log), moment)
        self.tilts[1] = straight
        return s, theta

    def lowest(self):
        """(bending, twisting) energy of the lowest rod."""
        turns = (0,) if self.free else (0, 1, -1)
        return min((self.energy(n) for n in turns), key=sum)
