"""Slow modulation of oscillating currents: amplitude and phase that change over days.

Unresolved neighbours of a tidal constituent (springs and neaps, N2 beside M2), a frequency a little above the inertial
one (Kunze 1985: the vorticity of the flow about it shifts it by some per cent), gusts and decay: all of them multiply
the oscillation by 1 + ε(t), with ε complex and slow (as in complex demodulation, Emery & Thomson 2001). ε has
a squared-exponential covariance and is part of the effect's uncertainty, as a smooth factor is in dives.
"""

import math

import numpy as np

from missionplan.arrays import Array

RELATIVE_SD = 0.3
"""Standard deviation of the real and of the imaginary part of ε."""
COHERENCE_TIME = 3.0 * 86400.0
"""Correlation length ℓ of ε: the passage of weather, a fifth of the spring–neap cycle [s]."""
MARGIN = 1.5
"""How far beyond the record the functions' domain reaches, in ℓ, at either end."""
MAX_RADIANS = 3.0
"""Functions of more than this many radians in ℓ have no weight (e^−4.5 of the spectral density at zero)."""


def smooth_functions(t: Array) -> Array:
    """Columns B with B Bᵀ ≈ exp(−½(Δt/ℓ)²), shape (n, m): cosines on a wider domain (Solin & Särkkä 2020, Eq. 20).

    Parameters
    ----------
    t : array, shape (n,)
        Times [s].
    """
    start, span = t.min() - MARGIN * COHERENCE_TIME, float(np.ptp(t)) + 2.0 * MARGIN * COHERENCE_TIME
    count = int(MAX_RADIANS * span / (math.pi * COHERENCE_TIME)) + 1
    frequency = math.pi * np.arange(count) / span
    density = math.sqrt(2.0 * math.pi) * COHERENCE_TIME * np.exp(-0.5 * (frequency * COHERENCE_TIME) ** 2)
    weight = np.where(np.arange(count) == 0, 1.0, 2.0) / span
    return np.asarray(np.sqrt(density * weight) * np.cos(frequency * (t - start)[:, None]))


def modulation(t: Array, in_phase: Array, in_quadrature: Array) -> Array:
    """Columns of Re(ε·w) for an oscillation Re(w), each of prior standard deviation 1, shape (2, n, 2m) [m/s].

    Parameters
    ----------
    t : array, shape (n,)
        Middles of the legs [s].
    in_phase, in_quadrature : array, shape (2, n)
        The oscillation, and the same a quarter of a period later [m/s].
    """
    functions = RELATIVE_SD * smooth_functions(t)
    return np.concatenate([part[:, :, None] * functions for part in (in_phase, in_quadrature)], axis=2)
