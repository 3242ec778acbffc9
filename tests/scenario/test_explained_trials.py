"""Trials of a mission with explanations: each draws which one holds, and its effects act in those trials alone."""

import copy

import numpy as np
import pytest

from missionplan import Mission, simulate
from missionplan.scenario.anchors import worst_case_weight
from missionplan.scenario.scenario import Scenario
from missionplan.studies.simulation.simulate import simulate_block

TRIALS = 400
LEGS = {
    "name": "legs in doubt",
    "site": {"origin": {"latitude": "37 deg", "longitude": "-76 deg"}},
    "navigation": {"velocity_error": {"sigma": "0.03 m/s"}, "surfacing_time": "60 s", "fix_error": "3 m"},
    "phases": [
        {
            "transit": {
                "name": "out",
                "from": ["0 m", "0 m"],
                "to": ["8 km", "0 m"],
                "speed": "1.5 m/s",
                "d_max": "1500 m",
                "arrival_radius": "100 m",
            }
        }
    ],
    "effects": [{"speed-scale": {"fraction": {"mean": 0.01, "sd": 0.01}}}],
}
CAUSES = [
    [{"compass-bias": {"angle": {"mean": "6 deg", "sd": "1 deg"}}}],
    [{"persistent-error": {"sigma": {"median": "0.1 m/s", "factor": 1.2}, "time": "1 h"}}, {"surface-drift": {}}],
    [{"heavy-tails": {"dof": 2.5}}, {"fix-error": {"sd": {"median": "30 m", "factor": 1.5}}}],
    [{"tidal-current": {"m2_east": {"mean": "0.2 m/s", "sd": "0.02 m/s"}, "modulation": 0.3}}],
    [
        {"inertial-current": {"amplitude": {"mean": "0.1 m/s", "sd": "0.02 m/s"}}},
        {"random-walk": {"rate": "1e-3 m/s**1.5"}},
    ],
    [
        {"mean-current": {"east": {"mean": "0.1 m/s", "sd": "0.02 m/s"}}},
        {"compass-deviation": {"amplitude": "3 deg", "phase": "1 rad"}},
    ],
]
MOOR = {
    "name": "dives in doubt",
    "vehicle": {
        "hull": {"length": "1.12 m", "diameter": "0.12 m"},
        "appendage_factor": 1.25,
        "mass": "10.2 kg",
        "net_buoyancy": "0.9 N",
        "anchor": {"diameter": "0.12 m", "flooded_mass": "2.6 kg"},
    },
    "site": {
        "depth": "24 m",
        "water": {"density": "1000 kg/m^3", "viscosity": "1.1e-6 m^2/s"},
        "current": [{"down_to": "24 m", "speed": {"mean": "0.3 m/s", "sd": "0.05 m/s"}, "toward": "60 deg"}],
    },
    "phases": [{"moor": {"radius": "20 m", "anchor_wet_weight": "12 N", "line_length": "5 m", "hold": "5 min"}}],
}
FALLS = [
    [{"drag-bias": {"fraction": {"mean": 0.4, "sd": 0.1}}}],
    [{"trapped-gas": {}}, {"line-payout": {}}],
    [{"vertical-current": {"speed": {"mean": "0.05 m/s", "sd": "0.01 m/s"}}}, {"sensor-lag": {"time": "1 s"}}],
]


def in_doubt(data, causes, share=0.9):
    data = copy.deepcopy(data)
    explanations = [{"probability": share / len(causes), "effects": effects} for effects in causes]
    data["effects"] = [*data.get("effects", []), {"one-of": explanations}]
    return data


def usual(effects):
    """Give effects without parameters those of their usual size."""
    from missionplan.effects import CATALOGUE

    sizes = {
        name: {k: f"{p.scale or p.median:g} {p.unit}".strip() for k, p in CATALOGUE[name].parameters.items() if p.scale}
        for effect in effects
        for name in effect
    }
    return [{name: given or sizes[name]} for effect in effects for name, given in effect.items()]


CASES = {"legs": (LEGS, [usual(each) for each in CAUSES]), "dives": (MOOR, [usual(each) for each in FALLS])}


