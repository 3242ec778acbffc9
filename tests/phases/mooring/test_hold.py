"""The hold: the envelope over a current that changes, the slope, what grounds and what holds."""

from dataclasses import replace

import numpy as np
import pytest

from missionplan.effects import CATALOGUE
from missionplan.phases.currents import layers
from missionplan.phases.mooring.hold import Hold, hold_vehicle, layers_above, lifted
from missionplan.phases.recorded_currents import SeriesCurrent
from missionplan.physics.drag import QuadraticDrag
from missionplan.physics.held_line import HeldBody, HeldLine
from missionplan.physics.line_statics import held_pose
from missionplan.physics.seafloor import LyingAnchor, Slope

BODY = HeldBody(1.12, 0.12, 0.9, 0.5 * 1.12 * 0.9, 0.0, 1.1, QuadraticDrag(3.3), 1025.0)
HOLD = Hold(BODY, HeldLine(5.0), LyingAnchor(11.8, 0.12, 0.18, 0.5), 20.0)


def held(hold=HOLD, speed=0.2, current=None, duration=3600.0, trials=1):
    current = current or layers([100.0], [speed], [0.5 * np.pi])
    return hold_vehicle(hold, current, np.zeros((2, trials)), np.full(trials, 100.0), duration)


def tide(*speeds, every=3600.0):
    """East at every depth, linear between hours."""
    east = np.array(speeds)[:, None] * np.ones(2)
    return SeriesCurrent(np.arange(len(speeds)) * every, np.array([0.0, 20.0]), east, 0.0 * east)


def test_the_envelope_holds_the_fastest_and_the_slowest_moment():
    record = held(current=tide(0.1, 0.4, 0.05), duration=7000.0)
    fastest, slowest, last = (held(speed=speed) for speed in (0.4, 0.05, 0.05 + 0.35 * 100.0 / 3600.0))
    assert record.nose_altitude == pytest.approx(fastest.nose_altitude, abs=0.05)
    assert record.excursion == pytest.approx(fastest.excursion, abs=0.05)
    assert record.holding_margin == pytest.approx(fastest.holding_margin, abs=0.01)
    assert record.line_tension[0] == pytest.approx(max(fastest.line_tension[0], slowest.line_tension[0]), abs=0.03)
    assert record.parted_from == pytest.approx(last.parted_from, abs=0.01)


def test_each_trial_of_a_block_meets_its_own_fastest_and_slowest_moment():
    current, durations = tide(0.1, 0.4, 0.05), np.array([7000.0, 2000.0, 0.0, 5000.0])
    block = held(current=current, duration=durations, trials=4)
    for number, duration in enumerate(durations):
        alone = held(current=current, duration=duration)
        assert block.excursion[number] == pytest.approx(alone.excursion[0], abs=1e-4)
        assert block.nose_altitude[number] == pytest.approx(alone.nose_altitude[0], abs=0.02)
        assert block.parted_from[:, number] == pytest.approx(alone.parted_from[:, 0], abs=1e-4)


def test_a_current_that_turns_leaves_the_watch_circle_as_wide():
    record = held(current=tide(0.3, -0.3), duration=3500.0)
    assert record.excursion == pytest.approx(held(speed=0.3).excursion, abs=0.05)
    assert record.parted_from[0, 0] < -3.0


def test_without_a_hold_the_current_at_touchdown_counts():
    record = held(current=tide(0.1, 0.4), duration=0.0)
    assert record.excursion == pytest.approx(held(speed=0.1 + 0.3 * 100.0 / 3600.0).excursion, rel=1e-6)


def test_layers_of_the_mission_are_those_above_the_anchor():
    current = layers([8.0, 17.0, 100.0], [0.5, 0.3, 0.1], [0.0, 0.0, 0.0])
    found = layers_above(HOLD, current, np.zeros((2, 1)), np.zeros(1))
    altitudes = np.array([[0.5], [2.9], [3.1], [11.9], [12.1]])
    assert found.at(altitudes)[1, :, 0].tolist() == [0.1, 0.1, 0.3, 0.3, 0.5]


