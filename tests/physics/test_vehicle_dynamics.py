"""Motion in the vertical plane: conservation, trim, and the propeller's limits."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from missionplan.physics import vehicle_dynamics as vd

IDEAL = vd.Derivatives(x_udot=-0.0006, z_wdot=-0.02, m_qdot=-0.0009, x_wq=-0.02, z_uq=0.0006, m_uw=0.0194)
"""Kirchhoff's added inertia of a body without lift or friction: X_wq = Z_ẇ, Z_uq = -X_u̇, M_uw = X_u̇ - Z_ẇ."""
BODY = vd.Body(7.0, 3600.0, 8966.0, 105.9, 0.0, 0.018, 1026.0, IDEAL)


def motion(*values):
    return vd.Motion(*(np.atleast_1d(np.asarray(value, dtype=float)) for value in values))


def total(body, now, plane=0.0):
    return vd.hydrodynamic_load(body, now, plane) + vd.hydrostatic_load(body, now.pitch) + vd.rigid_body_load(body, now)


@given(u=st.floats(-2, 2), w=st.floats(-1, 1), q=st.floats(-0.5, 0.5), pitch=st.floats(-1, 1))
def test_ideal_flow_neither_gives_nor_takes_energy(u, w, q, pitch):
    """Kinetic energy of body and water grows by what buoyancy and weight do, and by nothing else."""
    now = motion(u, w, q, pitch)
    du, dw, dq = vd.accelerations(vd.inverse_inertia(BODY), total(BODY, now))
    d, m = IDEAL, BODY.mass
    a11, a33, a55 = m - BODY.scale(3) * d.x_udot, m - BODY.scale(3) * d.z_wdot, BODY.inertia - BODY.scale(5) * d.m_qdot
    kinetic = a11 * u * du + a33 * w * dw + a55 * q * dq + m * BODY.z_g * (du * q + u * dq)
    static = vd.hydrostatic_load(BODY, now.pitch)
    work = static.x * u + static.z * w + static.m * q
    assert kinetic[0] == pytest.approx(work[0], abs=1e-6 * (1.0 + abs(work[0]) + a33))


def test_inverse_inertia_is_the_inverse_for_every_trial():
    body = replace(BODY, x_g=np.array([-0.01, 0.0, 0.02]))
    inverse = vd.inverse_inertia(body)
    assert inverse.shape == (3, 3, 3)
    np.testing.assert_allclose(inverse[..., 1:2], vd.inverse_inertia(replace(BODY, x_g=np.array([0.0]))), rtol=1e-12)


def test_buoyancy_lifts_and_gravity_rights():
    load = vd.hydrostatic_load(BODY, np.array([0.0, 0.2]))
    assert load.z[0] == -105.9
    assert load.m[0] == 0.0
    assert load.m[1] < 0.0
    assert load.x[1] > 0.0


LIFTING = vd.Derivatives(x_uu=-0.0025, z_uw=-0.015, z_ww=-0.03, m_uw=0.005, z_uud=-0.0027, m_uud=-0.0013)


@given(speed=st.floats(0.8, 2.0), excess=st.floats(20.0, 200.0))
def test_trim_is_an_equilibrium(speed, excess):
    body = replace(BODY, derivatives=LIFTING, excess_buoyancy=excess, z_g=0.02)
    trim = vd.level_trim(body, speed)
    now = motion(speed, speed * np.tan(trim.pitch), 0.0, trim.pitch)
    load = vd.hydrodynamic_load(body, now, trim.sternplane) + vd.hydrostatic_load(body, now.pitch)
    assert abs(float(load.z[0])) < 1e-5 * excess
    assert abs(float(load.m[0])) < 1e-4 * excess
    assert vd.depth_rate(now) == pytest.approx(0.0, abs=1e-12)
    assert trim.pitch < 0.0


@given(speed=st.floats(0.1, 3.0))
def test_propeller_holds_the_speed_commanded(speed):
    body = replace(BODY, derivatives=LIFTING)
    at = np.array([speed])
    drag = vd.hydrodynamic_load(body, motion(speed, 0, 0, 0), 0.0).x
    assert vd.propeller_force(body, (0.0, -0.0075, 0.01), at, at) == pytest.approx(-drag)


@given(speed=st.floats(-2, 2), command=st.floats(-2, 2))
def test_propeller_is_odd_and_finite_at_rest(speed, command):
    force, mirrored = (
        vd.propeller_force(BODY, (0.0, -0.0075, 0.01), np.array([s * speed]), np.array([s * command])) for s in (1, -1)
    )
    assert force == pytest.approx(-mirrored)
    assert np.isfinite(vd.propeller_force(BODY, (0.0, -0.0075, 0.01), np.zeros(1), np.zeros(1)))


def test_printed_propeller_for_motion_ahead():
    """Eq. 3 with n' = u_req/u."""
    b, u, required = (0.001, -0.0075, 0.009), np.array([1.2]), np.array([0.9])
    ratio = required / u
    printed = 0.5 * 1026.0 * 49.0 * u * np.abs(u) * (b[0] + b[1] * ratio + b[2] * ratio**2)
    np.testing.assert_allclose(vd.propeller_force(BODY, b, u, required), printed)
