"""Numbers of the page of `plan-legs`, by hand: costs, savings, candidates, and whether the answer is an order."""

from dataclasses import replace

import numpy as np
import pytest

from missionplan.montecarlo.statistics import Statistic, wilson
from missionplan.results import Provenance
from missionplan.studies.leg_length import plan_page
from missionplan.studies.leg_length.plan_result import CandidatePlan, LegCase, LegPlan, MeanAndError, SampledCost

NAN = float("nan")


def cost(value, arrived=995, surfacings=3.0):
    return SampledCost(value, 0.001, surfacings, wilson(arrived, 1000))


def case(name, fixed, adaptive, saved, probability=None):
    saving = MeanAndError(saved, 2.0)
    energy = MeanAndError(3600.0 * 0.1 * saved, 3600.0 * 0.1)
    return LegCase(
        name, 0.05, (0.0, 0.0), (0.0, 0.0), cost(fixed), cost(adaptive), saving, energy, probability=probability
    )


def candidate(name, minutes, energy, value, on_time, speed=1.0):
    time = Statistic(60.0 * minutes, 30.0, 0.0, 0.0, 60.0 * (minutes + 2.0), 1.2, 1000)
    joules = Statistic(3600.0 * energy, 360.0, 0.0, 0.0, 0.0, 36.0, 1000)
    return CandidatePlan(name, speed, time, joules, wilson(on_time, 1000), value, 1.0)


PLAN = LegPlan(
    how_found="By hand.",
    speed_factor=0.8,
    planned_sigma=0.05,
    base_spread=0.0,
    left=np.array([100.0, 1000.0]),
    leg=np.array([90.0, 600.0]),
    expected_cost=0.1,
    least_cost=0.09,
    expected_surfacings=3.0,
    fixed_d_max=400.0,
    fixed_cost=0.15,
    one_leg_cost=0.3,
    provenance=Provenance("plan-legs", "Bay", "bay.yaml", 1, 1000, elapsed_s=0.1),
    phase="out",
    phase_index=0,
    aim="mean",
    deadline=np.inf,
    distance=1000.0,
    mission_speed=1.25,
    arrival_radius=20.0,
    required_arrival=0.99,
    surfacing_time=60.0,
    sigma=0.05,
    goal=(1000.0, 0.0),
    cases=(case("", 0.15, 0.1, 50.0), case("σ_v twice as large", 0.3, 0.25, 40.0)),
    candidates=(
        candidate("fixed", 10.5, 11.0, 625.0, 620),
        candidate("fixed for the mean", 9.0, 14.0, 640.0, 600, 1.25),
        candidate("table", 9.5, 10.0, 540.0, 540),
    ),
    fixed_tracks=np.empty((2, 0, 0)),
    adaptive_tracks=np.empty((2, 0, 0)),
)


def plain(cells):
    return [str(cell).replace("\u00a0", " ").replace("\u202f", " ") for cell in cells]


@pytest.fixture(autouse=True)
def undrawn_here(monkeypatch):
    for drawn in ("tracks_figure", "cases_figure"):
        monkeypatch.setattr(plan_page, drawn, lambda plan: "")


def test_both_plans_stand_with_what_they_cost_in_the_trials_and_by_the_equation():
    table = plan_page.trials_table(PLAN)
    assert [plain(row) for row in table.rows] == [
        ["fixed d_max 400 m", "15.00 ± 0.10", "15.000", "3.00", "99.5 % (98.8 to 99.8 %)"],
        ["table of legs", "10.00 ± 0.10", "10.000", "3.00", "99.5 % (98.8 to 99.8 %)"],
    ]
    assert "no legs cost less than 9" in table.caption


@pytest.mark.parametrize("plan", ["fixed", "adaptive"])
@pytest.mark.parametrize(("errors", "agree"), [(2.9, True), (3.1, False)])
def test_trials_agree_with_the_equation_within_three_errors_of_both_plans(plan, errors, agree):
    own = getattr(PLAN.cases[0], plan)
    off = replace(PLAN.cases[0], **{plan: replace(own, cost=own.cost - errors * own.standard_error)})
    headings = [section.heading for section in plan_page._sections(replace(PLAN, cases=(off,)))]
    assert ("Trials and integral equation agree" in headings) == agree


