"""Anchors heavier than the mass in the vehicle file could be, which a search for the lightest may try."""

import numpy as np
import pytest

from missionplan import Mission
from missionplan.scenario.anchors import anchor_flooded_mass
from missionplan.scenario.scenario import Scenario
from missionplan.studies.anchor.sizing import AnchorTrials

MISSION = {
    "name": "a small vehicle in a strong current",
    "vehicle": {
        "hull": {"length": "1.003 m", "diameter": "0.1195 m"},
        "mass": "10.8 kg",
        "net_buoyancy": "0.9 N",
        "anchor": {"diameter": "0.118 m", "drag_coefficient": 0.32, "flooded_mass": "2.55 kg"},
    },
    "site": {
        "depth": "37.8 m",
        "water": {"density": "1010 kg/m^3", "viscosity": "1.02e-6 m^2/s"},
        "current": [{"down_to": "37.8 m", "speed": {"mean": "0.39 m/s", "sd": "0.06 m/s"}, "toward": "60 deg"}],
    },
    "phases": [{"moor": {"radius": "17.5 m", "anchor_wet_weight": "6.9 N", "line_length": "8 m"}}],
}


def test_the_heavier_the_anchor_the_less_it_drifts():
    mission = Mission.from_data(MISSION)
    study = AnchorTrials(mission, "moor", None, trials=200, seed=3)
    dives = [study.probabilities(weight) for weight in (10.0, 25.0, 78.0, 200.0)]
    drifts = [dive.offset.mean for dive in dives]
    assert all(dive.offset.count == 200 for dive in dives)
    assert np.all(np.diff(drifts) < 0.0)
    assert all(dive.within.value == 1.0 for dive in dives[1:])


def test_the_mass_in_the_file_counts_as_long_as_it_can_weigh_so_much():
    means = Scenario.at_means(Mission.from_data(MISSION))
    masses = anchor_flooded_mass(means, np.array([6.9, 22.0, 78.0]))
    assert masses[:2].tolist() == [2.55, 2.55]
    assert masses[2] == pytest.approx(78.0 / 9.80665 / (1.0 - 1010.0 / 11_340.0))