@pytest.mark.parametrize(("data", "causes"), CASES.values(), ids=CASES)
def test_an_explanation_acts_in_the_trials_in_which_it_holds_and_in_no_other(data, causes):
    mission = Mission.from_data(in_doubt(data, causes))
    (doubt,) = mission.doubts
    trials = simulate_block(mission, seed=4, block=0, trials=TRIALS)
    which = trials.draws[doubt.place]
    assert set(which) == set(range(len(causes) + 1))  # the last: none of them
    for number in range(len(causes) + 1):
        known = simulate_block(mission.knowing(doubt.place, number), seed=4, block=0, trials=TRIALS)
        held = which == number
        for name, values in known.columns().items():
            assert np.array_equal(values[held], trials.columns()[name][held], equal_nan=True), (number, name)


@pytest.mark.parametrize(("data", "causes"), CASES.values(), ids=CASES)
def test_without_any_explanation_the_mission_is_the_plain_one(data, causes):
    plain = simulate_block(Mission.from_data(data), seed=4, block=0, trials=TRIALS)
    mission = Mission.from_data(in_doubt(data, causes))
    none = simulate_block(mission.knowing(mission.doubts[0].place, len(causes)), seed=4, block=0, trials=TRIALS)
    for name, values in plain.columns().items():
        assert np.allclose(values, none.columns()[name], rtol=1e-12, atol=1e-12, equal_nan=True), name


def test_explanations_hold_as_often_as_their_probabilities():
    mission = Mission.from_data(in_doubt(LEGS, CAUSES[:2], share=0.8))
    drawn = Scenario.at_means(mission).sampled(seed=1, block=0)
    shares = np.bincount(drawn.draws["effects[1].one-of"].astype(int)) / drawn.trials
    assert shares == pytest.approx([0.4, 0.4, 0.2], abs=4 * np.sqrt(0.25 / drawn.trials))


def test_a_further_doubt_leaves_every_other_draw_alone():
    plain, doubtful = (
        Scenario.at_means(Mission.from_data(data)).sampled(seed=1, block=2) for data in (LEGS, in_doubt(LEGS, CAUSES))
    )
    assert all(np.array_equal(doubtful.draws[name], plain.draws[name]) for name in plain.draws)


def test_parameters_of_an_explanation_are_correlated_as_it_says():
    data = in_doubt(LEGS, [[{"mean-current": {k: {"mean": "0 m/s", "sd": "0.1 m/s"} for k in ("east", "north")}}]])
    pair = {"between": ["mean-current.north", "mean-current.east"], "rho": -0.7}
    data["effects"][1]["one-of"][0]["correlations"] = [pair]
    drawn = Scenario.at_means(Mission.from_data(data)).sampled(seed=1, block=0)
    east, north = (drawn.draws[f"effects[1].one-of[0].mean-current.{key}"] for key in ("east", "north"))
    assert np.corrcoef(east, north)[0, 1] == pytest.approx(-0.7, abs=0.04)


def test_the_number_of_jobs_does_not_change_a_bit():
    mission = Mission.from_data(in_doubt(MOOR, CASES["dives"][1]))
    once, shared = (simulate(mission, trials=4200, jobs=jobs, sheet=False).summary() for jobs in (1, 2))
    assert once["phases"] == shared["phases"]
    assert once["sensitivities"] == shared["sensitivities"]


def test_the_filter_knows_the_drift_of_explanations_by_their_probabilities():
    data = in_doubt(LEGS, [[{"mean-current": {"east": "0.2 m/s"}}], [{"persistent-error": {"sigma": "0.1 m/s"}}]], 1.0)
    data["navigation"]["drift_compensation"] = "filter"
    scenario = Scenario.at_means(Mission.from_data(data))
    model = scenario.compensation(scenario.transit()).model
    assert model.mean[0] == pytest.approx(0.1, abs=0.01)  # half of the trials have 0.2 m/s
    assert model.prior[0, 0] == pytest.approx(0.1**2, rel=0.1)
    assert np.trace(model.prior) - model.prior[0, 0] == pytest.approx(2 * 0.5 * 0.1**2, rel=0.1)


def test_the_worst_case_anchor_allows_for_the_explanation_that_needs_the_heaviest():
    mission = Mission.from_data(in_doubt(MOOR, CASES["dives"][1]))
    weights = []
    for number in range(len(FALLS) + 1):
        means = Scenario.at_means(mission.knowing(mission.doubts[0].place, number))
        weights.append(worst_case_weight(means, mission.moors[0]))
    assert worst_case_weight(Scenario.at_means(mission), mission.moors[0]) == max(weights)
    assert max(weights) > 1.2 * weights[-1]
