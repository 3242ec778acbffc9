"""Tunnel thruster on a moving vehicle: limits, the suction's bookkeeping, power."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from missionplan.physics import tunnel_thruster as tt

AUTOSUB = tt.TunnelThruster(0.196, 0.90, 6.69, position=0.0, suction_gradient=8.0)
ratios = st.floats(0.0, 3.0)


def test_at_rest_the_static_force_acts_at_the_thruster():
    thruster = tt.TunnelThruster(0.07, 0.02, 7.0, position=0.8, suction_gradient=5.0)
    load = tt.thruster_load(thruster, 30.0, 0.0, 1000.0)
    assert load.force == pytest.approx(0.02 * 900.0)
    assert load.moment == pytest.approx(load.force * 0.8)


def test_no_jet_no_force():
    load = tt.thruster_load(AUTOSUB, np.array([0.0, 0.0]), np.array([0.0, 1.5]), 1026.0)
    np.testing.assert_array_equal(load.force, 0.0)
    np.testing.assert_array_equal(load.moment, 0.0)


@given(ratio=ratios, decay=st.floats(0.5, 10.0))
def test_suction_and_net_force_add_to_the_static_force(ratio, decay):
    factor = tt.force_factor(ratio, decay)
    assert 0.0 <= factor <= 1.0
    assert tt.suction_force(50.0, factor) + 50.0 * factor == pytest.approx(50.0)


@given(ratio=ratios, x_t=st.floats(0.2, 2.0), x_s=st.floats(-2.0, 2.0))
def test_moment_factor_is_moment_over_static_moment(ratio, x_t, x_s):
    factor = tt.force_factor(ratio, 3.0)
    assert tt.moment(50.0, factor, x_t, x_s) / (50.0 * x_t) == pytest.approx(
        tt.moment_factor(factor, x_s / x_t), abs=1e-9
    )


@given(n=st.floats(1.0, 20.0), speed=st.floats(0.0, 2.0))
def test_reversing_the_thruster_reverses_force_and_moment(n, speed):
    ahead, astern = (tt.thruster_load(AUTOSUB, rate, speed, 1026.0) for rate in (n, -n))
    assert astern.force == pytest.approx(-ahead.force)
    assert astern.moment == pytest.approx(-ahead.moment)


def test_suction_of_a_central_thruster_pitches_as_if_lifted_aft():
    """A downward (positive) force on the centre: suction acts upward aft of it, so the nose goes down (N > 0 here)."""
    assert tt.thruster_load(AUTOSUB, 10.0, 0.5, 1026.0).moment > 0.0


@given(static=st.floats(-200.0, 200.0))
def test_revolutions_invert_static_thrust(static):
    revolutions = tt.revolutions_for(0.9, static)
    assert tt.static_thrust(0.9, revolutions) == pytest.approx(static, abs=1e-9)


def test_range_ends_where_93_percent_is_lost():
    assert tt.force_factor(tt.highest_ratio(6.69), 6.69) == pytest.approx(0.07)
    assert tt.highest_ratio(6.69) == pytest.approx(0.63, abs=0.005)
    assert tt.highest_ratio(3.0) == pytest.approx(0.94, abs=0.005)
    np.testing.assert_array_equal(tt.out_of_range(np.array([0.5, 0.7]), 6.69), [False, True])


def test_two_thrusters_need_one_over_root_two():
    area = AUTOSUB.area
    assert tt.hover_power(105.9, area, 1026.0, 2) / tt.hover_power(105.9, area, 1026.0) == pytest.approx(2**-0.5)
    smaller = tt.TunnelThruster(0.196 / 2**0.5, 0.9, 6.69).area
    assert tt.hover_power(105.9, smaller, 1026.0, 2) == pytest.approx(tt.hover_power(105.9, area, 1026.0))


def test_an_ideal_thruster_pays_for_the_kinetic_energy_of_its_jet():
    area, density, jet = 0.03, 1026.0, 1.8
    through = density * area * jet
    assert tt.thruster_power(through * jet, area, density, 1.0) == pytest.approx(0.5 * through * jet**2)


def test_a_real_thruster_gives_its_share_of_the_ideal_force_for_the_same_power():
    ideal = tt.thruster_power(100.0, 0.03, 1026.0, 1.0)
    assert tt.thruster_power(55.0, 0.03, 1026.0, 0.55) == pytest.approx(ideal)
