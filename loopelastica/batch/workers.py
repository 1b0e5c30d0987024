"""One function over many tasks: here, on a local cluster, or on a scheduler that is there already.

A task that raises, or that takes its worker down with it, is an outcome like any other. What a dead
worker had in hand is given to another one by dask. A task that was under way on several workers
when they died is tried once more alone, for its neighbour may have been the cause.
"""

import importlib
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

from loopelastica.errors import LoopelasticaError, MissingDependencyError

# deaths of a worker after which a task that was on it is not given out again
DEATHS = 2
# tasks given out per thread: enough to keep it busy, few enough that memory stays flat
AHEAD = 3


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
) -> Iterator[Outcome]:
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
        If `jobs` is below 1 or the scheduler cannot be reached.
    """
    if jobs < 1:
        raise ValueError(f"`jobs` is {jobs}; it must be 1 or more")
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
    """
    try:
        return Outcome(task, function(task))
    except LoopelasticaError as error:
        return Outcome(task, failure=str(error))
    except OSError as error:
        return Outcome(
            task, failure=f"{error.filename or task}: {error.strerror or error}", final=False
        )
    # one file must not stop the others, whatever is wrong with it
    except Exception as error:
        return Outcome(task, failure=f"{task}: {type(error).__name__}: {error}", final=False)


def _client(stack: ExitStack, jobs: int, scheduler: str | None) -> Any:
    try:
        dask = importlib.import_module("dask")
        distributed = importlib.import_module("distributed")
    except ImportError:
        raise MissingDependencyError(
            "several processes need dask; install it with `pip install loopelastica[scale]`"
        ) from None
    if scheduler is not None:
        try:
            return stack.enter_context(distributed.Client(scheduler, timeout="10s"))
        except (OSError, ValueError) as error:
            raise ValueError(f"`scheduler` {scheduler!r} cannot be reached ({error})") from None
    stack.enter_context(
        dask.config.set({"distributed.scheduler.allowed-failures": DEATHS, "logging": {}})
    )
    cluster = distributed.LocalCluster(
        n_workers=jobs, threads_per_worker=1, processes=True, dashboard_address=None,
        silence_logs=50,
    )  # fmt: skip
    return stack.enter_context(distributed.Client(stack.enter_context(cluster)))


def _on_workers(
    client: Any, function: Callable[[Any], Any], tasks: Iterable[Any], jobs: int
) -> Iterator[Outcome]:
    distributed = importlib.import_module("distributed")
    waiting = iter(tasks)
    running = distributed.as_completed([])
    given: dict[str, Any] = {}

    def give(n: int) -> None:
        for _, task in zip(range(n), waiting, strict=False):
            future = client.submit(attempt, function, task, pure=False)
            given[future.key] = task
            running.add(future)

    give(AHEAD * max(jobs, sum(client.nthreads().values())))
    for future in running:
        task = given.pop(future.key)
        if future.status == "finished":
            yield future.result()
        else:
            sentence = f"{task}: the workers it was on died; it is left out"
            yield Outcome(task, failure=sentence, final=False, lost=True)
        future.release()
        give(1)
