"""Slow modulation of an oscillating current."""

import numpy as np

from missionplan.diagnosis.legs.modulation import COHERENCE_TIME, RELATIVE_SD, modulation, smooth_functions

T = np.linspace(0.0, 20.0 * 86400.0, 90)


def test_functions_have_the_squared_exponential_covariance():
    functions = smooth_functions(T)
    expected = np.exp(-0.5 * ((T[:, None] - T) / COHERENCE_TIME) ** 2)
    np.testing.assert_allclose(functions @ functions.T, expected, atol=0.02)


def test_a_short_record_needs_few_functions():
    assert smooth_functions(T[:5]).shape[1] < smooth_functions(T).shape[1]


def test_modulation_is_as_large_in_phase_as_in_quadrature():
    """Variance of Re(ε·w): `RELATIVE_SD`² of the squared amplitude, at any moment of the oscillation."""
    phase = 2.0 * np.pi * T / 45000.0
    swirl = 0.1 * np.stack([np.cos(phase), -np.sin(phase)])
    later = 0.1 * np.stack([np.sin(phase), np.cos(phase)])
    variance = np.sum(modulation(T, swirl, later) ** 2, axis=2)
    np.testing.assert_allclose(variance, (RELATIVE_SD * 0.1) ** 2, rtol=0.05)
