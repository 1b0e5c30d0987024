"""One run at a time in a folder, by a lock of the operating system.

The system releases the lock when the process ends, however it ends; nothing has to be cleared away
by hand. Where there are no such locks (another system, some network file systems) the run goes on
without.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from loopelastica._files import make_folder, writing
from loopelastica.errors import LoopelasticaError

try:
    import fcntl
except ImportError:  # no POSIX system
    fcntl = None  # type: ignore[assignment]

_NAME = ".loopelastica.lock"


@contextmanager
def alone_in(folder: Path) -> Iterator[None]:
    """Make a folder, and keep other runs out of it while the block lasts.

    Parameters
    ----------
    folder : Path
        Of the results.

    Raises
    ------
    LoopelasticaError
        If another run is at work there.
    OutputError
        If the folder cannot be made or written to.
    """
    made = not folder.exists()
    make_folder(folder)
    path = folder / _NAME
    handle = _locked(path)
    if handle is None:
        raise LoopelasticaError(
            f"{folder}: another run is at work in this folder; wait for its end, or choose another"
            " folder"
        )
    try:
        yield
    finally:
        # before the lock goes, so that nobody locks a file that is then removed
        with suppress(OSError):
            path.unlink()
            if made:
                folder.rmdir()  # where nothing has come of it; any other is refused
        os.close(handle)


def _locked(path: Path) -> int | None:
    """The open file, locked where locks are to be had; None where another process has it."""
    while True:
        with writing(path.parent):
            handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        try:
            if fcntl is not None:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(handle)
            return None
        except OSError:
            return handle  # a file system without locks
        with suppress(OSError):
            if os.path.samestat(os.fstat(handle), path.stat()):
                return handle
        # its former owner has removed it in between
        os.close(handle)
