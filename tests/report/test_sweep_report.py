"""What the report of a sweep recommends where not every trial arrives."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure

from missionplan.mission import load
from missionplan.montecarlo.statistics import wilson
from missionplan.report.render import terminal_view
from missionplan.results import Provenance
from missionplan.studies.leg_length import figures, sweep_page
from missionplan.studies.leg_length.sweep_dmax import sweep_dmax
from missionplan.studies.leg_length.sweep_page import page
from missionplan.studies.leg_length.sweep_result import ExplainedSweep, Sweep, SweepCurve, SweepPoint

pytestmark = pytest.mark.usefixtures("unassumed")

AGAINST_THE_CURRENT = """
name: Against the current
site:
  depth: 20 m
  current: [{{down_to: 20 m, speed: {{mean: 0.3 m/s, sd: 0.06 m/s}}, toward: 270 deg}}]
navigation: {{velocity_error: {{sigma: 0.02 m/s}}, surfacing_time: 60 s, max_legs: 40}}
phases:
  - transit: {{name: out, from: [0 m, 0 m], to: [2 km, 0 m], speed: 0.35 m/s, d_max: 1 km, arrival_radius: 60 m}}
sweep: {{d_max: [500 m, 1 km, 2 km]}}
monte_carlo: {{trials: 400, seed: 2}}
{more}
"""


def point(d_max, cost, arrived, trials=500):
    return SweepPoint(
        d_max=d_max,
        d_max_over_distance=d_max / 1000.0,
        cost=cost,
        standard_error=0.001,
        sd=0.02,
        surfacings=2.0,
        arrived=wilson(arrived, trials),
        cost_analytic=None,
        excess_error=0.001,
        as_good=False,
    )


def sweep(*points, required=0.99, best=0):
    curve = SweepCurve(0.05, points, best, points[-1], None, required, 1000.0)
    provenance = Provenance("sweep-dmax", "Bay", "bay.yaml", 1, 500, elapsed_s=0.1)
    return Sweep(provenance, "out", "monte-carlo", 1000.0, 1.0, 60.0, 20.0, (curve,))


@pytest.mark.parametrize(("trials", "is_order"), [(1, False), (3, False), (15, False), (16, True)])
def test_so_few_trials_that_all_may_have_arrived_by_chance_are_no_ground_for_an_order(trials, is_order):
    """Of 15 that all arrive the interval goes below 80 %."""
    lucky = replace(point(700.0, 0.20, 500), arrived=wilson(trials, trials))
    words = page(sweep(lucky, required=0.9)).answer
    assert words.startswith("Choose d_max") == is_order
    assert words.startswith("Nothing to choose yet: first run more trials; as the mission stands") != is_order


def test_the_cheapest_d_max_that_arrives_often_enough_is_recommended():
    found = sweep(point(400.0, 0.10, 496), point(700.0, 0.20, 500), point(1000.0, 0.30, 500), required=0.995)
    entry = found.summary()["sweep"][0]
    assert entry["best"]["d_max_m"] == 400.0
    assert (entry["recommended"]["d_max_m"], entry["recommended"]["reaches_required_arrival"]) == (700.0, True)
    assert page(found).answer.startswith("Choose d_max = 700\u00a0m")
    assert terminal_view(found).verdict == page(found).verdict == ""


def test_means_of_those_that_arrive_say_of_how_many():
    answer = page(sweep(point(400.0, 0.10, 497), point(1000.0, 0.30, 500))).answer
    assert "of the 99.4\u00a0% that arrive" in answer


def test_without_a_d_max_that_arrives_often_enough_failures_are_counted():
    found = sweep(point(400.0, 0.10, 370), point(700.0, 0.50, 380), point(1000.0, 0.70, 200))
    entry = found.summary()["sweep"][0]["recommended"]
    assert (entry["d_max_m"], entry["reaches_required_arrival"]) == (400.0, False)
    answer = page(found).answer
    assert "no d_max of this sweep arrives as often as 99\u00a0%" in answer
    assert "with a failure counted as 10 missions, 400\u00a0m is best: 74\u00a0% of the trials arrive" in answer
    assert "Choose" not in answer
    assert terminal_view(found).verdict == page(found).verdict == "bad"


@pytest.mark.parametrize(
    ("more", "required"), [("", 0.99), ("requirements: [{quantity: out.arrived, probability: 0.2}]", 0.2)]
)
def test_the_missions_requirement_on_arrival_is_the_one_that_counts(tmp_path, more, required):
    path = tmp_path / "against.yaml"
    path.write_text(AGAINST_THE_CURRENT.format(more=more), encoding="utf-8")
    curve = sweep_dmax(load(path)).curves[0]
    assert curve.required_arrival == required
    assert max(point.arrived.value for point in curve.points) < 0.99
    assert curve.reaches(curve.recommended) is (required == 0.2)


def plain(text):
    return text.replace("\u00a0", " ").replace("\u202f", " ")


def three_curves(**table):
    """Of three velocity errors, in no order; a tooth of 12 % stands at half of the distance."""
    curves = []
    for sigma in (0.08, 0.02, 0.05):
        points = [
            replace(
                point(50.0 * k, 0.1 + 0.001 * abs(k - 14) + sigma + 0.12 * (k == 10), 500),
                as_good=13 <= k <= 15,
                surfacings=float(k),
            )
            for k in range(6, 21)
        ]
        best = min(range(len(points)), key=lambda index: points[index].cost)
        curves.append(SweepCurve(sigma, tuple(points), best, points[-1], table.get("table"), 0.99, 1000.0))
    provenance = Provenance("sweep-dmax", "Bay", "bay.yaml", 1, 500, elapsed_s=0.1)
    return Sweep(provenance, "out", "monte-carlo", 1000.0, 1.0, 60.0, 20.0, tuple(curves))


def test_the_rows_of_each_velocity_error_and_what_it_saves():
    columns, rows = sweep_page._chosen_rows(three_curves())
    assert columns[0] == "σ_v (m/s)"
    assert [[plain(cell) for cell in row] for row in rows] == [
        ["0.08", "700 m", "0.700", "100 %", "18.00 ± 0.10", "18.60 ± 0.10", "0.10 ± 0.02"],
        ["0.02", "700 m", "0.700", "100 %", "12.00 ± 0.10", "12.60 ± 0.10", "0.10 ± 0.02"],
        ["0.05", "700 m", "0.700", "100 %", "15.00 ± 0.10", "15.60 ± 0.10", "0.10 ± 0.02"],
    ]
    answer = plain(page(three_curves()).answer)
    assert answer.startswith(
        "Choose d_max = 700 m for σ_v = 0.05 m/s: the transit then takes 19.2 min on average, 6 s less than in one leg."
    )
    told = {name: plain(value) for name, value in sweep_page.page(three_curves()).numbers}
    assert told["Recommended d_max"] == "700 m (0.7 of the distance)"
    assert told["Mean cost of those that arrive"] == "15.00 ± 0.10 %"
    assert plain(sweep_page._as_good_in_words(three_curves())).endswith(
        "0.650 to 0.750 for σ_v = 0.08 m/s; 0.650 to 0.750 for σ_v = 0.02 m/s; 0.650 to 0.750 for σ_v = 0.05 m/s."
    )
    *_, toothed, surfacings, numbers = page(three_curves()).sections
    assert (toothed.heading, toothed.blocks) == ("The cost jumps at each critical point", [sweep_page._WHY_TEETH])
    assert plain(surfacings.heading).endswith("surfaces 14.0 times on average")
    (table,) = numbers.blocks
    assert [plain(cell) for cell in table.rows[0]] == ["0.300", "300 m", "18.80 ± 0.10", "12.80 ± 0.10", "15.80 ± 0.10"]
    assert len(table.rows) == 15


@pytest.mark.parametrize(
    ("lengths", "arrived", "heading"),
    [
        ((700.0, 400.0, 550.0), 500, "lies between 0.40 and 0.70 of the distance, depending on the velocity error"),
        ((700.0, 700.0, 700.0), 500, "is 0.70 of the distance"),
        ((700.0, 400.0, 550.0), 400, None),
    ],
)
def test_the_heading_has_the_shortest_and_the_longest_of_the_choices(lengths, arrived, heading):
    curves = tuple(sweep(point(each, 0.1, arrived)).curves[0] for each in lengths)
    words = sweep_page._choice_heading(replace(sweep(point(700.0, 0.1, 500)), curves=curves))
    failing = "Where no d_max arrives as often as required, the best with failures counted is shown"
    assert words == (f"The recommended d_max {heading}" if heading else failing)


def test_a_single_leg_that_does_as_well_saves_nothing():
    assert "; one leg does as well." in plain(page(sweep(point(400.0, 0.2995, 500), point(1000.0, 0.30, 500))).answer)
    assert "; in one leg 80 % arrive." in plain(page(sweep(point(400.0, 0.10, 500), point(1000.0, 0.05, 400))).answer)


def test_the_mission_s_table_is_held_against_the_best_fixed_length():
    own = replace(point(0.0, 0.13, 500), excess_error=0.002)
    ((section),) = sweep_page._table_section(three_curves(table=own))
    assert [plain(cell) for cell in section.blocks[0].rows[2]] == [
        "0.05",
        "13.00 ± 0.10",
        "15.00 ± 0.10",
        "0.33 ± 0.03",
    ]
    assert sweep_page._table_section(three_curves()) == []


def test_a_tooth_is_a_jump_at_a_critical_point():
    found = three_curves()
    assert found.critical_points == pytest.approx((1.0, 1.0 / 2.0, 1.0 / 3.0))
    assert sweep_page.has_teeth(found.middle, (0.5,))
    assert not sweep_page.has_teeth(found.middle, (0.7, 1.0))
    short = replace(found.middle, points=found.middle.points[:11])
    assert not sweep_page.has_teeth(short, (0.5,)), "of few points none can be told"
    noisy = replace(found.middle, points=tuple(replace(each, standard_error=0.03) for each in found.middle.points))
    assert not sweep_page.has_teeth(noisy, (0.5,)), "it may be chance"


def test_the_least_reached_arrival_is_told():
    (section,) = sweep_page._arrival_section(
        sweep(point(400.0, 0.1, 480), point(700.0, 0.2, 465), point(1000.0, 0.3, 500))
    )
    assert plain(section.blocks[0]).startswith("At d_max = 700 m only 93 % of the trials arrive")
    almost = sweep(point(400.0, 0.1, 500), replace(point(700.0, 0.2, 499), arrived=wilson(99_999, 100_000)))
    assert "only 99.999 % of the trials arrive" in plain(sweep_page._arrival_section(almost)[0].blocks[0])
    assert sweep_page._arrival_section(sweep(point(400.0, 0.1, 500), point(1000.0, 0.3, 500))) == []


def test_under_an_explanation_the_choice_loses_or_keeps():
    curve = sweep(point(400.0, 0.10, 500), point(700.0, 0.108, 500), point(1000.0, 0.30, 500)).curves[0]
    for chosen, excess, keeps in (
        (curve.points[1], 1.108 / 1.1 - 1.0, True),
        (curve.points[2], 1.3 / 1.1 - 1.0, False),
    ):
        each = ExplainedSweep(("compass-bias",), 0.3, curve, chosen)
        assert each.excess == pytest.approx(excess)
        assert each.keeps_choice == keeps
    seldom = ExplainedSweep((), 0.3, curve, replace(curve.points[0], arrived=wilson(400, 500)))
    assert not seldom.keeps_choice
    never = replace(curve, points=tuple(replace(each, arrived=wilson(400, 500)) for each in curve.points))
    assert ExplainedSweep((), 0.3, never, never.points[0]).keeps_choice  # none arrives as often as required
    found = replace(three_curves(), explanations=(ExplainedSweep(("compass-bias",), 0.3, curve, curve.points[2]),))
    (section,) = sweep_page._explanation_section(found)
    assert [plain(cell) for cell in section.blocks[0].rows[0]] == ["compass bias", "30.0 %", "400 m", "100 %", "18.2 %"]
    assert "But with compass bias it is 400 m, and the other takes 18 % longer then" in plain(page(found).answer)
    assert plain(page(found).answer).startswith("Nothing to choose yet: as the mission stands, d_max = 700 m is best")


def test_curves_of_a_sweep_go_through_their_points_and_the_slider_tells_each():
    own = replace(point(0.0, 0.13, 500), excess_error=0.002)
    found = three_curves(table=own)
    axes, below = Figure().add_subplot(), Figure().add_subplot()
    figures.draw_costs(axes, found)
    figures.draw_surfacings(below, found)
    lines = axes.get_lines()
    dots, rings = ([line for line in lines if line.get_marker() == marker] for marker in ".o")
    level = [line.get_ydata()[0] for line in lines if line.get_linestyle() == "--" and len(set(line.get_ydata())) == 1]
    assert level == pytest.approx([13.0] * 3)
    for number, sigma in enumerate((0.08, 0.02, 0.05)):
        costs = [100.0 * (0.1 + 0.001 * abs(k - 14) + sigma + 0.12 * (k == 10)) for k in range(6, 21)]
        assert dots[number].get_xdata() == pytest.approx([0.05 * k for k in range(6, 21)])
        assert dots[number].get_ydata() == pytest.approx(costs)
        assert np.ravel(rings[number].get_data()) == pytest.approx([0.7, min(costs)])
        band = axes.collections[number].get_paths()[0].vertices[:, 1]
        assert (band.min(), band.max()) == pytest.approx((min(costs) - 0.196, max(costs) + 0.196))
        assert below.get_lines()[number].get_ydata() == pytest.approx(range(6, 21))
    slider = figures._along_d_max(found)
    assert (slider.places[slider.start], slider.places[0]) == pytest.approx((0.7, 0.3))
    assert plain(slider.texts[0]).startswith(
        "300 m. σ_v 0.08 m/s: cost 18.80 %, 100 % arrive, 6.0 surfacings; σ_v 0.02"
    )
