"""Dives are offered with the anchors and lines that the mission says are in stock."""

from types import SimpleNamespace

import numpy as np
import pytest

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
