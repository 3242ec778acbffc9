"""The shortest way round: against a rectangle's corners by hand, moved, turned and mirrored, at its times and depths."""

from types import SimpleNamespace

import numpy as np
import pytest
import shapely

from missionplan.mission import Mission
from missionplan.mission.schema.site import CurrentFile, ForecastError
from missionplan.phases.place import Place
from missionplan.phases.zones import Fence, Zone
from missionplan.scenario.scenario import Scenario, leg_spread
from missionplan.scenario.ways import blocked, way_round
from tests.phases.place.ground_examples import ground

START, GOAL = np.array([0.0, 0.0]), np.array([2000.0, 0.0])
RANGE = shapely.box(800.0, -300.0, 1200.0, 500.0)
"""The shorter way passes it in the south."""
MARGIN = 50.0


def place(*zones, **given):
    return Place(None, Fence(tuple(zones)), **given)


def zone(geometry=RANGE, **limits):
    return Zone(geometry, "range", is_land=False, **limits)


def round_it(*zones, start=START, goal=GOAL, depth=5.0):
    found = way_round(place(*zones), start, goal, depth, MARGIN)
    return None if found is None else np.array([start, *found, goal])


def length(way):
    return np.hypot(*np.diff(way, axis=0).T).sum()


def test_the_way_is_the_shortest_about_the_corners():
    way = round_it(zone())
    corners = np.array([START, [750.0, -350.0], [1250.0, -350.0], GOAL])
    assert length(way) == pytest.approx(length(corners), rel=5e-3)
    assert way[1:-1] == pytest.approx(corners[1:-1], abs=5.0)
    assert shapely.distance(shapely.linestrings(way), RANGE) > 0.9 * MARGIN


@pytest.mark.parametrize(
    "turn", [np.array([[0.0, -1.0], [1.0, 0.0]]), np.array([[0.6, -0.8], [0.8, 0.6]]), np.diag([1.0, -1.0])]
)
def test_a_way_turned_mirrored_and_moved_is_the_same(turn):
    moved = shapely.transform(RANGE, lambda points: points @ turn.T + [300.0, -700.0])
    way = round_it(zone(moved), start=turn @ START + [300.0, -700.0], goal=turn @ GOAL + [300.0, -700.0])
    assert (way - [300.0, -700.0]) @ turn == pytest.approx(round_it(zone()), abs=1e-3)


def test_the_way_back_is_the_way_there():
    assert round_it(zone(), start=GOAL, goal=START)[::-1] == pytest.approx(round_it(zone()), abs=1e-6)


@pytest.mark.parametrize(
    ("limits", "is_round"),
    [
        ({"since": 1e6}, True),
        ({"until": 1.0}, True),
        ({"above": 5.1}, True),
        ({"above": 5.0}, False),
        ({"below": 4.9}, True),
        ({"below": 5.0}, False),
    ],
)
def test_a_zone_of_some_times_is_gone_round_and_one_of_other_depths_is_not(limits, is_round):
    assert len(round_it(zone(**limits))) == (4 if is_round else 2)


def test_what_is_surely_blocked_holds_at_all_times():
    both = place(zone(), zone(shapely.box(0.0, 900.0, 100.0, 1000.0), since=5.0), zone(RANGE.buffer(900.0), until=9.0))
    low, high = np.array([-1e4, -1e4]), np.array([1e4, 1e4])
    assert blocked(both, low, high, 5.0, at_some_time=False).equals(RANGE)
    assert blocked(both, low, high, 5.0, at_some_time=True).area > 5.0 * RANGE.area


def test_nothing_in_the_way_needs_no_points_and_no_way_is_none():
    assert len(round_it()) == 2
    assert len(round_it(zone(shapely.box(800.0, 900.0, 1200.0, 990.0)))) == 2
    ring = shapely.Point(0.0, 0.0).buffer(700.0).difference(shapely.Point(0.0, 0.0).buffer(500.0))
    assert round_it(zone(ring)) is None
    assert round_it(zone(shapely.box(-10.0, -10.0, 10.0, 10.0))) is None  # it begins in one


def test_near_a_wall_the_margin_is_what_the_start_has():
    quay = shapely.box(-300.0, 20.0, 200.0, 200.0)
    way = round_it(zone(quay), goal=np.array([0.0, 400.0]))
    assert len(way) > 2
    assert shapely.distance(shapely.linestrings(way), quay) == pytest.approx(20.0, abs=0.5)
    assert shapely.distance(shapely.linestrings(way[1:]), quay) > 0.75 * MARGIN


