"""Legs planned for a mission: the table, its trials beside the best fixed d_max, and the mission that it gives."""

from dataclasses import fields, replace
from types import SimpleNamespace

import numpy as np
import pytest
import yaml

from missionplan.errors import InputError
from missionplan.mission import load
from missionplan.montecarlo.statistics import RunningStatistic, wilson
from missionplan.phases.place import Place
from missionplan.phases.transit.compensation import Compensation
from missionplan.phases.transit.plan import LegTable
from missionplan.studies.leg_length import SweepScenario, analytic_transit, optimise_legs, paired_trials
from missionplan.studies.leg_length.analytic_transit import (
    AnalyticTransit,
    LegSpread,
    PolicyFamily,
    _RecordingCompensation,
    fit_leg_spread,
)
from missionplan.studies.leg_length.optimise_legs import LegAim, _family_of
from missionplan.studies.leg_length.paired_trials import LegsAtSpeed, best_plan, expected_cost, run_plans
from missionplan.studies.leg_length.plan_legs import _deadline, _late, _quantile, plan_legs
from missionplan.studies.leg_length.plan_result import MeanAndError
from missionplan.studies.leg_length.sweep_dmax import sweep_dmax

pytestmark = pytest.mark.usefixtures("unassumed", "unplanned", "unranked", "unheld")

MISSION = """
name: Legs
navigation:
  velocity_error: {sigma: 0.05 m/s}
  surfacing_time: 90 s
phases:
  - transit: {name: in, from: [0 m, 0 m], to: [3 km, 1 km], speed: 1 m/s, d_max: 1 km, arrival_radius: 50 m}
monte_carlo: {trials: 8000, seed: 5}
"""
ERRATIC = """
name: Large errors, a small circle
navigation: {velocity_error: {sigma: 0.15 m/s}, surfacing_time: 90 s}
phases:
  - transit: {name: in, from: [0 m, 0 m], to: [3 km, 1 km], speed: 1 m/s, d_max: 1 km, arrival_radius: 20 m}
monte_carlo: {trials: 4000, seed: 5}
"""


@pytest.fixture(scope="module")
def mission(tmp_path_factory):
    path = tmp_path_factory.mktemp("legs") / "legs.yaml"
    path.write_text(MISSION, encoding="utf-8")
    return load(path)


@pytest.fixture(scope="module")
def erratic(tmp_path_factory):
    """A mission whose table of legs saves about 3 % (by the integral equation), and more with larger errors."""
    path = tmp_path_factory.mktemp("legs") / "erratic.yaml"
    path.write_text(ERRATIC, encoding="utf-8")
    return load(path)


@pytest.fixture(scope="module")
def adaptive(erratic):
    return plan_legs(erratic, trials=4000)


def test_monte_carlo_agrees_with_the_integral_equation(adaptive):
    case = adaptive.cases[0]
    assert case.adaptive.cost == pytest.approx(adaptive.expected_cost, abs=3 * case.adaptive.standard_error)
    assert case.fixed.cost == pytest.approx(adaptive.fixed_cost, abs=3 * case.fixed.standard_error)
    assert case.saved.mean == pytest.approx(adaptive.saving, abs=3 * case.saved.standard_error)
    assert case.adaptive.arrived.value == 1.0


def test_legs_beat_the_best_fixed_d_max_which_beats_one_leg(adaptive):
    assert adaptive.least_cost <= adaptive.expected_cost < adaptive.fixed_cost < adaptive.one_leg_cost


def test_a_saving_of_less_than_a_hundredth_is_not_worth_a_table(adaptive):
    own, *others = adaptive.cases
    whole = adaptive.nominal_time * (1.0 + own.fixed.cost)
    found = {share: replace(own, saved=MeanAndError(share * whole, 0.001 * whole)) for share in (0.009, 0.011)}
    little, enough = (replace(adaptive, cases=(case, *others)) for case in found.values())
    assert enough.recommended
    assert not little.recommended
    assert little.d_max == f"{adaptive.fixed_d_max:.1f} m"
    assert list(little.to_frame()["leg_m"]) == [adaptive.fixed_d_max]


