"""One function over many tasks: here, on a local cluster, or on a scheduler that is there already.

A task that raises, or that takes its worker down with it, is an outcome like any other. What a dead
worker had in hand is given to another one by dask. A task that was under way on several workers
when they died is tried once more alone, for its neighbour may have been the cause. What ends them
all is an exception: no worker starts, the scheduler is gone, the disk is full.
"""

import errno
import importlib
import logging
import signal
import time
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from typing import Any

from loopelastica._checks import optional, text, whole
from loopelastica._files import OutputError
from loopelastica.errors import LoopelasticaError, MissingDependencyError
from loopelastica.molecule.reading import first_line

# deaths of a worker after which a task that was on it is not given out again
DEATHS = 2
# tasks given out per thread: enough to keep it busy, few enough that memory stays flat
AHEAD = 3
# how long a local cluster may be without any worker: a dead one is replaced within a few seconds
PATIENCE_S = 30.0
# a disk that takes nothing more, whatever the task
_NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EROFS)


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of a task: its value, or a sentence.

    `final`: another try would end the same way; `lost`: its workers died.
    """

    task: Any
    value: Any = None
    failure: str | None = None
    final: bool = True
    lost: bool = False


def outcomes(
    function: Callable[[Any], Any],
    tasks: Iterable[Any],
    jobs: int = 1,
    scheduler: str | None = None,
) -> Generator[Outcome, None, None]:
    """Apply a function to every task, yielding outcomes as they come.

    Parameters
    ----------
    function : callable
        Importable by name on the workers; its values can be pickled.
    tasks : iterable
        Taken one by one, a few ahead of the workers.
    jobs : int
        Processes of a local cluster; 1 works here, in order, without dask.
    scheduler : str, optional
        Address of a running dask scheduler, used instead. Its workers need this package and the
        same file system.

    Yields
    ------
    Outcome

    Raises
    ------
    MissingDependencyError
        If dask is needed and not installed.
    ValueError
        If `jobs` is no whole number, 1 or more, or `scheduler` no address.
    LoopelasticaError
        If the scheduler cannot be reached or is gone, or no worker starts.
    OutputError
        If the disk takes no more.
    """
    jobs = check_workers(jobs, scheduler)
    if jobs == 1 and scheduler is None:
        for task in tasks:
            yield attempt(function, task)
        return
    with ExitStack() as stack:
        client = _client(stack, jobs, scheduler)
        lost = []
        for outcome in _on_workers(client, function, tasks, jobs):
            if outcome.lost:
                lost.append(outcome.task)
            else:
                yield outcome
        for task in lost:
            yield from _on_workers(client, function, [task], jobs)


def check_workers(jobs: int, scheduler: str | None) -> int:
    """The number of processes, if there can be work on so many, or on this scheduler.

    Parameters
    ----------
    jobs, scheduler
        As for :func:`outcomes`; whether the scheduler answers is not tried.

    Returns
    -------
    int

    Raises
    ------
    MissingDependencyError, ValueError
        As :func:`outcomes` does.
    """
    jobs = whole(1)("jobs", jobs)
    if optional(text)("scheduler", scheduler) is None and jobs == 1:
        return jobs
    try:
        comm = importlib.import_module("distributed.comm")
    except ImportError:
        raise MissingDependencyError(
            "several processes need dask; install it with `pip install loopelastica[scale]`"
        ) from None
    if scheduler is not None:
        try:
            scheme, place = comm.parse_address(scheduler)
            comm.registry.get_backend(scheme)
            if scheme != "inproc":
                comm.parse_host_port(place)
        except ValueError as error:
            raise ValueError(
                f"`scheduler` is {scheduler!r}; it must be like tcp://host:8786 ({error})"
            ) from None
    return jobs


def attempt(function: Callable[[Any], Any], task: Any) -> Outcome:
    """The outcome of one task; nothing it raises gets out.

    Parameters
    ----------
    function : callable
        What is done.
    task : Any
        Its argument.

    Returns
    -------
    Outcome

    Raises
    ------
    OutputError
        If the disk takes no more: then it would be the same with the next task.
    """
    try:
        return Outcome(task, function(task))
    except MissingDependencyError as error:
        return Outcome(task, failure=str(error), final=False)
    except LoopelasticaError as error:
        return Outcome(task, failure=str(error))
    except OutputError as error:
        if error.errno in _NO_ROOM:
            raise
        return Outcome(task, failure=str(error), final=False)
    except OSError as error:
        return Outcome(
            task, failure=f"{error.filename or task}: {error.strerror or error}", final=False
        )
    except ValueError as error:
        # of an argument that only this file shows to be wrong: the sentence says all
        failure = f"{task}: {error}" if str(error).startswith("`") else _unforeseen(task, error)
        return Outcome(task, failure=failure, final=False)
    # one file must not stop the others, whatever is wrong with it
    except Exception as error:
        return Outcome(task, failure=_unforeseen(task, error), final=False)


def _unforeseen(task: Any, error: BaseException) -> str:
    return f"{task}: {type(error).__name__}: {first_line(error)}"


def _client(stack: ExitStack, jobs: int, scheduler: str | None) -> Any:
    dask = importlib.import_module("dask")
    distributed = importlib.import_module("distributed")
    stack.enter_context(_silence())
    if scheduler is not None:
        try:
            return stack.enter_context(distributed.Client(scheduler, timeout="10s"))
        # TypeError: an encrypted one, whose certificate is configured nowhere
        except (OSError, ValueError, TypeError) as error:
            raise LoopelasticaError(
                f"the scheduler at {scheduler} cannot be reached ({error})"
            ) from None
    stack.enter_context(dask.config.set({"distributed.scheduler.allowed-failures": DEATHS}))
    cluster = stack.enter_context(_cluster(distributed))
    for _ in range(jobs):
        cluster.worker_spec.update(cluster.new_worker_spec())

    async def started() -> None:
        await cluster

    # raised where a worker has died at its start, when all others are there
    with suppress(RuntimeError):
        cluster.sync(started)
    for name in [n for n, worker in cluster.workers.items() if worker.status.name != "running"]:
        del cluster.workers[name], cluster.worker_spec[name]
    client = stack.enter_context(distributed.Client(cluster))
    if not client.nthreads():
        raise LoopelasticaError(f"none of {jobs} worker processes has started")
    return client


@contextmanager
def _cluster(distributed: Any) -> Iterator[Any]:
    """A local cluster that has no workers yet."""
    with _deaf_children():
        cluster = distributed.LocalCluster(
            n_workers=0, threads_per_worker=1, processes=True, dashboard_address=None,
            silence_logs=50,
        )  # fmt: skip
    try:
        yield cluster
    finally:
        # a worker that is just being started cannot be closed; it ends with this process
        with suppress(Exception):
            cluster.close(timeout=5)


@contextmanager
def _silence() -> Iterator[None]:
    """Keep dask's remarks from the terminal: what a user should be aware of is an exception."""
    loggers = [logging.getLogger(name) for name in ("distributed", "distributed.client")]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    yield
    # not after an error: what is still closing then would go on talking
    for logger, level in zip(loggers, levels, strict=True):
        logger.setLevel(level)


