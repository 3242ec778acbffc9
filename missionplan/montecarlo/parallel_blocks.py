"""Fan-out of blocks over processes, threads or a cluster: joblib, and its loky, is the only way out of this process."""

import itertools
import warnings
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Future, wait
from contextlib import ExitStack, closing
from importlib import import_module
from typing import Any, Literal, TypeVar

import joblib

from missionplan.errors import InputError
from missionplan.montecarlo.pool import process_pool, shut_down_on_failure, sigint_blocked

Item = TypeVar("Item")
Result = TypeVar("Result")
Backend = Literal["loky", "threading", "dask"]
Progress = Callable[[int, int], None]
"""Called with the items done and their total, before the first and after each."""

_AHEAD = 64
"""Results that may wait for one that comes before them: what this process does while its workers start."""


def run_blocks(
    task: Callable[[Item], Result],
    items: Sequence[Item],
    *,
    jobs: int = 1,
    backend: Backend = "loky",
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> Iterator[Result]:
    """Run a task on every item and yield the results in the items' order, as they come.

    Parameters
    ----------
    task : callable
        Deterministic function of its item; picklable where `backend` is not threading.
    items : sequence
        Such as block numbers.
    jobs : int
        Processes, this one included, or threads, or a local cluster's workers; -1 uses every core.
    backend : {'loky', 'threading', 'dask'}
    scheduler : str, optional
        Address of the Dask scheduler, such as ``tcp://10.0.0.1:8786``; without it a local cluster of `jobs`.
    progress : callable, optional

    Raises
    ------
    InputError
        When the backend is not known, or Dask is not installed or does not answer.
    RunError
        When a worker process dies.
    """
    if backend not in ("loky", "threading", "dask"):
        raise InputError(f"--backend: given {backend!r}, expected loky, threading or dask")
    if jobs == 0 or jobs < -1:
        raise InputError(f"--jobs: given {jobs}, expected a positive number, or -1 for every core")
    results: Generator[Result, None, None]
    jobs = joblib.cpu_count() if jobs == -1 else jobs
    if not items or (backend != "dask" and (jobs == 1 or len(items) == 1)):
        results = (task(item) for item in items)
    elif backend == "loky":
        results = _by_pool(task, items, min(jobs, len(items)) - 1)
    else:
        results = _by_joblib(task, items, jobs, backend, scheduler)
    total = len(items)
    if progress is not None:
        progress(0, total)
    with closing(results):
        for done, result in enumerate(results, start=1):
            if progress is not None:
                progress(done, total)
            yield result


def _by_pool(task: Callable[[Item], Result], items: Sequence[Item], workers: int) -> Generator[Result, None, None]:
    """Do a part here while worker processes do the others; until they have started, do what was meant for them too."""
    todo = deque(items)
    line: deque[tuple[Item, Future[Result]]] = deque()  # those begun, in the items' order
    with shut_down_on_failure():
        executor = process_pool(workers)
        started = executor.submit(_nothing, task)
        elsewhere: list[Future[Result]] = []
        try:
            while todo or line:
                if todo and len(line) < _AHEAD:
                    line.append((todo.popleft(), Future()))
                    own = line[-1]
                    elsewhere = [future for future in elsewhere if not future.done()]
                    wanted = workers * (2 if started.done() else 1) - len(elsewhere)  # one runs, one waits
                    for item in [todo.popleft() for _ in range(min(wanted, len(todo)))]:
                        elsewhere.append(executor.submit(task, item))
                        line.append((item, elsewhere[-1]))
                    _do(task, *own)
                elif not started.done():
                    line[0] = line[0][0], Future()
                    _do(task, *line[0])
                else:
                    wait([line[0][1]])
                while line and line[0][1].done():
                    yield line.popleft()[1].result()
        finally:  # a reader may stop early, or a block fail
            for _, future in line:
                future.cancel()


def _nothing(task: object) -> None:
    """Answer: a worker has started, and has imported what the task needs."""


def _do(task: Callable[[Item], Result], item: Item, future: "Future[Result]") -> None:
    """Run a task in this process as a worker would: an error is raised where the result is read."""
    try:
        future.set_result(task(item))
    except Exception as error:
        future.set_exception(error)


def _by_joblib(
    task: Callable[[Item], Result], items: Sequence[Item], jobs: int, backend: Backend, scheduler: str | None
) -> Generator[Result, None, None]:
    with ExitStack() as stack:
        if backend == "dask":
            stack.enter_context(_dask_client(jobs, scheduler))
        with joblib.parallel_config(backend=backend, n_jobs=jobs):
            parallel = joblib.Parallel(return_as="generator", batch_size=1, pre_dispatch="2*n_jobs")
        wanted = True
        results: Any = parallel(joblib.delayed(task)(item) for item in itertools.takewhile(lambda _: wanted, items))
        try:
            for result in results:  # noqa: UP028  (`yield from` would close it before the filter below)
                yield result
        except GeneratorExit:  # a reader who stops early: let the few in flight end
            wanted = False
            for _ in results:
                pass
            raise
        finally:
            with warnings.catch_warnings():  # after an error nobody asks about the blocks left over
                warnings.simplefilter("ignore", UserWarning)
                results.close()


def _dask_client(jobs: int, scheduler: str | None) -> Any:
    """Connect to a Dask scheduler, or start a local cluster.

    Raises
    ------
    InputError
        When dask.distributed is not installed, or the scheduler does not answer.
    """
    try:
        distributed = import_module("distributed")
    except ImportError as error:
        raise InputError("--backend dask needs dask.distributed: pip install 'missionplan[dask]'") from error
    if scheduler is None:
        with sigint_blocked():
            return distributed.Client(n_workers=jobs, threads_per_worker=1, dashboard_address=None)
    try:
        return distributed.Client(scheduler, timeout="10s")
    except (OSError, ValueError) as error:
        raise InputError(f"--scheduler: no Dask scheduler answers at {scheduler}") from error