@pytest.mark.parametrize(("west", "east"), [(-500.0, 900.0), (-900.0, 450.0), (-900.0, 900.0)])
def test_a_wall_that_reaches_farther_than_the_goal_is_gone_round_and_not_through(west, east):
    quay = shapely.box(west, 150.0, east, 250.0)
    way = round_it(zone(quay), goal=np.array([0.0, 400.0]))
    side = west if -west < east else east
    by = side + np.copysign(MARGIN, side)
    corners = np.array([[0.0, 0.0], [by, 150.0 - MARGIN], [by, 250.0 + MARGIN], [0.0, 400.0]])
    assert length(way) == pytest.approx(length(corners), rel=0.02)
    assert shapely.distance(shapely.linestrings(way), quay) > 0.9 * MARGIN


def test_there_is_no_way_through_a_wall_without_an_end():
    assert round_it(zone(shapely.box(-9e4, 150.0, 9e4, 250.0)), goal=np.array([0.0, 400.0])) is None


def test_shoals_are_surely_blocked_less_a_node_and_perhaps_by_their_contour():
    """3 m beside 9 m, of which a transit at 5 m with half a metre of hull and as much beneath it needs 6: midway."""
    east = np.where(np.arange(41) < 20, 3.0, 9.0)  # the steps of 10 m from 190 to 200 m
    there = Place(ground(np.tile(east, (41, 1))), None, draught=0.5, clearance=0.5)
    low, high = np.array([100.0, 100.0]), np.array([300.0, 300.0])
    box = shapely.box(*low, *high)
    maybe, surely = (blocked(there, low, high, 5.0, at_some_time=each).intersection(box) for each in (True, False))
    assert maybe.bounds == pytest.approx((100.0, 100.0, 195.0, 300.0), abs=0.1)
    assert surely.bounds == pytest.approx((100.0, 100.0, 190.0, 300.0), abs=0.1)
    assert blocked(there, low, high, 1.9, at_some_time=True).is_empty


@pytest.mark.parametrize(("made_up_for", "carried"), [("mean", 0.0), ("none", 0.3 * 400.0)])
def test_a_way_keeps_as_far_off_as_a_leg_may_end_from_its_course(made_up_for, carried):
    """600 m at 1.5 m/s with 0.05 m/s of error, a fix of 4 m, 0.4 m/s for a minute afloat, and 0.3 m/s below."""
    layers = [
        {"down_to": "3 m", "speed": "0.4 m/s", "toward": "0 deg"},
        {"down_to": "30 m", "speed": "0.3 m/s", "toward": "90 deg"},
    ]
    navigation = {
        "velocity_error": {"sigma": "0.05 m/s"},
        "surfacing_time": "60 s",
        "fix_error": "4 m",
        "drift_compensation": made_up_for,
    }
    transit = {
        "name": "out",
        "from": ["0 m", "0 m"],
        "to": ["3 km", "0 m"],
        "depth": "9 m",
        "speed": "1.5 m/s",
        "arrival_radius": "50 m",
    }
    data = {
        "site": {"depth": "30 m", "current": layers},
        "navigation": navigation,
        "phases": [{"transit": transit | {"d_max": "600 m"}}],
    }
    means = Scenario.at_means(Mission.from_data(data))
    assert leg_spread(means, means.transit()) == pytest.approx(3.0 * np.hypot(0.05 * 400.0, 4.0) + carried + 0.4 * 60.0)


def test_the_error_of_a_forecast_is_forgotten_along_the_track_as_well_as_in_time():
    error = ForecastError.model_construct(sigma=0.1, time=3600.0, length=1800.0)
    for length, time in ((1800.0, 1.0 / (1.0 / 3600.0 + 1.5 / 1800.0)), (None, 3600.0)):
        current = CurrentFile.model_construct(error=error.model_copy(update={"length": length}))
        scenario = SimpleNamespace(recorded=current, drawn=SimpleNamespace(site=SimpleNamespace(current=current)))
        assert Scenario._error_along(scenario, SimpleNamespace(speed=1.5)) == pytest.approx((0.1, time))
        scenario.recorded = None
        assert Scenario._error_along(scenario, SimpleNamespace(speed=1.5)) is None
