"""Transits by a vehicle's own rules, in a steady current: what it does with and without a fix, in closed form."""

import numpy as np
import pytest
from transit_examples import GOAL, normals, plan, start

from missionplan.phases.currents import LayeredCurrent
from missionplan.phases.transit import transit
from missionplan.phases.transit.plan import Environment, Execution

ALONG, SPEED = 0.02, 1.25
"""Of the current, towards north, across the course; through the water [m/s]."""
POINTS = np.array([[500.0, 1000.0], [0.0, 0.0]])
UNTIL_FIX = np.array([30.0, 90.0, 150.0])


def sailed(execution, **changes):
    current = LayeredCurrent(np.array([1.0]), np.array([0.0]), np.array([ALONG]))
    made = plan(speed=SPEED, surfacing_time=UNTIL_FIX, arrival_radius=40.0, **changes)
    return transit(made, start(), normals(), Environment(current), execution=execution)


def test_without_a_fix_it_goes_on_by_dead_reckoning():
    """The third vehicle leaves before its fixes come: it drifts all the time and does not know it."""
    stay = 100.0
    state, record = sailed(Execution("count", POINTS[:, -1], surface_time=stay, points=POINTS))
    drift = ALONG * (500.0 / SPEED + stay)
    to_goal = np.hypot(500.0, drift)  # from the second fix on, back to the line
    assert record.duration[2] == pytest.approx(2.0 * (500.0 / SPEED + stay))
    assert record.duration[:2] == pytest.approx((500.0 + to_goal) / SPEED + 2.0 * stay)
    assert state.position[1] == pytest.approx([ALONG * (to_goal / SPEED + stay)] * 2 + [2.0 * drift], rel=1e-9)
    assert state.fix[1, 2] == pytest.approx(0.0, abs=1e-9)
    assert record.arrived.all()


def test_who_arrives_without_a_fix_is_judged_by_where_it_is():
    _, record = sailed(Execution("reckoning", np.array(GOAL), interval=100.0, fix_wait=100.0, key_wait=110.0))
    off = 10 * ALONG * (100.0 / SPEED + 210.0)
    assert record.arrival_error[2] == pytest.approx(off)
    assert off > 40.0
    assert record.arrived.tolist() == [True, True, False]


def test_it_stays_until_the_fix_and_then_for_a_key():
    _, record = sailed(Execution("reckoning", np.array(GOAL), fix_wait=100.0, key_wait=20.0))
    assert record.duration == pytest.approx(1000.0 / SPEED + np.array([50.0, 110.0, 120.0]))


def test_it_gives_up_where_no_fix_comes():
    _, record = sailed(Execution("fix", np.array(GOAL), interval=300.0, fix_wait=100.0, aborts=True))
    assert record.arrived.tolist() == [True, True, False]
    assert record.surfacings[2] == 1.0
    assert record.duration[2] == pytest.approx(300.0 / SPEED + 100.0)


def test_it_gives_up_after_a_time():
    _, record = sailed(Execution("fix", np.array(GOAL), interval=300.0, time_out=700.0))
    assert record.arrived.tolist() == [False] * 3
    assert np.all(record.duration >= 700.0)
    assert np.all(record.duration < 700.0 + 300.0 / SPEED + 150.0)
    assert np.all(record.surfacings < 4.0)


def test_it_holds_its_place_for_the_rest_of_its_time():
    """With a fix it goes back to the leg's end; with little time left, only so far as it gets against the current."""
    _, record = sailed(Execution("count", POINTS[:, -1], surface_time=151.0, points=POINTS, holds=True))
    drift = ALONG * (500.0 / SPEED + 151.0)
    assert record.arrival_error == pytest.approx([0.0, 0.0, drift - 1.0 * SPEED], abs=2e-3)
