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


def test_a_test_is_measured_less_simulated_with_its_stated_error_or_5_percent(folder, descent_mission):
    rows = (
        "a,terminal_velocity_m_s,1.2,0.05\na,simulated_terminal_velocity_m_s,1.5,\na,descent_time_s,20,\n"
        "b,descent_time_s,22,0.5\nb,simulated_descent_time_s,20,\nc,simulated_descent_time_s,21,\n"
    )
    data = read_summary(folder({"kind": "summary"}, HEADER + rows), descent_mission)
    one, other = data.tests  # of the third nothing was measured
    assert (one.name, one.quantities, one.relative) == ("a", ("terminal_velocity_m_s", "descent_time_s"), (True, False))
    assert one.values == pytest.approx([-0.3, 20.0])
    assert one.sd == pytest.approx([0.05, 1.0])
    assert (other.name, other.values.tolist(), other.sd.tolist(), other.relative) == ("b", [2.0], [0.5], (True,))
    assert (one.wet_weight, one.line_length, one.site_depth) == (12.0, 5.0, 24.0)
    assert [notice for notice in data.notices if "no sd" in notice] == [
        "a: descent_time_s states no sd; 5 % is assumed"
    ]


def test_tests_that_stand_twice_count_once(folder, descent_mission):
    rows = "".join(f"{run},descent_time_s,{time},0.5\n" for run, time in (("a", 20), ("b", 22), ("c", 20), ("d", 22)))
    data = read_summary(folder({"kind": "summary"}, HEADER + rows), descent_mission)
    assert [test.name for test in data.tests] == ["a", "b"]
    assert "the tests stand 2 times over, and count once" in data.notices
    plain = read_summary(folder({"kind": "summary"}, HEADER + rows.replace("20,", "21,", 1)), descent_mission)
    assert [test.name for test in plain.tests] == ["a", "b", "c", "d"]  # alike by chance


@pytest.mark.parametrize(
    ("rows", "line"),
    [
        (GOOD + "b,descent_time_s,1,1\n", 3),
        (GOOD + "b,terminal_velocity_m_s,0.009,\n", 3),
        (GOOD + "b,descent_time_s,3000,\n", 3),
    ],
)
def test_a_descent_faster_or_slower_than_any_is_named_with_its_line(folder, descent_mission, rows, line):
    with pytest.raises(InputError, match=r"expected from 0.01 to 20 m/s") as refused:
        read_summary(folder({"kind": "summary"}, HEADER + rows), descent_mission)
    assert [problem.line for problem in refused.value.problems] == [line]
