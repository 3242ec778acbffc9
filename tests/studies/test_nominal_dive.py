"""Dives that are faster than any: refused before a trial is run, with the mooring and its velocity."""

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

from missionplan.errors import InputError
from missionplan.mission import load
from missionplan.scenario.phases import dive_of
from missionplan.scenario.scenario import Scenario
from missionplan.studies.anchor import size_anchor
from missionplan.studies.held_vehicle import FASTEST, check_dives
from missionplan.studies.simulation.simulate import simulate

pytestmark = pytest.mark.usefixtures("unassumed")

MISSIONS = Path(__file__).parents[2] / "missions"


def with_weight(tmp_path, newtons):
    (tmp_path / "vehicles").mkdir(exist_ok=True)
    for name in ("anchor-design.yaml", "vehicles/vt475-self-mooring.yaml"):
        text = (MISSIONS / name).read_text()
        (tmp_path / name).write_text(text.replace("wet_weight: sized", f"wet_weight: {newtons:.6f} N"))
    return load(tmp_path / "anchor-design.yaml")


@pytest.fixture(scope="module")
def heaviest():
    """Weight that drags anchor and vehicle down at exactly 10 m/s: the drag there, and the net buoyancy."""
    means = Scenario.at_means(load(MISSIONS / "anchor-design.yaml"))
    dive = dive_of(means, means.moor())
    return float(dive.vehicle_drag(FASTEST) + dive.anchor_drag(FASTEST) + dive.net_buoyancy)


def test_the_limit_is_where_drag_at_ten_metres_a_second_carries_the_weight(tmp_path, heaviest):
    check_dives(Scenario.at_means(with_weight(tmp_path, 0.999 * heaviest)))
    with pytest.raises(InputError, match=r"moor goes down at 10 m/s; expected at most 10 m/s"):
        check_dives(Scenario.at_means(with_weight(tmp_path, 1.001 * heaviest)))


def test_the_velocity_in_the_message_balances_weight_and_drag(tmp_path, heaviest):
    mission = with_weight(tmp_path, 4.0 * heaviest)
    means = Scenario.at_means(mission)
    dive = dive_of(means, means.moor())
    pull = float(np.max(dive.wet_weight - dive.net_buoyancy))
    speed = brentq(lambda v: float(dive.vehicle_drag(v) + dive.anchor_drag(v)) - pull, 1.0, 100.0)
    with pytest.raises(InputError) as refused:
        check_dives(means)
    (problem,) = refused.value.problems
    assert f"goes down at {speed:.3g} m/s" in problem.message
    assert problem.key == "moor.anchor_wet_weight"
    assert "units" in problem.hint


@pytest.mark.parametrize("study", [simulate, size_anchor])
def test_studies_of_dives_refuse_it(tmp_path, heaviest, study):
    with pytest.raises(InputError, match="goes down at"):
        study(with_weight(tmp_path, 2.0 * heaviest), trials=10)


def test_an_anchor_that_is_sized_is_answered_with_what_it_does_and_not_asked_for_its_unit(tmp_path):
    """A radius of 8 ft takes an anchor that would go down at 15 m/s, and that its parts cannot make a good one."""
    (tmp_path / "vehicles").mkdir()
    for name in ("anchor-design.yaml", "vehicles/vt475-self-mooring.yaml"):
        (tmp_path / name).write_text((MISSIONS / name).read_text().replace("radius: 75 ft", "radius: 8 ft"))
    mission = load(tmp_path / "anchor-design.yaml")
    assert size_anchor(mission, trials=50).anchor.terminal_velocity > FASTEST
    assert simulate(mission, trials=50).total.events["success"].value < 0.5


def test_missions_without_dives_pass():
    check_dives(Scenario.at_means(load(MISSIONS / "fig8.yaml")))
