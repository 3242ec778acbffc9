"""`plan-legs` of a mission in doubt: table and fixed d_max under each explanation."""

import pytest

from missionplan import Mission, plan_legs
from missionplan.report.render import render_report
from missionplan.studies.leg_length.plan_page import answer, cases_table

pytestmark = pytest.mark.usefixtures("unassumed", "unsought", "unplanned", "unranked", "unheld")

BASE = {
    "name": "in doubt",
    "navigation": {"velocity_error": {"sigma": "0.04 m/s"}, "surfacing_time": "90 s"},
    "phases": [
        {
            "transit": {
                "name": "out",
                "from": ["0 m", "0 m"],
                "to": ["6 km", "0 m"],
                "speed": "1.2 m/s",
                "d_max": "1 km",
                "arrival_radius": "60 m",
            }
        }
    ],
}


def test_the_plans_run_under_each_explanation():
    causes = [{"compass-bias": {"angle": "1 deg"}}, {"mean-current": {"north": "0.1 m/s"}}]
    explanations = [{"probability": 0.4, "effects": [effect]} for effect in causes]
    found = plan_legs(Mission.from_data({**BASE, "effects": [{"one-of": explanations}]}), trials=300)
    explained = [case for case in found.cases if case.probability is not None]
    assert [case.name for case in explained] == ["compass bias", "mean current", "none of them"]
    whole = found.cases[0].fixed.cost
    costs = [case.fixed.cost for case in explained]
    assert min(costs) < whole < max(costs)
    assert costs[1] == max(costs)  # the current is the worst
    assert "explanation holds" in answer(found) or not found.adapts
    assert any(row[0].startswith("mean current (40") for row in cases_table(found).rows)
    assert "mean current (40" in render_report(found).html
    assert [case.get("explanation") for case in found.summary()["cases"]][-3:-1] == [0.4, 0.4]


def test_without_doubt_there_are_no_such_cases():
    found = plan_legs(Mission.from_data(BASE), trials=100)
    assert all(case.probability is None for case in found.cases)
    assert "explanation" not in answer(found)
