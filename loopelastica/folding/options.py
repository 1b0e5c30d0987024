"""Options of folding: one frozen object per kind of work, each value checked when it is made.

    options = FoldOptions(free_spin=False, torsion_ratio=0.8)

Public functions take the fields of such a class as keywords (:func:`keywords`), so that names,
defaults, ranges and units stand here and nowhere else.
"""

import inspect
import re
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, fields
from functools import update_wrapper
from typing import Any, Concatenate, ParamSpec, TypeVar, cast

from loopelastica._checks import (
    Check,
    between,
    file_name,
    flag,
    known_keywords,
    numbers,
    one_of,
    optional,
    positive,
    whole,
)
from loopelastica.molecule.clamp_rule import RNA_TAPER
from loopelastica.molecule.nucleotides import MAX_ATOMS, MAX_SIZE_MB, Limits
from loopelastica.molecule.selection import brackets, likeness, places

TAPER_MAX = 0.3
"""Beyond, the continued strand would turn straight to its axis."""

PERSISTENCE_LENGTH_A = 10.0
"""Persistence lengths of single strands in print run from 6 Å to several nm; this one only sets the
scale of ``energy_kT``."""

_P = ParamSpec("_P")
_O = TypeVar("_O")
_R = TypeVar("_R")


def option(default: Any, check: Check) -> Any:
    """A field of a class of options, with its default and what checks and converts a value."""
    return field(default=default, metadata={"check": check})


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    """Base of all options: what every value goes through, and its way into a file and back."""

    def __post_init__(self) -> None:
        for item in fields(self):
            value = item.metadata["check"](item.name, getattr(self, item.name))
            object.__setattr__(self, item.name, value)

    def to_dict(self) -> dict[str, Any]:
        """Names and values, JSON-ready; the constructor takes them back."""
        values = {item.name: getattr(self, item.name) for item in fields(self)}
        return {name: list(v) if isinstance(v, tuple) else v for name, v in values.items()}


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopOptions(Options):
    """Which loops are folded, and as what rod.

    Attributes
    ----------
    free_spin : bool
        Let the rod's end turn about its tangent; otherwise the direction to the helix axis is
        clamped too and `torsion_ratio` matters.
    torsion_ratio : float
        K3/K0 of the backbone, positive; unmeasured for single strands.
    length_per_nucleotide_A : float, optional
        Length of the rod per nucleotide, Å; default 6.0 (RNA) or 6.3 (DNA).
    persistence_length_A : float
        Scale of ``energy_kT`` (K0 = kT·lp), Å.
    irregular : bool
        Fold loops too whose stem is no A or B helix: the ideal strand misses it by more than 1.3 Å.
    pair, loop : str or list of str
        Pairs beside those of the coordinates, such as "A.12-A.25"; loops in place of those found,
        such as "A.13-24", which may be absent from the file. See :func:`find_hairpins`.
    dot_bracket : str, optional
        Secondary structure in place of the pairs of the coordinates.
    max_size_MB, max_atoms : float, int
        How large a file may be: megabytes after decompression, atoms of a model.
    """

    free_spin: bool = option(True, flag)
    torsion_ratio: float = option(1.0, positive)
    length_per_nucleotide_A: float | None = option(None, optional(positive))
    persistence_length_A: float = option(PERSISTENCE_LENGTH_A, positive)
    irregular: bool = option(False, flag)
    pair: str | Sequence[str] = option((), places)
    loop: str | Sequence[str] = option((), places)
    dot_bracket: str | None = option(None, optional(brackets))
    max_size_MB: float = option(MAX_SIZE_MB, positive)
    max_atoms: int = option(MAX_ATOMS, whole(1))

    @property
    def selection(self) -> dict[str, Any]:
        """What :func:`find_hairpins` takes: `pair`, `dot_bracket` and `loop`."""
        return {"pair": self.pair, "dot_bracket": self.dot_bracket, "loop": self.loop}

    @property
    def limits(self) -> Limits:
        """How large a file may be."""
        return Limits(self.max_size_MB, self.max_atoms)


