"""The anchor on the vehicle's nose until its first mooring: a longer hull, and more to push."""

import copy
from pathlib import Path

import pytest

import missionplan
from missionplan.mission import Mission
from missionplan.physics.energy import propulsive_power
from missionplan.physics.vehicle_drag import Hull, Sail, VehicleDrag
from missionplan.scenario.carried_anchor import carried_anchor
from missionplan.scenario.scenario import Scenario
from missionplan.studies.leg_length.sweep_dmax import sweep_dmax

MISSIONS = Path(__file__).parents[2] / "missions"
PROPULSION = {
    "diameter": "0.1 m",
    "thrust_coefficient": [0.4243, -0.9435],
    "torque_coefficient": [0.0626, -0.1212],
    "motor_efficiency": 0.8,
}


def data():
    return copy.deepcopy(dict(missionplan.load(MISSIONS / "chesapeake.yaml").raw))


@pytest.fixture(scope="module")
def means():
    return Scenario.at_means(missionplan.load(MISSIONS / "chesapeake.yaml"))


def test_the_hull_is_longer_by_the_anchor_less_the_overlap(means):
    ingress, egress = means.mission.transits
    anchor = carried_anchor(means, ingress)
    # 183 mm of anchor, of which the vehicle's nose fills the last 43.5 mm: a cap of 0.3 L
    assert anchor.length == pytest.approx(0.184 - 0.0435, abs=2e-3)
    assert anchor.mass == pytest.approx(1.6, abs=0.02)
    assert carried_anchor(means, egress) is None


def test_the_ingress_takes_the_power_of_the_longer_hull(means):
    ingress, egress = means.mission.transits
    added = carried_anchor(means, ingress).length
    drag = VehicleDrag(Hull(1.1176 + added, 0.12065), Sail(0.1016, 0.1016, 0.01524), 1.25, means.water)
    assert means.transit_plan(ingress).power_under_way == pytest.approx(8.0 + propulsive_power(drag(1.5), 1.5, 0.45))
    power = [means.propulsion_power(phase) for phase in (ingress, egress)]
    assert 1.08 < power[0] / power[1] < 1.10


def test_a_propeller_pushes_the_longer_hull_more_slowly():
    written = data()
    written["vehicle"]["propulsion"] = PROPULSION
    for phase in (written["phases"][0], written["phases"][2]):
        del phase["transit"]["speed"]
        phase["transit"]["shaft_rate"] = "1200 rpm"
    means = Scenario.at_means(Mission.from_data(written))
    assert means.transit("ingress").speed < 0.995 * means.transit("egress").speed
    plans = [means.transit_plan(phase) for phase in means.drawn.transits]
    assert plans[0].length_lost > plans[1].length_lost


def test_transits_can_be_studied_where_the_anchor_cannot_be_sized():
    written = data()
    written["phases"][1]["moor"]["anchor_wet_weight"] = "sized"
    written["site"]["current"] = []
    mission = Mission.from_data(written)
    assert carried_anchor(Scenario.at_means(mission), mission.transits[0]) is None
    assert sweep_dmax(mission, trials=64) is not None


def test_a_mission_without_a_mooring_carries_nothing():
    written = data()
    del written["phases"][1], written["requirements"]
    mission = Mission.from_data(written)
    assert carried_anchor(Scenario.at_means(mission), mission.transits[0]) is None


def test_a_drag_from_the_tank_is_taken_as_it_was_measured():
    written = data()
    written["vehicle"]["drag"] = {"coefficient": 0.3, "area": "0.0114 m^2"}
    means = Scenario.at_means(Mission.from_data(written))
    ingress, egress = (means.propulsion_power(phase) for phase in means.drawn.transits)
    assert ingress == egress
