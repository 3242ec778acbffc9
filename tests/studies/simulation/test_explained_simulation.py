"""`simulate` of a mission in doubt: each explanation beside the whole, and whether it is worth finding out which."""

import numpy as np
import pytest

from missionplan import Mission, simulate
from missionplan.report.explained import explanation_in_words
from missionplan.report.render import render_report
from missionplan.studies.simulation.simulate import simulate_block

pytestmark = pytest.mark.usefixtures("unplanned", "unheld")

TRIALS = 600
BASE = {
    "name": "in doubt",
    "vehicle": {
        "hull": {"length": "1.5 m", "diameter": "0.12 m"},
        "mass": "15 kg",
        "net_buoyancy": "0.9 N",
        "energy": {"hotel": "10 W", "propulsive_efficiency": 0.5, "capacity": "200 W*h"},
    },
    "site": {"water": {"density": "1000 kg/m^3", "viscosity": "1.1e-6 m^2/s"}},
    "navigation": {"velocity_error": {"sigma": "0.03 m/s"}, "surfacing_time": "60 s", "max_legs": 12},
    "phases": [
        {
            "transit": {
                "name": "out",
                "from": ["0 m", "0 m"],
                "to": ["8 km", "0 m"],
                "speed": "1.5 m/s",
                "d_max": "2 km",
                "arrival_radius": "60 m",
            }
        }
    ],
}


def outcome(*effects):
    explanations = [{"probability": 0.4, "effects": [effect]} for effect in effects]
    return simulate(Mission.from_data({**BASE, "effects": [{"one-of": explanations}]}), trials=TRIALS)


@pytest.fixture(scope="module")
def harmless():
    return outcome({"compass-bias": {"angle": "0.5 deg"}}, {"speed-scale": {"fraction": 0.002}})


@pytest.fixture(scope="module")
def decisive():
    return outcome({"compass-bias": {"angle": "1 deg"}}, {"mean-current": {"east": "-1.3 m/s"}})


def test_explanations_are_the_trials_in_which_they_hold(decisive):
    mission = Mission.from_data(dict(decisive.provenance.data))
    trials = simulate_block(mission, seed=1, block=0, trials=TRIALS)
    for each in decisive.explanations:
        held = trials.draws[each.place] == each.number
        assert each.trials == held.sum()
        assert each.success.value == pytest.approx(trials.success[held].mean())
        ended = trials.total["energy_wh"][held & np.isfinite(trials.total["energy_wh"])]
        assert each.energy.count == len(ended)
        assert not len(ended) or each.energy.mean == pytest.approx(ended.mean())
        assert each.probability == pytest.approx(held.mean(), abs=0.05)
    assert sum(each.trials for each in decisive.explanations) == TRIALS
    assert [each["causes"] for each in decisive.summary()["explanations"]] == [
        ["compass-bias"],
        ["mean-current"],
        [],
    ]


def test_a_doubt_that_decides_is_told_first(decisive):
    words = explanation_in_words(decisive)
    assert words.startswith("It depends on which explanation holds")
    assert "with mean current" in words
    (found,) = [s for s in decisive.sensitivities if (s.output, s.source) == ("total.success", "effects[0].one-of")]
    assert found.first_order > 0.5
    html = render_report(decisive).html
    assert "find out what you can before you rely on the plan" in html


def test_a_doubt_without_weight_is_left_alone(harmless):
    assert explanation_in_words(harmless).startswith("Whichever explanation holds")
    html = render_report(harmless).html
    assert "no need to find out" in html
    assert "which explanation holds" in html


def test_a_mission_without_doubt_has_no_such_section():
    found = simulate(Mission.from_data(BASE), trials=200)
    assert found.summary()["explanations"] == []
    assert "Which explanation holds" not in render_report(found).html
