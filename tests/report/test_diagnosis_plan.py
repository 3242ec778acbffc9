"""What the report of a diagnosis says about the plan."""

from types import SimpleNamespace
from typing import Any

import pytest

from missionplan.report.diagnosis.plan import plan_section, plan_words
from missionplan.results.learned import PlanGain


def diagnosed(
    before: dict[str, Any], after: dict[str, Any], kept: dict[str, Any], verdict: str = "explained", own: Any = None
) -> Any:
    gain = PlanGain(before, after, kept, as_written_under_extended=own)
    return SimpleNamespace(decision=gain, verdict=verdict, causes=("compass-bias",))


def anchor(weight: float, within: float) -> dict[str, Any]:
    return {"anchor_wet_weight_n": weight, "within_radius": within, "struck_seafloor": 0.0}


def legs(d_max: float, cost: float | None) -> dict[str, Any]:
    return {"d_max_m": d_max, "cost": cost, "arrived": 1.0}


def test_a_heavier_anchor_is_asked_for_with_what_the_old_one_would_do() -> None:
    (words,) = plan_words(diagnosed(anchor(2.14, 0.96), anchor(2.84, 0.97), anchor(2.14, 0.075)))
    assert words == (
        "Plan with an anchor of 2.84\u00a0N wet, 97 % within the radius; the anchor of the mission's model, "
        "2.14\u00a0N wet, stays within the radius in 8 % of the dives, not in 96 %."
    )


def test_an_anchor_that_serves_is_left() -> None:
    (words,) = plan_words(diagnosed(anchor(2.0, 0.95), anchor(2.0, 0.945), anchor(2.0, 0.945)))
    assert words == "The anchor of the mission's model, 2\u00a0N wet, still serves: 94 % within the radius."


def test_where_the_worst_case_asks_for_the_same_anchor_the_odds_are_pointed_to() -> None:
    (words,) = plan_words(diagnosed(anchor(4.36, 0.93), anchor(4.36, 0.88), anchor(4.36, 0.88)))
    assert "in 88 % of the dives, not in 93 %; size-anchor with --probability" in words


def test_an_anchor_that_seldom_holds_is_no_plan() -> None:
    (words,) = plan_words(diagnosed(anchor(1.02, 1.0), anchor(3.64, 0.18), anchor(1.02, 0.0)))
    assert (
        "in 0 % of the dives, not in > 99 %, and one sized with the extended model, 3.64\u00a0N wet, in 18 %" in words
    )
    assert words.endswith("size-anchor with --probability finds the weight for more.")


def test_a_vehicle_that_strikes_the_seafloor_is_said() -> None:
    struck = {**anchor(2.84, 0.97), "struck_seafloor": 0.31}
    (words,) = plan_words(diagnosed(anchor(2.14, 0.96), struck, anchor(2.14, 0.075)))
    assert words.endswith("not in 96 %. With that anchor the vehicle strikes the seafloor in 31 %: lengthen the line.")


def test_no_plan_is_asserted_on_a_cause_that_is_not() -> None:
    (words,) = plan_words(diagnosed(legs(16e3, 0.01), legs(5e3, 0.04), legs(16e3, 0.05), "ambiguous"))
    assert words.startswith("If that is what it was: plan with a d_max of 5\u00a0km, for 4 % beyond")
    assert "the d_max of the mission's model, 16\u00a0km, would take 5 % (expected: 1 %)" in words


@pytest.mark.parametrize(
    ("after", "kept"), [(legs(5e3, 0.04), legs(16e3, 0.041)), (legs(16e3, -0.012), legs(16e3, -0.012))]
)
def test_a_leg_length_that_serves_is_left(after: dict[str, Any], kept: dict[str, Any]) -> None:
    (words,) = plan_words(diagnosed(legs(16e3, 0.0), after, kept))
    assert words.startswith("The d_max of the mission's model, 16\u00a0km, still serves: it takes")
    assert "(expected: 0 %)" in words


def test_a_current_that_helps_takes_less_than_the_straight_way_s_time() -> None:
    (words,) = plan_words(diagnosed(legs(16e3, 0.0), legs(16e3, -0.012), legs(16e3, -0.012)))
    assert "serves: it takes 1.2 % less than the straight way's time (expected: 0 %)" in words


def test_what_stands_in_the_mission_is_held_against_the_new_plan_and_no_third_length_is_named() -> None:
    found = diagnosed(legs(564.0, 0.0), legs(484.0, 0.02), legs(564.0, 0.078), own=legs(300.0, 0.05))
    (words,) = plan_words(found)
    assert words == (
        "Plan with a d_max of 484\u00a0m, for 2 % beyond the straight way's time; the mission's d_max, 300\u00a0m, "
        "would take 5 %."
    )
    (section,) = plan_section(found)
    (table,) = section.blocks
    assert [row[0] for row in table.rows] == ["The mission as it is", "Planned anew"]
    (words,) = plan_words(diagnosed(anchor(2.1, 0.9), anchor(2.8, 0.97), anchor(2.1, 0.5), own=anchor(3.0, 0.98)))
    assert words == "The mission's anchor, 3\u00a0N wet, still serves: 98 % within the radius."


def test_legs_of_which_many_never_arrive_do_not_serve() -> None:
    own, anew = {**legs(1385.0, 3.6), "arrived": 0.783}, {**legs(4759.0, 8.3), "arrived": 0.824}
    (words,) = plan_words(diagnosed(legs(800.0, 0.1), anew, own, own=own))
    assert words == (
        "No d_max serves: with 4.76\u00a0km 82 % of the transits arrive, with the mission's d_max, 1.39\u00a0km, 78 %."
    )


def test_legs_that_never_arrive_take_no_end() -> None:
    (words,) = plan_words(diagnosed(legs(16e3, 0.01), legs(484.2, 0.04), legs(16e3, None)))
    assert words.startswith("Plan with a d_max of 484\u00a0m, for 4 %")
    assert "would take no end (expected: 1 %)" in words


def test_without_plans_nothing_is_said_but_why() -> None:
    none: Any = SimpleNamespace(decision=PlanGain(reason="no mooring"), verdict="explained", causes=())
    assert plan_words(none) == []
    (section,) = plan_section(none)
    assert section.heading == "No plans to compare"
    assert list(section.blocks) == ["no mooring"]
