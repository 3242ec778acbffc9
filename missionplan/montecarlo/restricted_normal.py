"""The standard normal distribution restricted to an interval: draws, distribution function, moments of a transform."""

import math
from collections.abc import Callable
from functools import cache
from statistics import NormalDist

import numpy as np
import scipy  # its submodules are loaded when first used: checking a mission needs none

from missionplan.arrays import Array

_NORMAL_REACH = 12.0
"""Standard deviations beyond which the normal has no weight in double precision."""


def normal_cdf(z: float) -> float:
    """Distribution function of the standard normal, ½ erfc(-z/√2), of one number."""
    return 0.5 * math.erfc(-z / math.sqrt(2.0))


def normal_quantile(probability: float) -> float:
    """Quantile function of the standard normal, of one number (Wichura 1988, algorithm AS 241)."""
    if 0.0 < probability < 1.0:
        return NormalDist().inv_cdf(probability)
    return -math.inf if probability <= 0.0 else math.inf


def restricted_normal(z: Array, low: float, high: float) -> Array:
    """Map standard normals to normals restricted to [low, high], through their probabilities (inverse transform)."""
    if low > 0.0:  # the lower tail keeps digits that the upper one rounds away
        return -restricted_normal(-z, -high, -low)
    p_low, p_high = scipy.special.ndtr(low), scipy.special.ndtr(high)
    restricted: Array = scipy.special.ndtri(p_low + (p_high - p_low) * scipy.special.ndtr(z))
    return np.clip(restricted, low, high)


def restricted_cdf(z: float, low: float, high: float) -> float:
    """Distribution function at `z` of a standard normal restricted to [low, high]."""
    if low > 0.0:
        return 1.0 - restricted_cdf(-z, -high, -low)
    return (normal_cdf(min(max(z, low), high)) - normal_cdf(low)) / (normal_cdf(high) - normal_cdf(low))


def restricted_quantile(probability: float, low: float, high: float) -> float:
    """Quantile function of a standard normal restricted to [low, high], of one number."""
    if low > 0.0:
        return -restricted_quantile(1.0 - probability, -high, -low)
    p_low, p_high = normal_cdf(low), normal_cdf(high)
    return min(max(normal_quantile(p_low + (p_high - p_low) * probability), low), high)


@cache
def _gauss_legendre() -> tuple[Array, Array]:
    """Nodes and weights of a quadrature with 200 points."""
    return np.polynomial.legendre.leggauss(200)


def restricted_moments(transform: Callable[[Array], Array], low: float, high: float) -> tuple[float, float]:
    """Mean and standard deviation of a transform of a restricted normal, by 200-point Gauss–Legendre quadrature."""
    start, end = max(low, min(high, 0.0) - _NORMAL_REACH), min(high, max(low, 0.0) + _NORMAL_REACH)
    nodes, weights = _gauss_legendre()
    z = 0.5 * (start + end) + 0.5 * (end - start) * nodes
    nearest = min(max(0.0, start), end)
    weight = weights * np.exp(0.5 * (nearest**2 - z**2))
    weight /= weight.sum()
    values = transform(z)
    mean = float(weight @ values)
    return mean, math.sqrt(float(weight @ (values - mean) ** 2))
