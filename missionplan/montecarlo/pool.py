"""The process pool (loky): kept from call to call, shut down at once when the command is interrupted."""

import multiprocessing.resource_tracker
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module

from loky import ProcessPoolExecutor
from loky.backend import resource_tracker
from loky.process_executor import BrokenProcessPool

from missionplan.errors import RunError

WORKER_DIED = "a worker process died (out of memory, or killed)"
_ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS"), "1")

_kept: dict[int, ProcessPoolExecutor] = {}  # one at most, by its number of processes


def process_pool(count: int) -> ProcessPoolExecutor:
    """Return a pool of at least `count` processes beside this one, that of the last call where it is large enough.

    The BLAS of each process uses one thread.
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
    """Start the resource trackers of the workers' locks, without warnings about workers killed while they start."""
    sys.warnoptions.append(silent := f"ignore::UserWarning:{resource_tracker.__name__}")
    try:
        for tracker in (multiprocessing.resource_tracker, resource_tracker):
            tracker.ensure_running()
    finally:
        sys.warnoptions.remove(silent)


@contextmanager
def sigint_blocked() -> Iterator[None]:
    """Block SIGINT while workers start; they inherit the mask.

    Without it, Ctrl-C would reach the workers too: they would print tracebacks, or end in the middle of a result that
    this process waits for. This process shuts them down.
    """
    _start_trackers()  # starting them inside the block would unblock the signal
    if sys.platform == "win32":
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def shut_down_pool() -> None:
    """Kill the pool's processes at once; the next call starts new ones."""
    for executor in _kept.values():
        executor.shutdown(wait=True, kill_workers=True)
    _kept.clear()


@contextmanager
def preloaded_pool(count: int, module: str) -> Iterator[None]:
    """Pool of processes that import a module in the background; shut down at the end of the context."""
    for _ in range(count):
        process_pool(count).submit(import_module, module)
    try:
        yield
    finally:
        shut_down_pool()


@contextmanager
def shut_down_on_failure() -> Iterator[None]:
    """Shut the pool down on Ctrl-C, or when one of its processes has died.

    Raises
    ------
    RunError
        When a process has died.
    """
    try:
        yield
    except KeyboardInterrupt:
        shut_down_pool()
        raise
    except BrokenProcessPool as error:
        shut_down_pool()
        raise RunError(WORKER_DIED) from error
