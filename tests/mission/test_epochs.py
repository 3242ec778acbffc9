"""Phases count from a date of their own: who edits `start` does not move the tide."""

import copy

import numpy as np
import pytest

from missionplan.errors import InputError
from missionplan.mission import Mission
from missionplan.mission.includes import hash_of
from missionplan.montecarlo.posterior import PosteriorFile, WeightedDraws
from missionplan.phases.hooks import Leg
from missionplan.scenario.scenario import Scenario
from tests.fixtures import TRANSIT

TIDE = {"m2_east": "0.3 m/s", "m2_east_phase": "40 deg", "s2_north": "0.1 m/s", "s2_north_phase": "-70 deg"}
TURNS = {"amplitude": "0.2 m/s", "phase": {"mean": "1 rad", "sd": "0.1 rad"}}
FIRST, LATER, HOURS = "2026-06-01T04:00Z", "2026-06-09T21:30Z", 8 * 24 + 17.5


def mission(start, effects, **more):
    return Mission.from_data({**copy.deepcopy(TRANSIT), "start": start, "effects": effects, **more})


def current(at, hours):
    """Velocity of a mission's effects so many hours after its start, shape (2, n)."""
    scenario = Scenario.at_means(at)
    n = len(hours)
    t, along = 3600.0 * np.asarray(hours, dtype=float), np.tile([[1.0], [0.0]], n)
    leg = Leg(t, np.full(n, 1e-3), np.zeros((2, n)), along, 1.0, scenario.latitude)
    return sum(effect.velocity(leg) for effect in scenario.transit_effects)


@pytest.mark.parametrize(("name", "own"), [("tidal-current", TIDE), ("inertial-current", TURNS)])
def test_an_effect_with_an_epoch_stays_in_time_when_the_start_is_moved(name, own):
    hours = np.linspace(0.0, 30.0, 12)
    first = mission(FIRST, [{name: own}])
    dated = mission(LATER, [{name: {**own, "epoch": FIRST}}])
    np.testing.assert_allclose(current(dated, hours), current(first, hours + HOURS), atol=1e-6)
    undated = mission(LATER, [{name: own}])
    np.testing.assert_allclose(current(undated, hours), current(first, hours), atol=1e-12)


def test_draws_stay_in_time_when_the_start_is_moved():
    columns = (("tidal-current", "m2_east"), ("tidal-current", "m2_east_phase"))
    rng = np.random.default_rng(2)
    values = np.stack([rng.uniform(0.2, 0.3, 200), rng.uniform(0.5, 0.9, 200)], axis=1)
    draws = WeightedDraws((("tidal-current",),), np.zeros(200, dtype=int), columns, values, np.full(200, 0.005))
    epoch = mission(FIRST, []).start.timestamp()
    learned = PosteriorFile.of(draws, hash_of(()), {}, epoch)
    hours = np.linspace(0.0, 30.0, 12)
    first, later = (mission(start, [], posterior=learned) for start in (FIRST, LATER))
    np.testing.assert_allclose(current(later, hours), current(first, hours + HOURS), atol=1e-5)


def test_an_epoch_needs_a_start_and_a_date():
    data = {key: value for key, value in mission(FIRST, []).raw.items() if key != "start"}
    with pytest.raises(InputError, match="has no start"):
        Mission.from_data({**data, "effects": [{"tidal-current": {**TIDE, "epoch": FIRST}}]})
    with pytest.raises(InputError, match="expected a date"):
        mission(FIRST, [{"tidal-current": {**TIDE, "epoch": 12}}])
    with pytest.raises(InputError, match="no such parameter"):
        mission(FIRST, [{"compass-bias": {"angle": "1 deg", "epoch": FIRST}}])
