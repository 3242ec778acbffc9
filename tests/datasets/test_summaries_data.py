"""Summaries of dives with numbers that no dive has."""

import numpy as np
import pytest

from missionplan.datasets.summaries import read_summary
from missionplan.diagnosis import summaries
from missionplan.diagnosis.summaries import summary_model
from missionplan.errors import InputError

HEADER = "run,quantity,value,sd\n"
GOOD = "a,terminal_velocity_m_s,1.2,0.05\n"


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ("a,terminal_velocity_m_s,1e300,\n", "expected 0, or from 1e-20 to 1e\\+12 in size"),
        ("a,terminal_velocity_m_s,1e-300,\n", "expected 0, or from"),
        ("a,terminal_velocity_m_s,1e6,\n", "a descent at 1e\\+06 m/s; expected from 0.01 to 20 m/s"),
        ("a,descent_time_s,0.01,\n", "0.01 s down to 24 m at 2.4e\\+03 m/s"),
        ("a,terminal_velocity_m_s,0,\n", "expected more than 0"),
        (",terminal_velocity_m_s,1.2,\n", "run: is blank; expected a name"),
        ('"a\x1b[31m",terminal_velocity_m_s,1.2,\n', "expected text without control characters"),
        (GOOD + GOOD, "this run has this quantity already"),
    ],
)
def test_numbers_that_no_dive_has(folder, descent_mission, rows, words):
    with pytest.raises(InputError, match=words):
        read_summary(folder({"kind": "summary"}, HEADER + rows), descent_mission)


@pytest.mark.parametrize("runs", ["abc", ["a"], {"a": "x"}, {"a": None}, 3])
def test_runs_that_are_none(folder, descent_mission, runs):
    with pytest.raises(InputError, match="expected a mapping"):
        read_summary(folder({"kind": "summary", "runs": runs}, HEADER + GOOD), descent_mission)


def test_below_the_depth_where_it_is_uniform_a_dive_needs_no_steps(folder, descent_mission, monkeypatch):
    """The time to 150 m, integrated all the way down and only to 100 m."""
    path = folder({"kind": "summary", "runs": {"a": {"depth": "150 m"}}}, HEADER + GOOD + "a,descent_time_s,120,1\n")
    bound = summary_model(read_summary(path, descent_mission), descent_mission).forward
    nothing = np.zeros((0, 1))
    short = bound.readings((), nothing)
    monkeypatch.setattr(summaries, "UNIFORM_BELOW", 1e4)
    monkeypatch.setattr(summaries, "FINE_DOWN_TO", 1e4)
    np.testing.assert_allclose(short, bound.readings((), nothing), rtol=1e-5)
