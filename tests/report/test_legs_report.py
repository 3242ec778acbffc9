"""The report of a plan of legs: what a mission file takes over, and what is left out where nothing adapts."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.montecarlo.statistics import Statistic, wilson
from missionplan.report.page import Figure, Listing, Table, draw, drawing_by
from missionplan.report.render import terminal_view
from missionplan.studies.leg_length import figures
from missionplan.studies.leg_length.plan_page import answer, page
from missionplan.studies.leg_length.plan_result import CandidatePlan, MeanAndError


@pytest.fixture(scope="module")
def adaptive(planned):
    return planned.result


@pytest.fixture(scope="module")
def fixed(adaptive):
    own, knot = np.array([693.25]), np.array([20.0])
    return replace(adaptive, left=knot, leg=own, fixed_d_max=693.25, speed_factor=0.845, mission_speed=1.0)


def blocks(plan, kind):
    return [block for section in page(plan).sections for block in section.blocks if isinstance(block, kind)]


def test_a_table_is_given_a_knot_a_line(adaptive):
    (listing,) = blocks(adaptive, Listing)
    assert listing.text.splitlines()[:2] == ["d_max:", "  table:"]
    assert len(listing.text.splitlines()) == 2 + adaptive.left.size


def test_a_fixed_d_max_is_given_as_a_length_with_the_speed_chosen(fixed):
    assert fixed.changes == {"speed": "0.845 m/s", "d_max": "693.2 m"}
    assert not blocks(fixed, Listing)  # it stands among what changes in the mission
    transit = fixed.mission_with_legs()["phases"][0]["transit"]
    assert (transit["speed"], transit["d_max"]) == ("0.845 m/s", "693.2 m")


def test_two_plans_are_set_beside_each_other_only_where_there_are_two(adaptive, fixed):
    assert [figure.name for figure in blocks(adaptive, Figure)] == ["tracks", "robustness"]
    assert [figure.name for figure in blocks(fixed, Figure)] == ["tracks"]
    assert {len(table.columns) for table in blocks(fixed, Table)} == {2, 5}
    assert all("able" not in head for table in blocks(fixed, Table) for head in table.columns)


def test_a_table_that_is_not_worth_it_is_not_shown_but_what_it_would_bring_is(adaptive):
    own, *others = adaptive.cases
    small = replace(adaptive, cases=(replace(own, saved=MeanAndError(10.0, 1.0)), *others))
    assert answer(small).startswith("Take a fixed d_max of ")
    assert (
        answer(small)
        .replace("\u00a0", " ")
        .endswith(": a table of legs would save 10.0 ± 1.0 s on average, no more than 1 % of the whole.")
    )
    losing = replace(
        adaptive,
        cases=(own, *others[:-1], replace(others[-1], saved=MeanAndError(-5.0, others[-1].saved.standard_error))),
    )
    assert answer(losing).endswith(f"but save nothing or lose with {others[-1].name}.")
    for plan in (small, losing):
        assert plan.changes == {"d_max": f"{adaptive.fixed_d_max:.1f} m"}
        assert terminal_view(plan).columns[0] == "Errors"
        assert all("knots" not in figure.caption for figure in [page(plan).figure, *blocks(plan, Figure)])
    with drawing_by(draw):
        assert "stops short" not in page(losing).figure.svg  # a fixed d_max aims at the target itself


def test_legs_that_arrive_less_often_than_required_are_said_to_in_red(adaptive):
    own, *others = adaptive.cases
    rare = wilson(1520, 2000)
    own = replace(own, fixed=replace(own.fixed, arrived=rare), adaptive=replace(own.adaptive, arrived=rare))
    plan = replace(adaptive, cases=(own, *others))
    assert answer(plan).startswith(
        "No legs arrive as often as 99\u00a0%; with a failure counted as 10 missions, the table"
    )
    assert "in 76.0\u00a0% of the trials" in answer(plan)
    assert page(plan).verdict == terminal_view(plan).verdict == "bad"


def test_legs_that_never_arrive_change_nothing_in_the_mission(adaptive):
    own, *others = adaptive.cases
    lost = {"arrived": wilson(0, 2000), "cost": np.nan, "standard_error": np.nan, "surfacings": np.nan}
    own = replace(own, fixed=replace(own.fixed, **lost), adaptive=replace(own.adaptive, **lost))
    plan = replace(adaptive, cases=(own, *others))
    assert answer(plan) == "No legs arrive of all that were tried."
    assert plan.recommended_values == {}
    assert not any("–" in section.heading for section in page(plan).sections)


@pytest.mark.parametrize("d_max", [800.0, 3162.3, 1e9])
def test_figures_are_drawn_where_every_leg_aims_at_the_target(adaptive, d_max):
    flat = replace(adaptive, fixed_d_max=d_max, left=np.array([20.0]), leg=np.array([d_max]))
    long = replace(adaptive, fixed_d_max=d_max, left=np.array([20.0, 3000.0]), leg=np.array([30.0, 4000.0]))
    with drawing_by(draw):
        assert [page(each).figure.name for each in (flat, long)] == ["policy"] * 2


def test_an_aim_of_energy_is_judged_by_energy(adaptive):
    case = replace(adaptive.cases[0], saved_energy=MeanAndError(7200.0, 360.0))  # J of 36 kJ
    energy = Statistic(36e3, 3600.0, 30e3, 36e3, 42e3, 36.0, 400)
    rival = CandidatePlan("rival", 1.0, Statistic.of_constant(3600.0, 400), energy, wilson(400, 400), 36e3, 36.0)
    plan = replace(adaptive, aim="energy", cases=(case,), candidates=(rival,) * 4)
    assert plan.recommended
    (table,) = (table for table in blocks(plan, Table) if table.columns[0] == "Errors")
    assert table.columns[-1] == "Energy saved (W\u202fh)"
    assert table.rows[0][-1] == "2.00\u00a0±\u00a00.10"
    unsure = replace(case, saved_energy=MeanAndError(1000.0, 360.0))  # less than three errors
    assert not replace(plan, cases=(unsure,)).recommended
    sure = replace(case, saved_energy=MeanAndError(350.0, 10.0))
    assert not replace(plan, cases=(sure,)).recommended  # less than 1 %


def drawn(draw_it, *given):
    axes = MatplotlibFigure().add_subplot()
    draw_it(axes, *given)
    return axes, [np.array(line.get_data(), dtype=float) for line in axes.get_lines()]


def test_a_table_is_drawn_by_the_lengths_and_the_aims_of_its_legs(adaptive):
    """Knots at 20, 1000 and 3000 m: of 500 m left a leg has 250 m; a fixed one of 800 m goes to the target from there."""
    plan = replace(
        adaptive, left=np.array([20.0, 1000.0, 3000.0]), leg=np.array([20.0, 500.0, 900.0]), fixed_d_max=800.0
    )
    _, (fixed, table, knots) = drawn(figures.draw_lengths, plan)
    assert knots == pytest.approx(np.array([[1.0, 3.0], [0.5, 0.9]]))
    assert np.interp([0.51, 2.0], *table) == pytest.approx([0.26, 0.7], abs=1e-3)
    assert np.interp([0.5, 2.0], *fixed) == pytest.approx([0.5, 0.8], abs=2e-3)
    _, (fixed, table, radius) = drawn(figures.draw_aims, plan)
    assert np.interp([510.0, 2000.0], *table) == pytest.approx([250.0, 1300.0], rel=2e-3)
    assert np.isnan(fixed[1, fixed[0] < 800.0]).all()
    assert np.interp(2000.0, *fixed) == pytest.approx(1200.0, rel=2e-3)
    assert set(radius[1]) == {20.0}


def test_tracks_are_turned_along_the_course_with_port_upward(adaptive):
    """To the east of north by 90°: what lies 30 m north of a course to the east lies to port."""
    tracks = np.array([[[100.0], [1100.0], [2100.0], [np.nan]], [[50.0], [80.0], [50.0], [np.nan]]])
    plan = replace(adaptive, goal=(2100.0, 50.0), arrival_radius=20.0, fixed_tracks=tracks)
    _, (circle, way) = drawn(figures._draw_tracks, plan, tracks)
    assert way == pytest.approx(np.array([[0.0, 1.0, 2.0], [0.0, 30.0, 0.0]]))
    assert (circle[0].min(), circle[0].max(), circle[1].max()) == pytest.approx((1.98, 2.02, 20.0))


def test_savings_are_drawn_case_under_case_with_95_percent_intervals(adaptive):
    names, saved = ("", "more error", "a current"), (50.0, -20.0, 10.0)
    cases = [
        replace(adaptive.cases[0], name=name, saved=MeanAndError(mean, 5.0))
        for name, mean in zip(names, saved, strict=True)
    ]
    axes, ((at, place), *_) = drawn(figures.draw_savings, replace(adaptive, cases=tuple(cases)))
    labels = dict(zip(axes.get_yticks(), [label.get_text() for label in axes.get_yticklabels()], strict=True))
    assert [(labels[y], x) for x, y in zip(at, place, strict=True)] == [
        ("as the mission", 50.0),
        *zip(names[1:], saved[1:], strict=True),
    ]
    assert place.tolist() == sorted(place, reverse=True)
    (bars,) = axes.collections[:1]
    assert [np.ptp(segment[:, 0]) for segment in bars.get_segments()] == pytest.approx([2.0 * 1.96 * 5.0] * 3)