def test_the_cases_have_their_own_costs_and_savings_in_the_unit_of_the_aim():
    doubt = replace(PLAN, cases=(*PLAN.cases, case("compass bias", 0.2, 0.22, -10.0, probability=0.3)))
    assert [plain(row) for row in plan_page.cases_table(doubt).rows] == [
        ["as the mission", "15.00 ± 0.10", "10.00 ± 0.10", "50 ± 2"],
        ["σ_v twice as large", "30.00 ± 0.10", "25.00 ± 0.10", "40 ± 2"],
        ["compass bias (30 %)", "20.00 ± 0.10", "22.00 ± 0.10", "−10 ± 2"],
    ]
    assert [row[-1] for row in map(plain, plan_page.cases_table(replace(doubt, aim="energy")).rows)] == [
        "5.00 ± 0.10",
        "4.00 ± 0.10",
        "−1.00 ± 0.10",
    ]


def test_candidates_have_their_speeds_times_and_energies():
    energy = replace(PLAN, aim="energy")
    rows = [plain(row) for row in plan_page.candidates_table(energy).rows]
    assert [row[:3] for row in rows] == [
        ["fixed", "1", "10.50 ± 0.02"],
        ["fixed for the mean", "1.25", "9.00 ± 0.02"],
        ["table", "1", "9.50 ± 0.02"],
    ]
    assert [float(row[3]) for row in rows] == [12.5, 11.0, 11.5]
    assert [row[4] for row in rows] == ["11.000 ± 0.010", "14.000 ± 0.010", "10.000 ± 0.010"]
    late = plan_page.candidates_table(replace(PLAN, aim="p95"))
    assert [float(row[3]) for row in late.rows] == pytest.approx([625.0 / 60.0, 640.0 / 60.0, 9.0], abs=0.02)
    assert [plain(row)[-1] for row in plan_page.candidates_table(replace(PLAN, deadline=600.0)).rows] == [
        "62 ± 3 %",
        "60 ± 3 %",
        "54 ± 3 %",
    ]


def test_the_speed_of_least_energy_is_told_with_that_of_the_mission():
    said = plan_page._speed_in_words(replace(PLAN, aim="energy")).replace("\u00a0", " ").replace("\u202f", " ")
    assert said == (
        " Go at 1 m/s: with a fixed d_max that needs 11.000 ± 0.010 W h; at the mission's 1.25 m/s it needs "
        "14.000 ± 0.010 W h."
    )


def test_what_95_percent_keep_is_told_with_what_it_gains_on_the_fixed_length():
    said = plan_page._slow_transits_in_words(PLAN, "400 m").replace("\u00a0", " ")
    assert said == "95 % of the transits then take at most 9.0 min, 85 s less than with 400 m."
    late = plan_page._slow_transits_in_words(replace(PLAN, deadline=600.0), "400 m").replace("\u00a0", " ")
    assert late == "54 ± 3 % of the transits keep the deadline of 10.0 min; with 400 m, 62 ± 3 % do."


@pytest.mark.parametrize(("aim", "deadline", "best"), [("p95", np.inf, "table"), ("p95", 600.0, "fixed for the mean")])
def test_the_best_candidate_takes_least_or_keeps_the_deadline_most_often(aim, deadline, best):
    late = tuple(replace(each, late=MeanAndError(85.0, 5.0)) for each in PLAN.cases)
    plan = replace(PLAN, aim=aim, deadline=deadline, cases=late)
    assert plan_page._candidates_section(plan).heading.endswith(f": {best}")
    kept = replace(plan, cases=(replace(late[0], late=MeanAndError(5.0, 0.1)), *late[1:]))
    less = "no more than 1\u00a0% of the whole" if deadline > 600.0 else best
    assert plan_page._candidates_section(kept).heading.endswith(less)


def test_a_fixed_length_is_an_order_where_no_explanation_is_in_doubt():
    slight = replace(PLAN, cases=(case("", 0.15, 0.149, 8.0), PLAN.cases[1]))  # of 1150 s a hundredth is 11.5
    assert not slight.recommended
    assert plan_page.answer(slight).startswith("Take a fixed d_max of")
    explained = case("compass bias", 0.2, 0.15, 40.0, probability=0.3)
    assert plan_page.answer(replace(slight, cases=(*slight.cases, explained))).startswith("Nothing to choose yet")
    assert plan_page.answer(PLAN).startswith("Let the legs adapt: the transit then takes 50")
    lucky = [replace(one, fixed=replace(one.fixed, arrived=wilson(3, 3))) for one in slight.cases]
    assert plan_page.answer(replace(slight, cases=tuple(lucky))).startswith(
        "Nothing to choose yet: first run more trials; as the mission stands, a fixed d_max of"
    )
    assert plan_page.answer(replace(PLAN, cases=(*PLAN.cases, explained))).startswith("Let the legs adapt")


def test_the_terminal_has_the_knots_with_how_far_each_leg_ends_short():
    assert plan_page._cells(PLAN)[1] == [["100.0", "90.0", "10.0"], ["1000.0", "600.0", "400.0"]]
