"""How functions are compiled and where compiled code is kept: the one place that configures numba.

Where compiled code is kept: ``code_store``.

Private names of numba are used here and nowhere else, for the versions that `SUPPORTED` names;
where they are missing, numba's own cache takes over.
"""

import contextlib
import functools
import hashlib
import logging
import pickle
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
from numba import njit, types
from numba.core import event

from loopelastica.rod.kernels import code_store as store

_LOG = logging.getLogger("loopelastica")

# numba's private names are as they are used here from the first on and below the second; the
# second is also the upper bound of the package's requirement
SUPPORTED = (0, 61), (0, 69)


# seconds of compiling after which nobody should wait without a word
_PATIENCE_S = 2.0


class _Announcer(event.Listener):  # type: ignore[misc]
    """Says once why it takes time, when compiling has taken `_PATIENCE_S` in this process.

    A warning is seen without any logging being configured; of several workers one says it.
    """

    def __init__(self) -> None:
        self._depth, self._began, self._spent, self._said = 0, 0.0, 0.0, False

    def on_start(self, event: Any) -> None:
        if self._depth == 0:
            self._began = time.perf_counter()
        self._depth += 1
        self._announce(self._spent + time.perf_counter() - self._began)

    def on_end(self, event: Any) -> None:
        self._depth -= 1
        if self._depth == 0:
            self._spent += time.perf_counter() - self._began
            self._announce(self._spent)

    def _announce(self, spent: float) -> None:
        if self._said or spent < _PATIENCE_S:
            return
        self._said = True
        if store.said_by_sibling():
            return
        kept = "is" if store.writable_folder() else "cannot be"
        _LOG.warning(
            "compiling the solver for this machine, about a minute; the result %s kept for later"
            " runs (`loopelastica warm` compiles beforehand)",
            kept,
        )


event.register("numba:compile", _Announcer())


def kernel(function: Callable[..., Any]) -> Any:
    """``function`` compiled at its first call, without the interpreter's lock, and kept on disk.

    Numba compiles a function anew for each constant passed to it; that is switched off here, since
    it took a third of the time to compile the solver and made nothing faster. A read-only array is
    another type too: callers hand over copies of what clampings and equilibria protect.

    Numba would also optimize a kernel's code anew inside each kernel that calls it, level by level.
    Here what is called from a kernel is left as lowered, a part (`_parts`), and optimized once,
    where a kernel called from Python takes in all its parts.
    """
    own = _private_names_known()
    pipelines = _parts() if own else (None, None)
    whole = njit(nogil=True, error_model="numpy", **_pipeline(pipelines[0]))(function)
    if not hasattr(whole, "get_call_template"):
        # compilation is switched off: the function is interpreted
        return whole
    part = whole
    if own:
        whole._cache = _Cache(function)
        part = njit(
            error_model="numpy",
            no_cpython_wrapper=True,
            no_cfunc_wrapper=True,
            **_pipeline(pipelines[1]),
        )(function)
    else:
        # nowhere to write: compiled in memory
        with contextlib.suppress(RuntimeError):
            whole.enable_caching()
    call_whole, overload_of_whole = whole.get_call_template, whole.get_overload
    call_part, overload_of_part = part.get_call_template, part.get_overload

    def call(args: Any, kws: Any) -> Any:
        args = tuple(types.unliteral(arg) for arg in args)
        kws = {name: types.unliteral(arg) for name, arg in kws.items()}
        # what Python has called is compiled already
        return (call_whole if args in whole.overloads else call_part)(args, kws)

    def overload(signature: Any) -> Any:
        return (overload_of_whole if signature in whole.overloads else overload_of_part)(signature)

    whole.get_call_template, whole.get_overload = call, overload
    return whole


def _pipeline(compiler: Any) -> dict[str, Any]:
    return {} if compiler is None else {"pipeline_class": compiler}


@functools.cache
def _private_names_known() -> bool:
    """Whether numba is a version whose private names are those used here."""
    try:
        version = tuple(int(part) for part in numba.__version__.split(".")[:2])
        from numba.core.codegen import JITCodeLibrary
        from numba.core.compiler import CompileResult
        from numba.core.serialize import dumps
    except (ImportError, ValueError):
        return False
    names: tuple[str, ...] = ("add_linking_library", "finalize", "get_pointer_to_function")
    names += ("enable_object_caching", "_optimize_final_module", "_get_module_for_linking")
    names += ("get_defined_functions",)
    known = callable(dumps) and all(hasattr(JITCodeLibrary, name) for name in names)
    known = known and hasattr(CompileResult, "_reduce") and hasattr(CompileResult, "_rebuild")
    return known and SUPPORTED[0] <= version < SUPPORTED[1]