def test_a_saving_of_three_hundredths_is_worth_a_table(adaptive):
    whole = adaptive.nominal_time * (1.0 + adaptive.fixed_cost)
    assert adaptive.saving / whole == pytest.approx(0.0315, abs=0.001)
    assert adaptive.cases[0].saved.mean == pytest.approx(
        adaptive.saving, abs=3.0 * adaptive.cases[0].saved.standard_error
    )
    assert adaptive.recommended


def test_a_table_is_not_recommended_that_loses_under_a_doubt_or_arrives_less_often(adaptive):
    own, *others = adaptive.cases
    losing = replace(others[-1], saved=MeanAndError(-1.0, others[-1].saved.standard_error))
    assert not replace(adaptive, cases=(own, *others[:-1], losing)).recommended
    rarely = replace(own, adaptive=replace(own.adaptive, arrived=wilson(3900, 4000)))
    assert not replace(adaptive, cases=(rarely, *others)).recommended
    both = replace(rarely, fixed=replace(own.fixed, arrived=wilson(3900, 4000)))
    assert replace(adaptive, cases=(both, *others)).recommended  # neither arrives as often as required
    unsure = replace(own, saved=MeanAndError(own.saved.mean, own.saved.mean / 2.9))
    assert not replace(adaptive, cases=(unsure, *others)).recommended


def test_a_trial_that_arrives_by_chance_is_worth_no_dearer_plan():
    """97.7 % for 1.29 times the straight way's time, or 97.6 % for 1.10; a plan that arrives often enough goes first."""

    def cost(arriving, values):
        arrived = np.arange(1000) < arriving
        return expected_cost(SimpleNamespace(arrived=arrived), 0.99, np.full(1000, values))

    assert cost(976, 1.10) < cost(977, 1.29)
    assert cost(976, 1.10) == (1.0, pytest.approx(1.10 * 1.24))
    assert cost(990, 9.0) == (0.0, 9.0) < cost(976, 1.10)
    assert cost(0, 1.0) == (1.0, np.inf)


def test_the_time_that_95_percent_keep_counts_failures_alike():
    """97 % in 1.3 h is better than 97.1 % in 2 h where 99 % must arrive; in time for a deadline, arriving goes first."""
    times = np.linspace(0.9, 1.1, 1000)

    def score(arriving, scale, **deadline):
        _, lateness, _ = _family_of(LegAim("p95", **deadline), 0.99)
        return lateness(SimpleNamespace(arrived=np.arange(1000) < arriving, duration=scale * times))

    assert score(970, 1.3) < score(971, 2.0)
    assert score(900, 1.3) < score(901, 2.0)
    assert score(1000, 1.0) == (0.0, pytest.approx(1.09, abs=1e-3))
    assert score(995, 9.0) < score(970, 1.0)
    assert score(995, 1.0, deadline=0.95) < score(970, 0.5, deadline=0.95)


@pytest.mark.usefixtures("unsought")
def test_where_none_arrives_as_often_as_required_failures_are_counted(tmp_path):
    path = tmp_path / "few-legs.yaml"
    few = "navigation: {max_legs: 3, "
    path.write_text(ERRATIC.replace("navigation: {", few), encoding="utf-8")
    mission = load(path)
    plan = plan_legs(mission, trials=4000)
    assert not plan.reaches
    curve = sweep_dmax(mission, trials=4000).curves[0]
    assert not curve.reaches(curve.recommended)
    arrived = plan.cases[0].fixed.arrived
    assert arrived.value == pytest.approx(curve.recommended.arrived.value, abs=0.03)
    assert arrived.value > curve.best.arrived.value - 0.03
    assert plan.cases[0].fixed.arrived.value < 0.99


@pytest.mark.usefixtures("unsought")
def test_legs_arrive_as_often_as_the_mission_requires(tmp_path):
    path = tmp_path / "six-legs.yaml"
    required = "requirements: [{quantity: in.arrived, probability: 0.85}]\n"
    path.write_text(ERRATIC.replace("navigation: {", "navigation: {max_legs: 4, ") + required, encoding="utf-8")
    mission = load(path)
    plan, curve = plan_legs(mission, trials=4000), sweep_dmax(mission, trials=4000).curves[0]
    assert plan.required_arrival == curve.required_arrival == 0.85
    assert plan.cases[0].fixed.arrived.value == pytest.approx(curve.recommended.arrived.value, abs=0.03)


