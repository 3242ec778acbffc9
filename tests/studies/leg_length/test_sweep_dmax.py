import functools
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from missionplan.errors import InputError
from missionplan.mission import Mission, load
from missionplan.report.render import terminal_view
from missionplan.results.decision import Assumption
from missionplan.scenario.scenario import Scenario
from missionplan.studies import judgement
from missionplan.studies.judgement import FRESH
from missionplan.studies.leg_length import MAX_PAIRED, CellTotals, SweepScenario, _totals
from missionplan.studies.leg_length.paired_trials import LegsAtSpeed, run_plans
from missionplan.studies.leg_length.plan_legs import plan_legs
from missionplan.studies.leg_length.sweep_dmax import sweep_dmax
from missionplan.studies.simulation.simulate import simulate_block

pytestmark = pytest.mark.usefixtures("unassumed", "unplanned", "unranked", "unheld")

FIG8 = Path(__file__).parents[3] / "missions" / "fig8.yaml"
SMALL = """
name: small
navigation:
  velocity_error: {error}
  surfacing_time: 60 s
  {more}
phases:
  - transit: {{name: out, from: [0 m, 0 m], to: [{to}, 0 m], speed: 1 m/s, d_max: 500 m, arrival_radius: 20 m}}
sweep: {sweep}
monte_carlo: {{trials: 6000, seed: 3}}
{rest}
"""
TABLE = {  # notes on the paper: independent high-precision values, sigma 0.015, 0.035, 0.055 m/s
    1.00: (0.02736, 0.04973, 0.07200),
    0.92: (0.01595, 0.02036, 0.03271),
    0.90: (0.01578, 0.02045, 0.03233),
    0.47: (0.03067, 0.03223, 0.03779),
    0.45: (0.03056, 0.03297, 0.04066),
    0.30: (0.04565, 0.04757, 0.05445),
}


@pytest.fixture
def small(tmp_path):
    return functools.partial(small_in, tmp_path)


def small_in(
    folder, error="{sigma: 0.05 m/s}", more="", to="1000 m", rest="", sweep="{d_max: [200 m, 450 m, 900 m, 1000 m]}"
):
    path = folder / "small.yaml"
    path.write_text(SMALL.format(error=error, more=more, to=to, rest=rest, sweep=sweep))
    return load(path)


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    return stripped(sweep_dmax(small_in(tmp_path_factory.mktemp("plain"))))


@functools.cache
def fig8(**options):
    return sweep_dmax(load(FIG8), **options)


@pytest.mark.parametrize(("times", "lengths"), [(0.5, 1.0), (1.0, 3.0), (2.0, 0.7)])
def test_costs_do_not_change_with_the_units_of_time_and_length(times, lengths):
    """A mission all of whose times and lengths are so many times as large costs the same shares of its time."""

    def mission(time, length):
        speed = length / time
        way = {"name": "out", "from": ["0 m", "0 m"], "to": [f"{1000 * length} m", f"{400 * length} m"], "depth": "1 m"}
        sizes = {"speed": f"{speed} m/s", "d_max": f"{500 * length} m", "arrival_radius": f"{20 * length} m"}
        return Mission.from_data(
            {
                "site": {
                    "depth": "9 m",
                    "current": [{"down_to": "9 m", "speed": f"{0.1 * speed} m/s", "toward": "10 deg"}],
                },
                "navigation": {
                    "velocity_error": {"mean": [f"{0.01 * speed} m/s", "0 m/s"], "sigma": f"{0.05 * speed} m/s"},
                    "surfacing_time": {"mean": f"{60 * time} s", "sd": f"{5 * time} s"},
                    "fix_error": f"{4 * length} m",
                    "drift_compensation": "last-leg",
                },
                "phases": [{"transit": {**way, **sizes}}],
                "sweep": {"d_max": [f"{share * length} m" for share in (200, 450, 1000)]},
                "monte_carlo": {"trials": 100, "seed": 3},
            }
        )

    one, other = (
        sweep_dmax(each, method="monte-carlo").curves[0] for each in (mission(1.0, 1.0), mission(times, lengths))
    )
    for mine, theirs in zip(one.points, other.points, strict=True):
        assert theirs.d_max == pytest.approx(lengths * mine.d_max)
        assert (theirs.cost, theirs.sd, theirs.surfacings) == pytest.approx(
            (mine.cost, mine.sd, mine.surfacings), rel=1e-6
        )


