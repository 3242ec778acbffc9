"""Damaged inputs, some dozens and with the slow tests three hundred, and all that ever broke something."""

import math
from pathlib import Path

import pytest

from .__main__ import CASES, run
from .attempts import attempt
from .targets import TARGETS

COUNTS = {
    "validate": 60,
    "simulate": 10,
    "read": 80,
    "current": 8,
    "field": 100,
    "identify": 40,
    "diagnose": 3,
    "names": 1,
    "resume": 3,
    "options": 6,
}


@pytest.mark.parametrize("share", [0.1, pytest.param(1.0, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", TARGETS)
def test_no_damaged_input_breaks_anything(name, share):
    _, findings = run(name, math.ceil(share * COUNTS[name]), seed=20, keep=None)
    assert not findings


@pytest.mark.parametrize(
    "case",
    [
        pytest.param(name, marks=pytest.mark.slow if name.startswith("diagnose-") else ())
        for name in sorted(path.name for path in CASES.iterdir() if path.is_dir())
    ],
)
def test_what_was_found_stays_mended(case, tmp_path):
    target = TARGETS[case.partition("-")[0]]
    _, finding = attempt(lambda: target.act(CASES / case), target.limit)
    assert finding is None


def test_findings_are_found(tmp_path: Path):
    def divide():
        return 1 / 0

    for act, name in ((divide, "ZeroDivisionError"), (lambda: {"a": float("nan")}, "not finite: a"), (_loop, "time")):
        ending, finding = attempt(act, limit=0.2)
        assert ending == "finding"
        assert finding.name.startswith(name)


def _loop():
    while True:
        pass