@pytest.mark.usefixtures("unsought")
def test_fixes_that_err_are_reported_and_progress_is_shown_while_legs_are_sought(tmp_path):
    path = tmp_path / "fixes.yaml"
    path.write_text(ERRATIC.replace("navigation: {", "navigation: {fix_error: 3 m, "), encoding="utf-8")
    calls = []
    found = plan_legs(load(path), trials=100, progress=lambda done, total: calls.append((done, total)))
    pilot = [(done, total) for done, total in calls if total > 10_000]
    assert len(pilot) > 100
    assert pilot == sorted(pilot)
    assert pilot[-1][0] == pilot[-1][1]
    assert any("fix error" in notice for notice in found.provenance.notices)


def test_robustness_covers_sigma_and_mean(adaptive):
    names = [case.name for case in adaptive.cases]
    assert names[0] == ""
    assert [case.sigma for case in adaptive.cases[1:3]] == pytest.approx([0.075, 0.3])
    course = np.array([3.0, 1.0]) / np.sqrt(10.0)
    for case, size in zip(adaptive.cases[3:], (0.075, 0.15), strict=True):
        assert np.hypot(*case.mean_error) == pytest.approx(size)
        assert np.dot(case.mean_error, course) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.usefixtures("unsought")
def test_robustness_varies_the_drift_that_the_mission_expects(tmp_path):
    path = tmp_path / "drift.yaml"
    site = "site: {depth: 20 m, current: [{down_to: 20 m, speed: 0.1 m/s, toward: 0 deg}]}\n"
    path.write_text(
        MISSION.replace("{sigma: 0.05 m/s}", "{mean: [0.03 m/s, 0 m/s], sigma: 0.05 m/s}") + site, encoding="utf-8"
    )
    half, double = plan_legs(load(path), trials=100).cases[3:]
    assert (half.name, double.name) == ("mean drift half as large", "mean drift twice as large")
    assert half.mean_error == pytest.approx((-0.015, -0.05))
    assert double.mean_error == pytest.approx((0.03, 0.1))
    assert half.surface_drift == pytest.approx((0.0, -0.05))
    assert double.surface_drift == pytest.approx((0.0, 0.1))


def test_the_mission_with_legs_loads_and_runs(adaptive, tmp_path):
    path = tmp_path / "mission.yaml"
    path.write_text(adaptive.files()["mission-with-legs.yaml"], encoding="utf-8")
    table = load(path).transits[0].d_max.table
    np.testing.assert_allclose(np.array(table), np.column_stack([adaptive.left, adaptive.leg]), atol=1e-6)
    assert yaml.safe_load(adaptive.files()["legs.yaml"])["d_max"] == adaptive.d_max


def test_same_numbers_for_any_jobs(erratic, adaptive):
    threaded = plan_legs(erratic, trials=4000, jobs=2, backend="threading")
    assert repr(threaded.cases) == repr(adaptive.cases)  # nan, where there is no energy budget, equals nothing


def test_tracks_start_together_and_end_near_the_target(adaptive):
    for tracks in (adaptive.fixed_tracks, adaptive.adaptive_tracks):
        np.testing.assert_array_equal(tracks[:, 0], 0.0)
        for track in np.moveaxis(tracks, -1, 0):
            last = track[:, ~np.isnan(track[0])][:, -1]
            assert np.hypot(*(last - [3000.0, 1000.0])) <= 20.0


def test_tables_and_summary(adaptive):
    frame = adaptive.to_frame()
    assert list(frame.columns) == ["distance_left_m", "leg_m", "aim_short_m"]
    summary = adaptive.summary()
    assert summary["adaptive"]["cost"] == adaptive.expected_cost
    assert summary["recommended"] == "adaptive"
    assert len(summary["cases"]) == 5


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("surfacing_time: 90 s", "surfacing_time: 0 s", "surfacing time"),
        ("sigma: 0.05 m/s", "sigma: 0.9 m/s", "too large"),
        ("arrival_radius: 50 m", "arrival_radius: 4 km", "within the arrival radius"),
    ],
)
def test_missions_that_cannot_be_planned(old, new, message, tmp_path):
    path = tmp_path / "bad.yaml"
    path.write_text(MISSION.replace(old, new), encoding="utf-8")
    with pytest.raises(InputError, match=message):
        plan_legs(load(path))


