"""The worker processes, joblib's own kind (loky): kept from call to call, ended at once when the command is."""

import multiprocessing.resource_tracker
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module

from joblib.externals.loky import ProcessPoolExecutor
from joblib.externals.loky.backend import resource_tracker
from joblib.externals.loky.process_executor import BrokenProcessPool

from missionplan.errors import RunError

WORKER_DIED = "a worker process died (out of memory, or killed)"
_ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS"), "1")

_kept: dict[int, ProcessPoolExecutor] = {}  # one at most, by its number of processes


def process_pool(count: int) -> ProcessPoolExecutor:
    """Give at least so many processes beside this one: those of the last call, where they are enough.

    They are the parallelism: the BLAS of each keeps to one thread.
    """
    if count > max(_kept, default=0):
        for executor in _kept.values():
            executor.shutdown(wait=False)
        _kept.clear()
        with sigint_blocked():
            _kept[count] = ProcessPoolExecutor(max_workers=count, env=_ONE_THREAD)
            _kept[count].submit(int)  # starts them
    return next(iter(_kept.values()))


def _start_trackers() -> None:
    """Start what watches over the workers' locks, told to be silent of workers that are ended while they start."""
    sys.warnoptions.append(silent := f"ignore::UserWarning:{resource_tracker.__name__}")
    try:
        for tracker in (multiprocessing.resource_tracker, resource_tracker):
            tracker.ensure_running()
    finally:
        sys.warnoptions.remove(silent)


@contextmanager
def sigint_blocked() -> Iterator[None]:
    """Hold back Ctrl-C, from processes started meanwhile for ever: it is this one that ends them.

    Else they would show where they were, or end in the midst of an answer that this process then waits for.
    """
    _start_trackers()  # as they start they would let it through again
    if sys.platform == "win32":
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def shut_down_pool() -> None:
    """End the processes at once, whatever they are doing; the next call starts others."""
    for executor in _kept.values():
        executor.shutdown(wait=True, kill_workers=True)
    _kept.clear()


@contextmanager
def preloaded_pool(count: int, module: str) -> Iterator[None]:
    """Start processes; they import a module while this one goes on, and end with the context."""
    for _ in range(count):
        process_pool(count).submit(import_module, module)
    try:
        yield
    finally:
        shut_down_pool()


@contextmanager
def shut_down_on_failure() -> Iterator[None]:
    """End the processes on Ctrl-C, or when one of them has died.

    Raises
    ------
    RunError
        When one died.
    """
    try:
        yield
    except KeyboardInterrupt:
        shut_down_pool()
        raise
    except BrokenProcessPool as error:
        shut_down_pool()
        raise RunError(WORKER_DIED) from error
