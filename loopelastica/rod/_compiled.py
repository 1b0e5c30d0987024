"""How functions are compiled: the one place where numba's options stand."""

from collections.abc import Callable
from typing import Any

from numba import njit, types


def kernel(function: Callable[..., Any]) -> Any:
    """``function`` compiled at its first call, without the interpreter's lock, and cached on disk.

    Numba compiles a function anew for each constant passed to it; that is switched off here, since
    it took a third of the time to compile the solver and made nothing faster.
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
