"""What the planner would choose before and after a diagnosis, and how the choice of before fares."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from missionplan.diagnosis.plan_gain import anchor_choice, leg_length_choice, plan_gain, with_urgency
from missionplan.mission import Mission, load
from missionplan.results.failures import SUCCESS
from missionplan.results.learned import PlanGain
from missionplan.results.learned.levels import Level, ParameterLevels
from missionplan.studies.anchor import worst_case_anchor
from missionplan.studies.leg_length import sweep_dmax
from missionplan.studies.simulation import simulate

MISSIONS = Path(__file__).parents[2] / "missions"
LIFT = {"lift": "2 N", "depth": "8 m", "thickness": "2 m"}


@pytest.fixture(scope="module")
def mission() -> Mission:
    """The prototype's mooring, whose vehicle floats with 0.89 N."""
    return load(MISSIONS / "anchor-design.yaml").with_(trials=2000)


@pytest.fixture(scope="module")
def lifted(mission: Mission) -> PlanGain:
    """Plans with the mission and with a lift added."""
    return planned(mission, {"stratification": LIFT})


def planned(mission: Mission, *effects: dict[str, Any]) -> PlanGain:
    """Plans with the mission and with its effects added."""
    return plan_gain(anchor_choice, mission, {**mission.raw, "effects": list(effects)}, seed=1, jobs=1)


def test_the_anchor_chosen_carries_the_vehicle_down(lifted: PlanGain) -> None:
    """Eq. 15 leaves out the net buoyancy: an anchor sized without sinks slower than was asked, or not at all."""
    assert lifted.before["within_radius"] > 0.9
    assert lifted.after["within_radius"] > 0.9
    assert lifted.after["success"] == lifted.after["within_radius"]  # nothing else can fail here


def test_the_anchor_is_heavier_by_the_net_buoyancy_than_the_mission_asks_for(
    mission: Mission, lifted: PlanGain
) -> None:
    carried = lifted.before["anchor_wet_weight_n"] - worst_case_anchor(mission)
    assert not mission.moors[0].carry_net_buoyancy
    assert carried == pytest.approx(mission.quantities()["vehicle.net_buoyancy"])


def test_a_lift_asks_for_a_heavier_anchor_and_the_old_one_drifts_too_far(lifted: PlanGain) -> None:
    heavier = lifted.after["anchor_wet_weight_n"] - lifted.before["anchor_wet_weight_n"]
    assert 1.0 < heavier < 2.0  # the lift acts below 8 m of 30
    kept = lifted.base_choice_under_extended
    assert kept["anchor_wet_weight_n"] == lifted.before["anchor_wet_weight_n"]
    assert kept["within_radius"] < lifted.after["within_radius"] - 0.05


def test_what_changes_no_descent_changes_no_plan(mission: Mission) -> None:
    plan = planned(mission, {"clock-offset": {"time": "0.7 s"}})
    assert plan.after == plan.base_choice_under_extended == plan.before


def test_what_the_mission_has_is_tried_with_the_extended_model(mission: Mission) -> None:
    written = {**mission.raw, "phases": [{"moor": {**mission.raw["phases"][0]["moor"], "anchor_wet_weight": "9 N"}}]}
    plan = planned(Mission.from_data(written), {"stratification": LIFT})
    own = plan.as_written_under_extended
    assert own["anchor_wet_weight_n"] == pytest.approx(9.0)
    assert own["within_radius"] < plan.after["within_radius"]
    kept, before = plan.base_choice_under_extended, plan.before
    assert (kept["anchor_wet_weight_n"], before["anchor_wet_weight_n"] > 10.0) == (before["anchor_wet_weight_n"], True)


@pytest.mark.parametrize(("fall", "ahead"), [(0.009, None), (0.011, 4)])
def test_a_trend_matters_from_a_fall_of_a_hundredth_on(
    fall: float, ahead: int | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Success falls in four missions, by a little less or more than that."""

    def success(then: Any, **given: Any) -> Any:
        return {SUCCESS: SimpleNamespace(value=0.9 - fall * (then >= 4.0))}

    monkeypatch.setattr(simulate, "event_probabilities", success)
    mission: Any = SimpleNamespace(at_place=lambda place, missions: missions)
    level = ParameterLevels(
        "speed-scale", "fraction", "", (Level("", None, 0.0, 0.1, 0.0),) * 3, -0.02, 0.001, 0.99, 0.0, 0.1
    )
    assert [each.matters_in for each in with_urgency([level], mission, 1)] == [ahead]


def test_a_mission_without_a_mooring_says_why_there_is_no_plan() -> None:
    fig8 = load(MISSIONS / "fig8.yaml")
    plan = plan_gain(anchor_choice, fig8, fig8.raw, seed=1, jobs=1)
    assert plan.before == plan.after == {}
    assert "mooring" in plan.reason


def test_the_length_of_before_is_told_as_the_extended_mission_has_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three lengths of which the second is best before and the third after, and the one that the mission writes."""
    asked = []

    def sweep(mission: Mission, **given: Any) -> Any:
        lengths, is_extended = mission.sweep.d_max, len(mission.effects) > 0
        asked.append((is_extended, lengths if isinstance(lengths, tuple) else None))
        own = (350.0,) if isinstance(lengths, tuple) else (100.0, 200.0, 300.0)
        points = [
            SimpleNamespace(d_max=each, cost=each / 1e3 + is_extended, arrived=SimpleNamespace(value=0.9))
            for each in own
        ]
        best = -1 if is_extended else 1
        return SimpleNamespace(points=points, recommended_index=best % len(own), recommended=points[best])

    monkeypatch.setattr(sweep_dmax, "first_curve", sweep)
    base = load(MISSIONS / "fig8.yaml").with_(**{"ingress.d_max": "350 m"})
    found = plan_gain(
        leg_length_choice, base, {**base.raw, "effects": [{"speed-scale": {"fraction": 0.1}}]}, seed=1, jobs=1
    )
    plans = (found.before, found.after, found.base_choice_under_extended, found.as_written_under_extended)
    assert [(plan["d_max_m"], plan["cost"]) for plan in plans] == [
        (200.0, 0.2),
        (300.0, 1.3),
        (200.0, 1.2),
        (350.0, 1.35),
    ]
    assert [each[0] for each in asked] == [False, True, True]
