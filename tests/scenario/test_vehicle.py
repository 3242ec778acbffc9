"""What the tank found, in a vehicle file: fragments load as they stand, and phases use them."""

from pathlib import Path

import numpy as np
import pytest
import yaml

import missionplan
from missionplan.errors import InputError
from missionplan.montecarlo.distributions import Normal
from missionplan.physics import propeller as p
from missionplan.scenario.phases import dive_of
from missionplan.scenario.scenario import Scenario
from missionplan.studies.identification import identify
from missionplan.studies.simulation.simulate import simulate_block
from tests.physics import propeller_example as example

MISSIONS = Path(__file__).parents[2] / "missions"
PROPULSION = {
    "diameter": "0.1 m",
    "thrust_coefficient": [0.4243, -0.9435],
    "torque_coefficient": [0.0626, -0.1212],
    "thrust_deduction": 0.1,
    "motor_efficiency": 0.8,
}


def mission_with(tmp_path, **extra):
    """Chesapeake's mission with more in its vehicle file."""
    vehicle = yaml.safe_load((MISSIONS / "vehicles" / "vt475-self-mooring.yaml").read_text())
    (tmp_path / "vehicles").mkdir(exist_ok=True)
    (tmp_path / "vehicles" / "vt475-self-mooring.yaml").write_text(yaml.safe_dump({**vehicle, **extra}))
    (tmp_path / "mission.yaml").write_text((MISSIONS / "chesapeake.yaml").read_text())
    return missionplan.load(tmp_path / "mission.yaml")


@pytest.mark.parametrize("name", ["avila-drag", "avila-added-mass"])
def test_a_fragment_loads_as_it_stands(tmp_path, name):
    fragment = dict(identify(MISSIONS / "measured" / name).fragment)
    mission = mission_with(tmp_path, **fragment)
    assert any(path.startswith(("vehicle.drag", "vehicle.added_mass")) for path in mission.uncertain())


def test_measured_drag_takes_the_place_of_the_build_up(tmp_path):
    mission = mission_with(tmp_path, drag={"coefficient": 0.3, "area": "0.0114 m^2"})
    scenario = Scenario.at_means(mission)
    density = float(scenario.water.density)
    assert scenario.vehicle_drag(1.5) == pytest.approx(0.5 * density * 0.0114 * 0.3 * 1.5**2)
    assert scenario.vehicle_drag(-1.5) == pytest.approx(-scenario.vehicle_drag(1.5))
    dive = dive_of(scenario, mission.moors[0])
    assert dive.vehicle_drag(1.0) == pytest.approx(0.5 * density * 0.0114 * 0.3)


def test_drag_against_reynolds_number(tmp_path):
    drag = {"coefficient": 0.3, "area": "0.0114 m^2", "exponent": -0.2, "at_reynolds": 1e6, "length": "1.1 m"}
    law = Scenario.at_means(mission_with(tmp_path, drag=drag)).vehicle_drag
    assert law(2.0) / law(1.0) == pytest.approx(2.0**1.8, rel=1e-6)
    assert np.isfinite(law(0.0))


def test_an_exponent_needs_its_reynolds_number(tmp_path):
    with pytest.raises(InputError, match="an exponent needs it"):
        mission_with(tmp_path, drag={"coefficient": 0.3, "area": "0.0114 m^2", "exponent": -0.2})


def test_measured_added_mass_slows_the_dive(tmp_path):
    mission = mission_with(tmp_path, added_mass={"surge": "3 kg"})
    light = dive_of(Scenario.at_means(mission_with(tmp_path)), mission.moors[0])
    heavy = dive_of(Scenario.at_means(mission), mission.moors[0])
    assert heavy.vehicle_added_mass == pytest.approx(3.0)
    assert light.vehicle_added_mass < 1.0


def test_a_tunnel_thruster_may_be_uncertain():
    text = (MISSIONS / "autosub-transition.yaml").read_text()
    assert "vehicles/autosub.yaml" in text
    mission = missionplan.load(MISSIONS / "autosub-transition.yaml")
    thruster = mission.vehicle.thrusters[0].model_copy(update={"decay": Normal(6.69, 0.3)})
    vehicle = mission.vehicle.model_copy(update={"thrusters": (thruster,)})
    trials = simulate_block(mission.model_copy(update={"vehicle": vehicle}), seed=1, block=0, trials=5)
    assert np.ptp(trials.draws["vehicle.thrusters[0].decay"]) > 0.0


def test_fragments_of_thrusters_load(tmp_path):
    volts = {
        "name": "thruster",
        "ahead": {"mean": "9.4 N/V^2", "sd": "0.1 N/V^2"},
        "astern": "6.6 N/V^2",
        "deadband": "0.3 V",
    }
    tunnel = {
        "diameter": "0.07 m",
        "position": "0.8 m",
        "thrust_constant": {"mean": "0.02 N*s^2", "sd": "0.0004 N*s^2"},
        "decay": {"mean": 7.0, "sd": 0.2},
        "suction_gradient": 9.0,
    }
    assert len(mission_with(tmp_path, thrusters=[volts, tunnel]).vehicle.thrusters) == 2


def test_propulsion_gives_the_power_of_a_transit(tmp_path):
    mission = mission_with(tmp_path, propulsion=PROPULSION)
    scenario = Scenario.at_means(mission)
    power = scenario.transit_plan(scenario.transit()).power_under_way - scenario.budget.hotel
    work = float(scenario.vehicle_drag(1.5)) * 1.5
    unit = p.from_open_water(0.1, (0.4243, -0.9435), (0.0626, -0.1212), density=float(scenario.water.density))
    assert power > work / 0.8
    assert work / power < float(np.max(example.open_water_efficiency(unit, np.linspace(0.01, 0.44, 99), 1010.0)))
