"""Work goes on when workers die: real processes, really killed."""

import errno
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from loopelastica._files import OutputError, writing
from loopelastica.batch.workers import attempt, outcomes
from loopelastica.errors import LoopelasticaError, MissingDependencyError, StructureError

ROOT = Path(__file__).resolve().parents[2]

pytestmark = pytest.mark.filterwarnings("ignore")  # remarks of dask when its workers die


def work(task):
    time.sleep(0.05)
    if task == "poison":
        os.kill(os.getpid(), signal.SIGKILL)
    if task == "error":
        raise RuntimeError("inside")
    if task == "absent":
        raise FileNotFoundError(2, "No such file or directory", "absent.pdb")
    if task == "refused":
        raise StructureError("A.G1: a sentence")
    return os.getpid()


@pytest.fixture
def by_value():
    """Workers cannot import a test: send it whole."""
    cloudpickle = pytest.importorskip("cloudpickle")
    pytest.importorskip("distributed")
    module = sys.modules[__name__]
    cloudpickle.register_pickle_by_value(module)
    yield
    cloudpickle.unregister_pickle_by_value(module)


def test_here_one_by_one_in_order():
    found = list(outcomes(work, [1, "error", "refused", 2]))
    assert [o.task for o in found] == [1, "error", "refused", 2]
    assert found[0].value == os.getpid()
    assert found[1].failure == "error: RuntimeError: inside"
    assert found[2].failure == "A.G1: a sentence"
    with pytest.raises(ValueError, match="jobs"):
        list(outcomes(work, [1], jobs=0))


def test_only_what_the_file_itself_is_refused_for_is_final():
    refused, absent, broken = outcomes(work, ["refused", "absent", "error"])
    assert (refused.final, absent.final, broken.final) == (True, False, False)
    assert absent.failure == "absent.pdb: No such file or directory"


@pytest.mark.slow
def test_a_killed_worker_and_a_poisonous_task_lose_nothing(by_value):
    tasks = [*range(12), "poison", "error", *range(12, 40)]
    seen, killed = [], None
    for outcome in outcomes(work, tasks, jobs=2):
        seen.append(outcome)
        if killed is None and outcome.value is not None:
            killed = outcome.value
            os.kill(killed, signal.SIGKILL)
    by_task = {o.task: o for o in seen}
    assert len(seen) == len(by_task) == len(tasks)
    assert by_task["poison"].lost
    assert by_task["error"].failure == "error: RuntimeError: inside"
    numbers = [by_task[k] for k in range(40)]
    assert all(o.failure is None for o in numbers)
    assert len({o.value for o in numbers}) >= 3  # the dead one's place was taken
    assert os.getpid() not in {o.value for o in numbers}


def test_a_scheduler_that_is_there_already_is_used(by_value):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None
    ) as cluster:
        found = list(outcomes(work, range(3), scheduler=cluster.scheduler_address))
    assert sorted(o.task for o in found) == [0, 1, 2]


def writes(task):
    with writing(Path("out/loop")):
        raise OSError(task, os.strerror(task))


def test_a_full_disk_ends_them_all_and_other_refusals_only_one():
    refused = attempt(writes, errno.EACCES)
    assert (refused.failure, refused.final) == (
        "out/loop: cannot be written (Permission denied)", False,
    )  # fmt: skip
    for code in (errno.ENOSPC, errno.EDQUOT, errno.EROFS):
        with pytest.raises(OutputError, match=r"out/loop: cannot be written"):
            attempt(writes, code)


def lacks_extra(task):
    raise MissingDependencyError("install it")


def several_lines(task):
    raise RuntimeError("one\ntwo\nthree")


def test_what_an_extra_is_missing_for_is_tried_again():
    assert not attempt(lacks_extra, 1).final


def test_an_unforeseen_error_is_one_line():
    assert attempt(several_lines, "a.pdb").failure == "a.pdb: RuntimeError: one"


@pytest.mark.parametrize("jobs", [0, -1, 1.5, True, "2", None, float("nan"), [2]])
def test_jobs_are_a_whole_number(jobs):
    with pytest.raises(ValueError, match="`jobs`"):
        list(outcomes(work, [], jobs))


@pytest.mark.parametrize("address", ["nonsense", "", "foo://host:1", "tcp://", "tcp://host", 5])
def test_an_address_that_is_none_is_refused(address):
    pytest.importorskip("distributed")
    with pytest.raises(ValueError, match="`scheduler` is"):
        list(outcomes(work, [], scheduler=address))


SCRIPT = """
import sys
from loopelastica.batch.workers import outcomes
from loopelastica.errors import LoopelasticaError
if __name__ == "__main__":
    try:
        print(sorted(o.value for o in outcomes(abs, range(20), jobs=2)) == list(range(20)))
    except LoopelasticaError as error:
        print(error)
"""
# a worker is a process that multiprocessing spawns; Python imports this module at its start
DIES = """
import os, sys
if any("spawn_main" in word for word in sys.orig_argv):
    try:
        os.close(os.open({path!r}, os.O_CREAT | os.O_EXCL))
    except FileExistsError:
        {others}
    else:
        os._exit(3)
"""


@pytest.mark.parametrize(
    ("others", "said"),
    [("pass", "True\n"), ("os._exit(3)", "none of 2 worker processes has started\n")],
)
def test_workers_that_die_at_their_start(tmp_path, others, said):
    pytest.importorskip("distributed")
    code = DIES.format(path=str(tmp_path / "once"), others=others)
    (tmp_path / "sitecustomize.py").write_text(code)
    (tmp_path / "script.py").write_text(SCRIPT)
    env = {**os.environ, "PYTHONPATH": f"{tmp_path}:{ROOT}"}
    done = subprocess.run(
        [sys.executable, str(tmp_path / "script.py")], env=env, capture_output=True, text=True,
        timeout=120,
    )  # fmt: skip
    assert (done.stdout, done.stderr) == (said, "")


@pytest.mark.slow
def test_a_scheduler_that_dies_is_one_sentence_after_what_was_done(by_value):
    pytest.importorskip("distributed")
    # a worker in the scheduler's own process dies with it
    code = (
        "from distributed import LocalCluster\n"
        "import time\n"
        "cluster = LocalCluster(protocol='tcp', n_workers=1, threads_per_worker=1, processes=False,"
        " dashboard_address=None)\n"
        "print(cluster.scheduler_address, flush=True)\n"
        "time.sleep(120)\n"
    )
    scheduler = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    )
    found = []

    def gather():
        for outcome in outcomes(work, range(200), scheduler=scheduler.stdout.readline().strip()):
            found.append(outcome)
            if len(found) == 3:
                scheduler.kill()

    try:
        with pytest.raises(LoopelasticaError, match=r"^the scheduler is gone$"):
            gather()
    finally:
        scheduler.kill()
        scheduler.wait()
        scheduler.stdout.close()
    assert 3 <= len(found) < 200
    assert all(outcome.failure is None for outcome in found)


def test_a_scheduler_that_does_not_answer_is_one_sentence(monkeypatch):
    distributed = pytest.importorskip("distributed")
    client = distributed.Client
    monkeypatch.setattr(distributed, "Client", lambda a, timeout: client(a, timeout="1s"))
    with pytest.raises(LoopelasticaError, match=r"the scheduler at tcp://127\.0\.0\.1:9 cannot"):
        list(outcomes(work, [1], scheduler="tcp://127.0.0.1:9"))
