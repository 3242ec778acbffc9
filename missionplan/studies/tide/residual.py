"""What a harmonic analysis leaves: an Ornstein–Uhlenbeck process in each component, its spread and coherence time."""

import math
from dataclasses import dataclass

import numpy as np
import scipy

from missionplan.arrays import Array

_LEAST_SAMPLES = 10


@dataclass(frozen=True)
class ResidualProcess:
    """An Ornstein–Uhlenbeck process.

    Attributes
    ----------
    sd : float
        Of one component [m/s].
    time : float
        After which the correlation has fallen to 1/e [s].
    """

    sd: float
    time: float

    def density(self, frequency: float) -> float:
        """Two-sided spectral density at an angular frequency [m²/s]: 2σ²τ/(1 + ω²τ²)."""
        return 2.0 * self.sd**2 * self.time / (1.0 + (frequency * self.time) ** 2)


def fit_residual(time: Array, east: Array, north: Array) -> ResidualProcess:
    """Fit the process by maximum likelihood, exactly for samples at any times.

    Parameters
    ----------
    time : array, shape (k,)
        Increasing, of the samples that are there [s].
    east, north : array, shape (k,)
        Residuals [m/s].
    """
    values = np.stack((east, north))
    spread = math.sqrt(float(np.mean(values**2)))
    if len(time) < _LEAST_SAMPLES or spread == 0.0:
        return ResidualProcess(spread, 0.0)
    steps = np.diff(time)
    shortest, longest = 0.05 * float(np.median(steps)), 0.5 * float(time[-1] - time[0])
    found = scipy.optimize.minimize_scalar(
        lambda log_time: _misfit(steps, values, math.exp(log_time))[0],
        bounds=(math.log(shortest), math.log(longest)),
        method="bounded",
    )
    lasting = math.exp(float(found.x))
    return ResidualProcess(math.sqrt(_misfit(steps, values, lasting)[1]), lasting)


def _misfit(steps: Array, values: Array, lasting: float) -> tuple[float, float]:
    """Minus twice the log-likelihood, the variance profiled out, and that variance."""
    correlation = np.exp(-steps / lasting)
    left = -np.expm1(-2.0 * steps / lasting)
    innovations = (values[:, 1:] - correlation * values[:, :-1]) ** 2 / left
    count = values.size
    variance = float(np.sum(innovations) + np.sum(values[:, 0] ** 2)) / count
    return count * math.log(variance) + len(values) * float(np.sum(np.log(left))), variance