def test_screening_on_few_trials_finds_the_plan_of_least_cost(mission, monkeypatch):
    monkeypatch.setattr(paired_trials, "HALVING_RUNGS", ((256, 12), (1024, 4)))
    scenario = replace(SweepScenario.of(mission), sigmas=(None,))
    plans = [LegsAtSpeed(float(length)) for length in np.linspace(300.0, 3100.0, 40)]

    def cost(run):
        return 0.0, float(run.cost.mean())

    screened = best_plan(scenario, plans, cost, seed=7)
    monkeypatch.setattr(paired_trials, "HALVING_RUNGS", ())
    assert screened == best_plan(scenario, plans, cost, seed=7)


MEAN_COMPENSATION = """
name: Currents, fixes that err, a drift that is learnt
vehicle:
  hull: {length: 1 m, diameter: 0.12 m, form_factor: hoerner}
  mass: 10 kg
  net_buoyancy: 1 N
  energy: {hotel: 8 W, propulsive_efficiency: 0.45, capacity: 60 W*h}
site:
  depth: 20 m
  water: {density: 1025 kg/m^3, viscosity: 1.2e-6 m^2/s}
  current: [{down_to: 20 m, speed: {mean: 0.15 m/s, sd: 0.05 m/s}, toward: 40 deg}]
navigation:
  velocity_error: {sigma: 0.05 m/s}
  surfacing_time: 90 s
  fix_error: 3 m
  drift_compensation: mean
phases:
  - transit: {name: in, from: [0 m, 0 m], to: [2 km, 0 m], speed: 1 m/s, d_max: 1 km, arrival_radius: 25 m, depth: 2 m}
monte_carlo: {trials: 6000, seed: 5}
"""


@pytest.fixture(scope="module")
def learning(tmp_path_factory):
    path = tmp_path_factory.mktemp("legs") / "learning.yaml"
    path.write_text(MEAN_COMPENSATION, encoding="utf-8")
    return load(path)


EFFECTS = """
effects:
  - persistent-error: {sigma: {mean: 0.02 m/s, sd: 0.005 m/s}, time: 2 h}
  - compass-bias: {angle: {mean: 0 deg, sd: 3 deg}}
"""


@pytest.mark.parametrize(
    ("method", "effects"),
    [
        ("filter", ""),
        ("none", EFFECTS),
        *(pytest.param(each, "", marks=pytest.mark.slow) for each in ("mean", "none", "forecast")),
    ],
)
def test_plans_run_together_have_the_numbers_that_each_has_alone(method, effects, tmp_path, monkeypatch):
    path = tmp_path / "slow.yaml"
    text = MEAN_COMPENSATION.replace("compensation: mean", f"compensation: {method}")
    text = text.replace("speed: 1 m/s", "speed: 0.25 m/s").replace("fix_error: 3 m", "fix_error: 3 m\n  max_legs: 60")
    path.write_text(text + effects, encoding="utf-8")
    around = SweepScenario.environment
    place = Place(draught=np.linspace(0.2, 0.4, 60))  # of each trial its own
    monkeypatch.setattr(SweepScenario, "environment", lambda *given: replace(around(*given), place=place))
    scenario = replace(SweepScenario.of(load(path)), sigmas=(None,))
    table = LegTable(np.array([30.0, 200.0, 900.0]), np.array([25.0, 150.0, 700.0]))
    plans = [LegsAtSpeed(400.0), LegsAtSpeed(table), LegsAtSpeed(1500.0), LegsAtSpeed(table, 1.2), LegsAtSpeed(900.0)]

    def run(together):
        monkeypatch.setattr(paired_trials, "TRIALS_TOGETHER", together)
        return list(run_plans(scenario, plans, 3, 0, 60))

    alone = run(1)
    assert not all(trials.arrived.all() for trials in alone)
    for one, shared in zip(alone, run(200), strict=True):
        for field in fields(one):
            np.testing.assert_array_equal(getattr(shared, field.name), getattr(one, field.name))


