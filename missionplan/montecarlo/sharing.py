"""One call's items shared among processes: a part is done here while loky's workers do the others."""

from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any, TypeVar

from joblib.externals.loky import get_reusable_executor
from joblib.externals.loky.process_executor import BrokenProcessPool
from threadpoolctl import threadpool_limits

from missionplan.errors import RunError

Item = TypeVar("Item")
Result = TypeVar("Result")
Part = Callable[[Sequence[Item]], list[Result]]
"""Gives a result for each item; deterministic, whatever the other items of its part are."""

MOST = 4
"""Processes beyond which parts are too small to gain."""


def start_workers(jobs: int, module: str) -> None:
    """Start the workers of `shared`; they import a module while this process goes on."""
    if jobs > 1:
        _executor(jobs).submit(import_module, module)


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
    jobs = min(jobs, MOST, len(items))
    if jobs < 2:
        return task(items)
    executor = _executor(jobs)
    try:
        futures = [executor.submit(_alone, task, items[part::jobs]) for part in range(1, jobs)]
        parts = [task(items[::jobs]), *(future.result() for future in futures)]
    except KeyboardInterrupt:
        executor.shutdown(wait=False, kill_workers=True)
        raise
    except BrokenProcessPool as error:
        raise RunError("a worker process died (out of memory, or killed)") from error
    return [parts[index % jobs][index // jobs] for index in range(len(items))]


def _executor(jobs: int) -> Any:
    return get_reusable_executor(max_workers=min(jobs, MOST) - 1)


def _alone(task: "Part[Item, Result]", items: Sequence[Item]) -> list[Result]:
    """Run a part as the process that shares it out would."""
    with threadpool_limits(limits=1):
        return task(items)
