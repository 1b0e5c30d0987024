"""The functions that the energies of oxDNA2 are products of, and their parameters.

Each is a simple curve near its optimum and goes to zero by a parabola b (x − c)² from a given
point on. Value and slope are continuous, so b and the end c of its range follow from that point
(Ouldridge, Louis and Doye, J. Chem. Phys. 134 (2011) 085101, doi:10.1063/1.3552946). The names f1
to f5 and the parameters are those of src/Interactions/DNAInteraction.cpp and src/model.h of
lorenzo-rovigatti/oxDNA; the b and c written out there are the same numbers rounded. Energies are in
its unit, 4.142e-20 J, lengths in 0.8518 nm, angles in radians.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Final

import numpy as np

from loopelastica._arrays import Array


@dataclass(frozen=True, slots=True)
class _End:
    """The parabola b (x − c)² that continues a curve of this value and slope at x = `at`."""

    at: float
    value: float
    slope: float

    @property
    def c(self) -> float:
        """Where the parabola comes to zero."""
        return self.at - 2 * self.value / self.slope

    def __call__(self, x: Array) -> Array:
        return np.asarray(self.slope**2 / (4 * self.value) * (x - self.c) ** 2)


@dataclass(frozen=True, slots=True)
class _Well(ABC):
    """A well of `width` at `r0`, shifted to be zero at `cut`, smoothed but from `low` to `high`."""

    width: float
    r0: float
    cut: float
    low: float
    high: float

    @abstractmethod
    def _value(self, r: Array) -> Array:
        """The curve where it is not smoothed."""

    @abstractmethod
    def _slope(self, r: Array) -> Array:
        """Its derivative."""

    def _end(self, at: float) -> _End:
        x = np.array([at])
        return _End(at, float(self._value(x)[0]), float(self._slope(x)[0]))

    @property
    def range(self) -> float:
        """Distance from which on it is zero."""
        return self._end(self.high).c

    def __call__(self, r: Array) -> Array:
        """Value at distances r (n,)."""
        low, high = self._end(self.low), self._end(self.high)
        inside = (r > low.c) & (r < high.c)
        return np.select(
            [inside & (r <= self.low), inside & (r <= self.high), inside],
            [low(r), self._value(r), high(r)],
            0.0,
        )


class Morse(_Well):
    """f1: a Morse well of unit depth before the shift; `width` is its exponent."""

    __slots__ = ()

    def _value(self, r: Array) -> Array:
        shift = (1 - np.exp(-(self.cut - self.r0) * self.width)) ** 2
        return np.asarray((1 - np.exp(-(r - self.r0) * self.width)) ** 2 - shift)

    def _slope(self, r: Array) -> Array:
        decay = np.exp(-(r - self.r0) * self.width)
        return np.asarray(2 * self.width * decay * (1 - decay))


class Harmonic(_Well):
    """f2: a harmonic well; `width` is its stiffness."""

    __slots__ = ()

    def _value(self, r: Array) -> Array:
        return 0.5 * self.width * ((r - self.r0) ** 2 - (self.cut - self.r0) ** 2)

    def _slope(self, r: Array) -> Array:
        return self.width * (r - self.r0)


@dataclass(frozen=True, slots=True)
class Repulsion:
    """f3: a Lennard-Jones repulsion of strength 2, smoothed beyond `high`.

    Attributes
    ----------
    sigma, high : float
        Where the unsmoothed curve is zero; up to where it is not smoothed.
    """

    sigma: float
    high: float

    @property
    def _end(self) -> _End:
        power = (self.sigma / self.high) ** 6
        slope = 4 * _EXCLUSION * (6 * power - 12 * power**2) / self.high
        return _End(self.high, 4 * _EXCLUSION * (power**2 - power), slope)

    @property
    def range(self) -> float:
        """Distance from which on it is zero."""
        return self._end.c

    def __call__(self, r: Array) -> Array:
        """Value at distances r (n,)."""
        # two sites in one place: huge, not infinite
        power = (self.sigma / np.maximum(r, 1e-6)) ** 6
        inner = 4 * _EXCLUSION * (power**2 - power)
        return np.select([r <= self.high, r < self.range], [inner, self._end(r)], 0.0)


@dataclass(frozen=True, slots=True)
class Angle:
    """f4: 1 − a (θ − θ0)², smoothed where the angle is further off than `plain`.

    Attributes
    ----------
    a, optimum, plain : float
        Width, the best angle θ0, and up to which |θ − θ0| it is not smoothed.
    """

    a: float
    optimum: float
    plain: float

    def __call__(self, cosine: Array) -> Array:
        """Value at angles of these cosines (n,)."""
        return self.at(np.arccos(np.clip(cosine, -1.0, 1.0)))

    def both(self, cosine: Array) -> Array:
        """Sum over an angle and its supplement: of terms that do not ask which way a base looks."""
        return self(cosine) + self(-cosine)

    def at(self, theta: Array) -> Array:
        """Value at angles (n,)."""
        off = np.abs(theta - self.optimum)
        end = _End(self.plain, 1 - self.a * self.plain**2, -2 * self.a * self.plain)
        return np.select([off <= self.plain, off < end.c], [1 - self.a * off**2, end(off)], 0.0)


@dataclass(frozen=True, slots=True)
class Side:
    """f5: 1 for cosines above 0, 1 − a x² below, smoothed below `plain`.

    Attributes
    ----------
    a, plain : float
        Width, and down to which cosine it is not smoothed.
    """

    a: float
    plain: float

    def __call__(self, cosine: Array) -> Array:
        """Value at these cosines (n,)."""
        end = _End(self.plain, 1 - self.a * self.plain**2, -2 * self.a * self.plain)
        return np.select(
            [cosine >= 0, cosine >= self.plain, cosine > end.c],
            [1.0, 1 - self.a * cosine**2, end(cosine)],
            0.0,
        )


@dataclass(frozen=True, slots=True)
class Screened:
    """Debye–Hückel repulsion of two backbone sites, smoothed beyond three Debye lengths.

    Attributes
    ----------
    debye : float
        Debye length.
    """

    debye: float

    @classmethod
    def of(cls, temperature: float, salt_M: float) -> Screened:
        """The repulsion at a temperature (oxDNA's unit) and a salt concentration (mol/l)."""
        return cls(_DEBYE * float(np.sqrt(temperature / 0.1 / salt_M)))

    @property
    def _end(self) -> _End:
        at = 3 * self.debye
        value = _CHARGES * np.exp(-3.0) / at
        return _End(at, value, -value * (1 / self.debye + 1 / at))

    @property
    def range(self) -> float:
        """Distance from which on it is zero."""
        return self._end.c

    def __call__(self, r: Array) -> Array:
        """Value at distances r (n,)."""
        safe = np.maximum(r, 1e-6)
        inner = _CHARGES * np.exp(-safe / self.debye) / safe
        return np.select([r <= 3 * self.debye, r < self.range], [inner, self._end(r)], 0.0)


# EXCL_EPS
_EXCLUSION: Final = 2.0
# dh_strength and dh_lambda of DNA2Interaction.cpp: prefactor, Debye length at 300 K and 1 mol/l
_CHARGES: Final = 0.0543
_DEBYE: Final = 0.3616455

FENE_STRENGTH: Final = 2.0
"""``FENE_EPS``: the bond's energy is −ε/2 ln(1 − (r − r0)² / Δ²)."""

BACKBONE_BACKBONE: Final = Repulsion(0.70, 0.675)
BACKBONE_BASE: Final = Repulsion(0.515, 0.50)
BASE_BASE: Final = Repulsion(0.33, 0.32)
"""Excluded volume (``EXCL_*``), the same among bonded neighbours, where backbones do not repel."""

STACKING: Final = Morse(6.0, 0.4, 0.9, 0.32, 0.75)
STACKING_DEPTH: Final = (1.3523, 2.6717)
"""Depth of stacking at temperature T is the first plus T times the second
(``STCK_BASE_EPS_OXDNA2``, ``STCK_FACT_EPS_OXDNA2``): averages over sequences."""
STACKING_4: Final = Angle(1.3, 0.0, 0.8)
STACKING_5_6: Final = Angle(0.9, 0.0, 0.95)
STACKING_SIDE: Final = Side(2.0, -0.65)

HYDROGEN: Final = Morse(8.0, 0.4, 0.75, 0.34, 0.7)
HYDROGEN_DEPTH: Final = 1.0678
"""``HYDR_EPS_OXDNA2``: average over sequences, of any complementary pair."""
HYDROGEN_1_2_3: Final = Angle(1.5, 0.0, 0.7)
HYDROGEN_4: Final = Angle(0.46, np.pi, 0.7)
HYDROGEN_7_8: Final = Angle(4.0, np.pi / 2, 0.45)

CROSS: Final = Harmonic(47.5, 0.575, 0.675, 0.495, 0.655)
CROSS_1: Final = Angle(2.25, np.pi - 2.35, 0.58)
CROSS_2_3: Final = Angle(1.70, 1.0, 0.68)
CROSS_4: Final = Angle(1.50, 0.0, 0.65)
CROSS_7_8: Final = Angle(1.70, 0.875, 0.68)

COAXIAL: Final = Harmonic(58.5, 0.4, 0.6, 0.22, 0.58)
COAXIAL_1: Final = Angle(2.0, np.pi - 0.25, 0.65)
COAXIAL_4: Final = Angle(1.3, 0.0, 0.8)
COAXIAL_5_6: Final = Angle(0.9, 0.0, 0.95)
COAXIAL_TURNED: Final = (20.0, np.pi - 0.025)
"""oxDNA2 adds 20 (θ1 − 3.1166)² above that angle (``CXST_THETA1_SA``, ``CXST_THETA1_SB``)."""
