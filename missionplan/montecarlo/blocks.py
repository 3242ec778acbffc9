"""Blocks run in parallel by processes (loky), threads (joblib) or a Dask cluster.

Parallel map over the items of one call: this process does a part of them while pool workers do the others.
"""

import itertools
import pickle
import warnings
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Executor, Future, wait
from contextlib import closing
from dataclasses import dataclass, replace
from functools import partial
from typing import Generic, Literal, TypeVar, cast

from missionplan.errors import InputError, Problem
from missionplan.montecarlo.dask_cluster import run_on_cluster
from missionplan.montecarlo.pool import PATIENCE, ShippedTask, borrowed_pool, interrupts_deferred, result_of

Item = TypeVar("Item")
Result = TypeVar("Result")
Backend = Literal["loky", "threading", "dask"]
Progress = Callable[[int, int], None]
"""Called with the items done and their total, before the first and after each."""

_MAX_PENDING = 64
"""Results that may wait for an earlier one: the work that this process may do while its workers start."""


@dataclass(frozen=True)
class Workers:
    """Where tasks run, and who is told of those done."""

    jobs: int = 1
    """Processes, this one included, or threads, or workers of a local cluster; -1 uses every core."""
    backend: Backend = "loky"
    scheduler: str | None = None
    """Address of the Dask scheduler, such as ``tcp://10.0.0.1:8786``; without it a local cluster of `jobs`."""
    progress: Progress | None = None

    def run(self, task: Callable[[Item], Result], items: Sequence[Item]) -> Generator[Result, None, None]:
        """Run a task on every item and yield the results in the order of the items, as soon as they are available.

        `task`: deterministic function of its item; picklable where the backend is not threading. `items`: such as block
        numbers. Raises InputError when an option is invalid, Dask is not installed or does not answer, or its workers
        run other code; RunError when a worker process dies, or the cluster is lost.
        """
        if self.backend not in ("loky", "threading", "dask"):
            raise InputError([Problem(f"given {self.backend!r}, expected loky, threading or dask", key="backend")])
        if self.jobs == 0 or self.jobs < -1:
            message = f"given {self.jobs}, expected a positive number, or -1 for every core"
            raise InputError([Problem(message, key="jobs")])
        progress, total = self.progress, len(items)
        if progress is not None:
            progress(0, total)
        with closing(self._results(task, items)) as results:
            for done, result in enumerate(results, start=1):
                if progress is not None:
                    progress(done, total)
                yield result

    def _results(self, task: Callable[[Item], Result], items: Sequence[Item]) -> Generator[Result, None, None]:
        """Results in the order of the items, by the backend; in this process where nothing is gained by others."""
        if not items or (self.backend != "dask" and (self.jobs == 1 or len(items) == 1)):
            return (task(item) for item in items)
        jobs = self.jobs
        if jobs == -1:
            from loky import cpu_count

            jobs = cpu_count()
        if self.backend == "loky":
            return _by_pool(task, items, min(jobs, len(items)) - 1)
        if self.backend == "dask":
            return run_on_cluster(task, items, jobs, self.scheduler)
        return _by_threads(task, items, jobs)

    @property
    def options(self) -> dict[str, object]:
        """Where tasks run, as options of a study."""
        return {"jobs": self.jobs, "backend": self.backend, "scheduler": self.scheduler}

    @property
    def quiet(self) -> "Workers":
        """The same, with nobody told."""
        return replace(self, progress=None)


IN_THIS_PROCESS = Workers()


def _by_pool(task: Callable[[Item], Result], items: Sequence[Item], workers: int) -> Generator[Result, None, None]:
    """Run a part of the items here and the others in the pool, and those too until its workers have started."""
    # What was submitted is never cancelled when the caller stops early or a block fails. A pool that is shut down with
    # a cancelled future in it loses the thread that kills its workers, and the command hangs (loky before 3.7).
    with borrowed_pool(workers) as executor:
        run = _PoolRun(executor, task, items, workers)
        while run.unfinished:
            run.advance()
            yield from run.ready()


