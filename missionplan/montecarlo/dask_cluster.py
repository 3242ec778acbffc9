"""Blocks run by the workers of a Dask cluster, once each worker has proven that it runs the same code."""

import gc
import logging
import time
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Generic, TypeVar

from missionplan.errors import InputError, MissionplanError, Problem, RunError
from missionplan.identity import Program, differences, how_to_install, running_program
from missionplan.montecarlo.pool import interrupts_blocked

if TYPE_CHECKING:
    from distributed import Client, Future

Item = TypeVar("Item")
Result = TypeVar("Result")

ANSWER_TIME = 10
"""Time in which a scheduler must answer, and have a worker [s]."""
_PATIENCE = 30
"""Time that a run waits without any worker: those that ended may be started again [s]."""
_LOGGERS = ("distributed", "distributed.client", "distributed.worker", "distributed.core", "tornado.application")


def run_on_cluster(
    task: Callable[[Item], Result], items: Sequence[Item], jobs: int, scheduler: str | None
) -> Generator[Result, None, None]:
    """Run a task on every item and yield the results in the order of the items.

    Raises InputError when dask.distributed is not installed, no scheduler answers or it has no workers, or a worker has
    another version of the package or none; RunError when the scheduler or all workers are lost.

    `task`: picklable. `jobs`: workers of the local cluster that is started where no `scheduler` is given. `scheduler`:
    address of the Dask scheduler.
    """
    with _connected(jobs, scheduler) as client:
        place = scheduler or "the local cluster"
        _check_workers(client, place)
        proven, todo = _Proven(task, running_program()), deque(items)
        begun: deque[Future[Result]] = deque()  # in the order of the items
        try:
            while todo or begun:
                wanted = 2 * max(sum(_threads(client).values()), 1) - len(begun)
                begun.extend(client.submit(proven, todo.popleft(), pure=False) for _ in range(min(wanted, len(todo))))
                yield _result(begun[0], client, place)
                begun.popleft()
        except (OSError, CancelledError) as error:
            raise RunError(f"the Dask scheduler at {place} no longer answers") from error
        finally:  # the caller may stop early, or a block fail
            with suppress(OSError, CancelledError):
                client.cancel(list(begun))  # type: ignore[no-untyped-call]


@dataclass(frozen=True, eq=False)
class _Proven(Generic[Item, Result]):
    """A task that a worker refuses where its code is not the client's: workers may join during a run."""

    task: Callable[[Item], Result]
    expected: Program

    def __call__(self, item: Item) -> Result:
        """Run the task on an item."""
        if (build := running_program()) != self.expected:
            worker = import_module("distributed").get_worker().address
            raise InputError([_other_code(worker, build, self.expected)])
        return self.task(item)


def _other_code(worker: str, build: Program, expected: Program) -> Problem:
    differ = "; ".join(differences(build.parts(), expected.parts()))
    message = f"the worker {worker} runs missionplan {build.version} with other code ({differ}): install the same there"
    return Problem(message, key="scheduler")


def _check_workers(client: "Client", place: str) -> None:
    """Let every worker prove its code.

    Raises InputError when there are no workers, or with each that runs other code or none.
    """
    deadline = time.monotonic() + ANSWER_TIME
    while not _threads(client):
        if time.monotonic() > deadline:
            message = f"the Dask scheduler at {place} has no workers; start some with: dask worker {place}"
            raise InputError([Problem(message, key="scheduler")])
        time.sleep(0.1)
    expected, wrong = running_program(), []
    try:
        client.run_on_scheduler(running_program)  # type: ignore[no-untyped-call]
    except Exception as error:  # it reads the tasks that it passes on
        words = str(error).splitlines()[0] if str(error) else ""
        message = f"the Dask scheduler at {place} cannot run missionplan: {type(error).__name__}: {words}"
        raise InputError([Problem(message, key="scheduler")]) from error
    for worker, answer in client.run(running_program, on_error="return").items():
        if isinstance(answer, BaseException):
            message = f"the worker {worker} cannot run missionplan: {type(answer).__name__}: {answer}"
            wrong.append(Problem(message, key="scheduler"))
        elif answer != expected:
            wrong.append(_other_code(worker, answer, expected))
    if wrong:
        raise InputError(wrong)


def _threads(client: "Client") -> dict[str, int]:
    """Return the number of threads of each worker, by its address."""
    threads: dict[str, int] = client.nthreads()  # type: ignore[no-untyped-call]
    return threads


def _result(future: "Future[Result]", client: "Client", place: str) -> Result:
    """Wait for a result as long as there is a scheduler, and workers."""
    alone = 0
    while True:
        try:
            return future.result(timeout=1.0)
        except TimeoutError:
            alone = 0 if client.status == "running" and _threads(client) else alone + 1
            if alone >= _PATIENCE:
                raise RunError(f"the Dask scheduler at {place} has had no workers for {_PATIENCE} s") from None
        except (MissionplanError, CancelledError, OSError):
            raise
        except Exception as error:
            words = str(error).splitlines()[0] if str(error) else ""
            raise RunError(f"the Dask cluster at {place} failed: {type(error).__name__}: {words}") from error


@contextmanager
def _connected(jobs: int, scheduler: str | None) -> "Iterator[Client]":
    """Connect to a Dask scheduler, or start a local cluster; closed at the end."""
    try:
        distributed = import_module("distributed")
    except ImportError as error:
        message = f"dask needs dask.distributed: {how_to_install('dask')}"
        raise InputError([Problem(message, key="backend")]) from error
    with _silent_loggers():  # from here on: distributed sets their levels when it is imported
        client = _client(distributed, jobs, scheduler)
        try:
            yield client
        finally:
            with suppress(OSError, CancelledError):
                client.close()  # type: ignore[no-untyped-call]


def _client(distributed: ModuleType, jobs: int, scheduler: str | None) -> "Client":
    """Return a client of a scheduler, or of a local cluster."""
    if scheduler is None:
        with interrupts_blocked(terminable=True):
            started: Client = distributed.Client(n_workers=jobs, threads_per_worker=1, dashboard_address=None)
            return started
    client: Client | None = None
    with suppress(Exception):  # whatever another service at the address makes of the greeting
        client = distributed.Client(scheduler, timeout=f"{ANSWER_TIME}s")
    if client is None:
        gc.collect()  # ends what is left of the client; collected while the next one starts, it would block that
        raise InputError([Problem(f"no Dask scheduler answers at {scheduler}", key="scheduler")])
    return client


@contextmanager
def _silent_loggers() -> Iterator[None]:
    """Keep Dask's own log off standard error: what went wrong is said in one sentence."""
    levels = {name: logging.getLogger(name).level for name in _LOGGERS}
    for name in _LOGGERS:
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for name, level in levels.items():
            logging.getLogger(name).setLevel(level)
