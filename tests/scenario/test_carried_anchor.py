"""The anchor on the vehicle's nose until its first mooring: a longer hull, and more to push."""

import copy
from pathlib import Path
from types import SimpleNamespace

import pytest

import missionplan
from missionplan.errors import InputError
from missionplan.mission import Mission
from missionplan.mission.schema.vehicle import Centre
from missionplan.physics.drag import Hull, Sail, VehicleDrag
from missionplan.physics.propulsion import propulsive_power
from missionplan.scenario.anchors import CarriedAnchors, _centres, carried_anchors, laden
from missionplan.scenario.phases import dive_of, hold_of
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.transits import PropelledVehicle
from missionplan.studies.leg_length.sweep_dmax import sweep_dmax

pytestmark = pytest.mark.usefixtures("unassumed")

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
    anchor = carried_anchors(means, ingress)
    # 183 mm of anchor, of which the vehicle's nose fills the last 43.5 mm: a cap of 0.3 L
    assert anchor.length == pytest.approx(0.184 - 0.0435, abs=2e-3)
    assert anchor.mass == pytest.approx(1.6, abs=0.02)
    assert carried_anchors(means, egress) is None


def test_the_ingress_takes_the_power_of_the_longer_hull(means):
    ingress, egress = means.mission.transits
    added = carried_anchors(means, ingress).length
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
    assert carried_anchors(Scenario.at_means(mission), mission.transits[0]) is None
    assert sweep_dmax(mission, trials=64) is not None


def test_a_mission_without_a_mooring_carries_nothing():
    written = data()
    del written["phases"][1], written["requirements"]
    mission = Mission.from_data(written)
    assert carried_anchors(Scenario.at_means(mission), mission.transits[0]) is None


def test_a_drag_from_the_tank_is_taken_as_it_was_measured():
    written = data()
    written["vehicle"]["drag"] = {"coefficient": 0.3, "area": "0.0114 m^2"}
    means = Scenario.at_means(Mission.from_data(written))
    ingress, egress = (means.propulsion_power(phase) for phase in means.drawn.transits)
    assert ingress == egress


def twice_moored(anchors, **vehicle):
    written = data()
    first, second = written["phases"][1], copy.deepcopy(written["phases"][1])
    first["moor"]["name"], second["moor"]["name"] = "first", "second"
    second["moor"]["anchor_wet_weight"] = "9 N"
    between = {"transit": {**written["phases"][0]["transit"], "name": "between", "to": ["800 m", "0 m"]}}
    del between["transit"]["from"]
    written["phases"] = [written["phases"][0], first, between, second, written["phases"][2]]
    written["vehicle"] = {**written["vehicle"], **vehicle, **({} if anchors is None else {"anchors": anchors})}
    written["requirements"] = []
    return Mission.from_data(written)


@pytest.mark.parametrize("anchors", [None, 1])
def test_a_mooring_without_an_anchor_is_refused(anchors):
    with pytest.raises(InputError, match="no anchor is left for second"):
        twice_moored(anchors)


def test_each_anchor_stays_aboard_until_its_mooring():
    means = Scenario.at_means(twice_moored(2))
    ingress, first, between, second, egress = means.drawn.phases
    both, one = carried_anchors(means, ingress), carried_anchors(means, between)
    assert [carried_anchors(means, phase) for phase in (second, egress)] == [None, None]
    assert both.mass > one.mass > 0.0
    assert both.length > one.length > 0.0
    assert carried_anchors(means, first) == one
    power = [float(means.propulsion_power(phase)) for phase in (ingress, between, egress)]
    assert power[0] > power[1] > power[2]
    plain = Scenario.at_means(missionplan.load(MISSIONS / "chesapeake.yaml"))
    dives = [dive_of(means, phase) for phase in (first, second)]
    assert dives[0].vehicle_mass == pytest.approx(10.2 + one.mass)
    assert dives[1].vehicle_mass == pytest.approx(10.2)
    assert [dive.wet_weight for dive in dives] == pytest.approx([11.8, 9.0])
    assert hold_of(means, first, 11.8).body.length == pytest.approx(44 * 0.0254 + one.length)
    assert hold_of(means, second, 9.0).body == hold_of(plain, plain.moor(), 9.0).body


def test_a_spare_anchor_is_never_left_behind():
    means = Scenario.at_means(twice_moored(3))
    *_, second, egress = means.drawn.phases
    assert carried_anchors(means, egress) == carried_anchors(means, second)


def test_the_centres_are_those_of_vehicle_and_anchors_together():
    centres = {"centre_of_gravity": {"from_nose": "560 mm", "below_axis": "8 mm"}}
    means = Scenario.at_means(twice_moored(2, **centres, centre_of_buoyancy={"from_nose": "559 mm"}))
    first = means.moor("first")
    carried, vehicle = carried_anchors(means, first), laden(means, first).mooring.vehicle
    gravity, buoyancy = vehicle.centres
    moment = 10.2 * (0.56 + carried.length) + carried.mass * 0.5 * carried.length
    assert gravity.from_nose == pytest.approx(moment / (10.2 + carried.mass))
    assert gravity.below_axis == pytest.approx(0.008 * 10.2 / (10.2 + carried.mass))
    assert buoyancy.from_nose < 0.559 + carried.length
    assert laden(laden(means, first), first).mooring.mass == laden(means, first).mooring.mass


def test_centres_move_with_the_anchor_as_moments_have_it():
    """2 kg of 20 cm before 10 kg at 0.5 m, which displace 11: neutral, its own weight and buoyancy at its middle."""
    centre = Centre.model_construct
    vehicle = SimpleNamespace(centres=(centre(from_nose=0.5, below_axis=0.012), centre(from_nose=0.48, below_axis=-0.013)),
                              net_buoyancy=9.80665)  # fmt: skip
    gravity, buoyancy = _centres(vehicle, 10.0, CarriedAnchors(0.2, 2.0)).values()
    assert (gravity.from_nose, gravity.below_axis) == pytest.approx(((10.0 * 0.7 + 2.0 * 0.1) / 12.0, 0.01))
    assert (buoyancy.from_nose, buoyancy.below_axis) == pytest.approx(((11.0 * 0.68 + 2.0 * 0.1) / 13.0, -0.011))
    assert _centres(SimpleNamespace(centres=None), 10.0, CarriedAnchors(0.2, 2.0)) == {}


def test_what_moves_on_a_transit_is_vehicle_anchor_and_the_water_it_displaces():
    vehicle = SimpleNamespace(mass=10.0, added_mass=None, net_buoyancy=9.80665, hull=SimpleNamespace(added_mass=0.05))
    drag = SimpleNamespace(hull=Hull(2.0, 0.2))
    moved = PropelledVehicle(None, vehicle, None, drag, carried_mass=3.0)
    assert moved.moving_mass == pytest.approx(10.0 + 3.0 + 0.05 * 11.0)
    vehicle.added_mass = SimpleNamespace(surge=0.7)
    assert moved.moving_mass == pytest.approx(13.7)
    vehicle.mass = None
    assert moved.moving_mass is None
