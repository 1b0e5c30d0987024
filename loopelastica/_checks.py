"""Checks of arguments: each gives the value back in its own type or a ValueError that names it."""

import difflib
import functools
import inspect
import math
import os
import reprlib
from collections.abc import Callable, Iterable
from numbers import Real
from typing import Any, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

Check = Callable[[str, Any], Any]
T = TypeVar("T")
P = ParamSpec("P")

_SHOWN = 60
_repr = reprlib.Repr()
_repr.maxstring = _repr.maxother = _repr.maxlong = _SHOWN


def shown(value: Any) -> str:
    """What a value looks like, in one short line.

    >>> shown(0.5), shown([1, 2]), len(shown("x" * 1000))
    ('0.5', '[1, 2]', 60)
    """
    text = " ".join(_repr.repr(value).split())
    return text if len(text) <= _SHOWN else f"{text[: _SHOWN - 2]}…{text[-1]}"


def flag(name: str, value: Any) -> bool:
    """True or False, of Python or NumPy; no number, no text."""
    if not isinstance(value, bool | np.bool_):
        raise ValueError(f"`{name}` is {shown(value)}; it must be True or False")
    return bool(value)


def positive(name: str, value: Any) -> float:
    """A positive, finite number."""
    if not (_is_finite(value) and value > 0):
        raise ValueError(f"`{name}` is {shown(value)}; it must be a positive, finite number")
    return float(value)


def finite(name: str, value: Any) -> float:
    """A finite number of either sign."""
    if not _is_finite(value):
        raise ValueError(f"`{name}` is {shown(value)}; it must be a finite number")
    return float(value)


def instance(name: str, value: Any, kind: type[T]) -> T:
    """An object of a class of ours."""
    if not isinstance(value, kind):
        raise ValueError(f"`{name}` is {shown(value)}; it must be of {kind.__name__}")
    return value


def between(low: float, high: float) -> Check:
    """A number from `low` to `high`."""

    def check(name: str, value: Any) -> float:
        if not (_is_finite(value) and low <= value <= high):
            raise ValueError(
                f"`{name}` is {shown(value)}; it must be a number from {low:g} to {high:g}"
            )
        return float(value)

    return check


def whole(least: int) -> Check:
    """A whole number, `least` or more."""

    def check(name: str, value: Any) -> int:
        if not (_is_finite(value) and value == int(value) and value >= least):
            raise ValueError(
                f"`{name}` is {shown(value)}; it must be a whole number, {least} or more"
            )
        return int(value)

    return check


def optional(check: Check) -> Check:
    """None, or what another check lets pass."""
    return lambda name, value: None if value is None else check(name, value)


def one_of(*names: str) -> Check:
    """One of some texts."""

    def check(name: str, value: Any) -> str:
        if not (isinstance(value, str) and value in names):
            known = " or ".join([", ".join(map(repr, names[:-1])), repr(names[-1])])
            raise ValueError(f"`{name}` is {shown(value)}; it must be {known}")
        return value

    return check


def file_name(name: str, value: Any) -> str:
    """A path as a text, not empty."""
    if isinstance(value, os.PathLike):
        value = os.fspath(value)
    if not isinstance(value, str) or not value.strip() or "\0" in value:
        raise ValueError(f"`{name}` is {shown(value)}; it must be the name of a file")
    return value


def text(name: str, value: Any) -> str:
    """A text."""
    if not isinstance(value, str):
        raise ValueError(f"`{name}` is {shown(value)}; it must be a text")
    return value


def texts(name: str, value: Any) -> tuple[str, ...]:
    """One text or a sequence of them, as a tuple."""
    found = (value,) if isinstance(value, str) else value
    if not (isinstance(found, list | tuple) and all(isinstance(one, str) for one in found)):
        raise ValueError(f"`{name}` is {shown(value)}; it must be a text or a list of texts")
    return tuple(found)


def numbers(low: float, high: float) -> Check:
    """One or more numbers from `low` to `high`, as a tuple."""

    def check(name: str, value: Any) -> tuple[float, ...]:
        try:
            found = () if isinstance(value, str) else tuple(value)
        except TypeError:
            found = ()
        if not found:
            raise ValueError(f"`{name}` is {shown(value)}; it must be one or more numbers")
        return tuple(between(low, high)(name, one) for one in found)

    return check


def array(name: str, value: Any) -> NDArray[np.float64]:
    """Real numbers of any shape, finite or not, as a new array of float64.

    No text, no truth values, nothing complex or masked: NumPy would drop what it cannot convert.

    >>> array("position", [0, 0, 1])
    array([0., 0., 1.])
    """
    try:
        found = np.array(value)
    except (TypeError, ValueError, OverflowError):  # rows of unequal length
        found = np.array(None)
    masked = isinstance(value, np.ma.MaskedArray) or np.ma.is_masked(value)
    if found.dtype.kind not in "iuf" or masked:
        raise ValueError(f"`{name}` is {shown(value)}; it must be an array of numbers")
    return np.array(found, dtype=np.float64, order="C")


def _is_finite(value: Any) -> bool:
    try:
        return isinstance(value, Real) and not isinstance(value, bool) and math.isfinite(value)
    except OverflowError:  # a whole number beyond the floating-point ones
        return False


def known_keywords(function: str, given: Iterable[str], known: Iterable[str]) -> None:
    """TypeError for a keyword that a function does not take; the sentence names the nearest.

    Parameters
    ----------
    function : str
        Its name.
    given : iterable of str
        Keywords of the call.
    known : iterable of str
        Keywords that it takes.

    Examples
    --------
    >>> known_keywords("fold", ["tapper"], ["taper", "like"])
    Traceback (most recent call last):
        ...
    TypeError: fold takes no `tapper`; the nearest that it takes is `taper`
    """
    names = [*known]
    for name in given:
        if name in names:
            continue
        near = difflib.get_close_matches(name, names, n=1)
        more = f"the nearest that it takes is `{near[0]}`" if near else f"it takes {_listed(names)}"
        raise TypeError(f"{function} takes no `{name}`; {more}")


def _listed(names: list[str]) -> str:
    return ", ".join(f"`{name}`" for name in names) or "no keyword"


def keywords_known(function: Callable[P, T]) -> Callable[P, T]:
    """Let a function say which keyword it knows in place of one that it does not."""
    parameters = inspect.signature(function).parameters.values()
    names = [p.name for p in parameters if p.kind in (p.KEYWORD_ONLY, p.POSITIONAL_OR_KEYWORD)]

    @functools.wraps(function)
    def checked(*args: P.args, **kwargs: P.kwargs) -> T:
        known_keywords(function.__name__, kwargs, names)
        return function(*args, **kwargs)

    return checked
