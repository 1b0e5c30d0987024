"""The one kind of array that public results hold: float64, read-only; and records of them."""

from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def read_only(values: ArrayLike) -> Array:
    """A float64 copy that cannot be written to."""
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array


class Record:
    """Base of frozen, slotted dataclasses whose arrays are read-only, in copies and pickles too."""

    __slots__ = ()

    def __post_init__(self) -> None:
        for name in _names(self):
            value = getattr(self, name)
            if isinstance(value, np.ndarray):
                value.setflags(write=False)

    def __reduce__(self) -> tuple[Any, ...]:
        # by the constructor: NumPy gives copies of arrays back writeable
        return _made, (type(self), {name: getattr(self, name) for name in _names(self)})


def _names(record: Any) -> list[str]:
    return [item.name for item in fields(record)]


def _made(kind: type[Any], values: dict[str, Any]) -> Any:
    record = kind(**values)
    # a kind that is filled in place does not do so by itself
    Record.__post_init__(record)
    return record
