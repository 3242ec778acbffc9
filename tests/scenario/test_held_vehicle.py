"""The vehicle on its line as mission and vehicle files give it."""

import copy
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import missionplan
from missionplan.errors import InputError
from missionplan.mission import Mission
from missionplan.mission.schema.phases import TransitPhase
from missionplan.physics.held_line import CROSSFLOW_COEFFICIENT
from missionplan.physics.seafloor import FRICTION, ROUGHNESS, lateral_coefficient
from missionplan.scenario.anchors import anchor_length
from missionplan.scenario.phases import held_body, hold_of, moor_plan, room_in_depth, start_of
from missionplan.scenario.scenario import Scenario
from missionplan.studies.held_vehicle import _knobs
from missionplan.studies.simulation.simulate import simulate_block

MISSIONS = Path(__file__).parents[2] / "missions"
CENTRES = {
    "centre_of_gravity": {"from_nose": "0.56 m", "below_axis": "8 mm"},
    "centre_of_buoyancy": {"from_nose": "0.559 m"},
}


def changed(file="chesapeake.yaml", *, vehicle=None, anchor=None, moor=None, site=None):
    data = copy.deepcopy(dict(missionplan.load(MISSIONS / file).raw))
    data["vehicle"] |= vehicle or {}
    data["vehicle"]["anchor"] |= anchor or {}
    data["site"] |= site or {}
    section = next(phase["moor"] for phase in data["phases"] if "moor" in phase)
    section |= {"line_material": None, "line_diameter": "0 m", **(moor or {})}
    return Mission.from_data(data)


def hold(mission):
    scenario = Scenario.at_means(mission)
    return hold_of(scenario, scenario.moor(), 11.8)


def test_what_no_file_gives_is_assumed():
    held = hold(changed())
    assert held.body.raising_moment == pytest.approx(0.5 * 1.1176 * 0.2 * 4.4482216)
    assert held.body.righting_moment == 0.0
    assert held.body.crossflow_coefficient == CROSSFLOW_COEFFICIENT
    assert held.anchor.friction == FRICTION
    assert (held.roughness, held.slope.angle, held.line.drag_factor) == (ROUGHNESS, 0.0, 0.0)


def test_what_the_files_give_is_used():
    held = hold(
        changed(
            vehicle={**CENTRES, "hull": {"length": "44 in", "diameter": "4.75 in", "crossflow_drag": 0.9}},
            anchor={"holding_factor": 0.3},
            moor={"line_diameter": "3 mm"},
            site={"slope": {"angle": "5 deg", "toward": "90 deg"}, "roughness": "6 mm"},
        )
    )
    weight, buoyancy = 10.2 * 9.80665, 0.2 * 4.4482216
    assert held.body.raising_moment == pytest.approx((weight + buoyancy) * 0.559 - weight * 0.56)
    assert held.body.righting_moment == pytest.approx(-weight * 0.008)
    assert (held.body.crossflow_coefficient, held.anchor.friction) == (0.9, 0.3)
    assert (held.line.drag_factor, held.roughness) == (
        pytest.approx(0.6 * 0.003 * held.body.density),
        pytest.approx(0.006),
    )
    assert held.slope.angle == pytest.approx(np.radians(5.0))


def test_the_anchor_is_as_long_with_its_construction_as_with_the_mass_that_it_gives():
    built = Scenario.at_means(changed("anchor-design.yaml"))
    length = float(anchor_length(built, 11.7))
    assert length == pytest.approx(0.183, abs=0.001)
    data = copy.deepcopy(dict(changed("anchor-design.yaml").raw))
    del data["vehicle"]["anchor"]["construction"]
    data["vehicle"]["anchor"]["flooded_mass"] = "2.793 kg"
    plain = Mission.from_data(data)
    assert float(anchor_length(Scenario.at_means(plain), 11.7)) == pytest.approx(length, abs=2e-3)


def failures(mission):
    trials = simulate_block(mission, seed=1, block=0, trials=300)
    phase = next(phase for phase in trials.phases if phase.kind == "moor")
    return phase, trials


def test_an_anchor_that_drags_fails_the_mission_only_where_its_holding_is_given():
    silent, _ = failures(changed("anchor-design.yaml"))
    assert not np.all(silent.events["anchor_holds"])
    assert "anchor dragged" not in silent.failures
    spoken, trials = failures(changed("anchor-design.yaml", anchor={"holding_factor": FRICTION}))
    assert np.array_equal(spoken.quantities["holding_margin"], silent.quantities["holding_margin"])
    assert np.array_equal(spoken.failures["anchor dragged"], ~silent.events["anchor_holds"])
    assert not np.any(trials.success & ~spoken.events["anchor_holds"])