def test_a_record_that_changes_with_depth_is_followed():
    shear = SeriesCurrent(
        np.array([0.0, 1e6]), np.array([10.0, 20.0]), np.array([[0.5, 0.0], [0.5, 0.0]]), np.zeros((2, 2))
    )
    found = layers_above(HOLD, shear, np.zeros((2, 1)), np.zeros(1))
    altitudes = np.linspace(0.1, 6.0, 30)[:, None]
    assert found.at(altitudes)[0, :, 0] == pytest.approx(0.05 * altitudes[:, 0], abs=1e-9)


def test_uphill_the_vehicle_stands_lower_above_the_seafloor():
    """The seafloor falls to the west, so that the current carries the vehicle uphill."""
    slope = Slope(np.radians(10.0), 1.5 * np.pi)
    level, uphill = held(), held(replace(HOLD, slope=slope))
    fall = level.excursion * np.tan(slope.angle)
    assert uphill.nose_altitude == pytest.approx(level.nose_altitude - fall)
    assert uphill.excursion == pytest.approx(level.excursion)


def test_it_grounds_where_the_hull_touches():
    assert not held(speed=0.9).grounded[0]
    strong = held(replace(HOLD, line=HeldLine(1.0)), speed=3.0)
    assert strong.nose_altitude[0] > 0.0
    assert strong.nose_altitude[0] < 0.06
    assert strong.grounded[0]
    assert held(replace(HOLD, slope=Slope(0.3, 1.5 * np.pi)), speed=0.9).grounded[0]


def test_a_tail_that_hangs_grounds_before_the_nose():
    short = replace(HOLD, line=HeldLine(1.0), body=replace(BODY, raising_moment=-0.5))
    assert held(short, speed=0.0).grounded[0]
    assert held(short, speed=0.0).nose_altitude[0] == pytest.approx(1.0)
    assert not held(replace(HOLD, line=HeldLine(1.0)), speed=0.0).grounded[0]


def test_the_anchor_holds_up_to_its_least_weight():
    current = layers([100.0], [0.8], [0.0])
    above = layers_above(HOLD, current, np.zeros((2, 1)), np.zeros(1))
    needed = HOLD.least_weight(held_pose(HOLD.body, HOLD.line, above), above)[0]
    for weight, holds in ((1.001 * needed, True), (0.999 * needed, False)):
        record = held(replace(HOLD, anchor=replace(HOLD.anchor, wet_weight=weight)), current=current)
        assert record.anchor_holds[0] == holds


def test_a_margin_falls_with_the_current():
    margins = [held(speed=speed).holding_margin[0] for speed in (0.0, 0.2, 0.5, 1.0)]
    assert margins == sorted(margins, reverse=True)
    assert margins[0] == pytest.approx(1.0 - 0.9 / 11.8)


def test_a_lift_acts_at_mid_length_at_the_depth_of_the_nose():
    """As if the vehicle were lighter there: twice as much for two, and less of trapped gas at depth."""
    gas = CATALOGUE["trapped-gas"].make({"lift": 0.4})
    once, twice = lifted(HOLD, (gas,)), lifted(HOLD, (gas, gas))
    at_nose = float(gas.lift(np.array([20.0 - 5.0]))[0])
    assert 0.0 < at_nose < 0.4
    assert once.body.net_buoyancy == pytest.approx(0.9 + at_nose)
    assert once.body.raising_moment == pytest.approx(0.5 * 1.12 * (0.9 + at_nose))
    assert twice.body.raising_moment == pytest.approx(0.5 * 1.12 * (0.9 + 2.0 * at_nose))
    assert lifted(replace(HOLD, line=HeldLine(30.0)), (gas,)).body.net_buoyancy == pytest.approx(
        0.9 + float(gas.lift(np.zeros(1))[0])
    )
    assert lifted(HOLD, ()).body.net_buoyancy == 0.9
    lighter = replace(BODY, net_buoyancy=0.9 + at_nose, raising_moment=0.5 * 1.12 * (0.9 + at_nose))
    assert held(once).nose_altitude == pytest.approx(held(replace(HOLD, body=lighter)).nose_altitude)
