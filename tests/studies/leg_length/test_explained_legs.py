"""`plan-legs` of a mission in doubt: table and fixed d_max under each explanation."""

from types import SimpleNamespace

import numpy as np
import pytest

from missionplan import Mission, plan_legs
from missionplan.report.render import render_report
from missionplan.studies.leg_length import plan_legs as module
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


def test_what_the_table_saves_is_the_fixed_plan_s_less_its_own_where_both_arrive(monkeypatch):
    def plan(cost, energy, surfacings, arrived):
        names = {"cost": cost, "energy": energy, "surfacings": surfacings, "arrived": arrived}
        return SimpleNamespace(nominal=100.0, **{name: np.array(values) for name, values in names.items()})

    fixed = plan([0.5, 0.7, 9.0], [20.0, 30.0, 99.0], [9.0, 7.0, 1.0], [True, True, True])
    table = plan([0.4, 0.5, 9.0], [18.0, 25.0, 11.0], [5.0, 6.0, 1.0], [True, True, False])
    monkeypatch.setattr(module, "run_plans", lambda *_, **__: (fixed, table))
    found = module.PairedPlansTask(None, [None], None, None, 3, 1)((0, 0))
    assert found.mean == pytest.approx([0.6, 0.45, 15.0, 8.0, 5.5, 3.5, 1.0, 2.0 / 3.0])
