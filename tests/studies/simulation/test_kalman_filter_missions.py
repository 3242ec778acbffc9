"""The filter in missions: its prior is the missions' own uncertainty, and it is no worse than any other way."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from missionplan.mission import load
from missionplan.phases.transit.kalman_filter import PERSISTENT, STEADY, SURFACE, WAVES
from missionplan.scenario.scenario import Scenario
from missionplan.studies.simulation.simulate import simulate

pytestmark = pytest.mark.usefixtures("unplanned", "unranked", "unheld")

MISSION = """
name: Filter
site:
  origin: {latitude: 37 deg, longitude: -76 deg}
  depth: 50 m
  current:
    - {down_to: 5 m, speed: {mean: 0.2 m/s, sd: 0.04 m/s}, toward: 90 deg}
    - {down_to: 50 m, speed: {mean: 0.1 m/s, sd: 0.02 m/s}, toward: 0 deg}
navigation:
  velocity_error: {mean: [{mean: 0.01 m/s, sd: 0.03 m/s}, 0 m/s], sigma: 0.02 m/s}
  surfacing_time: 100 s
  fix_error: 3 m
  drift_compensation: filter
phases:
  - transit: {from: [0 m, 0 m], to: [4 km, 0 m], speed: 1 m/s, d_max: 800 m, arrival_radius: 40 m, depth: 10 m}
effects:
  - mean-current: {east: {mean: 0.02 m/s, sd: 0.01 m/s}}
  - persistent-error: {sigma: 0.05 m/s, time: 2 h}
  - random-walk: {rate: 4e-4 m/s**1.5}
  - tidal-current: {m2_east: 0.1 m/s, m2_east_phase: {low: 0 rad, high: 6.2832 rad}}
  - inertial-current: {amplitude: {mean: 0.05 m/s, sd: 0.01 m/s}, phase: 0 rad}
monte_carlo: {trials: 400, seed: 2}
"""


@pytest.fixture
def mission(tmp_path):
    path = tmp_path / "filter.yaml"
    path.write_text(MISSION, encoding="utf-8")
    return load(path)


def test_the_prior_is_the_mission_s_own_uncertainty(mission):
    means = Scenario.at_means(mission)
    model = means.compensation(means.transit()).model
    sd = np.sqrt(np.diag(model.prior))
    few = 4.0 / np.sqrt(4096)
    assert sd[STEADY] == pytest.approx(np.hypot(0.03, 0.01), rel=few)
    assert sd[STEADY + 1] == pytest.approx(0.02, rel=few)
    assert sd[SURFACE] == pytest.approx(4.0, rel=few)
    assert sd[SURFACE + 1] == pytest.approx(0.0, abs=1e-9)
    assert sd[PERSISTENT] == pytest.approx(0.05)
    assert sd[WAVES : WAVES + 2] == pytest.approx(0.1 / np.sqrt(2.0), rel=few)
    assert sd[WAVES + 2 : WAVES + 4] == pytest.approx(0.0, abs=1e-9)
    assert sd[-2:] == pytest.approx([0.01, 0.0], rel=few, abs=1e-9)
    assert model.mean[STEADY] == pytest.approx(0.02, abs=few * 0.03)
    assert (model.persistence, model.walk) == pytest.approx((7200.0, 4e-4))
    assert model.fix_error == 3.0


def test_a_mission_with_everything_arrives_sooner_than_without_compensation(mission, tmp_path):
    path = tmp_path / "none.yaml"
    path.write_text(MISSION.replace("drift_compensation: filter", "drift_compensation: none"), encoding="utf-8")
    with_filter, without = (
        simulate(each, sheet=False).phases[0].quantities["duration_s"] for each in (mission, load(path))
    )
    assert with_filter.missing == 0
    assert with_filter.mean < without.mean


def comparison():
    """The script that makes the figure and the table of the documentation."""
    path = Path(__file__).parents[3] / "docs" / "figures" / "drift_filter.py"
    spec = importlib.util.spec_from_file_location("drift_filter_figure", path)
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    return script


def test_no_way_of_compensating_does_better():
    found = comparison().cell(0.1, 3600.0, trials=1024, fixed=True)
    assert found.excess <= 3.0 * found.excess_error


UNSEEN_SURFACING = 3.0 * 100.0 * 90.0 / 8000.0
"""What a surfacing of 90 s on a way of 8000 s costs [%], by the rule of three.

Where an error lasts a minute a correction turns each trial by next to nothing, which costs 1e-5 %, and spares one trial
in many thousands a surfacing: a sample that holds no such trial knows neither the gain nor its error.
"""


@pytest.mark.slow
@pytest.mark.parametrize("fixed", [False, True])
def test_no_way_of_compensating_does_better_anywhere_on_the_grid(fixed):
    script = comparison()
    for current in script.CURRENTS:
        for time in script.TIMES:
            found = script.cell(current, time, trials=2048, fixed=fixed)
            assert found.excess <= 3.0 * found.excess_error + UNSEEN_SURFACING / 2048, (current, time)
