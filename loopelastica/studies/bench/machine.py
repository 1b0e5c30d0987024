"""What a time is worth: the machine, the versions and the date."""

import datetime
import importlib.metadata
import os
import platform
from pathlib import Path

_PACKAGES = ("loopelastica", "numpy", "scipy", "numba")


def setting() -> str:
    """One sentence: date, processor, Python and packages."""
    return (
        f"{datetime.date.today().isoformat()}, {_processor()}, {os.cpu_count()} cores,"
        f" {platform.system()}, Python {platform.python_version()}, "
        + ", ".join(f"{name} {_version(name)}" for name in _PACKAGES)
    )


def _version(name: str) -> str:
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return "(not installed)"


def _processor() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def peak_memory_MB() -> float:
    """Largest resident memory of this process so far, in 1e6 bytes (Linux and macOS)."""
    try:
        # getrusage would also count what the parent had before it started this process
        for line in Path("/proc/self/status").read_text(encoding="utf-8").splitlines():
            if line.startswith("VmHWM:"):
                return 1024e-6 * float(line.split()[1])
    except OSError:
        pass
    import resource
    import sys

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return float(peak) * (1e-6 if sys.platform == "darwin" else 1024e-6)