class _PoolRun(Generic[Item, Result]):
    """Items to be done, and those begun with the futures of their results, here or in the pool."""

    def __init__(self, executor: Executor, task: Callable[[Item], Result], items: Sequence[Item], workers: int) -> None:
        self._task, self._workers, self._shipped = task, workers, ShippedTask.of(task)
        self._todo = deque(items)
        self._begun: deque[tuple[Item, Future[Result]]] = deque()  # in the order of the items
        self._in_pool: list[Future[Result]] = []
        self._executor = executor
        with interrupts_deferred():
            self._started = self._executor.submit(self._shipped.prepare)

    @property
    def unfinished(self) -> bool:
        """Whether a result is still to come."""
        return bool(self._todo or self._begun)

    def advance(self) -> None:
        """Run one item here, after submitting others to idle workers; where none is left, wait for the pool a while."""
        with interrupts_deferred():
            here = self._next()
            if here is None:
                wait([self._begun[0][1]], PATIENCE)
        if here is not None:
            self._run(*here)

    def _next(self) -> "tuple[Item, Future[Result]] | None":
        """Begin the next item, or the first again that the pool was given before it started."""
        if self._todo and len(self._begun) < _MAX_PENDING:
            self._begun.append((self._todo.popleft(), Future()))
            pair = self._begun[-1]
            # submit items to the pool: one per worker, and once the workers have started another that waits
            self._in_pool = [future for future in self._in_pool if not future.done()]
            wanted = self._workers * (2 if self._started.done() else 1) - len(self._in_pool)
            for item in [self._todo.popleft() for _ in range(min(wanted, len(self._todo)))]:
                self._in_pool.append(self._executor.submit(self._shipped, item))
                self._begun.append((item, self._in_pool[-1]))
            return pair
        if self._started.done():
            return None
        self._begun[0] = self._begun[0][0], Future()
        return self._begun[0]

    def ready(self) -> Iterator[Result]:
        """Yield the results up to the first that is not available yet."""
        while self._begun:
            with interrupts_deferred():
                if not self._begun[0][1].done():
                    return
                result = self._begun.popleft()[1].result()
            yield result

    def _run(self, item: Item, future: "Future[Result]") -> None:
        """Run an item here as a worker would: an error is raised where its result is read."""
        try:
            future.set_result(self._task(item))
        except Exception as error:
            future.set_exception(error)


def _by_threads(task: Callable[[Item], Result], items: Sequence[Item], jobs: int) -> Generator[Result, None, None]:
    import joblib  # processes are the rule

    with joblib.parallel_config(backend="threading", n_jobs=jobs):
        parallel = joblib.Parallel(return_as="generator", batch_size=1, pre_dispatch="2*n_jobs")
    wanted = True
    calls = (joblib.delayed(task)(item) for item in itertools.takewhile(lambda _: wanted, items))
    results = cast("Generator[Result, None, None]", parallel(calls))
    try:
        for result in results:  # noqa: UP028  (`yield from` would close it before the warning filter below)
            yield result
    except GeneratorExit:  # the caller stops early: let the few in flight end
        wanted = False
        for _ in results:
            pass
        raise
    finally:
        with warnings.catch_warnings():  # after an error the remaining blocks are of no interest
            warnings.simplefilter("ignore", UserWarning)
            results.close()


Part = Callable[[Sequence[Item]], list[Result]]
"""Returns a result for each item of a part; deterministic, whatever the other items of the part."""

MAX_PROCESSES = 4
"""Processes beyond which parts become too small to gain time."""


def parallel_map(
    task: "Part[Item, Result]", items: Sequence[Item], *, jobs: int, separately: bool = False
) -> list[Result]:
    """Run a task on items, in this process and in others in parallel.

    Raises RunError when a worker process dies.

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
    """
    if jobs < 2 or len(items) < 2:
        return task(items)
    if separately:
        return list(Workers(min(jobs, MAX_PROCESSES)).run(partial(_alone, task), items))
    from loky.backend.reduction import dumps

    parts = min(jobs, MAX_PROCESSES, len(items))
    with borrowed_pool(min(jobs, MAX_PROCESSES) - 1) as executor:
        # pickled here, not by the executor's thread: this process may change the task's caches while it runs its part
        pickled = [bytes(dumps((task, items[part::parts]))) for part in range(1, parts)]
        with interrupts_deferred():
            futures = [executor.submit(_run_pickled, part) for part in pickled]
        results = [task(items[::parts]), *(result_of(future) for future in futures)]
    return [results[index % parts][index // parts] for index in range(len(items))]


def _alone(task: "Part[Item, Result]", item: Item) -> Result:
    return task([item])[0]


def _run_pickled(content: bytes) -> list[Result]:
    """Run a task on its items, both pickled."""
    task, items = pickle.loads(content)
    results: list[Result] = task(items)
    return results
