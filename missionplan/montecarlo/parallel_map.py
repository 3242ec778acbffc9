"""One call's items shared among processes: a part is done here while workers do the others."""

import pickle
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from joblib.externals.loky.backend.reduction import dumps

from missionplan.montecarlo.pool import process_pool, shut_down_on_failure

Item = TypeVar("Item")
Result = TypeVar("Result")
Part = Callable[[Sequence[Item]], list[Result]]
"""Gives a result for each item; deterministic, whatever the other items of its part are."""

MAX_PROCESSES = 4
"""Processes beyond which parts are too small to gain."""


def parallel_map(task: "Part[Item, Result]", items: Sequence[Item], *, jobs: int) -> list[Result]:
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
    executor = process_pool(min(jobs, MAX_PROCESSES) - 1)
    parts = min(jobs, MAX_PROCESSES, len(items))
    with shut_down_on_failure():
        # pickled here, not by the executor's thread: the task may keep what it finds while it does its own part
        futures = [executor.submit(_alone, bytes(dumps((task, items[part::parts])))) for part in range(1, parts)]
        results = [task(items[::parts]), *(future.result() for future in futures)]
    return [results[index % parts][index // parts] for index in range(len(items))]


def _alone(pickled: bytes) -> list[Any]:
    """Run a part, a task and its items, as the process that shares it out would."""
    task, items = pickle.loads(pickled)
    found: list[Any] = task(items)
    return found
