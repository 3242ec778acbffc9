"""A study in a copy of the process, which imports the page meanwhile: the same answer, errors and ends as here."""

import os
import signal
import sys
import threading
from pathlib import Path

import pytest

from missionplan.cli.running import beside_import
from missionplan.errors import InputError, Problem, RunError
from missionplan.montecarlo.pool import shut_down_pool

pytestmark = [
    pytest.mark.skipif(sys.platform != "linux", reason="processes are copied on Linux alone"),
    pytest.mark.filterwarnings("ignore:This process .* is multi-threaded"),
]
PAGE = "missionplan.report.wording"


@pytest.fixture(autouse=True)
def without_other_threads(monkeypatch):
    """Tests before leave threads, of workers and of Dask, beside which no process is copied."""
    shut_down_pool()
    alive = threading.enumerate()
    monkeypatch.setattr(threading, "active_count", lambda: 1 + len(set(threading.enumerate()) - set(alive)))


def test_the_answer_is_that_of_another_process():
    assert beside_import(PAGE, os.getpid) != os.getpid()
    assert beside_import("", os.getpid) == os.getpid()


def test_errors_are_raised_as_they_were():
    def refuses():
        raise InputError([Problem("given 3, expected 2", "mission.yaml", 4, key="site.depth")])

    with pytest.raises(InputError) as found:
        beside_import(PAGE, refuses)
    assert str(found.value.problems[0]) == "mission.yaml:4: site.depth: given 3, expected 2"
    with pytest.raises(ZeroDivisionError) as bug:
        beside_import(PAGE, lambda: 1 // 0)
    assert "in outcome" in bug.value.__notes__[0]  # where it was raised, which a pickled error forgets


def test_a_copy_that_dies_is_told_of():
    with pytest.raises(RunError, match="died"):
        beside_import(PAGE, lambda: os.kill(os.getpid(), signal.SIGKILL))


def test_ctrl_c_ends_the_copy(tmp_path: Path):
    number, parent = tmp_path / "number", os.getpid()

    def endless():
        number.write_text(str(os.getpid()), encoding="utf-8")
        os.kill(parent, signal.SIGINT)
        signal.pause()

    with pytest.raises(KeyboardInterrupt):
        beside_import(PAGE, endless)
    with pytest.raises(ProcessLookupError):
        os.kill(int(number.read_text(encoding="utf-8")), 0)