@pytest.mark.parametrize("block", [0, 3])
def test_plans_are_sailed_on_the_trials_of_the_simulation_of_their_block(small, block):
    """All that is drawn of a trial, its errors and the mission's uncertain quantities, is as `simulate` draws it."""
    mission = small(more="fix_error: {mean: 5 m, sd: 2 m, low: 0 m}")
    mission = mission.with_({"navigation.surfacing_time": {"mean": "60 s", "sd": "9 s"}})
    plans = [LegsAtSpeed(500.0), LegsAtSpeed(300.0)]
    sailed, _ = run_plans(SweepScenario.of(mission, Scenario.at_means(mission)), plans, 3, block, 40)
    expected = simulate_block(mission, seed=3, block=block, trials=40).phases[0].quantities
    assert sailed.arrived.sum() > 30
    assert sailed.duration[sailed.arrived] == pytest.approx(expected["duration_s"][sailed.arrived])


def test_analytic_cost_is_the_table():
    for curve, column in zip(fig8(trials=8192).curves, zip(*TABLE.values(), strict=True), strict=True):
        found = {round(point.d_max_over_distance, 6): point.cost_analytic for point in curve.points}
        assert [found[ratio] for ratio in TABLE] == pytest.approx(column, abs=1e-4)


def test_monte_carlo_agrees_with_the_analytic_cost():
    sweep = fig8(trials=8192)
    points = [point for curve in sweep.curves for point in curve.points]
    scores = np.array([(point.cost - point.cost_analytic) / max(point.standard_error, 1e-7) for point in points])
    assert np.abs(scores).max() < 4.5
    assert {point.arrived.value for point in points} == {1.0}


@pytest.mark.slow
def test_monte_carlo_is_the_table():
    for curve, column in zip(fig8(trials=400_000).curves, zip(*TABLE.values(), strict=True), strict=True):
        found = {round(point.d_max_over_distance, 6): point.cost for point in curve.points}
        assert [found[ratio] for ratio in TABLE] == pytest.approx(column, abs=3e-4)


def test_the_papers_two_numbers():
    """5.0 % in one leg and 2.1 % at best for sigma = 0.035 m/s, with the fit of the notes."""
    data = load(FIG8).raw
    alone = Mission.from_data({**data, "sweep": {**data["sweep"], "sigma": ["0.035 m/s"]}})
    (curve,) = sweep_dmax(alone, method="analytic").curves
    assert curve.one_leg.cost == pytest.approx(0.0497, abs=0.0005)
    assert curve.best.cost == pytest.approx(0.0203, abs=0.0005)
    assert curve.best.d_max_over_distance == pytest.approx(0.915, abs=0.025)


def test_cost_is_lower_just_below_each_critical_point():
    sweep = fig8(trials=8192)
    for curve in sweep.curves[1:]:  # below, sigma/U is so small that r_x hides the effect from a = 2 on
        costs = {round(point.d_max_over_distance, 2): point.cost_analytic for point in curve.points}
        for below, above in ((0.96, 1.0), (0.48, 0.51), (0.32, 0.34)):
            assert costs[below] < costs[above]
    assert sweep.critical_points[:4] == pytest.approx((1.0, 1 / 2, 1 / 3, 1 / 4))


def test_what_is_as_good_as_the_best_shrinks_with_more_trials():
    few, many = fig8(trials=200, method="monte-carlo").curves[1], fig8(trials=8192).curves[1]
    for curve in (few, many):
        assert curve.best in curve.as_good
        assert curve.best.excess_error == 0.0
    assert len(many.as_good) < len(few.as_good)
    analytic_best = min(many.points, key=lambda point: point.cost_analytic)
    assert any(point.d_max == analytic_best.d_max for point in many.as_good)


def test_paired_errors_are_those_of_the_differences():
    rng = np.random.default_rng(5)
    common = rng.normal(size=20_000)
    costs = np.stack([0.03 + 0.01 * common, 0.031 + 0.01 * common + 0.001 * rng.normal(size=20_000)])
    blocks = [_totals(part, part, np.array([0.02, 0.02])) for part in np.split(costs, 5, axis=1)]
    totals = functools.reduce(CellTotals.merge, blocks)
    theory = np.std(costs[1] - costs[0], ddof=1) / math.sqrt(20_000)
    assert totals.difference_error(0)[1] == pytest.approx(theory, rel=0.08)
    assert totals.difference_error(0)[0] == 0.0
    assert totals.difference_error(0)[1] < 0.2 * totals.cost.standard_error[1]


def test_trials_that_did_not_arrive_are_never_dropped_silently():
    costs = np.tile(np.linspace(0.0, 1.0, 256), (2, 1))
    costs[1, ::4] = math.nan
    totals = _totals(costs, costs, np.zeros(2))
    assert totals.arrived.tolist() == [1.0, 0.75]
    assert totals.best() == 0
    assert not totals.as_good_as(0)[1]
    assert totals.difference_error(0)[1] > totals.cost.standard_error[0]


