import functools
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import nullcontext
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from loky import process_executor

from missionplan.errors import InputError, RunError
from missionplan.montecarlo.blocks import Workers
from missionplan.montecarlo.distributions import LogNormal, Normal
from missionplan.montecarlo.pool import interrupts_deferred, process_pool, shut_down_pool
from missionplan.montecarlo.statistics import RunningStatistic
from missionplan.montecarlo.streams import Correlation, JointDistribution, LegNormals

JOINT = JointDistribution.of({"a": Normal(0.0, 1.0), "b": LogNormal(2.0, 1.3)}, [Correlation(("a", "b"), 0.5)])


def block_of_trials(block):
    drawn = JOINT.draw(seed=9, block=block, size=1000)
    return drawn["a"] + drawn["b"] * LegNormals(9, "legs", block).leg(1)[0, :1000]


def slow_block(block):
    time.sleep(0.02 * (3 - block % 3))
    return block


@functools.cache
def reference():
    return [block_of_trials(block) for block in range(6)]


@pytest.mark.parametrize(
    ("jobs", "backend"), [(1, "loky"), (2, "loky"), (3, "loky"), (2, "threading"), (4, "threading")]
)
def test_bits_do_not_depend_on_jobs_or_backend(jobs, backend):
    blocks = list(Workers(jobs=jobs, backend=backend).run(block_of_trials, range(6)))
    assert all(np.array_equal(found, expected) for found, expected in zip(blocks, reference(), strict=True))
    merged = functools.reduce(RunningStatistic.merge, map(RunningStatistic.of, blocks)).statistic()
    assert merged == functools.reduce(RunningStatistic.merge, map(RunningStatistic.of, reference())).statistic()


class CountingTask:
    """Returns the process and how many items it has run there; it keeps the count."""

    def __init__(self):
        self.count = 0

    def __call__(self, item):
        time.sleep(0.02)
        self.count += 1
        return os.getpid(), self.count


@pytest.mark.usefixtures("warm_worker")
def test_a_worker_keeps_the_task_for_its_next_items():
    """What a task has computed for one item serves the others; a new run begins anew."""
    for _ in range(2):
        found = list(Workers(jobs=2).run(CountingTask(), range(16)))
        assert len({process for process, _ in found}) > 1
        assert len(set(found)) == len(found)  # no count twice in a process
        assert min(count for _, count in found) == 1


def test_bits_do_not_depend_on_the_order_of_blocks():
    order = [4, 0, 5, 2, 1, 3]
    for block, found in zip(order, Workers().run(block_of_trials, order), strict=True):
        assert np.array_equal(found, reference()[block])


class IdlePool:
    """A pool whose workers have started and never come to what is submitted."""

    def __init__(self):
        self.futures = []

    def submit(self, task, *arguments):
        self.futures.append(Future())
        if not self.futures[1:]:
            self.futures[0].set_result(None)
        return self.futures[-1]


def interrupted_after_the_first(item):
    if item > 0:
        raise KeyboardInterrupt
    return item


@pytest.mark.parametrize("interrupted", [True, False])
def test_what_was_submitted_is_not_cancelled(monkeypatch, interrupted):
    """A cancelled future ends the thread of loky that would kill the workers at shutdown, and the command then hangs."""
    pool = IdlePool()
    monkeypatch.setattr("missionplan.montecarlo.blocks.borrowed_pool", lambda count: nullcontext(pool))
    results = Workers(jobs=2).run(interrupted_after_the_first, range(9))
    assert next(results) == 0
    if interrupted:
        with pytest.raises(KeyboardInterrupt):
            next(results)
    else:
        results.close()
    assert len(pool.futures) > 1
    assert not any(future.cancelled() for future in pool.futures)


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_waits_until_the_pool_has_answered(sent):
    before = signal.signal(sent, signal.default_int_handler)
    steps = []

    def interrupted():
        with interrupts_deferred():
            signal.raise_signal(sent)
            steps.append("went on")

    try:
        with pytest.raises(KeyboardInterrupt):
            interrupted()
        assert steps == ["went on"]
        assert signal.getsignal(sent) is signal.default_int_handler
    finally:
        signal.signal(sent, before)


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_a_signal_that_is_ignored_stays_ignored():
    before = signal.signal(signal.SIGTERM, signal.SIG_IGN)
    try:
        with interrupts_deferred():
            assert signal.getsignal(signal.SIGTERM) is signal.SIG_IGN
            signal.raise_signal(signal.SIGTERM)
    finally:
        signal.signal(signal.SIGTERM, before)


def test_other_threads_defer_nothing():
    def use():
        with interrupts_deferred():
            return signal.getsignal(signal.SIGINT)

    with ThreadPoolExecutor(1) as thread:
        assert thread.submit(use).result() is signal.getsignal(signal.SIGINT)


@pytest.mark.parametrize("jobs", [1, 3])
def test_results_come_in_order_with_progress(jobs):
    calls = []
    done = list(
        Workers(jobs=jobs, backend="threading", progress=lambda *call: calls.append(call)).run(slow_block, range(7))
    )
    assert done == list(range(7))
    assert calls == [(count, 7) for count in range(8)]


