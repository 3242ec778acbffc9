"""Oscillating currents: their mean over a leg, and the frequency of the inertial one."""

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.phases.hooks import Leg

EARTH_ROTATION = 7.2921159e-5
"""Angular velocity of the Earth [rad/s]."""


def inertial_frequency(latitude: float) -> float:
    """Return the angular frequency f = 2Ω sin(latitude) at which an inertial current turns [rad/s]."""
    return 2.0 * EARTH_ROTATION * float(np.sin(latitude))


def polar(amplitude: Scalars, phase: Scalars) -> tuple[Array, Array]:
    """Return ``amplitude·cos(ωt − phase)`` as coefficients of cos ωt and sin ωt."""
    return np.asarray(amplitude * np.cos(phase)), np.asarray(amplitude * np.sin(phase))


def mean_phasor(leg: Leg, frequency: float) -> tuple[Array, Array]:
    """Mean of cos ωt and sin ωt over each leg.

    The mean over a leg of duration T about its middle t is the value there times sin(ωT/2)/(ωT/2).

    Parameters
    ----------
    leg : Leg
        Legs.
    frequency : float
        Angular frequency ω [rad/s].

    Returns
    -------
    cosine, sine : array, shape (n,)
        Means.
    """
    middle = leg.t_start + 0.5 * leg.duration
    damping = np.sinc(frequency * leg.duration / (2.0 * np.pi))
    return damping * np.cos(frequency * middle), damping * np.sin(frequency * middle)


def wave(cosine: Array, sine: Array, amplitude: Scalars, phase: Scalars) -> Array:
    """``amplitude·cos(ωt − phase)`` from the means of cos ωt and sin ωt."""
    return amplitude * (np.cos(phase) * cosine + np.sin(phase) * sine)
