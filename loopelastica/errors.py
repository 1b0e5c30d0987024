"""The exceptions a user can meet.

Bad arguments raise :class:`ValueError`; a numerical outcome is never an exception but a status.
"""


class LoopelasticaError(Exception):
    """Base of the exceptions raised by loopelastica.

    Examples
    --------
    >>> import loopelastica as le
    >>> try:
    ...     le.load_library("absent.lib")
    ... except le.LoopelasticaError as error:
    ...     print(error)
    absent.lib: there is no such file; a library was expected
    """


class StructureError(LoopelasticaError):
    """A structure, or one loop of it, cannot be used; the message names what and why.

    Examples
    --------
    >>> import loopelastica as le
    >>> le.fold("absent.pdb")
    Traceback (most recent call last):
        ...
    loopelastica.errors.StructureError: absent.pdb: there is no such file
    """


class MissingDependencyError(LoopelasticaError):
    """An optional package is needed for this input; the message names the extra to install.

    Examples
    --------
    >>> import sys
    >>> from unittest.mock import patch
    >>> import loopelastica as le
    >>> with patch.dict(sys.modules, pandas=None):
    ...     try:
    ...         le.to_dataframe([])
    ...     except le.MissingDependencyError as error:
    ...         print(error)
    tables need pandas; install it with `pip install loopelastica[table]`
    """
