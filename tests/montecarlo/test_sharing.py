import functools
import os
import signal

import pytest

from missionplan.errors import RunError
from missionplan.montecarlo.sharing import shared, started_workers


def squares(items):
    return [item**2 for item in items]


def processes(items):
    return [os.getpid()] * len(items)


def die_elsewhere(here, items):
    if os.getpid() != here:
        os.kill(os.getpid(), signal.SIGKILL)
    return list(items)


@pytest.mark.parametrize("jobs", [1, 2, 3])
@pytest.mark.parametrize("count", [0, 1, 2, 7])
def test_results_come_in_the_items_order(jobs, count):
    assert shared(squares, range(count), jobs=jobs) == [item**2 for item in range(count)]


def test_a_part_is_done_here():
    with started_workers(2, "json"):
        found = shared(processes, range(4), jobs=2)
    assert found[0] == found[2] == os.getpid()
    assert found[1] == found[3] != os.getpid()


def test_an_error_in_a_part_is_raised():
    with pytest.raises(TypeError):
        shared(squares, [1, "a"], jobs=2)


def test_a_worker_that_dies_is_told():
    with pytest.raises(RunError, match="worker process died"):
        shared(functools.partial(die_elsewhere, os.getpid()), range(4), jobs=2)
    assert shared(squares, range(4), jobs=2) == [0, 1, 4, 9]
