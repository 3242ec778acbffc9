"""Drag coefficients, scaling and speed under thrust: definitions against each other."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from missionplan.physics import tank
from missionplan.physics.drag import drag_force
from tests.physics import avila_example as avila

positive = st.floats(0.01, 100.0)


@given(speed=positive, coefficient=positive, area=positive)
def test_coefficient_inverts_the_force(speed, coefficient, area):
    force = drag_force(speed, coefficient, area, 1000.0)
    assert tank.drag_coefficient(force, speed, area, 1000.0) == pytest.approx(coefficient)


@given(thrust=positive, efficiency=st.floats(0.1, 1.0), coefficient=positive, area=positive)
def test_thrust_balances_drag_at_top_speed(thrust, efficiency, coefficient, area):
    speed = avila.top_speed(thrust, efficiency, coefficient, area, 1000.0)
    assert drag_force(speed, coefficient, area, 1000.0) == pytest.approx(efficiency * thrust)


def test_a_body_scales_with_its_volume():
    assert avila.characteristic_area(8.0) == pytest.approx(avila.characteristic_length(8.0) ** 2) == pytest.approx(4.0)
    assert tank.full_size_mass(10.0, 2.0) == pytest.approx(80.0)


def test_drag_coefficient_at_its_reynolds_number_is_the_constant():
    assert tank.reynolds_drag_coefficient(1e5, 2.2, -0.3, 1e5) == 2.2
    assert tank.reynolds_drag_coefficient(4e5, 2.0, -0.5, 1e5) == pytest.approx(1.0)


def test_step_response_solves_the_equation_of_motion():
    mass, thrust, area, coefficient = 500.0, 370.0, 0.33, 2.24
    speed = avila.top_speed(thrust, 1.0, coefficient, area, 1000.0)
    time = np.linspace(0.0, 8.0, 4001)
    response = avila.step_response(time, speed, thrust, mass)
    acceleration = np.gradient(response, time)[1:-1]
    balance = thrust - drag_force(response, coefficient, area, 1000.0)
    np.testing.assert_allclose(mass * acceleration, balance[1:-1], atol=1e-3 * thrust)
    assert response[0] == 0.0
    assert response[-1] == pytest.approx(speed, rel=1e-4)
