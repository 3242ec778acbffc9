"""Transits of a vehicle with a propeller: speed from shaft rate, gathering way, speed inferred wrongly."""

import copy
import math

import numpy as np
import pytest
import yaml

from missionplan.errors import InputError
from missionplan.mission import load
from missionplan.physics.propeller import Resistance, from_open_water
from missionplan.physics.propulsion import distance_lost, shaft_rate_for, speed_error
from missionplan.scenario.scenario import Scenario
from missionplan.studies.leg_length.sweep_dmax import sweep_dmax
from missionplan.studies.simulation.simulate import simulate

PROPULSION = {
    "diameter": "0.2 m",
    "thrust_coefficient": [0.4243, -0.9435],
    "torque_coefficient": [0.0626, -0.1212],
    "wake_fraction": 0.2,
    "thrust_deduction": 0.1,
    "axial_flow_factor": 0.25,
}
BASE = {
    "name": "Run with a propeller",
    "site": {"water": {"density": "1000 kg/m^3", "viscosity": "1.01e-6 m^2/s"}},
    "vehicle": {
        "hull": {"length": "1.5 m", "diameter": "0.25 m"},
        "mass": "60 kg",
        "drag": {"coefficient": 0.3, "area": "0.05 m^2"},
        "added_mass": {"surge": "3 kg"},
    },
    "energy": {"hotel": "10 W"},
    "navigation": {"velocity_error": {"sigma": "0 m/s"}, "surfacing_time": "60 s"},
    "phases": [
        {
            "transit": {
                "name": "run",
                "from": ["0 m", "0 m"],
                "to": ["1 km", "0 m"],
                "speed": "1 m/s",
                "d_max": "250 m",
                "arrival_radius": "1 m",
            }
        }
    ],
    "monte_carlo": {"trials": 300, "seed": 1},
}
UNIT = from_open_water(
    0.2,
    (0.4243, -0.9435),
    (0.0626, -0.1212),
    density=1000.0,
    axial_flow_factor=0.25,
    wake_fraction=0.2,
    thrust_deduction=0.1,
)
HULL = Resistance(mass=63.0, linear=0.0, quadratic=7.5)
RATE = float(shaft_rate_for(UNIT, 7.5, 1.0))
LOST = float(distance_lost(UNIT, HULL, RATE))


def mission(tmp_path, propulsion=PROPULSION, **transit):
    data = copy.deepcopy(BASE)
    if propulsion is not None:
        data["vehicle"]["propulsion"] = propulsion
    own = data["phases"][0]["transit"]
    own.update(transit)
    data["phases"][0]["transit"] = {key: value for key, value in own.items() if value is not None}
    if "sigma" in own:
        data["navigation"]["velocity_error"] = {"sigma": own.pop("sigma")}
        data["phases"][0]["transit"].pop("sigma")
    path = tmp_path / "mission.yaml"
    path.write_text(yaml.safe_dump(data))
    return load(path)


def duration(found):
    return found.phases[0].quantities["duration_s"].mean


def test_speed_follows_from_the_shaft_rate(tmp_path):
    turning = mission(tmp_path, speed=None, shaft_rate=f"{RATE} rad/s")
    assert float(Scenario.at_means(turning).transit("run").speed) == pytest.approx(1.0, rel=1e-9)
    same = mission(tmp_path)
    assert duration(simulate(turning, sheet=False)) == pytest.approx(duration(simulate(same, sheet=False)), rel=1e-9)
    assert math.isnan(turning.transits[0].speed)


def test_an_uncertain_shaft_rate_is_an_uncertain_speed(tmp_path):
    uncertain = mission(tmp_path, speed=None, shaft_rate={"mean": f"{RATE} rad/s", "sd": f"{0.05 * RATE} rad/s"})
    speed = np.asarray(Scenario.at_means(uncertain).sampled(seed=1, block=0, size=4000).transit("run").speed)
    # drag and thrust are quadratic: speed is in proportion to the shaft rate
    assert speed.mean() == pytest.approx(1.0, abs=0.004)
    assert speed.std() == pytest.approx(0.05, rel=0.05)


