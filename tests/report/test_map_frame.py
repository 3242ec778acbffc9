"""Maps whose limits no single trial sets, and curves that are said to have teeth only where they have."""

from types import SimpleNamespace

import numpy as np
import pytest

from missionplan.report.plan_view import frame
from missionplan.report.site_map import _goals, _rows_of_names, room_for_names
from missionplan.studies.leg_length.sweep_page import has_teeth


def tracks(count: int, *, astray: float = 0.0) -> list[np.ndarray]:
    generator = np.random.default_rng(1)
    found = [np.linspace((0.0, 0.0), (1600.0, 0.0), 6).T + generator.normal(0.0, 10.0, (2, 6)) for _ in range(count)]
    return [*found, np.array([[0.0, astray], [0.0, -astray]])] if astray else found


def test_a_trial_gone_astray_does_not_set_the_limits_but_is_told():
    usual, robust = frame(tracks(199)), frame(tracks(199, astray=1e6))
    assert robust.width == pytest.approx(usual.width, rel=0.05)
    assert usual.outliers_in_words() == ""
    assert robust.outliers_in_words() == " 1 trial leaves the map, the farthest by 1000\u00a0km."


def test_what_always_counts_lies_inside():
    far = np.array([[5000.0], [0.0]])
    assert frame(tracks(50), [far]).west_east[1] > 5000.0
    assert frame([], [far, np.zeros((2, 1))]).west_east[0] < 0.0


def test_a_map_is_no_taller_than_is_asked():
    tall = np.array([[0.0, 10.0], [0.0, 1000.0]])
    assert frame([], [tall]).shape == pytest.approx(1.25)
    assert frame([], [tall], tallest=0.75).shape == pytest.approx(0.75)


def test_goals_in_degrees_and_minutes_are_on_the_map():
    """A minute of latitude is 1857 m at 60° north."""
    origin = {"latitude": "60 06.0 N", "longitude": "005 22.5 E"}
    ways = [{"transit": {"from": ["0 m", "0 m"], "to": {**origin, "latitude": "60 07.0 N"}, "arrival_radius": "9 m"}}]
    start, goal = _goals({"site": {"origin": origin}, "phases": ways})
    assert (start.name, goal.name, goal.radius) == ("start", "transit", 9.0)
    assert goal.place == pytest.approx((0.0, 1857.0), abs=1.0)
    assert len(list(_goals({"phases": ways}))) == 1  # without an origin it has no place on the plane


def test_names_that_would_run_into_one_another_stand_in_rows():
    """A kilometre apart, 12 letters together have room; 50 letters have not, nor has a third place of that height."""
    way = np.array([[0.0, 1000.0, 1000.0], [0.0, 0.0, 1200.0]])
    assert _rows_of_names(way, [("start", (0.0, 0.0)), ("ingress", (1000.0, 0.0))]) == [1, -1]
    way = np.array([[0.0, 1000.0, 1000.0, 0.0], [0.0, 0.0, 1200.0, 0.0]])
    names = [("start, home", (0.0, 0.0)), (40 * "x", (1000.0, 0.0)), ("on", (1000.0, 1200.0))]
    assert _rows_of_names(way, names) == [-1, -2, 1]


def curve(cost) -> SimpleNamespace:
    ratio = np.linspace(0.05, 1.0, 96)
    points = [
        SimpleNamespace(d_max_over_distance=r, cost=c, standard_error=1e-4)
        for r, c in zip(ratio, cost(ratio), strict=True)
    ]
    return SimpleNamespace(points=points)


def test_teeth_are_told_only_where_the_cost_jumps_at_a_critical_point():
    smooth = curve(lambda r: 0.1 * (r - 0.6) ** 2)
    steep = curve(lambda r: 0.02 / r + np.where(r > 0.7, 3.0 * (r - 0.7), 0.0))
    toothed = curve(lambda r: 0.1 * (r - 0.6) ** 2 + np.where(r > 0.5, 0.01, 0.0))
    elsewhere = curve(lambda r: 0.1 * (r - 0.6) ** 2 + np.where(r > 0.42, 0.01, 0.0))
    found = [has_teeth(each, (1.0, 0.5, 1.0 / 3.0, 0.25)) for each in (smooth, steep, toothed, elsewhere)]
    assert found == [False, False, True, False]


def test_a_mission_without_a_way_needs_no_room_for_names():
    assert list(room_for_names({"phases": [{"moor": {}}]})) == []
