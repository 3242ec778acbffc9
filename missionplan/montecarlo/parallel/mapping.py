"""Parallel map over the items of one call: this process does a part of them while pool workers do the others."""

import pickle
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Generic, TypeVar

from missionplan.montecarlo.parallel.blocks import run_blocks
from missionplan.montecarlo.parallel.pool import borrowed_pool, interrupts_deferred, result_of

Item = TypeVar("Item")
Result = TypeVar("Result")
Part = Callable[[Sequence[Item]], list[Result]]
"""Returns a result for each item of a part; deterministic, whatever the other items of the part."""

MAX_PROCESSES = 4
"""Processes beyond which parts become too small to gain time."""


def parallel_map(
    task: "Part[Item, Result]", items: Sequence[Item], *, jobs: int, separately: bool = False
) -> list[Result]:
    """Run a task on items, in this process and in others in parallel.

    Parameters
    ----------
    task : callable
        Of a sequence of items; picklable, as items and results are.
    jobs : int
        Processes, this one included; 1 runs everything here.
    separately : bool
        Whether each item is a part of its own, done by whichever process is free: for items that gain nothing from
        being done together and take unequal times. Otherwise each process does an equal share.

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
    if separately:
        return list(run_blocks(partial(_alone, task), items, jobs=min(jobs, MAX_PROCESSES)))
    parts = min(jobs, MAX_PROCESSES, len(items))
    with borrowed_pool(min(jobs, MAX_PROCESSES) - 1) as executor:
        # pickled here, not by the executor's thread: this process may change the task's caches while it runs its part
        pickled = [_PickledPart.of(task, items[part::parts]) for part in range(1, parts)]
        with interrupts_deferred():
            futures = [executor.submit(part.run) for part in pickled]
        results = [task(items[::parts]), *(result_of(future) for future in futures)]
    return [results[index % parts][index // parts] for index in range(len(items))]


def _alone(task: "Part[Item, Result]", item: Item) -> Result:
    return task([item])[0]


@dataclass(frozen=True)
class _PickledPart(Generic[Item, Result]):
    """A task with its items, pickled."""

    content: bytes

    @classmethod
    def of(cls, task: "Part[Item, Result]", items: Sequence[Item]) -> "_PickledPart[Item, Result]":
        """Pickle a task and its items."""
        from loky.backend.reduction import dumps

        return cls(bytes(dumps((task, items))))

    def run(self) -> list[Result]:
        """Run the task on its items."""
        task, items = pickle.loads(self.content)
        results: list[Result] = task(items)
        return results