def test_a_grid_too_fine_to_be_paired_has_unpaired_errors():
    costs = np.tile(np.linspace(0.0, 1.0, 64), (MAX_PAIRED + 1, 1))
    totals = _totals(costs, costs, np.zeros(MAX_PAIRED + 1))
    assert totals.products.size == 0
    assert totals.difference_error(3)[0] == pytest.approx(math.sqrt(2.0) * totals.cost.standard_error[0])


def stripped(sweep):
    return replace(sweep, provenance=None, judged=sweep.judged.total.events)


@pytest.mark.parametrize(
    "options",
    [{"jobs": 2}, pytest.param({"jobs": 4}, marks=pytest.mark.slow), {"jobs": 2, "backend": "threading"}],
    ids=["2 processes", "4 processes", "2 threads"],
)
def test_bits_do_not_depend_on_jobs_or_backend(small, plain, options):
    assert stripped(sweep_dmax(small(), **options)) == plain


def test_a_seed_is_a_sample_and_more_trials_contain_fewer(small, plain):
    mission = small()
    assert stripped(sweep_dmax(mission, seed=4)) != plain
    assert stripped(sweep_dmax(mission, seed=3, trials=6000)) == plain


def test_every_sigma_has_the_same_normals(small):
    """At the same seed a sigma costs the same whatever other sigmas and lengths are swept beside it."""
    one = sweep_dmax(small(sweep="{d_max: [450 m], sigma: [0.05 m/s]}")).curves[0].points[0]
    many = sweep_dmax(small(sweep="{d_max: [300 m, 450 m], sigma: [0.01 m/s, 0.05 m/s]}")).curves[1].points[1]
    assert (one.cost, one.standard_error) == (many.cost, many.standard_error)


def test_without_error_every_cost_is_closed_form(small):
    curve = sweep_dmax(small(error="{sigma: 0 m/s}")).curves[0]
    legs = np.array([5, 3, 2, 1])
    assert [point.cost for point in curve.points] == pytest.approx(60.0 * (legs - 1) / 1000.0, abs=1e-12)
    assert [point.surfacings for point in curve.points] == legs.tolist()
    assert curve.best.d_max == 1000.0


def test_the_analytic_form_is_refused_where_it_does_not_hold(small):
    current = "site: {current: [{down_to: 9 m, speed: 0.1 m/s, toward: 0 deg}]}"
    for changes, words in (
        ({"more": "drift_compensation: mean"}, "drift compensation"),
        ({"more": "fix_error: 3 m"}, "a fix error"),
        ({"error": "{covariance: [[0.01 m^2/s^2, 0 m^2/s^2], [0 m^2/s^2, 0.02 m^2/s^2]]}"}, "isotropic"),
        ({"error": "{mean: [0.1 m/s, 0 m/s], sigma: 0.05 m/s}"}, "mean is not zero"),
        ({"error": "{sigma: {mean: 0.05 m/s, sd: 0.01 m/s}}"}, "uncertain"),
        ({"error": "{sigma: 0.8 m/s}"}, "0.7 of the speed"),
        ({"rest": current}, "a current"),
        ({"rest": "effects: [{mean-current: {east: 0.1 m/s, north: 0 m/s}}]"}, "effects"),
    ):
        with pytest.raises(InputError, match=words):
            sweep_dmax(small(**changes), method="analytic")
        if "0.8" not in words:
            assert sweep_dmax(small(**changes), trials=64).curves[0].points[0].cost_analytic is None


def test_a_drift_as_fast_as_the_vehicle_is_refused(small):
    with pytest.raises(InputError, match=r"the mean drift, 1\.1 m/s, reaches the vehicle's speed, 1 m/s"):
        sweep_dmax(small(error="{mean: [-1.1 m/s, 0 m/s], sigma: 0 m/s}"))


def test_a_transit_without_length_is_refused(small):
    with pytest.raises(InputError, match="within the arrival radius"):
        sweep_dmax(small(to="0 m"))


def test_a_mission_without_transit_is_refused(tmp_path):
    path = tmp_path / "none.yaml"
    path.write_text("name: none\nnavigation: {velocity_error: {sigma: 0.1 m/s}, surfacing_time: 60 s}\n")
    with pytest.raises(InputError, match="no transit"):
        sweep_dmax(load(path))


def test_runs_that_never_arrive_are_reported_as_a_fraction(small):
    sweep = sweep_dmax(small(more="drift_compensation: as-printed"), trials=500)
    one_leg = sweep.curves[0].one_leg
    assert 0.0 < one_leg.arrived.value < 1.0
    assert one_leg.arrived.low < one_leg.arrived.value < one_leg.arrived.high


