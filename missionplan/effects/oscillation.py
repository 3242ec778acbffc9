"""Mean of an oscillation over a leg, for the tidal and the inertial current."""

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.phases.hooks import Leg


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