def test_grounding_fails_the_mission_only_where_the_centres_are_given():
    hanging = {**CENTRES, "centre_of_buoyancy": {"from_nose": "0.5 m"}}
    short = {"line_length": "1 m"}
    spoken, trials = failures(changed(vehicle=hanging, moor=short))
    assert spoken.events["grounded"].all()
    assert not trials.success.any()
    assert "grounded in the hold" not in failures(changed(moor=short))[0].failures


def test_a_vehicle_with_centres_pitches_over_after_the_snatch():
    plain, _ = failures(changed())
    assert "nose_down_time_s" not in plain.quantities
    pitched, _ = failures(changed(vehicle=CENTRES))
    time, lost = (pitched.quantities[key] for key in ("nose_down_time_s", "depth_lost_m"))
    done = np.isfinite(pitched.quantities["offset_m"])
    assert ((time[done] > 1.0) & (time[done] < 2.0)).all()
    assert ((lost[done] > 0.0) & (lost[done] < 0.3)).all()
    later = pitched.quantities["descent_time_s"][done] - plain.quantities["descent_time_s"][done]
    assert ((later > 0.1) & (later < 0.5)).all()


def test_a_holding_factor_may_vary_and_leaves_other_draws_alone():
    plain, varied = (
        failures(changed("anchor-design.yaml", anchor=anchor))
        for anchor in ({}, {"holding_factor": {"low": 0.2, "high": 0.6}})
    )
    assert np.array_equal(plain[0].quantities["offset_m"], varied[0].quantities["offset_m"])
    assert np.ptp(varied[1].draws["vehicle.anchor.holding_factor"]) > 0.3


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"vehicle": {"centre_of_gravity": {"from_nose": "0.5 m"}}}, "given together"),
        ({"vehicle": {**CENTRES, "centre_of_gravity": {"from_nose": "1.5 m"}}}, "behind the tail"),
        (
            {"vehicle": {**CENTRES, "centre_of_gravity": {"from_nose": "0.5 m", "below_axis": "7 cm"}}},
            "outside the hull",
        ),
        ({"site": {"slope": {"angle": "70 deg", "toward": "0 deg"}}}, "at most 1"),
        ({"moor": {"line_diameter": "3 m"}}, "impossible"),
        ({"anchor": {"holding_factor": "0.3 N"}}, "holding_factor"),
    ],
)
def test_what_cannot_be_is_refused(changes, words):
    with pytest.raises(InputError, match=words):
        changed(**changes)


OFF_THE_AXIS = {
    "centre_of_gravity": {"from_nose": "0.57 m", "below_axis": "11 mm"},
    "centre_of_buoyancy": {"from_nose": "0.552 m", "below_axis": "-4 mm"},
}


def test_each_centre_has_its_own_force_and_arm():
    """The weight at the centre of gravity, the buoyancy at its own: none for the other, along the axis and off it."""
    scenario = Scenario.at_means(changed(vehicle=OFF_THE_AXIS, moor={"line_stiffness": "12 kN/m"}))
    weight = 10.2 * 9.80665
    buoyancy = weight + 0.2 * 4.4482216
    body = held_body(scenario)
    assert body.raising_moment == pytest.approx(buoyancy * 0.552 - weight * 0.57)
    assert abs(body.righting_moment) == pytest.approx(weight * 0.011 + buoyancy * 0.004)
    dive = moor_plan(scenario, scenario.moor()).dive
    pitching = dive.pitching
    at_nose = 1.0 / pitching.lateral_mass + 0.57**2 / pitching.inertia
    assert dive.spring.nose_mass == pytest.approx(1.0 / at_nose)
    assert (pitching.centre, pitching.ahead, pitching.below) == pytest.approx((0.57, 0.57 - 0.552, -0.004 - 0.011))
    assert pitching.buoyancy == pytest.approx(buoyancy)
    assert pitching.inertia == pytest.approx(pitching.lateral_mass * pitching.length**2 / 12.0)


