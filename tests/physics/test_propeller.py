"""The propeller: closed forms, symmetry and energy, and the constants that Blanke et al. print."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from missionplan.physics import propeller as p
from tests.physics import propeller_example as example

TURN = 2.0 * math.pi
PRESETS = [example.table_1("surge"), example.table_1("momentum"), example.as_printed()]
shaft_rates = st.floats(-200.0, 200.0)
flows = st.floats(-5.0, 5.0)


def test_constants_of_table_2_in_revolutions():
    table_1 = example.table_1()
    assert table_1.thrust_nn * TURN**2 == pytest.approx(3.5228, abs=5e-5)
    assert table_1.torque_nn * TURN**2 == pytest.approx(0.15592, abs=5e-6)
    assert table_1.thrust_nu * TURN == pytest.approx(-20.889, abs=5e-4)
    assert table_1.torque_nu * TURN == pytest.approx(-0.8050, abs=5e-5)
    assert table_1.flow_mass == pytest.approx(21.74, abs=5e-3)


def test_printed_axial_constants_are_those_of_another_axial_factor():
    unit = p.from_open_water(0.30, (0.4243, -0.9435), (0.0626, -0.1212), density=1025.0, axial_flow_factor=0.1)
    assert unit.thrust_nu == pytest.approx(example.as_printed().thrust_nu, rel=2e-4)
    assert unit.torque_nu == pytest.approx(example.as_printed().torque_nu, rel=2e-4)


def test_constants_in_radians():
    table_1 = example.table_1()
    assert table_1.thrust_nn == pytest.approx(0.08923, abs=5e-6)
    assert table_1.torque_nn == pytest.approx(0.003950, abs=5e-7)
    assert 1.25 * table_1.thrust_nu == pytest.approx(-4.1558, abs=5e-5)


def test_the_two_dampings_disagree_for_table_1_and_agree_near_26_kg_m():
    factors = {"axial_flow_factor": 0.25, "wake_fraction": 0.2, "thrust_deduction": 0.1}
    assert example.table_1("surge").flow_damping_quadratic == pytest.approx(2777.8, abs=0.05)
    assert example.table_1("momentum").flow_damping_quadratic == pytest.approx(144.9, abs=0.05)
    assert example.surge_flow_damping(0.2, 26.08, **factors)[1] == pytest.approx(144.9, rel=1e-3)


def test_open_water_lines_come_back():
    advance = np.linspace(0.0, 0.6, 7)
    np.testing.assert_allclose(
        example.thrust_coefficient(example.table_1(), advance, 1025.0), 0.4243 - 0.9435 * advance, atol=1e-12
    )
    np.testing.assert_allclose(
        example.torque_coefficient(example.table_1(), advance, 1025.0), 0.0626 - 0.1212 * advance, atol=1e-12
    )


def test_open_water_efficiency_stays_below_one_while_the_propeller_drives():
    advance = np.linspace(0.0, 0.4243 / 0.9435, 50)
    efficiency = example.open_water_efficiency(example.table_1(), advance, 1025.0)
    assert np.all((efficiency >= -1e-12) & (efficiency < 0.5))


@pytest.mark.parametrize("propeller", PRESETS)
@given(shaft_rate=shaft_rates, flow=flows)
def test_ahead_and_astern_mirror_each_other(propeller, shaft_rate, flow):
    assert p.thrust(propeller, -shaft_rate, -flow) == -p.thrust(propeller, shaft_rate, flow)
    assert p.torque(propeller, -shaft_rate, -flow) == -p.torque(propeller, shaft_rate, flow)


@pytest.mark.parametrize("propeller", PRESETS)
@given(shaft_rate=shaft_rates, flow=flows)
def test_the_blades_generate_no_energy(propeller, shaft_rate, flow):
    shaft, water = p.torque(propeller, shaft_rate, flow) * shaft_rate, p.thrust(propeller, shaft_rate, flow) * flow
    assert shaft - water >= -1e-9 * (abs(shaft) + abs(water))


@pytest.mark.parametrize("propeller", PRESETS)
@given(shaft_rate=st.floats(0.5, 200.0), speed=st.floats(0.0, 3.0), sign=st.sampled_from([-1.0, 1.0]))
def test_steady_flow_does_not_accelerate(propeller, shaft_rate, speed, sign):
    flow = p.steady_axial_flow(propeller, sign * shaft_rate, sign * speed)
    size = abs(p.thrust(propeller, shaft_rate, 0.0)) + propeller.flow_damping_quadratic * flow**2
    assert flow * sign > 0.0
    residual = p.flow_acceleration(propeller, sign * shaft_rate, flow, sign * speed) * propeller.flow_mass
    assert abs(residual) <= 1e-9 * size


def test_the_water_set_in_motion_is_a_cylinder_as_long_as_wide():
    unit = p.from_open_water(0.5, (0.4, -0.4), (0.05, -0.05), density=1000.0)
    assert unit.flow_mass == pytest.approx(1000.0 * math.pi * 0.25**2 * 0.5)
