"""For which processor code is compiled that is to run on others too.

Apart from the rest since the build asks for it before numba is loaded.
"""

import platform

# a processor that nearly all of its architecture can stand for, and what it needs: without the
# vectors of four numbers (x86-64-v2) the shooting is a quarter slower
PORTABLE = {
    "x86_64": ("x86-64-v3", ("avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe")),
    "aarch64": ("generic", ()),
}
_SYNONYMS = {"amd64": "x86_64", "arm64": "aarch64"}


def portable_processor() -> tuple[str, tuple[str, ...]]:
    """A processor that nearly all of this architecture can stand for, and the features it needs.

    No name where none is known.
    """
    architecture = platform.machine().lower()
    return PORTABLE.get(_SYNONYMS.get(architecture, architecture), ("", ()))


def portable_environment() -> dict[str, str]:
    """Environment variables that have code compiled for any processor of this architecture."""
    name, _ = portable_processor()
    return {"NUMBA_CPU_NAME": name, "NUMBA_CPU_FEATURES": ""} if name else {}
