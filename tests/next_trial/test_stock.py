"""Dives are offered with the anchors and lines that the mission says are in stock."""

from types import SimpleNamespace

import numpy as np
import pytest

from missionplan.diagnosis.dives import designs
from missionplan.diagnosis.dives.preparation import binned
from missionplan.diagnosis.next_trial.dive_trials import FACTORS, LIGHT, LONG, DiveTrials
from missionplan.mission import Mission


@pytest.fixture
def offered(measured, descent_mission):
    """Trials after four dives, with what is in stock."""
    model = measured()

    def make(**stock):
        (moor,) = descent_mission.moors
        choose = [{"key": f"{moor.name}.{key}", "choices": choices} for key, choices in stock.items()]
        mission = Mission.from_data(dict(descent_mission.raw) | ({"optimise": {"choose": choose}} if choose else {}))
        return DiveTrials(SimpleNamespace(mission=mission, model=model))

    return make


def test_what_is_in_stock_is_offered_and_chosen_from(offered):
    trials = offered(anchor_wet_weight=["9 N", "1.2 kgf", "sized"], line_length=["3 m", "8 m"])
    names = {name.split(" with ")[1] for name in trials.designs}
    assert {"an anchor of 11.8 N", "a line of 8 m"} <= names
    assert not any(name in names for name in ("an anchor of 9 N", "a line of 3 m"))  # of the dives so far
    np.testing.assert_allclose(trials.alternatives().values, [9.0, 11.768], rtol=1e-4)


def test_a_mission_that_lists_no_stock_gets_a_lighter_anchor_and_a_longer_line(offered):
    trials = offered()
    first = trials.bound.model.forward.logs[0]
    names = [name.split(" with ")[1] for name in trials.designs]
    assert f"an anchor of {LIGHT * first.wet_weight:.3g} N" in names
    assert f"a line of {LONG * first.line_length:.3g} m" in names
    assert len(trials.alternatives().values) == len(FACTORS)
    for number, name in enumerate(trials.designs):
        words = {"two dives": 2, "four dives": 4}
        assert len(trials.trial(number)["phases"]) == next((n for each, n in words.items() if name.startswith(each)), 8)


def test_a_longer_line_lies_in_deeper_water_so_that_the_vehicle_ends_as_deep(offered):
    trials = offered(line_length=["8 m"])
    number = next(i for i, name in enumerate(trials.designs) if "a line of 8 m" in name)
    first = trials.bound.model.forward.logs[0]
    site = trials.trial(number)["site"]
    assert site["depth"] == f"{first.site_depth + 8.0 - first.line_length:.4g} m"


def test_dives_of_a_diagnosis_have_lighter_anchors_longer_lines_or_deeper_water(monkeypatch):
    """The vehicle of a line three times as long ends as deep as with the first."""
    monkeypatch.setattr(designs, "sampled_dives", lambda forward, logs: tuple(logs))
    logs = [binned("a", np.arange(3.0), np.arange(3.0), 0.05, weight, 5.0, 24.0) for weight in (9.0, 12.0, 15.0)]
    forward = SimpleNamespace(logs=logs)
    found = {
        entry: [(dive.wet_weight, dive.line_length, dive.site_depth) for dive in designs.design_dives(forward, entry)]
        for entry in (None, 0, 1, 2)
    }
    assert found == {
        None: [(9.0, 5.0, 24.0), (12.0, 5.0, 24.0)],
        0: [(pytest.approx(3.6), 5.0, 24.0), (pytest.approx(4.8), 5.0, 24.0)],
        1: [(9.0, 15.0, 34.0), (12.0, 15.0, 34.0)],
        2: [(9.0, 5.0, 48.0), (12.0, 5.0, 48.0)],
    }


def test_a_log_is_stretched_over_the_dive_to_come_with_more_readings_in_each_of_its_bins():
    """At 1 m/s from 2 s on down to 12 % above 20 m, 17.6 m: ten seconds of readings become 17.4, from 2.2 to 19.6 s."""
    log = binned("a", np.arange(1.0, 12.0), np.zeros(11), 0.05, 9.0, 5.0, 25.0)
    times = np.linspace(0.0, 40.0, 401)
    found = designs._stretched(log, times, np.clip(times - 2.0, 0.0, 20.0))
    assert (found.t[0], found.t[-1]) == pytest.approx((2.2, 19.7), abs=0.11)
    factor = (found.t[-1] - found.t[0]) / 10.0
    np.testing.assert_allclose(np.diff(found.t), factor)
    np.testing.assert_allclose(found.fine, found.t)
    np.testing.assert_allclose(found.sd, 0.05 / np.sqrt(factor))
    shallow = designs._near_touchdown(log, times, np.zeros(401))
    assert shallow == designs.LONGEST_DIVE
