"""Covariance of a dive's readings: sensor, what differs from dive to dive, turbulence."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

DIVE_SD = {"release": 0.1, "zero": 0.05, "drag": 0.025, "weight": 0.012}
"""Dive-to-dive scatter: separation [s], zero of the depth [m], drag and wet weight [1]."""
SCATTERS = (0.5, 1.0, 2.0)
"""Factors κ on that scatter over which the evidence is averaged."""
SCATTER_SPREAD = 0.45
WALKS = (4e-5, 3e-4, 2e-3)
"""Rates q of the random walk of depth that turbulence gives [m²/s]: velocities of 1 to 4 cm/s for a second or two."""
WALK_CENTRE, WALK_SPREAD = 3e-4, 1.3


@dataclass(frozen=True)
class Noise:
    """Hyperparameters of the covariance: scatter κ and random-walk rate q [m²/s], with their log prior weight."""

    scatter: float
    walk: float
    log_prior: float


@cache
def grid() -> tuple[Noise, ...]:
    """Grid of hyperparameters with normalised prior weights."""
    points = list(itertools.product(SCATTERS, WALKS))
    logs = np.array(
        [
            -0.5 * (np.log(scatter) / SCATTER_SPREAD) ** 2 - 0.5 * (np.log(walk / WALK_CENTRE) / WALK_SPREAD) ** 2
            for scatter, walk in points
        ]
    )
    logs -= np.logaddexp.reduce(logs)
    return tuple(Noise(scatter, walk, float(log)) for (scatter, walk), log in zip(points, logs, strict=True))


NOMINAL = Noise(1.0, WALK_CENTRE, 0.0)
"""In the middle of the grid, for the climb."""


def dive_covariance(t: Array, sd: Array, sensitivities: Array, bend: Array, noises: Sequence[Noise]) -> Array:
    """σ²I + κ²(J S Jᵀ + bend²) + q·min(t, t′) for each of g noises, shape (g, m, m) [m²].

    Parameters
    ----------
    t, sd : array, shape (m,)
        Times [s] and the sensor's standard deviations [m].
    sensitivities : array, shape (m, 4)
        Of the readings to release, zero, drag and weight, in the order of `DIVE_SD`.
    bend : array, shape (m,)
        What the scatter of the separation does beyond the linear, where the vehicle starts with a jerk [m].
    noises : sequence of Noise, length g
        Hyperparameters.
    """
    scaled = sensitivities * np.array(list(DIVE_SD.values()))
    scattered = scaled @ scaled.T + np.diag(bend**2)
    since = t - min(0.0, float(t.min()))
    walked = np.minimum(since[:, None], since[None, :])
    scatter, walk = (
        np.array([getattr(noise, name) for noise in noises])[:, None, None] for name in ("scatter", "walk")
    )
    return np.asarray(np.diag(sd**2) + scatter**2 * scattered + walk * walked)


SHAPE_SD = 0.02
"""Standard deviation of the smooth factor by which a cause's true shape differs from the catalogue's."""
SHAPE_LENGTH = 0.25
"""Its correlation length, of a dive's duration."""


def caricature(t: Array, added: Array) -> Array:
    """Covariance of what a cause adds to the readings, shape (m, m) [m²]: SHAPE_SD²·g(t)·g(t′)·exp(−½(Δt/ℓ)²).

    Parameters
    ----------
    t, added : array, shape (m,)
        Times [s] and what the cause adds, g [m].
    """
    length = SHAPE_LENGTH * max(float(np.ptp(t)), 1e-9)
    kernel = np.exp(-0.5 * ((t[:, None] - t[None, :]) / length) ** 2)
    return np.asarray(SHAPE_SD**2 * added[:, None] * added[None, :] * kernel)
