"""Flooding of the anchor after its separation."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from missionplan.phases.currents import layers
from missionplan.phases.mooring.descent import descend
from missionplan.phases.mooring.forces import Dive, LineSpring
from missionplan.phases.mooring.motion import CrossFlowBody, TiedBodies
from missionplan.physics.drag import QuadraticDrag

DIVE = Dive(
    wet_weight=11.7,
    anchor_mass=2.8,
    anchor_added_mass=0.5,
    anchor_drag=QuadraticDrag(1.17),
    vehicle_mass=10.2,
    vehicle_added_mass=0.24,
    net_buoyancy=0.89,
    vehicle_drag=QuadraticDrag(3.3),
    line_length=5.0,
    site_depth=30.0,
)
TIED = TiedBodies(CrossFlowBody(7.5, 4.0), CrossFlowBody(76.0, 20.0, 0.56))


def run(dive, current=None, **options):
    trials = np.size(dive.flooding_time)
    return descend(
        dive,
        release_time=np.zeros(trials),
        current=current or layers([1000.0], [0.0], [0.0]),
        position=np.zeros((2, trials)),
        t_start=np.zeros(trials),
        **options,
    )


def test_the_weight_grows_from_neutral_to_the_wet_weight():
    dive = replace(DIVE, flooding_time=8.0)
    assert dive.weight_at(0.0) == 0.0
    assert dive.weight_at(4.0) == pytest.approx(0.75 * DIVE.wet_weight)
    assert dive.weight_at(np.array([8.0, 50.0])) == pytest.approx([DIVE.wet_weight] * 2)


def test_torricelli_fills_the_anchor_in_that_time():
    """The head falls with what is still empty: dV/dt ∝ √(head), integrated by scipy."""
    found = solve_ivp(
        lambda _, v: 2.0 / 8.0 * np.sqrt(np.maximum(1.0 - v, 0.0)), (0.0, 7.9), [0.0], rtol=1e-9, atol=1e-12
    )
    share = replace(DIVE, flooding_time=8.0).weight_at(7.9) / DIVE.wet_weight
    assert share == pytest.approx(found.y[0, -1], rel=1e-5)


def test_no_time_is_no_flooding():
    for tied in (None, TIED):
        dive = replace(DIVE, tied=tied)
        plain, nought = run(dive), run(replace(dive, flooding_time=np.zeros(1)))
        assert nought.descent_time == pytest.approx(plain.descent_time, rel=1e-12)
        assert nought.lowest_altitude == pytest.approx(plain.lowest_altitude, rel=1e-12)


def test_pay_out_of_a_flooding_anchor_against_an_adaptive_integrator():
    def fall(t, y):
        weight = 11.7 * (1.0 - max(1.0 - t / 6.0, 0.0) ** 2)
        return [y[1], (weight - 1.17 * y[1] * abs(y[1])) / 3.3]

    def taut(_, y):
        return y[0] - 5.0

    taut.terminal = True
    found = solve_ivp(fall, (0.0, 60.0), [0.0, 0.0], events=taut, rtol=1e-10, atol=1e-12, max_step=0.1)
    assert run(replace(DIVE, flooding_time=6.0)).payout_time[0] == pytest.approx(found.t_events[0][0], abs=1e-5)


@given(st.floats(0.1, 60.0), st.floats(1.05, 3.0))
@settings(max_examples=6)
def test_the_longer_it_floods_the_later_it_lands(time, factor):
    record = run(replace(DIVE, flooding_time=np.array([0.0, time, factor * time])))
    assert (np.diff(record.descent_time) > 0.0).all()
    assert (np.diff(record.payout_time) > 0.0).all()


def test_a_slow_anchor_drifts_further_and_lands_all_the_same():
    current = layers([15.0, 30.0], [0.5, 0.5], [0.0, 0.0])
    times = np.array([0.0, 10.0, 100.0])
    for tied in (None, TIED):
        record = run(replace(DIVE, tied=tied, flooding_time=times), current)
        assert record.touched_down.all()
        assert record.offset_distance == pytest.approx(0.5 * record.descent_time, rel=1e-9)


def test_the_snatch_of_a_flooding_anchor_is_weaker():
    record = run(replace(DIVE, flooding_time=np.array([0.0, 20.0]), spring=LineSpring(1e4, 5.0)))
    assert record.snatch_tension[1] < 0.8 * record.snatch_tension[0]
