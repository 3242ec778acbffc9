"""When parts fail: ages at failure from standard normals, so that every law is drawn from one stream.

With E = −ln(1 − Φ(z)), exponential of mean 1, a part of constant rate λ fails at the age E/λ, one of a Weibull law at
η E^(1/β), and one that fails with probability p each time at the ⌈E/(−ln(1 − p))⌉-th (Rausand & Høyland, *System
Reliability Theory*, 2004, ch. 2). Ages are in the unit of the exposure: seconds, metres or events.
"""

from dataclasses import dataclass, fields

import numpy as np
import scipy

from missionplan.arrays import Array, Scalars


def exponential(normals: Array) -> Array:
    """Exponential variables of mean 1 from standard normals, shape (n,)."""
    return np.asarray(-scipy.special.log_ndtr(-normals))


def age_at_rate(rate: Scalars, normals: Array) -> Array:
    """Age at failure of a constant rate, shape (n,); infinite at a rate of 0."""
    rate = np.asarray(rate, dtype=float)
    return np.where(rate > 0.0, exponential(normals) / np.where(rate > 0.0, rate, 1.0), np.inf)


def age_weibull(shape: Scalars, scale: Scalars, normals: Array) -> Array:
    """Age at failure of a Weibull law of shape β and scale η, shape (n,)."""
    return np.asarray(scale * exponential(normals) ** (1.0 / np.asarray(shape)))


def age_at_chance(chance: Scalars, normals: Array) -> Array:
    """Age, in events, of a part that fails with a probability each time, shape (n,): it does so at the next event."""
    chance = np.asarray(chance, dtype=float)
    return age_at_rate(-np.log1p(-np.minimum(chance, 1.0 - 1e-15)), normals)


def rate_of_counts(failures: float, exposure: float, normals: Array) -> Array:
    """Rate given failures in an exposure, from standard normals, shape (n,); see `rate_quantile`."""
    return rate_quantile(failures, exposure, scipy.special.ndtr(normals))


def rate_quantile(failures: float, exposure: float, share: Scalars) -> Array:
    """Quantile of the rate given failures in an exposure: gamma of shape failures + ½, Jeffreys' posterior."""
    return np.asarray(scipy.special.gammaincinv(failures + 0.5, share) / exposure)


def counts_of_rate(mean: float, sd: float) -> tuple[float, float]:
    """Failures and exposure that leave a rate with a mean and a standard deviation; failures are from 0 on.

    The gamma distribution of shape m²/s² = failures + ½ and scale s²/m; one wider than Jeffreys' posterior of no
    failure keeps its mean.
    """
    failures = max((mean / sd) ** 2 - 0.5, 0.0)
    return failures, (failures + 0.5) / mean


def chance_of_counts(failures: float, exposure: float, prior_failures: float, prior_exposure: float) -> float:
    """Probability of counts as far out or farther on their side, by the rate that other counts leave.

    Counts of a gamma-mixed Poisson distribution are negative binomial (Gelman et al., *Bayesian Data Analysis*, 2013,
    sect. 2.6): P(N ≥ k) = I_x(k, a) with x = T/(T₀ + T) and a of the gamma's shape.
    """
    x, shape = exposure / (exposure + prior_exposure), prior_failures + 0.5
    at_least = 1.0 if failures <= 0.0 else float(scipy.special.betainc(failures, shape, x))
    at_most = float(scipy.special.betainc(shape, failures + 1.0, 1.0 - x))
    return min(at_least, at_most)


@dataclass(frozen=True)
class Exposure:
    """What the vehicle's equipment has been through; floats or arrays of shape (n,)."""

    time: Scalars = 0.0
    distance: Scalars = 0.0
    """[s], and through the water [m]."""
    surfacings: Scalars = 0.0
    dives: Scalars = 0.0
    releases: Scalars = 0.0
    wake_ups: Scalars = 0.0

    def plus(self, other: "Exposure") -> "Exposure":
        """Add what comes next."""
        return Exposure(*(getattr(self, field.name) + getattr(other, field.name) for field in fields(self)))

    def of(self, per: str) -> Array:
        """Return what a hazard counts by."""
        names = {"hour": "time", "km": "distance", "surfacing": "surfacings", "dive": "dives"}
        names |= {"release": "releases", "wake-up": "wake_ups"}
        return np.asarray(getattr(self, names[per]), dtype=float)
