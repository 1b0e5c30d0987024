"""Two runs in one folder exclude each other; a dead one excludes nobody."""

import errno
import os
import subprocess
import sys

import pytest

from loopelastica._files import OutputError
from loopelastica.batch import lock
from loopelastica.batch.lock import alone_in
from loopelastica.errors import LoopelasticaError

HOLDER = """
import sys, time
from pathlib import Path
from loopelastica.batch.lock import alone_in
with alone_in(Path(sys.argv[1])):
    print("locked", flush=True)
    time.sleep(60)
"""


@pytest.fixture
def holder(tmp_path):
    command = [sys.executable, "-c", HOLDER, str(tmp_path)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "locked\n"
    yield process
    process.kill()
    process.wait()
    process.stdout.close()


def enter(folder):
    with alone_in(folder):
        return [p.name for p in folder.iterdir()]


def test_a_folder_has_room_for_one_run_and_nothing_is_left_of_the_lock(tmp_path):
    out = tmp_path / "new" / "out"
    with alone_in(out), pytest.raises(LoopelasticaError, match="out: another run is at work"):
        enter(out)
    assert not out.exists()
    assert enter(out) == [lock._NAME]
    out.mkdir()
    enter(out)
    assert list(out.iterdir()) == []


def test_the_lock_dies_with_the_process_that_holds_it(tmp_path, holder):
    with pytest.raises(LoopelasticaError, match="another run"):
        enter(tmp_path)
    holder.kill()
    holder.wait()
    assert enter(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_lock_file_that_is_removed_in_between_is_no_lock(tmp_path, monkeypatch):
    flock, seen = lock.fcntl.flock, []

    def removed_once(handle, how):
        if not seen:
            (tmp_path / lock._NAME).unlink()
        seen.append(handle)
        flock(handle, how)

    monkeypatch.setattr(lock.fcntl, "flock", removed_once)
    assert enter(tmp_path) == [lock._NAME]
    assert len(seen) == 2


@pytest.mark.parametrize("code", [errno.ENOLCK, errno.EOPNOTSUPP])
def test_where_the_file_system_has_no_locks_the_run_goes_on(tmp_path, monkeypatch, code):
    def refuse(handle, how):
        raise OSError(code, os.strerror(code))

    monkeypatch.setattr(lock.fcntl, "flock", refuse)
    assert enter(tmp_path)


def test_where_the_system_has_no_locks_the_run_goes_on(tmp_path, monkeypatch):
    monkeypatch.setattr(lock, "fcntl", None)
    assert enter(tmp_path)


def test_a_folder_that_cannot_be_made_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match=r"file: cannot be written \(a file is there\)"):
        enter(tmp_path / "file")
    with pytest.raises(OutputError, match=r"file/out: cannot be written"):
        enter(tmp_path / "file" / "out")
