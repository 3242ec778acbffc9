"""Free oscillation: frequency and added mass, and the decay against its closed forms."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from missionplan.physics import oscillation as osc


@given(stiffness=st.floats(10.0, 1e5), mass=st.floats(0.1, 1e3), added=st.floats(0.0, 1e3))
def test_added_mass_comes_back_from_its_frequency(stiffness, mass, added):
    frequency = osc.natural_frequency(stiffness, mass + added)
    assert osc.added_mass(frequency, stiffness, mass) == pytest.approx(added, abs=1e-9 * (mass + added))


def test_error_of_added_mass_is_its_slope_in_frequency():
    step = 1e-6
    slope = (osc.added_mass(1.7 + step, 4000.0, 24.0) - osc.added_mass(1.7 - step, 4000.0, 24.0)) / (2 * step)
    assert osc.added_mass_sd(1.7, 0.01, 4000.0) == pytest.approx(-0.01 * slope, rel=1e-6)


def test_linear_damping_is_the_damped_cosine():
    time = np.linspace(0.0, 6.0, 241)
    rate, frequency = 0.4, 1.7
    damped = np.sqrt((2 * np.pi * frequency) ** 2 - rate**2)
    exact = 0.05 * np.exp(-rate * time) * (np.cos(damped * time) + rate / damped * np.sin(damped * time))
    np.testing.assert_allclose(osc.displacement(time, 0.05, 0.0, frequency, rate, 0.0), exact, atol=1e-6 * 0.05 * 10)


def test_amplitude_follows_the_averaged_envelope():
    time = np.linspace(0.0, 8.0, 1601)
    record = osc.displacement(time, 0.05, 0.0, 1.7, 0.05, 1.5)
    peaks = np.flatnonzero((record[1:-1] > record[:-2]) & (record[1:-1] >= record[2:])) + 1
    np.testing.assert_allclose(record[peaks], osc.envelope(time[peaks], 0.05, 1.7, 0.05, 1.5), rtol=0.02)


def test_envelope_without_linear_damping_is_hyperbolic():
    time = np.linspace(0.0, 8.0, 9)
    expected = 0.05 / (1.0 + 8.0 / 3.0 * 1.5 * 1.7 * 0.05 * time)
    np.testing.assert_allclose(osc.envelope(time, 0.05, 1.7, 0.0, 1.5), expected)
    np.testing.assert_allclose(osc.envelope(time, 0.05, 1.7, 1e-7, 1.5), expected, rtol=1e-5)


def test_undamped_energy_is_kept():
    time = np.linspace(0.0, 50.0, 501)
    record = osc.displacement(time, 0.05, 0.0, 1.0, 0.0, 0.0)
    np.testing.assert_allclose(record[::10], 0.05, rtol=1e-4)


def test_columns_are_independent_oscillations():
    time = np.linspace(0.0, 2.0, 41)
    both = osc.displacement(time, np.array([0.05, 0.02]), 0.0, 1.7, 0.1, np.array([0.0, 2.0]))
    np.testing.assert_allclose(both[:, 1], osc.displacement(time, 0.02, 0.0, 1.7, 0.1, 2.0))
