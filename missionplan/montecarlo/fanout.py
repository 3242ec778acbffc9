"""Fan-out of blocks over processes, threads or a cluster: joblib is the only way out of this process."""

import itertools
import warnings
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import ExitStack, closing
from importlib import import_module
from typing import Any, Literal, TypeVar

import joblib
from joblib.externals.loky import get_reusable_executor
from joblib.externals.loky.process_executor import BrokenProcessPool

from missionplan.errors import InputError, RunError

Item = TypeVar("Item")
Result = TypeVar("Result")
Backend = Literal["loky", "threading", "dask"]
Progress = Callable[[int, int], None]
"""Called with the items done and their total, before the first and after each."""

WORKER_DIED = "a worker process died (out of memory, or killed)"


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
        Workers; 1 runs in this process (unless on a cluster), -1 uses every core.
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
    results: Generator[Result, None, None] = (
        (task(item) for item in items)
        if not items or (backend != "dask" and (jobs == 1 or len(items) == 1))
        else _in_parallel(task, items, jobs, backend, scheduler)
    )
    total = len(items)
    if progress is not None:
        progress(0, total)
    with closing(results):
        for done, result in enumerate(results, start=1):
            if progress is not None:
                progress(done, total)
            yield result


def _in_parallel(
    task: Callable[[Item], Result], items: Sequence[Item], jobs: int, backend: Backend, scheduler: str | None
) -> Generator[Result, None, None]:
    with ExitStack() as stack:
        if backend == "dask":
            stack.enter_context(_dask_client(jobs, scheduler))
        # each worker's BLAS keeps to one thread: the blocks are the parallelism
        options: dict[str, Any] = {"inner_max_num_threads": 1} if backend == "loky" else {}
        with joblib.parallel_config(backend=backend, n_jobs=jobs, **options):
            # no more in flight than loky's call queue holds: killing workers while others wait outside it
            # ends its manager thread with a KeyError
            parallel = joblib.Parallel(return_as="generator", batch_size=1, pre_dispatch="2*n_jobs")
        wanted = True
        results: Any = parallel(joblib.delayed(task)(item) for item in itertools.takewhile(lambda _: wanted, items))
        try:
            for result in results:  # noqa: UP028  (`yield from` would close it before the filter below)
                yield result
        except GeneratorExit:  # a reader who stops early: let the few in flight end, and keep the workers
            wanted = False
            for _ in results:
                pass
            raise
        except KeyboardInterrupt:
            _kill_workers(backend)
            raise
        except BrokenProcessPool as error:
            raise RunError(WORKER_DIED) from error
        finally:
            with warnings.catch_warnings():  # after an error nobody asks about the blocks left over
                warnings.simplefilter("ignore", UserWarning)
                results.close()


def _kill_workers(backend: Backend) -> None:
    """End the worker processes at once, whatever they are doing."""
    if backend == "loky":
        get_reusable_executor().shutdown(wait=False, kill_workers=True)


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
        return distributed.Client(n_workers=None if jobs < 0 else jobs, threads_per_worker=1, dashboard_address=None)
    try:
        return distributed.Client(scheduler, timeout="10s")
    except (OSError, ValueError) as error:
        raise InputError(f"--scheduler: no Dask scheduler answers at {scheduler}") from error