def test_where_no_trial_arrives_there_is_no_cost(small):
    sweep = sweep_dmax(small(more="max_legs: 1", sweep="{d_max: [100 m, 200 m]}"), trials=64, method="monte-carlo")
    assert all(math.isnan(point.cost) and point.arrived.value == 0.0 for point in sweep.curves[0].points)
    assert sweep.summary()["sweep"][0]["curve"][0]["arrived"]["value"] == 0.0


def test_summary_and_table_have_the_contracts_keys(small):
    sweep = sweep_dmax(small(), trials=512)
    (curve,) = sweep.summary()["sweep"]
    assert curve["sigma_m_s"] == pytest.approx(0.05)
    point = {"d_max_m", "d_max_over_distance", "cost", "standard_error"}
    assert point | {"surfacings", "cost_analytic"} <= set(curve["curve"][0])
    assert set(curve["best"]) == point
    assert {"cost", "standard_error"} <= set(curve["one_leg"])
    frame = sweep.to_frame()
    assert len(frame) == 4
    assert {"sigma_m_s", "d_max_m", "cost", "cost_analytic", "as_good_as_best"} <= set(frame)
    assert sweep.files()["sweep.csv"].startswith("sigma_m_s,d_max_m,")
    assert sweep.curves[0].best_saves == pytest.approx(
        1000.0 * (sweep.curves[0].one_leg.cost - sweep.curves[0].best.cost)
    )


def test_a_d_max_at_which_fewer_arrive_is_not_the_best_however_cheap():
    costs = np.stack([np.full(256, 0.5), np.full(256, 0.1)])
    costs[1, ::4] = math.nan
    assert _totals(costs, costs, np.zeros(2)).best() == 0


def test_a_difference_from_what_never_always_arrives_is_unpaired():
    """Costs that are equal where both arrive differ by nothing in pairs; their errors add up as of independent runs."""
    costs = np.tile(np.linspace(0.0, 1.0, 256), (2, 1))
    costs[1, ::4] = math.nan
    totals = _totals(costs, costs, np.zeros(2))
    assert totals.difference_error(0)[1] == pytest.approx(math.hypot(*totals.cost.standard_error))


@pytest.mark.parametrize(("errors", "as_good"), [(1.5, True), (1.9, True), (2.1, False)])
def test_as_good_is_within_two_standard_errors(errors, as_good):
    noise = np.random.default_rng(6).normal(size=512)
    noise -= noise.mean()
    dearer = errors * np.std(noise.reshape(32, 16).mean(axis=1), ddof=1) / math.sqrt(32)
    costs = np.stack([np.full(512, 0.5), 0.5 + dearer + noise])
    assert _totals(costs, costs, np.zeros(2)).as_good_as(0)[1] == as_good


@pytest.mark.parametrize("study", [sweep_dmax, plan_legs])
def test_a_transit_that_the_battery_cannot_pay_is_refused(study):
    """Drag power and hotel over 1600 m at 1.5 m/s and the current."""
    data = dict(load(FIG8.with_name("chesapeake.yaml")).raw)
    vehicle = {**data["vehicle"], "energy": {**data["vehicle"]["energy"], "capacity": "1 W*h"}}
    with pytest.raises(InputError, match=r"the straight course alone takes [5-9]\.\d+ W h, the battery holds 1 W h"):
        study(Mission.from_data({**data, "vehicle": vehicle, "requirements": []}), trials=10)


@pytest.mark.parametrize(
    ("spoils", "lead"), [("out", "Nothing to choose yet: first wait; as"), ("moor", "Choose d_max")]
)
def test_a_choice_that_an_assumption_could_turn_is_no_order_where_nothing_is_required(small, monkeypatch, spoils, lead):
    swell = Assumption("it is calm", "a swell", -0.4, 0.6, spoils=spoils, first="wait")
    monkeypatch.setattr(judgement, "ledger", lambda *_: (swell,))
    found = terminal_view(sweep_dmax(small(), trials=64)).sentence
    assert found.startswith(lead)
    assert found.endswith("But this assumes that it is calm: with a swell it succeeds 60\u00a0% of the time.")


@pytest.mark.usefixtures("unsought")
@pytest.mark.parametrize(
    ("study", "hours", "met"),
    [
        (sweep_dmax, "100 h", True),
        (plan_legs, "1 s", False),
        (sweep_dmax, "1 s", False),
        (plan_legs, "100 h", True),
    ],
)
def test_what_is_recommended_is_held_to_the_whole_mission_on_fresh_draws(small, study, hours, met):
    requirement = f"requirements: [{{quantity: total.duration, at_most: {hours}, probability: 0.9}}]"
    found = study(small(rest=requirement), trials=64)
    assert found.judged.requirements_met is met
    assert found.judged.provenance.seed == found.provenance.seed + FRESH
    assert found.summary()["judged"]["requirements"][0]["met"] is met
