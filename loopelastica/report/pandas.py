"""pandas for those who have it (extra ``table``)."""

import importlib
from typing import Any

from loopelastica.errors import MissingDependencyError


def pandas() -> Any:
    """The module pandas.

    Raises
    ------
    MissingDependencyError
        If it is not installed.
    """
    try:
        return importlib.import_module("pandas")
    except ImportError:
        raise MissingDependencyError(
            "tables need pandas; install it with `pip install loopelastica[table]`"
        ) from None
