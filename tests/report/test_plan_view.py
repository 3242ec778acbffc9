"""Circles, ellipses and the median track."""

import math

import numpy as np
import pytest
from outcome_example import example

from missionplan.exporters.geojson import circle
from missionplan.report.plan_view import area, circular_error, ellipse, median_trial, rings, track
from missionplan.results.simulation import Tracks


def test_circular_error_of_normal_misses():
    misses = np.random.default_rng(1).normal(0.0, 2.0, (2, 100_000))
    assert circular_error(misses, 0.5) == pytest.approx(2.0 * math.sqrt(2.0 * math.log(2.0)), rel=0.01)
    assert circular_error(misses, 0.95) == pytest.approx(2.0 * math.sqrt(-2.0 * math.log(0.05)), rel=0.01)


def test_a_circle_is_closed_and_runs_counter_clockwise():
    line = circle((3.0, -2.0), 5.0)
    assert np.allclose(line[:, 0], line[:, -1])
    assert np.allclose(np.hypot(line[0] - 3.0, line[1] + 2.0), 5.0)
    assert area(line) == pytest.approx(25.0 * math.pi, rel=2e-3)


def test_an_ellipse_holds_its_share_and_has_the_shape_of_the_scatter():
    covariance = np.array([[9.0, 4.0], [4.0, 4.0]])
    points = np.random.default_rng(2).multivariate_normal((100.0, -50.0), covariance, 50_000).T
    line = ellipse(points, 0.95)
    assert np.allclose(line[:, :-1].mean(axis=1), (100.0, -50.0), atol=0.1)
    exact = math.pi * math.sqrt(np.linalg.det(covariance)) * -2.0 * math.log(0.05)
    assert area(line) == pytest.approx(exact, rel=0.03)


def test_an_ellipse_of_points_on_a_line_is_a_line():
    east = np.linspace(-1.0, 1.0, 101)
    line = ellipse(np.array([east, np.zeros(101)]), 0.95)
    assert np.ptp(line[0]) == pytest.approx(1.9, rel=0.02)
    assert np.ptp(line[1]) < 1e-3


def test_every_goal_has_its_circle_and_every_mooring_its_ellipses():
    found = [(ring.phase, ring.kind) for ring in rings(example())]
    assert found.count(("ingress", "CEP")) == 2
    assert found.count(("moor", "mooring ellipse")) == 2
    assert found.count(("egress", "arrival circle")) == 1
    assert ("egress", "mooring ellipse") not in found


def test_the_median_track_is_a_trial_that_came_furthest_and_ends_in_the_middle():
    position = np.full((4, 2, 5), np.nan)
    position[0] = 0.0
    position[1, 0], position[1, 1] = 10.0, (-2.0, -1.0, 0.1, 1.0, 2.0)
    position[2:, 0, :2], position[2:, 1, :2] = 20.0, (3.0, 2.0)
    position[2, 0, 3:], position[2, 1, 3:] = 20.0, (3.5, 9.0)
    trials = position.shape[2]
    profile, success = np.empty((2, 0, trials)), np.ones(trials, dtype=bool)
    time, phase = np.zeros(position[:, 0].shape), np.array([0, 0, 1, 1])
    tracks = Tracks(position, time, phase, {}, np.empty((2, 0)), None, profile, success)
    assert median_trial(tracks) == 3
    assert track(tracks, 3).shape == (2, 3)


def test_the_radius_of_an_ellipse_is_that_of_a_circle_of_its_area():
    (ring, *_) = (ring for ring in rings(example()) if ring.kind == "mooring ellipse")
    assert np.pi * ring.radius**2 == pytest.approx(area(ring.line))