def test_a_lighter_vehicle_is_held_as_one_whose_file_says_so():
    """What a remedy tries is what the mission would compute with that number, without centres at mid-length."""
    scenario = Scenario.at_means(changed())
    before = hold_of(scenario, scenario.mission.moors[0], 11.8)
    knobs = {knob.name: knob for knob in _knobs(before, scenario)}
    assert {name: (knob.value, knob.unit) for name, knob in knobs.items()} == {
        "anchor": (11.8, "N wet"),
        "net buoyancy": (pytest.approx(0.2 * 4.4482216), "N"),
        "line": (5.0, "m"),
    }
    other = hold(changed(vehicle={"net_buoyancy": "2.5 N"}))
    made = knobs["net buoyancy"].changed(2.5)
    assert made.body.net_buoyancy == other.body.net_buoyancy
    assert made.body.raising_moment == pytest.approx(other.body.raising_moment)
    longer = knobs["line"].changed(7.0)
    assert (longer.line.length, longer.body) == (7.0, before.body)
    heavier = knobs["anchor"].changed(np.array([14.0]))
    assert heavier.anchor.wet_weight == 14.0
    assert heavier.anchor.length == pytest.approx(hold_of(scenario, scenario.mission.moors[0], 14.0).anchor.length)


def test_bodies_and_line_of_a_dive_are_by_hand_those_of_the_files():
    """Spheroids by Lamb's integrals; the anchor displaces what it does not weigh, and the nose inside it."""
    given = {"construction": None, "flooded_mass": "2.8 kg", "overlap_volume": "0.3 L", "flooding_time": "7 s"}
    line = {
        "line_stiffness": "12 kN/m",
        "line_strength": "1.5 kN",
        "line_wet_weight": "0.02 N/m",
        "line_diameter": "2 mm",
    }
    scenario = Scenario.at_means(
        changed(anchor=given, moor={"anchor_wet_weight": "11.7 N", "lateral": "coupled", **line})
    )
    plan, density = moor_plan(scenario, scenario.moor()), float(scenario.water.density)
    dive, length, diameter = plan.dive, 1.1176, 0.12065

    def lamb(fineness):
        e = np.sqrt(1.0 - fineness**-2.0)
        alpha = 2.0 * (1.0 - e**2) / e**3 * (np.arctanh(e) - e)
        beta = 1.0 / e**2 - (1.0 - e**2) / e**3 * np.arctanh(e)
        return alpha / (2.0 - alpha), beta / (2.0 - beta)

    displaced = 10.2 + 0.2 * 4.4482216 / 9.80665
    along, across = (share * displaced for share in lamb(length / diameter))
    assert (dive.vehicle_added_mass, dive.tied.vehicle.mass) == pytest.approx((along, 10.2 + across), rel=1e-6)
    assert dive.tied.vehicle.drag == pytest.approx(0.5 * density * CROSSFLOW_COEFFICIENT * length * diameter)
    assert dive.tied.vehicle.centre == pytest.approx(0.5 * length)
    of_nose = 1.0 / (1.0 / (10.2 + across) + 0.25 * length**2 / ((10.2 + across) * length**2 / 12.0))
    assert (dive.spring.nose_mass, dive.spring.stiffness, dive.spring.strength) == pytest.approx((of_nose, 12e3, 1.5e3))
    anchor = float(anchor_length(scenario, 11.7))
    water = 2.8 - 11.7 / 9.80665 + density * 0.3e-3
    assert dive.tied.anchor.mass == pytest.approx(2.8 + lamb(anchor / diameter)[1] * water)
    assert dive.tied.anchor.drag == pytest.approx(
        0.5 * density * lateral_coefficient(anchor / diameter) * anchor * diameter
    )
    assert (dive.wet_weight, dive.anchor_mass, dive.flooding_time) == pytest.approx((11.7, 2.8, 7.0))
    assert plan.held.line.compliance == pytest.approx(1.0 / (12e3 * 5.0))  # of a metre
    assert plan.held.line.wet_weight == pytest.approx(0.02)
    assert (plan.moored_time, plan.surfacing_time, plan.hotel_power) == pytest.approx((1200.0 + 600.0, 90.0, 8.0))
    assert room_in_depth(dive, 1.0) == pytest.approx([12.192 - 5.0 - 1.0])


def test_a_mooring_s_last_fix_is_after_all_transits_before_it_at_their_speeds():
    def transit(name, to, speed, start=None):
        return TransitPhase.model_construct(name=name, start=start, to=to, speed=speed)

    phases = [
        transit("in", np.array([300.0, 400.0]), 2.0), transit("on", np.array([300.0, 1000.0]), 0.5),
        transit("jump", np.array([0.0, 100.0]), 1.0, np.zeros(2)), SimpleNamespace(name="moor"),
        transit("out", np.zeros(2), 1.0),
    ]  # fmt: skip
    means = SimpleNamespace(drawn=SimpleNamespace(phases=phases), position=lambda place: place[:, None])
    place, time = start_of(SimpleNamespace(means=means), phases[3])
    assert (place.tolist(), time) == ([0.0, 100.0], 250.0 + 1200.0 + 100.0)
