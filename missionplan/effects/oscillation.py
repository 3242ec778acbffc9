"""Oscillating currents: their mean over a leg, their slow modulation, and the frequency of the inertial one."""

from abc import abstractmethod
from typing import Self

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.effects.info import Parameter
from missionplan.phases.hooks import Leg, TransitEffect

EARTH_ROTATION = 7.2921159e-5
"""Angular velocity of the Earth [rad/s]."""

MODULATION, COHERENCE_TIME = "modulation", "coherence_time"
"""Parameters of an oscillation whose amplitude and phase change slowly."""
USUAL_TIME = 432000.0
"""Usual coherence time: the passage of weather, a third of the spring–neap cycle [s]."""
MODULATION_PARAMETERS = {
    MODULATION: Parameter(
        "",
        "standard deviation of slow changes, in phase and a quarter of a period off, relative to the amplitude",
        0.0,
        2.0,
        median=0.3,
        factor=2.0,
    ),
    COHERENCE_TIME: Parameter(
        "s", "e-folding time of these changes", 3600.0, 1e8, median=USUAL_TIME, factor=2.0, default=USUAL_TIME
    ),
}
"""The same for every oscillation."""


class Oscillation(TransitEffect):
    """An oscillating current w(t) that may be modulated: Re((1 + ε(t))·w(t)).

    ε is complex, its parts are independent Ornstein–Uhlenbeck processes of standard deviation `modulation` and
    correlation time `coherence_time`, the same for all constituents and both components.
    """

    modulation: Scalars
    coherence_time: Scalars

    @abstractmethod
    def later(self) -> Self:
        """Return the same oscillation a quarter of a period later."""

    @property
    def is_random(self) -> bool:
        """It needs standard normals for each leg where it is modulated."""
        return bool(np.any(np.asarray(self.modulation) > 0.0))

    def step(
        self, memory: Array | None, elapsed: Array, normals: Array, leg: Leg
    ) -> tuple[Array | None, Array | float]:
        """Advance ε by the exact transition of the process; return what it adds to the mean velocity of the leg."""
        if not self.is_random:
            return None, 0.0
        if memory is None:
            change = self.modulation * normals
        else:
            kept = np.exp(-elapsed / self.coherence_time)
            change = kept * memory + self.modulation * np.sqrt(1.0 - kept**2) * normals
        return change, change[0] * self.velocity(leg) - change[1] * self.later().velocity(leg)


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
    frequency : float
        Angular frequency ω [rad/s].

    Returns
    -------
    cosine, sine : array, shape (n,)
    """
    middle = leg.t_start + 0.5 * leg.duration
    damping = np.sinc(frequency * leg.duration / (2.0 * np.pi))
    return damping * np.cos(frequency * middle), damping * np.sin(frequency * middle)


def wave(cosine: Array, sine: Array, amplitude: Scalars, phase: Scalars) -> Array:
    """``amplitude·cos(ωt − phase)`` from the means of cos ωt and sin ωt."""
    return amplitude * (np.cos(phase) * cosine + np.sin(phase) * sine)
