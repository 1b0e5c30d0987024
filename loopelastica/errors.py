"""The exceptions a user can meet.

Bad arguments raise :class:`ValueError`; a numerical outcome is never an exception but a status.
"""


class LoopelasticaError(Exception):
    """Base of the exceptions raised by loopelastica."""


class StructureError(LoopelasticaError):
    """A structure, or one loop of it, cannot be used; the message names what and why."""


class MissingDependencyError(LoopelasticaError):
    """An optional package is needed for this input; the message names the extra to install."""
