"""Covariance of a dive's readings: sensor, turbulence, scatter from dive to dive, and error of a cause's shape."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from missionplan.arrays import Array

DIVE_SD = {"release": 0.1, "zero": 0.05, "drag": 0.025, "weight": 0.012}
"""Scatter from dive to dive: release delay [s], zero of the depth [m], drag and wet weight, of themselves."""
SCATTER_FACTORS = (0.5, 1.0, 2.0)
"""Factors κ on that scatter over which the evidence is averaged; log-normal about 1."""
SCATTER_LOG_SD = 0.45
DIFFUSION_RATES = (4e-5, 3e-4, 2e-3)
"""Long-run rates q of the depth's variance due to turbulence [m²/s], 2σ²τ for velocities σ of time scale τ; log-normal
about a median."""
DIFFUSION_MEDIAN, DIFFUSION_LOG_SD = 3e-4, 1.3
EDDY_TIMES = (1.0, 4.0)
"""Time scales τ of the turbulent velocity [s]: eddies of a vehicle's length, and of several."""
NOMINAL_EDDY_TIME = 2.0
SHAPE_SD = 0.02
"""Standard deviation of the smooth factor by which a cause's true shape differs from the catalogue's."""
SHAPE_LENGTH = 0.25
"""Its correlation length, of a dive's duration."""
FORM_SD = SHAPE_SD
"""Standard deviation of the part that all dives share, in the strength of any cause whose form no law gives."""


@dataclass(frozen=True)
class Noise:
    """Hyperparameters of the covariance, a point of the grid."""

    scatter: float
    """Factor κ on the scatter from dive to dive."""
    diffusion: float
    """Rate q of the turbulence [m²/s]."""
    eddy_time: float
    """Time scale τ of the turbulence [s]."""
    log_prior: float
    """Log prior weight."""


@cache
def noise_grid() -> tuple[Noise, ...]:
    """Grid of hyperparameters with normalised prior weights; all eddy times weigh the same."""
    points = list(itertools.product(SCATTER_FACTORS, DIFFUSION_RATES, EDDY_TIMES))
    logs = np.array(
        [
            -0.5 * (np.log(scatter) / SCATTER_LOG_SD) ** 2
            - 0.5 * (np.log(diffusion / DIFFUSION_MEDIAN) / DIFFUSION_LOG_SD) ** 2
            for scatter, diffusion, _ in points
        ]
    )
    logs -= np.logaddexp.reduce(logs)
    return tuple(Noise(*point, float(log)) for point, log in zip(points, logs, strict=True))


NOMINAL_NOISE = Noise(1.0, DIFFUSION_MEDIAN, NOMINAL_EDDY_TIME, 0.0)
"""In the middle of the grid, for the search."""


def sensor_and_turbulence_covariance(t: Array, sd: Array, noises: Sequence[Noise]) -> Array:
    """σ²I + q·(turbulence), which no model of the dive changes, at each of g noises, shape (g, m, m) [m²].

    `t`, `sd`, shape (m,): times [s] and the sensor's standard deviations [m].
    """
    since = t - min(0.0, float(t.min()))
    turbulence = {time: integrated_velocity_covariance(since, time) for time in {noise.eddy_time for noise in noises}}
    return np.stack([np.diag(sd**2) + noise.diffusion * turbulence[noise.eddy_time] for noise in noises])


def integrated_velocity_covariance(t: Array, eddy_time: float) -> Array:
    """Covariance of the depth due to turbulence, for a long-run rate of 1 m²/s, shape (m, m) [m²].

    The integral of an Ornstein–Uhlenbeck velocity with time scale τ (Taylor 1921; Uhlenbeck & Ornstein 1930):
    min(t, t′) − ½τ(1 − e^(−t/τ) − e^(−t′/τ) + e^(−|t − t′|/τ)), a random walk for τ → 0.

    `t`, shape (m,): times since the separation [s]. `eddy_time`: τ [s].
    """
    faded = np.exp(-t / eddy_time)
    apart = np.exp(-np.abs(t[:, None] - t[None, :]) / eddy_time)
    decay = 1.0 - faded[:, None] - faded[None, :] + apart
    return np.asarray(np.minimum(t[:, None], t[None, :]) - 0.5 * eddy_time * decay)


def dive_to_dive_covariance(sensitivities: Array, curvature: Array, noises: Sequence[Noise]) -> Array:
    """κ²(J S Jᵀ + diag(c²)) at each of g noises, shape (g, m, m) [m²].

    Random effects of each dive (Laird & Ware 1982), to first order, with the second-order term c of the release delay.

    `sensitivities`, shape (m, 4): J, of the readings to what `DIVE_SD` lists, in its order. `curvature`, shape (m,): c
    [m].
    """
    scaled = sensitivities * np.array(list(DIVE_SD.values()))
    scatter = np.array([noise.scatter for noise in noises])
    return np.asarray(scatter[:, None, None] ** 2 * (scaled @ scaled.T + np.diag(curvature**2)))


def shape_error_covariance(t: Array, added: Array) -> Array:
    """SHAPE_SD²·g(t)·g(t′)·exp(−½(Δt/ℓ)²), shape (m, m) [m²].

    Model discrepancy (Kennedy & O'Hagan 2001) in proportion to what a cause adds to the readings, g, with a
    squared-exponential correlation (Rasmussen & Williams 2006, Eq. 4.9).

    `t`, `added`, shape (m,): times [s] and g [m].
    """
    length = SHAPE_LENGTH * max(float(np.ptp(t)), 1e-9)
    kernel = np.exp(-0.5 * ((t[:, None] - t[None, :]) / length) ** 2)
    return np.asarray(SHAPE_SD**2 * added[:, None] * added[None, :] * kernel)