@pytest.mark.slow
def test_where_drift_is_learnt_the_table_is_no_worse_than_the_best_fixed_d_max(learning):
    own = plan_legs(learning).cases[0]
    assert own.saved.mean > -3.0 * own.saved.standard_error


@pytest.mark.usefixtures("unsought")
def test_sweep_and_plan_recommend_a_d_max_of_the_same_cost_and_arrivals(learning):
    plan, curve = plan_legs(learning, trials=4000), sweep_dmax(learning, trials=4000).curves[0]
    chosen = min(curve.points, key=lambda point: abs(point.d_max - plan.fixed_d_max))
    assert chosen.d_max == pytest.approx(plan.fixed_d_max, rel=0.03)
    assert curve.reaches(chosen)
    assert curve.reaches(curve.recommended)
    assert chosen.cost == pytest.approx(curve.recommended.cost, abs=3.0 * max(chosen.excess_error, 1e-4))


@pytest.mark.slow
def test_legs_for_a_deadline_are_on_time_as_often_as_any_other_plan(learning, monkeypatch):
    monkeypatch.setattr(optimise_legs, "DEADLINE_FAMILY", PolicyFamily((1.0, 1.4), (1.0,)))
    plan = plan_legs(learning, aim="p95")
    *others, chosen = plan.candidates
    for other in others:
        assert chosen.value <= other.value + 3.0 * np.hypot(chosen.standard_error, other.standard_error)
    assert chosen.duration.mean > 0.0
    assert "common trials" in plan.how_found


@pytest.mark.parametrize(
    ("aim", "asked", "required"),
    [
        (LegAim("mean"), 0.5, 0.5),
        (LegAim("energy"), 0.0, 0.0),
        (LegAim("p95"), 0.5, 0.95),
        (LegAim("p95"), 0.99, 0.99),
        (LegAim("p95", 3450.0), 0.5, 0.5),
    ],
)
def test_a_time_that_19_of_20_keep_needs_as_many_to_arrive_but_a_deadline_of_the_mission_none(aim, asked, required):
    assert aim.required(SimpleNamespace(required_arrival=asked)) == required


@pytest.mark.usefixtures("unsought")
def test_p95_uses_the_deadline_of_the_mission(tmp_path, monkeypatch):
    monkeypatch.setattr(optimise_legs, "DEADLINE_FAMILY", PolicyFamily((1.0,), (1.0,)))
    path = tmp_path / "deadline.yaml"
    deadline = "requirements: [{quantity: in.duration, at_most: 3450 s, probability: 0.9}]\n"
    path.write_text(MISSION + deadline, encoding="utf-8")
    plan = plan_legs(load(path), aim="p95", trials=1000)
    assert plan.deadline == 3450.0
    assert all(candidate.value == candidate.on_time.value for candidate in plan.candidates)
    assert "probability of meeting the deadline" in plan.how_found


@pytest.mark.slow
def test_energy_chooses_the_speed_and_needs_less_than_at_the_mission_s_own(tmp_path):
    text = MEAN_COMPENSATION.replace("  drift_compensation: mean\n", "").replace("fix_error: 3 m", "fix_error: 0 m")
    still = "\n".join(line for line in text.splitlines() if "current:" not in line)
    path = tmp_path / "energy.yaml"
    path.write_text(still, encoding="utf-8")
    plan = plan_legs(load(path), aim="energy", trials=3000)
    fixed, mean_fixed, mean_table, chosen = plan.candidates
    assert chosen.speed == plan.speed != plan.mission_speed
    assert chosen.energy.mean < mean_table.energy.mean < mean_fixed.energy.mean
    assert chosen.energy.mean <= fixed.energy.mean
    assert f"{plan.speed:.3f} m/s" in plan.files()["mission-with-legs.yaml"]


def test_energy_without_a_vehicle_is_refused(mission):
    with pytest.raises(InputError, match="needs a vehicle"):
        plan_legs(mission, aim="energy", trials=100)


def test_the_spread_of_legs_is_estimated_from_pilot_trials(mission):
    scenario = replace(SweepScenario.of(mission), sigmas=(None,))
    spread = fit_leg_spread(scenario, 1)
    assert spread.sigma == pytest.approx(0.05, rel=0.03)
    assert spread.base < 5.0