def test_turns_a_minute_are_turns(tmp_path):
    turning = mission(tmp_path, speed=None, shaft_rate=f"{RATE * 30.0 / math.pi} rpm")
    assert float(Scenario.at_means(turning).transit("run").speed) == pytest.approx(1.0, rel=1e-9)


@pytest.mark.parametrize("speed", [1.0, 1.6])
def test_each_leg_gathers_way(speed, tmp_path):
    """Where thrust and drag go by squares the way lost is the same at every speed."""
    assert Scenario.at_means(mission(tmp_path)).propelled.moving_mass == 63.0
    with_it, without = (
        duration(simulate(mission(tmp_path, propulsion, speed=f"{speed} m/s"), sheet=False))
        for propulsion in (PROPULSION, None)
    )
    assert without == pytest.approx(1000.0 / speed + 4 * 60.0)
    assert with_it - without == pytest.approx(4 * LOST / speed, rel=1e-9)
    assert LOST > 0.5


def test_error_grows_with_the_time_that_gathering_way_takes(tmp_path):
    """One leg's error is σ times its time: 250 m and what is lost, at 1 m/s."""
    one = {"to": ["250 m", "0 m"], "sigma": "0.01 m/s", "arrival_radius": "60 m"}
    for propulsion, length in ((PROPULSION, 250.0 + LOST), (None, 250.0)):
        found = simulate(mission(tmp_path, propulsion, **one), trials=4000, sheet=False)
        mean = found.phases[0].quantities["arrival_error_m"].mean
        assert mean == pytest.approx(0.01 * length * math.sqrt(math.pi / 2.0), rel=0.03)


@pytest.mark.parametrize("speed", ["1 m/s", "1.6 m/s"])
def test_a_speed_inferred_wrongly_moves_the_vehicle(speed, tmp_path):
    factors = {"thrust_factor": 0.9, "drag_factor": 1.2}
    weak = mission(tmp_path, PROPULSION | factors, speed=speed, arrival_radius="60 m")
    at_weak, at_right = Scenario.at_means(weak), Scenario.at_means(mission(tmp_path))
    (effect,) = at_weak.effects_under_way(at_weak.transit())
    expected = speed_error(UNIT, HULL, RATE, 1e9, thrust_factor=0.9, drag_factor=1.2)
    assert effect.fraction == pytest.approx(float(expected), rel=1e-6)
    error = simulate(weak, sheet=False).phases[0].quantities["arrival_error_m"].mean
    # four legs of d_max, each short by the same share of its time
    assert error == pytest.approx(-float(expected) * 4.0 * (250.0 + LOST), rel=1e-6)
    assert at_right.effects_under_way(at_right.transit()) == ()


def test_missions_without_a_propeller_are_as_they_were(tmp_path):
    plain = mission(tmp_path, propulsion=None)
    means = Scenario.at_means(plain)
    plan = means.transit_plan(means.transit())
    assert plan.length_lost is None
    distance = np.array([1234.5, 77.7])
    np.testing.assert_array_equal(plan.time_under_way(distance, np.array([5.0, 1.0])), distance / 1.0)


def test_sweep_charges_gathering_way(tmp_path):
    """More legs, more time lost: the cost of straight legs is that of the surfacings and of gathering way."""
    swept = sweep_dmax(mission(tmp_path), trials=50, method="monte-carlo").curves[0]
    for point in swept.points[::20]:
        legs = math.ceil(1000.0 / point.d_max - 1e-9)
        assert point.cost == pytest.approx(((legs - 1) * 60.0 + legs * LOST) / 1000.0, abs=1e-6)


@pytest.mark.parametrize(
    ("transit", "propulsion", "words"),
    [
        ({"shaft_rate": "60 rad/s"}, PROPULSION, "exactly one of speed and shaft_rate"),
        ({"speed": None}, PROPULSION, "missing"),
        ({"speed": None, "shaft_rate": "60 rad/s"}, None, "vehicle.propulsion"),
    ],
)
def test_what_is_refused(tmp_path, transit, propulsion, words):
    with pytest.raises(InputError, match=words):
        mission(tmp_path, propulsion, **transit)
