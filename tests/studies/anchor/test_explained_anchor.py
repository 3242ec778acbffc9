"""`size-anchor` of a mission in doubt: what the anchor to build achieves under each explanation, and what would do."""

import numpy as np
import pytest

from missionplan import Mission, size_anchor
from missionplan.montecarlo.statistics import RunningStatistic, wilson
from missionplan.report.anchor.page import answer
from missionplan.report.render import render_report
from missionplan.results.sized_anchor import DiveProbabilities
from missionplan.studies.anchor.sizing import AnchorTrials

pytestmark = pytest.mark.usefixtures("unassumed", "unplanned", "unranked")

BASE = {
    "name": "dives in doubt",
    "vehicle": {
        "hull": {"length": "1.12 m", "diameter": "0.12 m"},
        "appendage_factor": 1.25,
        "mass": "10.2 kg",
        "net_buoyancy": "0.9 N",
        "anchor": {"diameter": "0.12 m", "flooded_mass": "2.6 kg"},
    },
    "site": {
        "depth": "9 m",
        "water": {"density": "1000 kg/m^3", "viscosity": "1.1e-6 m^2/s"},
        "current": [{"down_to": "9 m", "speed": {"mean": "0.4 m/s", "sd": "0.05 m/s"}, "toward": "60 deg"}],
    },
    "phases": [
        {"moor": {"radius": "5.5 m", "anchor_wet_weight": "12 N", "line_length": "3 m", "lateral": "uncoupled"}}
    ],
}


def sized(*effects, probability=0.95):
    share = 1.0 / len(effects)
    explanations = [{"probability": share, "effects": [effect]} for effect in effects]
    mission = Mission.from_data({**BASE, "effects": [{"one-of": explanations}]})
    return mission, size_anchor(mission, probability=probability, trials=100)


def made_up(dives, weight, line_length=None):
    """Dives within the radius from 8 N on where the water resists more, else from 5 N on, and clear of the seafloor."""
    (doubt,) = dives.mission.effect_list.items
    held = doubt.explanations if doubt.known is None else (doubt.explanations[doubt.known],)
    enough = [weight >= (8.0 if each.effects[0].effect == "drag-bias" else 5.0) for each in held]
    good = np.average(enough, weights=[each.probability for each in held])
    some, none = (wilson(round(100 * share), 100) for share in (good, 0.0))
    lasting = RunningStatistic.of(np.arange(5.0)).statistic()
    return DiveProbabilities(some, some, None, none, lasting, lasting, ())


def test_a_doubt_that_changes_the_anchor_is_told(monkeypatch):
    monkeypatch.setattr(AnchorTrials, "probabilities", made_up)
    _, found = sized({"drag-bias": {"fraction": 0.7}}, {"depth-scale": {"fraction": 0.05}})
    heavy, light = found.explanations
    assert heavy.needed == pytest.approx(8.0, rel=0.002)
    assert light.needed == pytest.approx(5.0, rel=0.002)
    assert found.to_build.wet_weight == pytest.approx(8.0, rel=0.002)
    assert light.good.value == 1.0
    assert "The doubt changes the choice: with depth scale" in answer(found)
    assert "Which explanation holds" in render_report(found).html
    assert [each["causes"] for each in found.summary()["explanations"]] == [["drag-bias"], ["depth-scale"]]


@pytest.mark.slow
def test_an_anchor_that_meets_more_drag_must_be_heavier():
    _, found = sized({"drag-bias": {"fraction": 0.7}}, {"depth-scale": {"fraction": 0.05}})
    heavy, light = found.explanations
    assert heavy.needed > 1.3 * light.needed
    assert light.needed < found.to_build.wet_weight <= 1.002 * heavy.needed


@pytest.mark.slow
def test_what_an_explanation_needs_is_what_a_mission_that_knows_it_needs():
    mission, found = sized({"drag-bias": {"fraction": 0.7}}, {"depth-scale": {"fraction": 0.05}})
    heavy, _ = found.explanations
    known = size_anchor(mission.knowing("effects[0].one-of", 0), probability=0.95, trials=100)
    assert known.to_build.wet_weight == pytest.approx(heavy.needed, rel=2e-3)  # found from another start


@pytest.mark.slow
def test_readings_alone_change_no_anchor():
    _, found = sized({"clock-offset": {"time": "1 s"}}, {"depth-scale": {"fraction": 0.05}})
    assert "Whichever explanation holds, the same anchor is best" in answer(found)
    first, second = found.explanations
    assert first.needed == second.needed


def test_without_a_probability_each_explanation_is_judged_by_the_anchor():
    _, found = sized({"drag-bias": {"fraction": 0.5}}, {"trapped-gas": {"lift": "0.1 N"}}, probability=None)
    assert all(each.needed is None for each in found.explanations)
    assert "hichever explanation holds" in answer(found) or "It depends on which explanation holds" in answer(found)


def test_a_mission_without_doubt_has_none():
    found = size_anchor(Mission.from_data(BASE), trials=100)
    assert found.explanations == ()
    assert "explanation" not in answer(found)
