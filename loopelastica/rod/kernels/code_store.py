"""Where compiled code is kept, and which is for whom.

Compiled code is kept in folders, by a key that covers the text of every kernel of the package, its
version, Python, numba and llvmlite: numba's own cache asks only the file of the function itself
whether it changed, and answers from yesterday's code when a function that it calls was edited.
These folders are searched:

- one inside the package, or inside an installation of the same text elsewhere on Python's path,
  filled when the wheel is built and never needed to be written to;
- the user's: ``$LOOPELASTICA_CACHE``, else ``loopelastica`` in the user's folder of caches.

In both, code for any processor of an architecture (``portable``) stands beside code for this one.
What is found in neither is compiled, and kept in the user's folder if that can be written. A file
is read only if its checksum is right; another is made anew.
"""

import contextlib
import functools
import hashlib
import logging
import multiprocessing
import os
import re
import shutil
import sys
import sysconfig
import tempfile
import time
import zlib
from pathlib import Path

import llvmlite
import llvmlite.binding as llvm
import numba
from numba.core import config

from loopelastica._files import whole_file
from loopelastica._version import __version__
from loopelastica.rod.kernels.portable import portable_processor

_LOG = logging.getLogger("loopelastica")

# sets of compiled code kept in the user's folder
_KEPT = 8
# the names of such sets, see `key`
_SET = re.compile("[0-9a-f]{20}")
_DIGEST = 32
# seconds for which workers count on what another one has said
_SAID_S = 600.0


def read(path: Path) -> bytes | None:
    """The content of a file of compiled code; None if there is none that is whole."""
    try:
        stored = path.read_bytes()
    except OSError:
        return None
    content = stored[_DIGEST:]
    if hashlib.sha256(content).digest() != stored[:_DIGEST]:
        drop(path, "its checksum is wrong")
        return None
    return zlib.decompress(content)


def write(path: Path, content: bytes) -> None:
    """Write compiled code, compressed, behind its checksum; whole or not at all."""
    packed = zlib.compress(content, 1)
    with whole_file(path) as part:
        part.write_bytes(hashlib.sha256(packed).digest() + packed)


def drop(path: Path, reason: str) -> None:
    """Remove a file that is no use, and log it."""
    _LOG.info("compiled code in %s is made anew: %s", path, reason)
    with contextlib.suppress(OSError):
        path.unlink(missing_ok=True)


@functools.cache
def key(folder: Path) -> str:
    """Name of the set of compiled code that functions of a folder belong to."""
    here = Path(__file__).resolve().parent
    digest = hashlib.sha256()
    settings = (config.OPT, config.BOUNDSCHECK, config.DEBUGINFO_DEFAULT)
    versions = (__version__, numba.__version__, llvmlite.__version__)
    for value in (*versions, *settings, sys.implementation.cache_tag, sysconfig.get_platform()):
        digest.update(f"{value}\n".encode())
    for place in dict.fromkeys((here, folder.resolve())):
        for path in sorted(place.glob("*.py")):
            content = path.read_bytes()
            digest.update(f"{path.name} {len(content)}\n".encode())
            digest.update(content)
    return digest.hexdigest()[:20]


@functools.cache
def processor() -> str:
    """Name of the processor that is compiled for."""
    name, features = config.CPU_NAME, config.CPU_FEATURES
    if (name, features) == (portable_processor()[0], ""):
        return str(name)
    if name is None:
        name = llvm.get_host_cpu_name()
    if features is None:
        features = llvm.get_host_cpu_features().flatten()
    return f"{name}-{hashlib.sha256(features.encode()).hexdigest()[:8]}"


@functools.cache
def processors() -> tuple[str, ...]:
    """Names of the processors whose code runs here, the best first."""
    portable, needed = portable_processor()
    here = llvm.get_host_cpu_features()
    runs = bool(portable) and all(here.get(feature, False) for feature in needed)
    return tuple(dict.fromkeys((processor(), portable) if runs else (processor(),)))


def shipped_folder() -> Path:
    """Folder of compiled code inside the package."""
    return Path(__file__).resolve().parents[2] / "_compiled"


@functools.cache
def folders() -> tuple[Path, ...]:
    """Folders that are searched, in this order."""
    users = user_folder()
    # a checkout is imported where Python is started in it, an installation of its text being there
    installed = (Path(entry) / "loopelastica" / "_compiled" for entry in sys.path if entry)
    found = dict.fromkeys((shipped_folder(), *(place for place in installed if place.is_dir())))
    return tuple(found) if users is None else (*found, users)


@functools.cache
def user_folder() -> Path | None:
    """The user's folder of compiled code, which need not exist; None where there can be none."""
    chosen = os.environ.get("LOOPELASTICA_CACHE")
    if chosen:
        return Path(chosen).absolute()
    try:
        home = Path.home()
    except RuntimeError:
        return None
    if sys.platform == "darwin":
        return home / "Library" / "Caches" / "loopelastica"
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", home)) / "loopelastica" / "Cache"
    return Path(os.environ.get("XDG_CACHE_HOME") or home / ".cache") / "loopelastica"


@functools.cache
def writable_folder() -> Path | None:
    """The user's folder, if files can be made in it; said once if not."""
    folder = user_folder()
    if folder is None:
        cannot_keep("no home folder")
        return None
    try:
        try_writing(folder)
    except OSError as error:
        cannot_keep(f"{folder}: {error.strerror}")
        return None
    return folder


def said_by_sibling() -> bool:
    """Whether another worker of the same parent has announced the same; otherwise this one has.

    Workers that start with no compiled code all compile, and one sentence is enough.
    """
    parent, folder = multiprocessing.parent_process(), writable_folder()
    if parent is None or folder is None:
        return False
    with contextlib.suppress(OSError):
        for mark in folder.glob("said-*"):
            if time.time() - mark.stat().st_mtime > _SAID_S:
                mark.unlink()
    try:
        (folder / f"said-{parent.pid}").touch(exist_ok=False)
    except FileExistsError:
        return True
    except OSError:
        return False
    return False


def try_writing(folder: Path) -> None:
    """OSError unless files can be made in a folder, which permissions alone do not say."""
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryFile(dir=folder):
        pass


@functools.cache
def cannot_keep(reason: str) -> None:
    """Say once, for each reason, that compiled code stays in memory."""
    _LOG.warning(
        "compiled code cannot be kept (%s); what was not compiled at the installation is compiled"
        " in memory, in each process anew",
        reason,
    )


@functools.cache
def mark_used(place: Path) -> None:
    """Have a set of compiled code count as used now, once in a process."""
    with contextlib.suppress(OSError):
        os.utime(place)


def forget_old(folder: Path) -> None:
    """Remove the sets of compiled code unused for longest, which edits and updates leave behind.

    The folder may be one that the user named: whatever has not the name of a set stays.
    """
    sets = [path for path in folder.iterdir() if path.is_dir() and _SET.fullmatch(path.name)]
    for path in sorted(sets, key=lambda path: path.stat().st_mtime)[: max(0, len(sets) - _KEPT)]:
        shutil.rmtree(path, ignore_errors=True)
