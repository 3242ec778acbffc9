"""`sweep-dmax` of a mission in doubt: the best d_max of each explanation beside that over all of them."""

from types import SimpleNamespace

import pytest

from missionplan import Mission, sweep_dmax
from missionplan.montecarlo.statistics import wilson
from missionplan.report.render import render_report
from missionplan.studies.leg_length.sweep_page import _doubt_in_words, answer

pytestmark = pytest.mark.usefixtures("unassumed", "unplanned", "unranked", "unheld")

BASE = {
    "name": "in doubt",
    "navigation": {"velocity_error": {"sigma": "0.02 m/s"}, "surfacing_time": "90 s"},
    "phases": [
        {
            "transit": {
                "name": "out",
                "from": ["0 m", "0 m"],
                "to": ["8 km", "0 m"],
                "speed": "1.5 m/s",
                "d_max": "2 km",
                "arrival_radius": "100 m",
            }
        }
    ],
    "sweep": {"d_max": {"from": 0.1, "to": 1.0, "points": 8, "of": "distance"}},
}


def swept(*effects, sigma=None):
    explanations = [{"probability": 0.5, "effects": [effect]} for effect in effects]
    sweep = BASE["sweep"] | ({"sigma": sigma} if sigma else {})
    mission = Mission.from_data({**BASE, "sweep": sweep, "effects": [{"one-of": explanations}]})
    return sweep_dmax(mission, trials=300)


def test_a_doubt_that_changes_the_choice_is_told():
    found = swept({"compass-bias": {"angle": "0.2 deg"}}, {"mean-current": {"north": "0.35 m/s"}})
    first, second = found.explanations
    assert first.curve.recommended.d_max != second.curve.recommended.d_max
    assert not all(each.keeps_choice for each in found.explanations)
    assert answer(found).startswith("Nothing to choose yet: as the mission stands, d_max = ")
    assert "first find out which explanation holds" in answer(found)
    assert [each["causes"] for each in found.summary()["explanations"]] == [["compass-bias"], ["mean-current"]]
    assert "Which explanation holds" in render_report(found).html
    at = found.middle.recommended_index
    assert first.chosen == first.curve.points[at]
    assert first.excess == pytest.approx((1 + first.chosen.cost) / (1 + first.curve.recommended.cost) - 1)


@pytest.mark.parametrize(
    ("short", "words"),
    [
        (False, "with compass bias it is 300 m, and the other takes 30 % longer then"),
        (True, "with mean current it is 200 m, and the other arrives in 40"),
    ],
)
def test_of_several_doubts_that_change_the_choice_the_worst_is_told(short, words):
    """One that no longer arrives as often as required is worse than any that takes longer."""
    chosen = SimpleNamespace(arrived=wilson(400, 1000))
    explanations = [
        SimpleNamespace(
            causes=(cause,),
            excess=excess,
            chosen=chosen,
            keeps_choice=cause == "fix-error",
            curve=SimpleNamespace(
                recommended=SimpleNamespace(d_max=d_max),
                reaches=lambda _, cause=cause: not short or cause != "mean-current",
            ),
        )
        for cause, excess, d_max in (
            ("mean-current", 0.1, 200.0),
            ("compass-bias", 0.3, 300.0),
            ("fix-error", 0.9, 9.0),
        )
    ]
    assert words in _doubt_in_words(SimpleNamespace(explanations=explanations)).replace("\u00a0", " ")


def test_a_doubt_that_leaves_the_choice_is_told_too():
    found = swept(
        {"speed-scale": {"fraction": 0.001}}, {"speed-scale": {"fraction": -0.001}}, sigma=["0.01 m/s", "0.02 m/s"]
    )
    assert "Whichever explanation holds, this d_max is as good" in answer(found)
    assert all(each.curve.sigma == found.middle.sigma for each in found.explanations)


def test_the_whole_lies_between_its_explanations():
    found = swept({"compass-bias": {"angle": "0.2 deg"}}, {"mean-current": {"north": "0.2 m/s"}})
    for index, point in enumerate(found.middle.points):
        costs = [each.curve.points[index].cost for each in found.explanations]
        assert min(costs) <= point.cost <= max(costs)


def test_without_doubt_there_is_none():
    found = sweep_dmax(Mission.from_data(BASE), trials=200)
    assert found.explanations == ()
    assert "explanation" not in answer(found)
