"""What a result tells the crew to do: was and now by the mission's own keys, in every summary."""

from pathlib import Path

import pytest

import missionplan
from missionplan.report.render import terminal_view
from missionplan.results.decision import changes_of, written

MISSIONS = Path(__file__).parents[2] / "missions"
DATA = {
    "site": {"current": [{"speed": "0.2 m/s"}]},
    "phases": [{"transit": {"name": "out", "d_max": "300 m"}}, {"moor": {"line_length": "5 m"}}],
}


def test_what_a_mission_has_at_a_key_is_found_by_phase_and_list():
    assert written(DATA, "out.d_max") == "300 m"
    assert written(DATA, "moor.line_length") == "5 m"
    assert written(DATA, "site.current[0].speed") == "0.2 m/s"
    assert written(DATA, "site.current[3].speed") is None
    assert written(DATA, "energy.hotel") is None


def test_only_what_differs_changes():
    (change,) = changes_of(DATA, {"out.d_max": "400 m", "moor.line_length": "5 m"})
    assert (change.key, change.was, change.now) == ("out.d_max", "300 m", "400 m")


def test_every_summary_has_the_decision_that_the_terminal_shows():
    sweep = missionplan.sweep_dmax(MISSIONS / "fig8.yaml", trials=50, method="analytic")
    outcome = missionplan.simulate(MISSIONS / "chesapeake.yaml", trials=100, sheet=False)
    for result in (sweep, outcome):
        decision = result.summary()["decision"]
        assert decision["do"] == terminal_view(result).sentence
        assert set(decision) >= {"do", "sure", "assumes", "changes", "not_in_this_probability"}
    assert outcome.summary()["decision"]["sure"]["value"] == outcome.total.events["success"].value
    (change,) = sweep.summary()["decision"]["changes"]
    assert (change["key"], change["was"]) == ("ingress.d_max", "4 nmi")
    assert float(change["now"].removesuffix(" m")) == pytest.approx(sweep.middle.recommended.d_max, abs=0.1)
