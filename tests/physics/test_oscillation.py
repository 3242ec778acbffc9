"""Free oscillation: frequency and added mass, and the decay against its closed forms."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from missionplan.physics import tank as osc


@given(stiffness=st.floats(10.0, 1e5), mass=st.floats(0.1, 1e3), added=st.floats(0.0, 1e3))
def test_added_mass_comes_back_from_its_frequency(stiffness, mass, added):
    frequency = osc.natural_frequency(stiffness, mass + added)
    assert osc.added_mass(frequency, stiffness, mass) == pytest.approx(added, abs=1e-9 * (mass + added))


def test_error_of_added_mass_is_its_slope_in_frequency():
    step = 1e-6
    slope = (osc.added_mass(1.7 + step, 4000.0, 24.0) - osc.added_mass(1.7 - step, 4000.0, 24.0)) / (2 * step)
    assert osc.added_mass_sd(1.7, 0.01, 4000.0) == pytest.approx(-0.01 * slope, rel=1e-6)


@pytest.mark.parametrize("rate", [0.0, 0.4, 9.0, 2 * np.pi * 1.7, 14.0], ids=lambda rate: f"{rate:.3g}")
def test_linear_damping_is_exact_below_and_above_critical(rate):
    time = np.linspace(0.0, 6.0, 97) ** 1.5
    root = np.sqrt(complex(rate**2 - (2 * np.pi * 1.7) ** 2))
    if root == 0.0:
        exact = 0.05 * np.exp(-rate * time) * (1.0 + rate * time)
    else:
        slow, fast = (root + rate) * np.exp((root - rate) * time), (root - rate) * np.exp((-root - rate) * time)
        exact = 0.05 * ((slow + fast) / (2.0 * root)).real
    np.testing.assert_allclose(osc.displacement(time, 0.05, 0.0, 1.7, rate, 0.0), exact, atol=1e-10)


@pytest.mark.parametrize(
    ("rate", "quadratic", "share"), [(0.05, 0.5, 1e-5), (0.05, 2.0, 2e-5), (0.4, 2.0, 2e-5), (0.2, 20.0, 3e-4)]
)
def test_both_dampings_agree_with_a_fine_integration(rate, quadratic, share):
    time = np.sort(np.random.default_rng(8).uniform(0.0, 7.0, 200))
    square = (2 * np.pi * 1.7) ** 2

    def motion(t, state):
        x, v = state
        return v, -square * x - (2.0 * rate + quadratic * abs(v)) * v

    exact = solve_ivp(motion, time[[0, -1]], (0.05, 0.1), "DOP853", time, rtol=1e-9, atol=1e-11, max_step=0.05).y[0]
    found = osc.displacement(time, 0.05, 0.1, 1.7, rate, quadratic)
    np.testing.assert_allclose(found, exact, atol=share * 0.05)


def envelope(time: np.ndarray, amplitude: float, frequency: float, linear: float, quadratic: float) -> np.ndarray:
    """Amplitude of a lightly damped oscillation, averaged over its periods (Krylov and Bogoliubov) [m].

    dA/dt = -δA - 4βωA²/3π, so A = A₀e^(-δt)/(1 + g(1 - e^(-δt))/δ) with g = 4βωA₀/3π.

    Parameters
    ----------
    time : array
        Since the start [s].
    amplitude : float or array
        A₀ [m].
    frequency, linear, quadratic : float or array
        As in `displacement`.
    """
    rate = 8.0 / 3.0 * quadratic * frequency * amplitude
    product = np.asarray(linear * time)
    decayed = np.where(np.abs(product) > 1e-9, -np.expm1(-product) / np.where(product == 0.0, 1.0, product), 1.0) * time
    return amplitude * np.exp(-product) / (1.0 + rate * decayed)


def test_amplitude_follows_the_averaged_envelope():
    time = np.linspace(0.0, 8.0, 1601)
    record = osc.displacement(time, 0.05, 0.0, 1.7, 0.05, 1.5)
    peaks = np.flatnonzero((record[1:-1] > record[:-2]) & (record[1:-1] >= record[2:])) + 1
    np.testing.assert_allclose(record[peaks], envelope(time[peaks], 0.05, 1.7, 0.05, 1.5), rtol=0.02)


def test_envelope_without_linear_damping_is_hyperbolic():
    time = np.linspace(0.0, 8.0, 9)
    expected = 0.05 / (1.0 + 8.0 / 3.0 * 1.5 * 1.7 * 0.05 * time)
    np.testing.assert_allclose(envelope(time, 0.05, 1.7, 0.0, 1.5), expected)
    np.testing.assert_allclose(envelope(time, 0.05, 1.7, 1e-7, 1.5), expected, rtol=1e-5)


def test_undamped_energy_is_kept():
    time = np.linspace(0.0, 50.0, 501)
    record = osc.displacement(time, 0.05, 0.0, 1.0, 0.0, 0.0)
    np.testing.assert_allclose(record[::10], 0.05, rtol=1e-9)


def test_columns_are_independent_oscillations():
    time = np.linspace(0.0, 2.0, 41)
    both = osc.displacement(time, np.array([0.05, 0.02]), 0.0, 1.7, 0.1, np.array([0.0, 2.0]))
    np.testing.assert_allclose(both[:, 1], osc.displacement(time, 0.02, 0.0, 1.7, 0.1, 2.0))


@given(quadratic=st.floats(0.0, 100.0), rate=st.floats(0.0, 20.0), velocity=st.floats(-3.0, 3.0))
def test_energy_never_grows(quadratic, rate, velocity):
    time = np.linspace(0.0, 4.0, 60)
    record = osc.displacement(time, 0.05, velocity, 1.7, rate, quadratic)
    most = np.hypot(0.05, velocity / (2 * np.pi * 1.7))
    assert np.all(np.abs(record) <= most * (1.0 + 1e-9))


def test_one_sample_is_the_start():
    assert osc.displacement(np.array([3.0]), 0.05, 0.2, 1.7, 0.1, 1.0).tolist() == [0.05]