def test_nothing_waits_for_the_workers_to_start():
    shut_down_pool()
    assert set(Workers(jobs=2).run(worker_after, range(3))) == {os.getpid()}


@pytest.fixture
def warm_worker():
    process_pool(1).submit(worker_after, 0).result()


def filled(megabytes):
    """Keep memory in use in this process, and its number."""
    process_pool.__dict__["filled"] = np.ones(megabytes * 2**17)
    process_executor._MEMORY_LEAK_CHECK_DELAY = 0.0  # of this worker: else it looks no more than once a second
    return os.getpid()


@pytest.mark.usefixtures("warm_worker")
def test_a_worker_that_uses_more_memory_than_at_first_is_no_leak():
    """It begins with nothing: what a diagnosis loads alone is more than the 300 MB from which loky replaces it."""
    pytest.importorskip("psutil")
    assert process_pool(1).submit(filled, 400).result() == process_pool(1).submit(filled, 0).result()


@pytest.mark.usefixtures("warm_worker")
def test_a_part_is_done_here():
    processes = list(Workers(jobs=2).run(worker_after, range(20)))
    assert processes[0] == os.getpid()
    assert len(set(processes)) > 1


def die_elsewhere(here, block):
    if os.getpid() != here:
        os.kill(os.getpid(), signal.SIGKILL)
    return slow_block(block)


@pytest.mark.usefixtures("warm_worker")
def test_a_dead_worker_is_reported_and_replaced():
    with pytest.raises(RunError, match="worker process died"):
        list(Workers(jobs=2).run(functools.partial(die_elsewhere, os.getpid()), range(20)))
    assert list(Workers(jobs=2).run(slow_block, range(4))) == [0, 1, 2, 3]


@pytest.mark.parametrize(("jobs", "backend"), [(1, "loky"), (2, "loky"), (2, "threading")])
def test_a_reader_may_stop_early(jobs, backend):
    results = Workers(jobs=jobs, backend=backend).run(slow_block, range(50))
    assert next(results) == 0
    results.close()
    assert list(Workers(jobs=jobs, backend=backend).run(slow_block, range(3))) == [0, 1, 2]


def worker_after(block):
    time.sleep(0.02)
    return os.getpid()


@pytest.mark.usefixtures("warm_worker")
def test_workers_outlive_a_reader_who_stops_early():
    before = set(Workers(jobs=2).run(worker_after, range(12)))
    assert len(before) > 1
    results = Workers(jobs=2).run(worker_after, range(50))
    next(results)
    results.close()
    assert set(Workers(jobs=2).run(worker_after, range(12))) <= before


def test_an_error_in_a_block_reaches_the_caller():
    with pytest.raises(ZeroDivisionError):
        list(Workers(jobs=2).run(functools.partial(divmod, 1), [1, 0]))


@pytest.mark.parametrize("options", [{"backend": "carrier-pigeon"}, {"jobs": 0}, {"jobs": -2}])
def test_bad_options_are_refused(options):
    with pytest.raises(InputError, match="expected"):
        list(Workers(**options).run(slow_block, range(2)))


def test_dask_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match="pip install 'dask>="):
        list(Workers(backend="dask").run(slow_block, range(2)))


INTERRUPTED = """
import sys, time
from missionplan.montecarlo.blocks import Workers
from missionplan.montecarlo.pool import shut_down_pool
try:
    for _ in Workers(jobs=2).run(time.sleep, [0.0] + [60.0] * int(sys.argv[1])):
        print("block", flush=True)
        time.sleep(float(sys.argv[2]))
except KeyboardInterrupt:
    shut_down_pool()  # as the command does
    sys.exit(130)
"""


def descendants(process):
    children = {}
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            parent = int((folder / "stat").read_text().rpartition(")")[2].split()[1])
        except (OSError, IndexError):
            continue
        children.setdefault(parent, []).append(int(folder.name))
    found, waiting = [], [process]
    while waiting:
        found += (below := children.get(waiting.pop(), []))
        waiting += below
    return found


def running(process):
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="reads the process table of Linux")
@pytest.mark.parametrize(
    ("more", "busy", "send"),
    [
        ("1", "0", os.kill),
        ("5", "0", os.killpg),
        ("5", "60", os.killpg),
        pytest.param("1", "0", os.killpg, marks=pytest.mark.slow),
        pytest.param("5", "0", os.kill, marks=pytest.mark.slow),
    ],
    ids=["waiting, sent to it alone", "in a block", "in the loop's body", "waiting", "in a block, sent to it alone"],
)
def test_ctrl_c_ends_at_once_and_leaves_no_process(more, busy, send):
    command = [sys.executable, "-c", INTERRUPTED, more, busy]
    heeding = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)  # a background shell ignores it
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(command, start_new_session=True, preexec_fn=heeding, **pipes) as run:
        assert run.stdout is not None
        run.stdout.readline()
        while len(workers := descendants(run.pid)) < 2:  # one worker, and loky's tracker
            time.sleep(0.05)
        send(run.pid, signal.SIGINT)
        assert run.wait(timeout=120) == 130
    deadline = time.monotonic() + 10.0
    while any(map(running, workers)) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not any(map(running, workers))
