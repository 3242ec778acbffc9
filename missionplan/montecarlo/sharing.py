"""One call's items shared among processes: a part is done here while loky's workers do the others."""

import pickle
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from importlib import import_module
from typing import Any, TypeVar

from joblib.externals.loky import ProcessPoolExecutor
from joblib.externals.loky.backend.reduction import dumps
from joblib.externals.loky.process_executor import BrokenProcessPool
from threadpoolctl import threadpool_limits

from missionplan.errors import RunError
from missionplan.montecarlo.fanout import WORKER_DIED

Item = TypeVar("Item")
Result = TypeVar("Result")
Part = Callable[[Sequence[Item]], list[Result]]
"""Gives a result for each item; deterministic, whatever the other items of its part are."""

MOST = 4
"""Processes beyond which parts are too small to gain."""


@contextmanager
def started_workers(jobs: int, module: str) -> Iterator[None]:
    """Start the workers of `shared`; they import a module while this process goes on, and end with the context."""
    if jobs < 2:
        yield
        return
    workers = min(jobs, MOST) - 1
    executor = _executor(workers)
    for _ in range(workers):
        executor.submit(import_module, module)
    try:
        yield
    finally:
        _end(executor)


def shared(task: "Part[Item, Result]", items: Sequence[Item], *, jobs: int) -> list[Result]:
    """Run a task on items, in this process and in others at the same time.

    Parameters
    ----------
    task : callable
        Of a sequence of items; picklable, as items and results are.
    items : sequence
    jobs : int
        Processes, this one included; 1 shares nothing.

    Returns
    -------
    list
        A result for each item, in their order.

    Raises
    ------
    RunError
        When a worker process dies.
    """
    if jobs < 2 or len(items) < 2:
        return task(items)
    executor = _executor(min(jobs, MOST) - 1)
    parts = min(jobs, MOST, len(items))
    try:
        # pickled here, not by the executor's thread: the task may keep what it finds while it does its own part
        futures = [executor.submit(_alone, bytes(dumps((task, items[part::parts])))) for part in range(1, parts)]
        results = [task(items[::parts]), *(future.result() for future in futures)]
    except KeyboardInterrupt:
        _end(executor)
        raise
    except BrokenProcessPool as error:
        _end(executor)
        raise RunError(WORKER_DIED) from error
    return [results[index % parts][index // parts] for index in range(len(items))]


@cache
def _executor(workers: int) -> ProcessPoolExecutor:
    """Processes of this module's own: joblib keeps, and replaces, those of its own calls."""
    return ProcessPoolExecutor(max_workers=workers)


def _end(executor: ProcessPoolExecutor) -> None:
    """End the processes at once, whatever they are doing; the next call starts others."""
    _executor.cache_clear()
    executor.shutdown(wait=False, kill_workers=True)


def _alone(pickled: bytes) -> list[Any]:
    """Run a part, a task and its items, as the process that shares it out would."""
    with threadpool_limits(limits=1):
        task, items = pickle.loads(pickled)
        found: list[Any] = task(items)
        return found