@functools.cache
def _parts() -> tuple[Any, Any]:
    """Two of numba's compilers: for what Python calls, and for what only kernels call."""
    from types import SimpleNamespace

    from numba.core.codegen import JITCodeLibrary
    from numba.core.compiler import CompilerBase, DefaultPassBuilder

    class Whole(JITCodeLibrary):  # type: ignore[misc]
        """The code of a function called from Python, with all parts that it comes to."""

        def add_linking_library(self, library: Any) -> None:
            super().add_linking_library(library)
            if isinstance(library, Part):
                for part in library._linking_libraries:
                    super().add_linking_library(part)

        def _optimize_final_module(self) -> None:
            # what nothing referred to when it was linked was left out: again, until none is missing
            homes = {
                function.name: library
                for library in self._linking_libraries
                for function in library.get_defined_functions()
            }
            while True:
                missing = dict.fromkeys(
                    homes[function.name]
                    for function in self._final_module.functions
                    if function.is_declaration and function.name in homes
                )
                if not missing:
                    break
                for library in missing:
                    self._final_module.link_in(library._get_module_for_linking(), preserve=True)
            super()._optimize_final_module()

    class Part(Whole):
        """The code of a function called from compiled code: not optimized, not executable."""

        def finalize(self) -> None:
            self._finalized = True

        def get_pointer_to_function(self, name: str) -> int:
            return 0

        @property
        def codegen(self) -> Any:
            """Takes the place of what would put constants into the executable."""
            return SimpleNamespace(set_env=lambda name, env: None)

    def compiler(library: Any) -> Any:
        class Compiler(CompilerBase):  # type: ignore[misc]
            def define_pipelines(self) -> Any:
                codegen, name = self.state.targetctx.codegen(), self.state.func_id.func_qualname
                self.state.library = library(codegen, name)
                self.state.library.enable_object_caching()
                return [DefaultPassBuilder.define_nopython_pipeline(self.state)]

        return Compiler

    return compiler(Whole), compiler(Part)


class _Cache:
    """What numba asks of a function's cache: the compiled code of a signature, or None."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self._source = Path(function.__code__.co_filename)
        self._name = f"{self._source.stem}.{function.__qualname__}".replace("<locals>", "")

    @property
    def cache_path(self) -> str:
        """Folder that new code goes to."""
        folder = store.writable_folder()
        return (
            ""
            if folder is None
            else str(folder / store.key(self._source.parent) / store.processor())
        )

    def enable(self) -> None:
        """It always is."""

    def disable(self) -> None:
        """It cannot be."""

    def flush(self) -> None:
        """Nothing is held back."""

    def load_overload(self, signature: Any, target_context: Any) -> Any:
        """The compiled code of a signature, or None."""
        from numba.core.compiler import CompileResult

        target_context.refresh()
        key, file = store.key(self._source.parent), self._file(signature)
        for folder in store.folders():
            for processor in store.processors():
                path = folder / key / processor / file
                content = store.read(path)
                if content is None:
                    continue
                store.mark_used(folder / key)
                try:
                    return CompileResult._rebuild(target_context, *pickle.loads(content))
                except Exception as error:
                    store.drop(path, str(error) or type(error).__name__)
        return None

    def save_overload(self, signature: Any, result: Any) -> None:
        """Keep compiled code, if there is anywhere to."""
        from numba.core.serialize import dumps

        folder = store.writable_folder()
        if folder is None or result.library.has_dynamic_globals or result.lifted:
            return
        place = folder / store.key(self._source.parent)
        try:
            if not place.is_dir():
                store.forget_old(folder)
            content = dumps(result._reduce())
            store.write(place / store.processor() / self._file(signature), content)
        except OSError as error:
            store.cannot_keep(f"{folder}: {error.strerror}")

    def _file(self, signature: Any) -> str:
        digest = hashlib.sha256(str(signature).encode()).hexdigest()
        return f"{self._name}-{digest[:12]}.bin"
