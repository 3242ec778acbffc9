"""Copies of this process, which have all that it has loaded and compute something beside it; on Linux."""

import os
import pickle
import select
import signal
import sys
import threading
from collections.abc import Callable
from functools import cached_property
from typing import Generic, NoReturn, TypeVar, cast

Result = TypeVar("Result")
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
