import functools
import os
import signal
import threading
import time

import pytest

from missionplan.errors import RunError
from missionplan.montecarlo.blocks import parallel_map
from missionplan.montecarlo.pool import preloaded_pool


def squares(items):
    return [item**2 for item in items]


def processes(items):
    return [os.getpid()] * len(items)


def processes_but_slow_here(items):
    if os.getpid() == items[0]:
        time.sleep(0.3)
    return [os.getpid()] * len(items)


class Remembering:
    """A task that caches what it computes, like a model its properties, while it is still being sent to workers."""

    def __getstate__(self):
        return {"thread": threading.current_thread().name}

    def __call__(self, items):
        for item in items:
            setattr(self, f"found{item}", item)
        return [self.__dict__.get("thread")] * len(items)


def die_elsewhere(here, items):
    if os.getpid() != here:
        os.kill(os.getpid(), signal.SIGKILL)
    return list(items)


@pytest.mark.parametrize("separately", [False, True])
@pytest.mark.parametrize("jobs", [1, 2, 3])
@pytest.mark.parametrize("count", [0, 1, 2, 7])
def test_results_come_in_the_items_order(jobs, count, separately):
    assert parallel_map(squares, range(count), jobs=jobs, separately=separately) == [item**2 for item in range(count)]


def test_a_process_that_is_slow_does_fewer_of_the_items():
    with preloaded_pool(1, "json"):
        parallel_map(squares, range(2), jobs=2)  # its process has started
        found = parallel_map(processes_but_slow_here, [os.getpid()] * 9, jobs=2, separately=True)
    assert 1 <= found.count(os.getpid()) < 5


def test_a_part_is_done_here():
    with preloaded_pool(1, "json"):
        found = parallel_map(processes, range(4), jobs=2)
    assert found[0] == found[2] == os.getpid()
    assert found[1] == found[3] != os.getpid()


@pytest.mark.parametrize("separately", [False, True])
def test_an_error_in_a_part_is_raised(separately):
    with pytest.raises(TypeError):
        parallel_map(squares, [1, "a"], jobs=2, separately=separately)


def test_a_dead_worker_is_reported():
    with pytest.raises(RunError, match="worker process died"):
        parallel_map(functools.partial(die_elsewhere, os.getpid()), range(4), jobs=2)
    assert parallel_map(squares, range(4), jobs=2) == [0, 1, 4, 9]


def test_a_task_is_sent_as_it_was_at_the_call():
    found = parallel_map(Remembering(), range(4), jobs=2)
    assert found[1] == found[3] == threading.main_thread().name  # no other thread reads it while it changes
