"""Work goes on when workers die: real processes, really killed."""

import os
import signal
import sys
import time

import pytest

from loopelastica.batch.workers import outcomes
from loopelastica.errors import StructureError

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
