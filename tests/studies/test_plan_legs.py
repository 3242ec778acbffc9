"""Legs planned for a mission: the table, its trials beside the best fixed d_max, and the mission that it gives."""

import numpy as np
import pytest
import yaml

from missionplan.errors import InputError
from missionplan.mission import load
from missionplan.studies.plan_legs import plan_legs
from missionplan.studies.sweep_dmax import sweep_dmax

MISSION = """
name: Legs
navigation:
  velocity_error: {sigma: 0.05 m/s}
  surfacing_time: 90 s
phases:
  - transit: {name: in, from: [0 m, 0 m], to: [3 km, 1 km], speed: 1 m/s, d_max: 1 km, arrival_radius: 50 m}
monte_carlo: {trials: 8000, seed: 5}
"""


@pytest.fixture(scope="module")
def mission(tmp_path_factory):
    path = tmp_path_factory.mktemp("legs") / "legs.yaml"
    path.write_text(MISSION, encoding="utf-8")
    return load(path)


@pytest.fixture(scope="module")
def plan(mission):
    return plan_legs(mission)


def test_monte_carlo_agrees_with_the_integral_equation(plan):
    case = plan.cases[0]
    assert case.adaptive.cost == pytest.approx(plan.expected_cost, abs=3 * case.adaptive.standard_error)
    assert case.fixed.cost == pytest.approx(plan.fixed_cost, abs=3 * case.fixed.standard_error)
    assert case.saving == pytest.approx(plan.saving, abs=3 * case.saving_error)
    assert case.adaptive.arrived.value == 1.0


def test_legs_beat_the_best_fixed_d_max_which_beats_one_leg(plan):
    assert plan.least_cost <= plan.expected_cost < plan.fixed_cost < plan.one_leg_cost
    assert plan.recommended


def test_robustness_covers_sigma_and_mean(plan):
    names = [case.name for case in plan.cases]
    assert names[0] == ""
    assert [case.sigma for case in plan.cases[1:3]] == pytest.approx([0.025, 0.1])
    course = np.array([3.0, 1.0]) / np.sqrt(10.0)
    for case, size in zip(plan.cases[3:], (0.025, 0.05), strict=True):
        assert np.hypot(*case.mean_error) == pytest.approx(size)
        assert np.dot(case.mean_error, course) == pytest.approx(0.0, abs=1e-12)


def test_the_mission_with_legs_loads_and_runs(plan, tmp_path):
    path = tmp_path / "mission.yaml"
    path.write_text(plan.files()["mission-with-legs.yaml"], encoding="utf-8")
    table = load(path).transits[0].d_max.table
    np.testing.assert_allclose(np.array(table), np.column_stack([plan.left, plan.leg]), atol=1e-6)
    assert yaml.safe_load(plan.files()["legs.yaml"])["d_max"] == plan.d_max


def test_same_numbers_for_any_jobs(mission, plan):
    threaded = plan_legs(mission, jobs=2, backend="threading")
    assert threaded.cases == plan.cases


def test_tracks_start_together_and_end_near_the_target(plan):
    for tracks in (plan.fixed_tracks, plan.adaptive_tracks):
        np.testing.assert_array_equal(tracks[:, 0], 0.0)
        for track in np.moveaxis(tracks, -1, 0):
            last = track[:, ~np.isnan(track[0])][:, -1]
            assert np.hypot(*(last - [3000.0, 1000.0])) <= 50.0


def test_tables_and_summary(plan):
    frame = plan.to_frame()
    assert list(frame.columns) == ["distance_left_m", "leg_m", "aim_short_m"]
    summary = plan.summary()
    assert summary["adaptive"]["cost"] == plan.expected_cost
    assert summary["recommended"] == "adaptive"
    assert len(summary["cases"]) == 5


def test_what_the_legs_leave_out_is_said(tmp_path):
    path = tmp_path / "fixes.yaml"
    path.write_text(MISSION.replace("surfacing_time: 90 s", "surfacing_time: 90 s\n  fix_error: 5 m"), encoding="utf-8")
    notices = plan_legs(load(path), trials=500).provenance.notices
    assert any("fix error" in notice for notice in notices)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("surfacing_time: 90 s", "surfacing_time: 0 s", "surfacing time"),
        ("sigma: 0.05 m/s", "sigma: 0.9 m/s", "too large"),
        ("arrival_radius: 50 m", "arrival_radius: 4 km", "outside the arrival radius"),
    ],
)
def test_missions_that_cannot_be_planned(old, new, message, tmp_path):
    path = tmp_path / "bad.yaml"
    path.write_text(MISSION.replace(old, new), encoding="utf-8")
    with pytest.raises(InputError, match=message):
        plan_legs(load(path))


def test_sweep_and_plan_agree_on_the_best_d_max(mission, plan):
    curve = sweep_dmax(mission, method="analytic").curves[0]
    assert curve.best.cost >= plan.fixed_cost - 1e-9
    assert curve.best.cost == pytest.approx(plan.fixed_cost, abs=5e-4)
