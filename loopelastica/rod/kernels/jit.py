"""How functions are compiled: the one place where numba's options stand.

Compiling is what a first call waits for: the whole cascade takes half a minute. So functions are of
two kinds. Kernels do the arithmetic and are always compiled. Drivers choose which kernels to call;
called from Python they are interpreted, so that only those kernels are compiled that the case at
hand comes to, and called from a kernel (`solve_batch`) they are compiled with it.
"""

import functools
import logging
from collections.abc import Callable
from typing import Any

from numba import njit, types
from numba.core import event

_LOG = logging.getLogger("loopelastica")


class _Teller(event.Listener):  # type: ignore[misc]
    """Logs that the solver is being compiled, once: nobody should wait for it without a word."""

    told = False

    def on_start(self, event: Any) -> None:
        if not self.told:
            self.told = True
            _LOG.info("compiling the solver: once after an installation, half a minute to a minute")

    def on_end(self, event: Any) -> None:
        pass


event.register("numba:compile", _Teller())


def kernel(function: Callable[..., Any]) -> Any:
    """``function`` compiled at its first call, without the interpreter's lock, and cached on disk.

    Numba compiles a function anew for each constant passed to it; that is switched off here, since
    it took a third of the time to compile the solver and made nothing faster. A read-only array is
    another type too: callers hand over copies of what clampings and equilibria protect.
    """
    compiled = njit(cache=True, nogil=True, error_model="numpy")(function)
    specialise = getattr(compiled, "get_call_template", None)
    if specialise is None:
        # compilation is switched off: the function is interpreted
        return compiled

    def without_constants(args: Any, kws: Any) -> Any:
        return specialise(
            tuple(types.unliteral(arg) for arg in args),
            {name: types.unliteral(arg) for name, arg in kws.items()},
        )

    compiled.get_call_template = without_constants
    return compiled


class driver:  # noqa: N801 (a decorator)
    """A function that Python interprets, and that kernels call as a compiled one."""

    def __init__(self, function: Callable[..., Any]) -> None:
        functools.update_wrapper(self, function)
        self._interpreted = function
        self._compiled = kernel(function)

    def __call__(self, *args: Any) -> Any:
        """Interpret it."""
        return self._interpreted(*args)

    @property
    def _numba_type_(self) -> Any:
        return types.Dispatcher(self._compiled)
