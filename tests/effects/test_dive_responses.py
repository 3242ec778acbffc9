"""Responses of dives without a name, and effects on their logs, by their closed forms."""

import numpy as np
import pytest

from missionplan.effects import CATALOGUE, effects_of
from missionplan.effects.dive_log import ClockRate, SensorPosition
from missionplan.effects.dive_responses import (
    DragByDepth,
    DragByLine,
    DragBySpeed,
    LiftByDepth,
    LiftInLayer,
    ReadingAtFirst,
    ReadingByTime,
    WeightFromMoment,
    WeightUntilMoment,
)
from missionplan.phases.mooring.forces import DescentHooks, SteadyDescent

T = np.linspace(0.0, 20.0, 201)
STEADY = 1.5 * T[:, None]


def test_a_fast_clock_reads_a_steady_dive_as_a_slower_one():
    np.testing.assert_allclose(ClockRate(0.05).reading(T, STEADY), STEADY / 1.05, rtol=1e-12)
    np.testing.assert_allclose(ClockRate(-0.05).reading(T, STEADY), STEADY / 0.95, rtol=1e-12)


def test_a_fast_clock_reads_each_depth_late():
    curved = np.stack([0.1 * T**2, STEADY[:, 0]], axis=1)
    rates = np.array([0.1, 0.0])
    found = ClockRate(rates).reading(T, curved)
    np.testing.assert_allclose(found[:, 0], 0.1 * (T / 1.1) ** 2, atol=1e-3)
    np.testing.assert_array_equal(found[:, 1], curved[:, 1])


def test_a_sensor_behind_the_nose_is_higher_and_not_above_the_surface():
    found = SensorPosition(0.9).reading(T, STEADY)
    np.testing.assert_allclose(found[STEADY > 0.9], STEADY[STEADY > 0.9] - 0.9)
    assert found[STEADY <= 0.9].max() == 0.0


def test_a_lift_by_depth_begins_at_its_start_and_tends_to_its_size():
    effect = LiftByDepth(-2.0, 4.0, 10.0)
    assert effect.lift(3.9) == 0.0
    assert effect.lift(14.0) == pytest.approx(-2.0 * (1.0 - np.exp(-1.0)))
    assert effect.lift(500.0) == pytest.approx(-2.0)


def test_a_lift_in_a_layer_is_gone_outside_it():
    effect = LiftInLayer(1.2, 10.0, 2.0)
    assert effect.lift(10.0) == 1.2
    assert effect.lift(8.0) == effect.lift(12.0) == pytest.approx(1.2 * np.exp(-0.5))
    assert effect.lift(30.0) < 1e-9


def test_drag_follows_depth_line_and_speed():
    assert DragByDepth(0.5, 4.0, 10.0).local_drag_factor(14.0, 5.0) == pytest.approx(1.5 - 0.5 * np.exp(-1.0))
    assert DragByLine(0.02).local_drag_factor(14.0, 10.0) == pytest.approx(1.2)
    assert DragBySpeed(0.5, 1.0).drag_factor(0.0, 0.8) == 1.0
    assert DragBySpeed(0.5, 1.0).drag_factor(0.0, 1.6) == pytest.approx(1.3)
    assert DragBySpeed(-0.9, 0.1).drag_factor(0.0, 5.0) > 0.0


def test_a_pull_changes_at_its_moment():
    assert WeightFromMoment(-0.3, 8.0).wet_weight_factor(7.0) == pytest.approx(1.0, abs=1e-4)
    assert WeightFromMoment(-0.3, 8.0).wet_weight_factor(9.0) == pytest.approx(0.7, abs=1e-4)
    assert WeightUntilMoment(0.3, 8.0).wet_weight_factor(7.0) == pytest.approx(1.3, abs=1e-4)
    assert WeightUntilMoment(0.3, 8.0).wet_weight_factor(9.0) == pytest.approx(1.0, abs=1e-4)


def test_a_reading_drifts_to_its_offset():
    found = ReadingByTime(0.4, 5.0).reading(T, STEADY) - STEADY
    assert found[0] == 0.0
    assert found[50] == pytest.approx(0.4 * (1.0 - np.exp(-1.0)))


def test_a_reading_that_errs_at_first_comes_right_and_never_lies_above_the_surface():
    depth = 1.5 * np.maximum(T - 2.04, 0.0)[:, None] * np.array([1.0, 0.5])
    found = ReadingAtFirst(offset=-0.4, time=1.0).reading(T, depth)
    wanted = np.maximum(depth - 0.4 * np.exp(-(T - 2.04))[:, None], 0.0)
    np.testing.assert_allclose(found[21:], wanted[21:], atol=1e-12)
    assert np.all(found[:21] == 0.0)
    late = ReadingAtFirst(offset=0.4, time=1.0).reading(T, depth)
    assert np.all(late[:21] == 0.0)
    np.testing.assert_allclose(late[21:] - depth[21:], 0.4 * np.exp(-(T[21:] - 2.04))[:, None] * [1.0, 1.0], atol=1e-12)


def test_an_anchor_is_sized_for_drag_that_is_there_at_depth():
    plain = SteadyDescent.at(1.5, DescentHooks(), 40.0, 8.0)
    deep = SteadyDescent.at(1.5, DescentHooks([DragByDepth(0.5, 1.0, 0.1), DragByLine(0.01)]), 40.0, 8.0)
    assert plain.drag_factor == 1.0
    assert deep.drag_factor == pytest.approx(1.5 * 1.08, rel=0.02)
    assert deep.wet_weight(10.0) == pytest.approx(10.0 * deep.drag_factor)


@pytest.mark.parametrize("info", [info for info in effects_of("descent") if info.tier == "neutral"], ids=lambda i: i.id)
def test_a_response_names_no_cause_and_asks_for_nothing(info):
    assert info.follows
    assert info.finding.remedy == ""
    assert info.finding.positive != info.finding.negative
    strength = next(iter(info.parameters.values()))
    assert strength.low < 0.0 <= strength.high  # of one sign where a named effect has the other


def test_what_follows_nothing_has_a_name():
    assert all(info.tier == "neutral" for info in CATALOGUE.values() if info.follows)
