"""Missions whose forecast of the current errs: what it does to legs, drifts and the filter."""

import math

import numpy as np
import pytest
from simulate_missions import chesapeake, chesapeake_data
from test_simulate_currents import STEADY, csv, steady

from missionplan.errors import InputError
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.site_current import recorded_current
from missionplan.studies.simulation.simulate import simulate, simulate_block

pytestmark = pytest.mark.usefixtures("unplanned", "unranked", "unheld")

SIGMA, TIME = 0.05, 7200.0


def erring(folder, changes=None, **error):
    written = csv(folder, steady)
    written["site.current"]["error"] = {"sigma": f"{SIGMA} m/s", "time": f"{TIME} s"} | error
    way_in = {"phases": chesapeake_data()["phases"][:1], "requirements": []}
    return chesapeake(folder, STEADY | written | way_in | (changes or {}))


def test_the_current_of_each_trial_is_the_forecast_and_an_error(tmp_path):
    mission = erring(tmp_path)
    means = Scenario.at_means(mission, recorded_current(mission))
    drawn = means.sampled(seed=3, block=0, size=4096)
    here = np.zeros((2, 1))
    forecast, sailed = means.current.velocity(600.0, 2.0, here), drawn.current.velocity(600.0, 2.0, here)
    assert sailed.std(axis=1) == pytest.approx(SIGMA, rel=0.05)
    assert sailed.mean(axis=1) == pytest.approx(forecast[:, 0], abs=4.0 * SIGMA / 64.0)
    again = means.sampled(seed=3, block=0, size=1024).current.velocity(600.0, 2.0, here)
    assert again == pytest.approx(sailed[:, :1024], abs=1e-15), "fewer trials of a block are its first"


def test_a_mission_without_an_error_has_the_same_numbers(tmp_path):
    way_in = {"phases": chesapeake_data()["phases"][:1], "requirements": []}
    plain = chesapeake(tmp_path, STEADY | csv(tmp_path, steady) | way_in)
    none = erring(tmp_path, sigma="0 m/s")
    found = [simulate_block(each, seed=1, block=0, trials=50).columns() for each in (plain, none)]
    for name, values in found[0].items():
        assert found[1][name] == pytest.approx(values, rel=1e-9, nan_ok=True), name


def test_one_leg_misses_by_the_integral_of_the_error(tmp_path):
    """One leg of 1600 m in a memory so long that the error is steady: it misses by σT, and drifts on for t_s."""
    one = {
        "phases.0.transit.d_max": "5000 m",
        "phases.0.transit.arrival_radius": "900 m",
        "navigation.drift_compensation": "forecast",
    }
    mission = erring(tmp_path, one, time="1000000 s")
    block = simulate_block(mission, seed=2, block=0, trials=700)
    miss, lasting = block.phases[0].miss, block.phases[0].quantities["duration_s"]
    assert np.isfinite(miss).all()
    assert miss.std(axis=1) == pytest.approx(SIGMA * float(np.mean(lasting)), rel=0.06)


def test_the_filter_expects_the_error_and_learns_it(tmp_path):
    legs = {"phases.0.transit.d_max": "200 m", "navigation.fix_error": "3 m"}
    spread = {}
    for way in ("forecast", "filter"):
        mission = erring(tmp_path, legs | {"navigation.drift_compensation": way}, time="100000 s")
        found = simulate(mission, trials=500, seed=4, sheet=False)
        spread[way] = found.phases[0].quantities["arrival_error_m"].mean
    assert spread["filter"] < 0.9 * spread["forecast"]


@pytest.mark.parametrize(
    ("error", "message"),
    [
        ({"time": "0 s"}, "site.current.error.time"),
        ({"sigma": "-1 m/s"}, "site.current.error.sigma"),
        ({"sigma": "9 m/s"}, "site.current.error.sigma"),
        ({"length": "0 m"}, "site.current.error.length"),
        ({"tau": "1 h"}, "site.current.error.tau: unknown key"),
    ],
)
def test_impossible_errors_are_refused(tmp_path, error, message):
    with pytest.raises(InputError, match=message):
        erring(tmp_path, **error)


def test_the_statistics_may_be_uncertain_and_are_then_inputs(tmp_path):
    mission = erring(tmp_path, sigma={"median": "0.05 m/s", "factor": 1.5}, length="2 km")
    assert "site.current.error.sigma" in mission.uncertain()
    block = simulate_block(mission, seed=1, block=0, trials=64)
    assert np.ptp(block.draws["site.current.error.sigma"]) > 0.0
    assert math.isfinite(float(block.total["duration_s"].mean()))
