"""The process pool (loky): kept from call to call, shut down at once when the command is interrupted.

A task as it is sent to the processes of the pool, each of which keeps it: what it has computed serves its items. Copies
of this process, which have all that it has loaded and compute something beside it; on Linux.
"""

import multiprocessing.resource_tracker
import os
import pickle
import select
import signal
import sys
import threading
import time
import uuid
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Future, wait
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from typing import TYPE_CHECKING, Generic, NoReturn, TypeVar, cast

from missionplan.errors import OUT_OF_FILES, RunError, out_of_files

if TYPE_CHECKING:
    from loky import ProcessPoolExecutor

Result = TypeVar("Result")

WORKER_DIED = "a worker process died (out of memory, or killed)"
_THREADS = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS"), "1")
_ENVIRONMENT = {**_THREADS, "LOKY_MAX_MEMORY_LEAK_SIZE": "1e15"}
"""Of a worker: it begins with nothing, and is not leaking when it has loaded what a diagnosis needs."""

PATIENCE = 0.1
"""Time for which a wait for the pool or a copy is deaf to Ctrl-C [s]."""
_WATCH_INTERVAL = 0.5
"""Time between a worker's looks at its parent [s]."""

_kept: "dict[int, ProcessPoolExecutor]" = {}  # one at most, by its number of processes
_users: Counter[int] = Counter()  # runs that use a pool, by its identity
_lock = threading.RLock()  # runs in threads of one process share the pool


def process_pool(count: int) -> "ProcessPoolExecutor":
    """Return a pool of at least `count` processes beside this one, that of the last call where it is large enough.

    The BLAS of each process uses one thread.
    """
    with _lock:
        if count > max(_kept, default=0):
            for executor in _kept.values():
                if not _users[id(executor)]:  # else whoever uses it last shuts it down
                    executor.shutdown(wait=False)
            _kept.clear()
            with interrupts_blocked():
                _kept[count] = _started(count)
        return next(iter(_kept.values()))


def _started(count: int) -> "ProcessPoolExecutor":
    from loky import ProcessPoolExecutor  # which many a run needs none of

    executor = ProcessPoolExecutor(max_workers=count, env=_ENVIRONMENT, initializer=end_with, initargs=(os.getpid(),))
    try:
        executor.submit(int)  # starts them
    except Exception as error:
        executor.shutdown(wait=False, kill_workers=True)
        if out_of_files(error):
            raise RunError(OUT_OF_FILES) from None
        raise
    return executor


def end_with(parent: int) -> None:
    """End this worker when its parent is gone, even if that was killed: nobody else would end it."""

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(_WATCH_INTERVAL)
        os._exit(1)  # whatever the worker is doing

    sys.stdout = sys.stderr  # what a plug-in prints is no part of an answer
    if sys.platform != "win32":  # where a process keeps the number of a parent that is gone
        threading.Thread(target=watch, daemon=True).start()


def _start_trackers() -> None:
    """Start the resource trackers of the workers' locks, without warnings about workers killed while they start."""
    from loky.backend import resource_tracker

    sys.warnoptions.append(silent := f"ignore::UserWarning:{resource_tracker.__name__}")
    try:
        for tracker in (multiprocessing.resource_tracker, resource_tracker):
            tracker.ensure_running()
    finally:
        sys.warnoptions.remove(silent)


@contextmanager
def interrupts_blocked(*, terminable: bool = False) -> Iterator[None]:
    """Block SIGINT, SIGTERM and SIGHUP while workers start; they inherit the mask.

    Without it, Ctrl-C would reach the workers too: they would print tracebacks, or end in the middle of a result that
    this process waits for. This process shuts them down, and they end by themselves when it is gone.

    `terminable` leaves SIGTERM alone, by which Dask ends its workers.
    """
    if sys.platform == "win32":
        _start_trackers()
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGHUP})  # for the trackers: it would end them
    try:
        _start_trackers()  # which unblocks the other two signals, and ignores them
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT} if terminable else {signal.SIGINT, signal.SIGTERM})
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def interrupts_deferred() -> Iterator[None]:
    """Hold back Ctrl-C (SIGTERM and SIGHUP too, where they act like it) until the end of the context.

    While this process asks the pool for something it holds locks that the pool's thread needs to end the workers. An
    exception between such a lock and its release would leave it locked for ever, and the command would hang.
    """
    if threading.current_thread() is not threading.main_thread():  # signals are handled in the main thread alone
        yield
        return
    caught: list[int] = []
    numbers = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
    before = {number: handler for number in numbers if callable(handler := signal.getsignal(number))}
    for number in before:
        signal.signal(number, lambda number, _: caught.append(number))
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        for number in caught:
            signal.raise_signal(number)


def result_of(future: "Future[Result]") -> Result:
    """Wait for a result; Ctrl-C ends the wait."""
    done = False
    while not done:
        with interrupts_deferred():
            done = bool(wait([future], PATIENCE).done)
    return future.result()