def test_a_leg_that_is_meant_to_end_short_errs_by_what_it_misses_besides():
    class Short(Compensation):
        def offset(self, memory, leg):
            return self.undershoot(memory, leg) + 7.0

        def undershoot(self, memory, leg):
            return np.array([[30.0], [-40.0]])

    recording, duration = _RecordingCompensation(Short()), np.array([100.0, 200.0])
    planned = SimpleNamespace(duration=duration)
    memory = recording.begin(2)
    np.testing.assert_array_equal(recording.offset(memory, planned), [[37.0], [-33.0]])
    miss = np.array([[-30.0 + 3.0, 50.0], [40.0 + 4.0, 60.0]])  # the second trial is already there
    recording.update(memory, SimpleNamespace(duration=np.array([90.0, 0.0]), miss=miss))
    assert np.concatenate(recording.durations).tolist() == [100.0]
    assert np.concatenate(recording.squared_misses).tolist() == [25.0]


def test_legs_for_larger_errors_and_dearer_surfacings_are_those_of_a_mission_that_has_them(mission, monkeypatch):
    scenario, asked, legs = SweepScenario.of(mission), [], LegTable(np.array([50.0]), np.array([100.0]))
    monkeypatch.setattr(analytic_transit, "_best_legs", lambda *args: asked.append(args) or SimpleNamespace(legs=legs))
    AnalyticTransit(scenario, LegSpread(0.04, 8.0), 1.0, 90.0).best_table(2.0, 1.5)
    AnalyticTransit(scenario, LegSpread(2.0 * 0.04, 2.0 * 8.0), 1.0, 1.5 * 90.0).best_table()
    assert asked[0] == asked[1] == (scenario.distance, 1.0, 50.0, 0.08, 135.0, 16.0)


def test_sweep_and_plan_agree_on_the_best_d_max(erratic, adaptive):
    curve = sweep_dmax(erratic, method="analytic").curves[0]
    assert curve.best.cost >= adaptive.fixed_cost - 1e-9
    assert curve.best.cost == pytest.approx(adaptive.fixed_cost, abs=5e-4)


def test_the_sweep_sets_a_table_beside_the_fixed_d_max(adaptive, tmp_path):
    path = tmp_path / "mission.yaml"
    path.write_text(adaptive.files()["mission-with-legs.yaml"], encoding="utf-8")
    sweep = sweep_dmax(load(path), trials=4000)
    curve = sweep.curves[0]
    assert curve.table.cost_analytic == pytest.approx(adaptive.expected_cost, abs=1e-5)
    assert curve.table.cost == pytest.approx(curve.table.cost_analytic, abs=3 * curve.table.standard_error)
    assert curve.table.cost < curve.best.cost
    summary = sweep.summary()["sweep"][0]["table"]
    assert summary["cost"] == curve.table.cost
    assert "d_max_m" not in summary
    assert "table of legs" in (sweep.save(tmp_path / "out") / "report.html").read_text(encoding="utf-8")


def test_the_deadline_is_the_tightest_of_the_transits_own():
    required = (("in.duration", 3600.0), ("in.duration", 3450.0), ("in.duration", None), ("back.duration", 10.0))
    requirements = [SimpleNamespace(quantity=quantity, at_most=most) for quantity, most in required]
    scenario = SimpleNamespace(phase=SimpleNamespace(name="in"), mission=SimpleNamespace(requirements=requirements))
    assert _deadline(scenario) == 3450.0


def test_a_quantile_counts_who_never_arrives_and_is_as_sure_as_its_neighbours():
    """Of 10 000 the times 1 to 9800: the 9500th, and half of what lies between 2.18 standard errors of 0.00218."""
    value, error = _quantile(RunningStatistic.of(np.arange(1.0, 9801.0)), 0.95, 10_000)
    assert value == pytest.approx(9500.0, rel=1e-3)
    assert error == pytest.approx(np.hypot(21.8, 5e-4 * 9500.0), rel=0.15)
    assert _quantile(RunningStatistic.of(np.arange(1.0, 9401.0)), 0.95, 10_000) == (np.inf, np.inf)
    assert _late(RunningStatistic.of(np.arange(1.0, 9401.0)), 10_000)[0] == pytest.approx(0.95 * 9400.0 * 1.6, rel=1e-3)
