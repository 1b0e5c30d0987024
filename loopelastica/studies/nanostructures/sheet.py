"""A design of scadnano while it is drawn: helices on a lattice or far apart, strands, geometry."""

from __future__ import annotations

import importlib
from copy import copy
from typing import Any, Final

import numpy as np

from loopelastica._arrays import Array
from loopelastica.errors import MissingDependencyError

GEOMETRIES: Final = ("default", "relaxed")
"""Of designs of even and of odd number."""
_RELAXED: Final = {"bases_per_turn": 32 / 3, "inter_helix_gap": 0.1}
_LATTICES: Final = ("square", "honeycomb", "hex")
# least offset of helices
_FIRST: Final = -100
# helices that are far from each other, nm: further than the longest strand reaches
_FAR_NM: Final = 60.0


class Sheet:
    """A design while it is drawn.

    Parameters
    ----------
    rng : numpy.random.Generator
        Of all that is random.
    number : int
        Of the design: its parity chooses the geometry.
    """

    def __init__(self, rng: np.random.Generator, number: int) -> None:
        self.package = package()
        self.rng, self.relaxed = rng, number % 2 == 1
        self.lattice = _LATTICES[number // 2 % len(_LATTICES)]
        self.geometry = self.package.Geometry(**(_RELAXED if self.relaxed else {}))
        self.grid = self.package.Grid[self.lattice]
        self.helices: list[Any] = []
        self.strands: list[Any] = []

    def between(self, low: int, high: int) -> int:
        """A random number from low to high, both included."""
        return int(self.rng.integers(low, high + 1))

    def helix(self, column: int, row: int) -> int:
        """A helix of the lattice; its number."""
        return self._add(grid_position=(column, row))

    def far(self, column: float, group: int) -> int:
        """A helix of a group that is far from other groups, which go on in squares; its number.

        `column` counts helices that are side by side in the group.
        """
        self.grid = self.package.Grid.none
        apart = 2.0 + self.geometry.inter_helix_gap
        place = self.package.Position3D(
            group % 32 * _FAR_NM + column * apart, group // 32 * _FAR_NM, 0.0
        )
        return self._add(position=place)

    def _add(self, **place: Any) -> int:
        # where it ends follows from what is drawn on it
        self.helices.append(self.package.Helix(min_offset=_FIRST, **place))
        return len(self.helices) - 1

    def domain(self, helix: int, forward: bool, start: int, end: int) -> Any:
        """A domain from an offset to before another."""
        return self.package.Domain(helix, forward, start, end)

    def strand(self, *parts: Any) -> None:
        """A strand of domains; a number between them is a loopout of so many nucleotides."""
        made = [self.package.Loopout(part) if isinstance(part, int) else part for part in parts]
        self.strands.append(self.package.Strand(made))

    def duplex(self, helix: int, start: int, end: int) -> None:
        """Both strands."""
        for forward in (True, False):
            self.strand(self.domain(helix, forward, start, end))

    def places(self) -> Array:
        """Where the helices of the lattice are, across their axes (n, 2), nm."""
        places = [helix.calculate_position(self.grid, self.geometry) for helix in self.helices]
        return np.array([[place.x, place.y] for place in places])

    def neighbours(self) -> list[tuple[int, int]]:
        """Helices that are side by side on the lattice."""
        points = self.places()
        apart = np.linalg.norm(points[:, None] - points[None], axis=2)
        first, second = np.nonzero(apart < 1.05 * (2.0 + self.geometry.inter_helix_gap))
        return [(i, j) for i, j in zip(first.tolist(), second.tolist(), strict=True) if i < j]

    def design(self) -> Any:
        """The design as scadnano has it."""
        design = self._drawn(self.strands)
        if self.relaxed:
            # only crossovers turn helices there, so loopouts are taken for crossovers
            twin = self._drawn([self._crossing(strand) for strand in self.strands])
            twin.relax_helix_rolls()
            for index, helix in design.helices.items():
                helix.roll = twin.helices[index].roll
        return design

    def _drawn(self, strands: list[Any]) -> Any:
        return self.package.Design(
            helices=[copy(helix) for helix in self.helices],
            strands=strands,
            grid=self.grid,
            geometry=self.geometry,
        )

    def _crossing(self, strand: Any) -> Any:
        """A strand without its single strands, unless it is a hairpin."""
        domains = [part for part in strand.domains if isinstance(part, self.package.Domain)]
        return self.package.Strand(domains) if len({one.helix for one in domains}) > 1 else strand


def package() -> Any:
    """The package scadnano.

    Raises
    ------
    MissingDependencyError
        If it is not installed.
    """
    try:
        return importlib.import_module("scadnano")
    except ImportError:
        raise MissingDependencyError(
            "the designs of this study are drawn with the package scadnano; install it with"
            " `pip install loopelastica[origami]`"
        ) from None