def shut_down_pool() -> None:
    """Kill the pool's processes at once; the next call starts new ones."""
    for executor in _kept.values():
        executor.shutdown(wait=True, kill_workers=True)
    _kept.clear()


def _import(modules: Sequence[str]) -> None:
    for module in modules:
        import_module(module)


@contextmanager
def preloaded_pool(count: int, *modules: str) -> Iterator[None]:
    """Pool of processes that import modules in the background; shut down at the end of the context."""
    if count:
        with interrupts_deferred():
            executor = process_pool(count)
            for _ in range(count):
                executor.submit(_import, modules)
    try:
        yield
    finally:
        shut_down_pool()


@contextmanager
def borrowed_pool(count: int) -> "Iterator[ProcessPoolExecutor]":
    """Use a pool of at least `count` processes; shut it down on Ctrl-C, or when one of its processes has died.

    Raises RunError when a process has died.
    """
    with interrupts_deferred(), _lock:
        executor = process_pool(count)
        _users[id(executor)] += 1
    try:
        yield executor
    except KeyboardInterrupt:
        shut_down_pool()
        raise
    except BrokenExecutor as error:
        shut_down_pool()
        raise RunError(WORKER_DIED) from error
    finally:
        with _lock:
            _users[id(executor)] -= 1
            if not _users[id(executor)] and executor not in _kept.values():
                executor.shutdown(wait=False)


Item = TypeVar("Item")

_sent: dict[str, object] = {}  # one at most: the last task that this process was sent


@dataclass(frozen=True)
class ShippedTask(Generic[Item, Result]):
    """A task, pickled once; use `of`.

    It is pickled before this process runs items too, and changes what the task keeps.
    """

    content: bytes
    name: str

    @classmethod
    def of(cls, task: Callable[[Item], Result]) -> "ShippedTask[Item, Result]":
        """Pickle a task."""
        from loky.backend.reduction import dumps

        return cls(bytes(dumps(task)), uuid.uuid4().hex)

    def __call__(self, item: Item) -> Result:
        """Run the task on an item."""
        return self.unpacked()(item)

    def unpacked(self) -> Callable[[Item], Result]:
        """Return the task, as this process has kept it."""
        if self.name not in _sent:
            _sent.clear()
            _sent[self.name] = pickle.loads(self.content)
        return cast(Callable[[Item], Result], _sent[self.name])

    def prepare(self) -> None:
        """Import what the task needs, and keep it."""
        self.unpacked()


_DEAF = {getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)}
"""Signals that end a command."""


def copies_at_once(processes: int | None = None) -> int:
    """Return how many copies may compute beside this process, of so many processes; default: one per core.

    None where a process cannot be copied safely: off Linux, or beside other threads, whose locks a copy would hold for
    ever.
    """
    if sys.platform != "linux" or threading.active_count() > 1:
        return 0
    return (processes or len(os.sched_getaffinity(0))) - 1


class Copy(Generic[Result]):
    """A copy of this process that computes something; raises OSError where there may be no more of them."""

    def __init__(self, compute: Callable[[], Result]) -> None:
        self.compute, self._waits_for = compute, False
        self._pipe, writer = os.pipe()
        mask = signal.pthread_sigmask(signal.SIG_BLOCK, _DEAF)  # Ctrl-C is for this process, which ends the copy
        try:
            self.process = os.fork()
            if self.process == 0:
                self._compute_and_end(writer)
            self._waits_for = True
        finally:
            os.close(writer)
            if not self._waits_for:
                os.close(self._pipe)
            try:
                signal.pthread_sigmask(signal.SIG_SETMASK, mask)
            except KeyboardInterrupt:  # which came meanwhile: nobody has the copy yet
                self.end()
                raise

    def _compute_and_end(self, writer: int) -> NoReturn:
        try:
            os.close(self._pipe)  # or a write to a parent that is gone would never fail
            with open(writer, "wb") as to_parent:
                pickle.dump(self.compute(), to_parent)
        finally:
            os._exit(0)  # what this process would clean up is its parent's

    @property
    def is_busy(self) -> bool:
        """Whether it still computes: a copy writes once it is done."""
        return self._waits_for and not select.select([self._pipe], [], [], 0.0)[0]

    @cached_property
    def result(self) -> Result:
        """What it computes, waited for; raises EOFError when it has died."""
        try:
            while not select.select([self._pipe], [], [], PATIENCE)[0]:
                pass  # a signal that another thread takes would not end a longer wait
            with open(self._pipe, "rb", closefd=False) as from_copy:
                return cast(Result, pickle.load(from_copy))
        except pickle.UnpicklingError:
            raise EOFError from None
        finally:
            self.end()

    def end(self) -> None:
        """End it, whatever it still computes."""
        if self._waits_for:
            self._waits_for = False
            os.close(self._pipe)
            os.kill(self.process, signal.SIGKILL)
            os.waitpid(self.process, 0)