@contextmanager
def _deaf_children() -> Iterator[None]:
    """Let a cluster that is made in this block, with all workers it ever starts, hear no Ctrl-C.

    The terminal sends it to every process of a group; this one ends the others. A signal that is
    blocked here stays so in the threads and processes that come of this block.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    # else the first process that is started would start it, and free the signal
    importlib.import_module("multiprocessing.resource_tracker").ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _on_workers(
    client: Any, function: Callable[[Any], Any], tasks: Iterable[Any], jobs: int
) -> Iterator[Outcome]:
    distributed = importlib.import_module("distributed")
    waiting = iter(tasks)
    given: dict[Any, Any] = {}

    def give(n: int) -> None:
        for _, task in zip(range(n), waiting, strict=False):
            given[client.submit(attempt, function, task, pure=False)] = task

    try:
        give(AHEAD * max(jobs, sum(client.nthreads().values())))
        while given:
            for future in _finished(client, list(given)):
                yield _outcome(future, given.pop(future))
                future.release()
                give(1)
    except OutputError:
        raise
    except (distributed.CancelledError, OSError):
        raise LoopelasticaError("the scheduler is gone") from None


def _outcome(future: Any, task: Any) -> Outcome:
    if future.status == "finished":
        outcome: Outcome = future.result()
        return outcome
    error = future.exception()
    if isinstance(error, OutputError):
        raise error
    if type(error).__name__ == "KilledWorker":
        sentence = f"{task}: the workers it was on died; it is left out"
        return Outcome(task, failure=sentence, final=False, lost=True)
    return Outcome(task, failure=_unforeseen(task, error), final=False)


def _finished(client: Any, futures: list[Any]) -> list[Any]:
    """Those that are done, one at least; LoopelasticaError where no worker is left."""
    distributed = importlib.import_module("distributed")
    last_seen = time.monotonic()
    while True:
        try:
            done = distributed.wait(futures, timeout=1.0, return_when="FIRST_COMPLETED").done
            return [future for future in futures if future in done]
        except TimeoutError:
            # what a scheduler of others has no workers for may still get them
            if client.cluster is None or client.nthreads():
                last_seen = time.monotonic()
            elif time.monotonic() - last_seen > PATIENCE_S:
                raise LoopelasticaError("all worker processes have died") from None