@dataclass(frozen=True, slots=True, kw_only=True)
class FoldOptions(LoopOptions):
    """Options of :func:`loopelastica.fold`: those of `LoopOptions`, and how a loop is clamped.

    Attributes
    ----------
    stem_extend_5, stem_extend_3 : int, optional
        Loop nucleotides laid on the continued 5' and 3' strand of the stem. Default: the rule of
        :mod:`loopelastica.molecule.clamp_rule`, less where the rod could not span its ends.
    taper : float, optional
        Loss of radius per nucleotide of the continued 3' strand, in units of its radius, 0 to 0.3.
        Default: the same rule. ``stem_extend_5=0, stem_extend_3=0, taper=0`` clamps at the closing
        pair.
    energy_max : float, optional
        Highest dimensionless energy E·L/K0 listed; default as in :func:`equilibria`.
    max_candidates : int
        Most candidates kept per loop, 1 or more.
    all_models : bool
        Fold each model of a file with its own clamp and compare it with its own loop.
    shapes : {"all", "rod"}
        "rod": only rods clamped by the rule, no shapes of other loops.
    rank : {"default", "energy"}
        Order of the candidates: the one that was measured to be best, or least deformation energy
        per length first. Rods that touch something come last, by energy all that touch.
    like : str, optional
        A structure file whose loop this one is taken to be like, "FILE", or which of its loops,
        "FILE:A.4-A.9", by its closing pair.
    library : str, optional
        File of a library of loops, or a folder of structures to take them from. Default: the
        library that comes with the program.
    exclude_relatives : bool
        Use no shape of a loop that is related to this one, for honest tests.
    surroundings : bool
        Where atoms other than its own hairpin's are near the loop, fold it as a rod in its
        surroundings too.
    """

    stem_extend_5: int | None = option(None, optional(whole(0)))
    stem_extend_3: int | None = option(None, optional(whole(0)))
    taper: float | None = option(None, optional(between(0.0, TAPER_MAX)))
    energy_max: float | None = option(None, optional(positive))
    max_candidates: int = option(10, whole(1))
    all_models: bool = option(True, flag)
    shapes: str = option("all", one_of("all", "rod"))
    rank: str = option("default", one_of("default", "energy"))
    like: str | None = option(None, optional(likeness))
    library: str | None = option(None, optional(file_name))
    exclude_relatives: bool = option(False, flag)
    surroundings: bool = option(True, flag)

    def __post_init__(self) -> None:
        Options.__post_init__(self)
        if self.like is not None and self.shapes == "rod":
            raise ValueError("`like` goes without `shapes` 'rod', which takes no shape of a loop")

    @property
    def clamp(self) -> dict[str, Any]:
        """The fields of a clamp that are given here, not left to the rule."""
        names = ("stem_extend_5", "stem_extend_3", "taper", "length_per_nucleotide_A")
        given = {name: getattr(self, name) for name in names}
        return {name: value for name, value in given.items() if value is not None}


@dataclass(frozen=True, slots=True, kw_only=True)
class ScanOptions(LoopOptions):
    """Options of :func:`loopelastica.scan`: those of `LoopOptions`, and which clamps are solved.

    Attributes
    ----------
    extend_5_max, extend_3_max : int
        Most loop nucleotides laid on the continued 5' and 3' strand, 0 or more.
    tapers : sequence of float
        Tapers of the 3' strand, each 0 to 0.3.
    """

    extend_5_max: int = option(2, whole(0))
    extend_3_max: int = option(3, whole(0))
    tapers: Sequence[float] = option((0.0, RNA_TAPER), numbers(0.0, TAPER_MAX))


def keywords(
    options: Callable[_P, _O],
) -> Callable[[Callable[[Any, _O], _R]], Callable[Concatenate[Any, _P], _R]]:
    """Let a function of a structure and an options object take the options as keywords.

    Signature and docstring of the result show them all: the line ``{options}`` of the docstring
    gives way to the attributes in the docstrings of the options class.

    Parameters
    ----------
    options : type
        A class of options.

    Returns
    -------
    callable
        A decorator.
    """

    def decorator(function: Callable[[Any, _O], _R]) -> Callable[Concatenate[Any, _P], _R]:
        names = option_names(options)
        first = next(iter(inspect.signature(function).parameters))
        made: Callable[..., _O] = options

        def taking(*given: Any, **kwargs: Any) -> _R:
            if first in kwargs:
                given = (*given, kwargs.pop(first))
            if len(given) != 1:
                raise TypeError(
                    f"{function.__name__} takes one argument beside its options, `{first}`;"
                    " options have names"
                )
            known_keywords(function.__name__, kwargs, names)
            return function(given[0], made(**kwargs))

        update_wrapper(taking, function)
        show_options(taking, options)
        return cast(Callable[Concatenate[Any, _P], _R], taking)

    return decorator


def option_names(options: Any, without: Collection[str] = ()) -> list[str]:
    """Names of the fields of a class of options, but for those that are left out."""
    return [name for name in inspect.signature(options).parameters if name not in without]


def show_options(function: Any, options: Any, without: Collection[str] = ()) -> None:
    """Put the fields of an options class into signature and docstring of a function or class.

    Parameters
    ----------
    function : callable
        Its last parameter gives way to the options, and so does ``{options}`` in its docstring.
    options : type
        A class of options.
    without : collection of str
        Options that are left out.
    """
    own = list(inspect.signature(function).parameters.values())[:-1]
    more = [p for p in inspect.signature(options).parameters.values() if p.name not in without]
    returns = inspect.signature(function).return_annotation
    function.__signature__ = inspect.Signature([*own, *more], return_annotation=returns)
    if function.__doc__ is not None:
        # an entry begins where a line is not indented: names, then " : type"
        entries = [
            entry
            for base in reversed(options.__mro__[:-1])
            for entry in re.split(r"\n(?=\S)", inspect.cleandoc(base.__doc__ or ""))
            if " : " in entry and not {*entry.split(" : ")[0].split(", ")} <= {*without}
        ]
        text = "\n".join(entries).replace("\n", "\n    ")
        function.__doc__ = function.__doc__.replace("{options}", text)
