"""A handful of killed runs; `python -m tests.kill` does more."""

import signal
import sys

import pytest

from .runs import Kill, files_of, killed_and_resumed, resumed_by_other_code, started_together, undisturbed

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not sys.platform.startswith("linux"), reason="looks for processes in /proc"),
]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return undisturbed(tmp_path_factory.mktemp("whole") / "out")


@pytest.mark.parametrize(
    "kill",
    [
        Kill("alone", 1, signal.SIGKILL, 0.5),
        Kill("alone", 1, signal.SIGKILL, 0.95),
        Kill("workers", 3, signal.SIGTERM, 0.6),
        Kill("workers", 3, signal.SIGKILL, 0.6),
    ],
    ids=lambda kill: f"{kill.backend}-{kill.signal.name}-{kill.share}",
)
def test_a_killed_run_is_resumed_to_the_same_files(whole, tmp_path, kill):
    expected, duration = whole
    assert killed_and_resumed(tmp_path / "out", kill, duration) == []
    assert files_of(tmp_path / "out") == expected


def test_a_killed_run_is_not_resumed_by_other_code_and_then_to_the_same_files(whole, tmp_path):
    expected, duration = whole
    assert resumed_by_other_code(tmp_path / "out", 0.8, duration) == []
    assert files_of(tmp_path / "out") == expected


@pytest.mark.parametrize("shared", [False, True], ids=["their own", "one folder"])
def test_of_eight_runs_started_together_no_result_is_lost(tmp_path, shared):
    assert started_together(tmp_path, 8, shared=shared) == []
