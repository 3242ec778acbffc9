"""Palmer, Hearn & Stevenson (2009): statements of the text on forward and aft tunnel thrusters."""

import pytest
from scipy.optimize import brentq

from missionplan.physics import tunnel_thruster as tt


def test_aft_moment_changes_sign_near_one_half():
    """c = 3 and a constant centre of suction at 1.9 x_T."""
    crossing = brentq(lambda ratio: tt.moment_factor(tt.force_factor(ratio, 3.0), 1.9), 0.1, 1.0)
    assert crossing == pytest.approx(0.5, abs=0.01)


def test_forward_force_falls_faster_than_aft():
    assert tt.force_factor(0.4, 7.0) < tt.force_factor(0.4, 3.0)


def test_centre_of_suction_moves_aft_on_the_forward_thruster_only():
    forward = tt.TunnelThruster(0.07, 0.02, 7.0, position=0.8, suction_gradient=10.0)
    aft = tt.TunnelThruster(0.07, 0.02, 3.0, position=-0.8, suction_offset=0.72)
    assert tt.suction_centre(forward, 0.0) == 0.8
    assert tt.suction_centre(forward, 0.6) < tt.suction_centre(forward, 0.2)
    assert tt.suction_centre(aft, 0.2) == tt.suction_centre(aft, 0.6) == pytest.approx(1.9 * -0.8)


def test_forward_moment_is_lost_less_than_force():
    """Fig. 8: suction moves towards the pivot, so 'limited reduction in moment'."""
    forward = tt.TunnelThruster(0.07, 0.02, 7.0, position=0.8, suction_gradient=10.0)
    ratio = 0.4
    factor = tt.force_factor(ratio, 7.0)
    assert tt.moment_factor(factor, tt.suction_centre(forward, ratio) / 0.8) > factor


def test_hover_of_autosub():
    """Second paper: 105.9 N at K_3 = 0.90 is 10.85 rev/s; Eq. 13 gives about 240 W in a tunnel of 0.196 m."""
    assert tt.revolutions_for(0.90, 105.9) == pytest.approx(10.85, abs=0.005)
    assert tt.thruster_power(105.9, tt.TunnelThruster(0.196, 0.9, 6.69).area, 1026.0) == pytest.approx(240.0, abs=2.0)
