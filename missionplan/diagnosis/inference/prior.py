"""Prior of the coordinates of a model: normal distributions, and slabs with heavy tails.

A slab is a Student-t distribution, so that a strong effect is measured as it is while a weak one still pays for its
parameters. As a scale mixture it is normal with variance sd²·λ, λ inverse-gamma (½ν, ½ν) (Gelman et al. 2013, *Bayesian
Data Analysis*, section 17.2): given the λ a linear model stays linear and Gaussian.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaln, log_ndtr, logsumexp, stdtr

from missionplan.arrays import Array
from missionplan.diagnosis.inference.marginal_likelihood import LOG_2PI, Marginal, normal_log_pdf

DOF = 3.0
"""Degrees of freedom ν of a slab."""
SCALE_STEPS, SCALE_CONVERGED = 12, 0.02
"""Steps towards the likeliest λ, and change of ln λ below which it is found."""
LEAST_CURVATURE = 0.3
"""Least negative curvature along ln λ: less than without any data, where it is ½ν."""
LAPLACE_ERROR = 0.048
"""What Laplace's method leaves out of each ln λ [nats]: ln Γ(a) − a ln a + a − ½ ln(2π/a), 0.041 at a = 2, where the
coordinate is known, and 0.055 at a = 3/2, where nothing is."""


@dataclass(frozen=True)
class Prior:
    """Distributions of k coordinates, independent but for those that are tied."""

    centre: Array
    sd: Array
    """Means and standard deviations; of a Student-t distribution its scale, shape (k,)."""
    heavy: NDArray[np.bool_] | None = None
    """Shape (k,). Whether a coordinate's is a Student-t distribution; default none."""
    tied: tuple[tuple[NDArray[np.int_], Array], ...] = ()
    """Coordinates of joint normal distributions, shape (m,), and their covariances, shape (m, m); default none."""
    low: Array | None = None
    high: Array | None = None
    """Ends of the ranges outside which a coordinate cannot lie; default none, shape (k,)."""

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Ends of the coordinates' ranges, shape (k,) each."""
        nowhere = np.full(len(self.sd), np.inf)
        return (-nowhere if self.low is None else self.low, nowhere if self.high is None else self.high)

    @property
    def log_mass(self) -> float:
        """Log probability that the distributions without ends give to what lies inside the ranges."""
        return float(self.log_masses.sum())

    @property
    def log_masses(self) -> Array:
        """The same of each coordinate by itself, shape (k,)."""
        low, high = ((end - self.centre) / np.where(self.sd > 0.0, self.sd, 1.0) for end in self.bounds)
        heavy = np.zeros(len(self.sd), dtype=bool) if self.heavy is None else self.heavy
        student = np.log(stdtr(DOF, high) - stdtr(DOF, low))
        return np.where(np.isfinite(low) | np.isfinite(high), np.where(heavy, student, log_normal_mass(low, high)), 0.0)

    def of(self, chosen: NDArray[np.int_]) -> "Prior":
        """Return the prior of some of the coordinates."""
        heavy = None if self.heavy is None else self.heavy[chosen]
        kept = [(np.flatnonzero(np.isin(places, chosen)), places, covariance) for places, covariance in self.tied]
        where = {int(index): place for place, index in enumerate(chosen)}
        tied = tuple(
            (np.array([where[int(index)] for index in places[rows]], dtype=int), covariance[np.ix_(rows, rows)])
            for rows, places, covariance in kept
        )
        low, high = (None if end is None else end[chosen] for end in (self.low, self.high))
        return Prior(self.centre[chosen], self.sd[chosen], heavy, tied, low, high)

    def preceded(self, centre: Array, sd: Array) -> "Prior":
        """Return the prior of these with other coordinates before them, of independent normal distributions."""
        more = len(sd)
        heavy = None if self.heavy is None else np.concatenate([np.zeros(more, dtype=bool), self.heavy])
        low, high = (
            np.concatenate([np.full(more, sign * np.inf), end]) for sign, end in zip((-1, 1), self.bounds, strict=True)
        )
        tied = tuple((places + more, covariance) for places, covariance in self.tied)
        return Prior(np.concatenate([centre, self.centre]), np.concatenate([sd, self.sd]), heavy, tied, low, high)

    def root(self, sd: Array) -> Array:
        """Return a factor R of the covariance R Rᵀ, shape (k, k); the standard deviations, (k,), where nothing is tied.

        `sd`, shape (k,): of the coordinates that are not tied.
        """
        if not self.tied:
            return sd
        root = np.diag(sd)
        for places, covariance in self.tied:
            root[np.ix_(places, places)] = np.linalg.cholesky(covariance)
        return root

    def log_density(self, at: Array) -> Array:
        """Log density at points, shape (..., k) → (...)."""
        low, high = self.bounds
        logs = np.where((at >= low) & (at <= high), normal_log_pdf(at, self.centre, self.sd), -np.inf)
        if self.heavy is not None and self.heavy.any():
            squared = np.square((at - self.centre) / self.sd)
            constant = gammaln(0.5 * (DOF + 1.0)) - gammaln(0.5 * DOF) - 0.5 * math.log(DOF * math.pi)
            student = constant - np.log(self.sd) - 0.5 * (DOF + 1.0) * np.log1p(squared / DOF)
            logs = np.where(self.heavy & np.isfinite(logs), student, logs)
        together = np.zeros(logs.shape[:-1])
        for places, covariance in self.tied:
            factor = np.linalg.cholesky(covariance)
            white = np.linalg.solve(factor, (at - self.centre)[..., places, None])[..., 0]
            logs[..., places] = -0.5 * np.square(white) - 0.5 * LOG_2PI
            together = together - np.log(np.diag(factor)).sum()
        return np.asarray(logs.sum(axis=-1) + together if self.tied else logs.sum(axis=-1))

    def misfit(self, at: Array) -> float:
        """Minus the log density at a point, less its least value."""
        return float(self.log_density(self.centre) - self.log_density(at))

    def variance(self, at: Array) -> Array:
        """Variances of the normal distributions that touch the prior at a point, shape (k,): sd²·λ, λ its mean there.

        With them, a Gauss–Newton step is one of iteratively reweighted least squares (Lange, Little & Taylor 1989).
        """
        if self.heavy is None:
            return np.square(self.sd)
        squared = np.square((at - self.centre) / self.sd)
        return np.square(self.sd) * np.where(self.heavy, (DOF + squared) / (DOF + 1.0), 1.0)


@dataclass(frozen=True)
class SlabScales:
    """Likeliest scales λ of the slabs."""

    sd: Array
    """Standard deviations of the coordinates given these scales, shape (k,)."""
    log_factor: float
    """What the evidence given these scales lacks: their prior density, and the integral over them by Laplace's method.
    """


def likeliest_scales(marginal_of: Callable[[Array], Marginal], prior: Prior) -> SlabScales:
    """Find the scales of a prior's slabs, each by its logarithm, and integrate over them.

    The likeliest λ is (ν + E z²)/(ν + 1), E z² the posterior mean of the squared coordinate over sd²: a fixed point
    that expectation–maximisation reaches (Dempster, Laird & Rubin 1977).

    `marginal_of` gives, of `Prior.root`, the linear model with its coordinates integrated out; those of `Marginal` are
    counted from the prior's centre.
    """
    slabs = np.flatnonzero(prior.heavy) if prior.heavy is not None else np.zeros(0, dtype=int)
    if not len(slabs):
        return SlabScales(prior.sd, 0.0)
    scale, sd = np.ones(len(slabs)), prior.sd.copy()
    for _ in range(SCALE_STEPS):
        sd[slabs] = prior.sd[slabs] * np.sqrt(scale)
        marginal = marginal_of(prior.root(sd))
        before = scale
        squared = (np.square(marginal.mean[slabs]) + np.diag(marginal.covariance)[slabs]) / np.square(prior.sd[slabs])
        scale = (DOF + squared) / (DOF + 1.0)
        if np.max(np.abs(np.log(scale / before))) < SCALE_CONVERGED:
            break
    # negative curvature of the log posterior along the ln λ at its mode, shape (h, h)
    mean = marginal.mean[slabs] / sd[slabs]
    covariance = marginal.covariance[np.ix_(slabs, slabs)] / np.outer(sd[slabs], sd[slabs])
    curvature = np.asarray(
        0.5 * (DOF + 1.0) * np.eye(len(mean)) - 0.5 * (2.0 * np.outer(mean, mean) * covariance + np.square(covariance))
    )
    log_determinant = float(np.log(np.maximum(np.linalg.eigvalsh(curvature), LEAST_CURVATURE)).sum())
    log_prior = 0.5 * DOF * (math.log(0.5 * DOF) - np.log(before) - 1.0 / before) - gammaln(0.5 * DOF)
    constant = 0.5 * LOG_2PI + LAPLACE_ERROR
    return SlabScales(sd, float(log_prior.sum()) + len(slabs) * constant - 0.5 * log_determinant)


@dataclass(frozen=True)
class Integrated:
    """A linear model integrated over its coordinates, the scales of its slabs and its noise."""

    log_evidence: float
    noise: int
    """Most likely noise of the grid."""
    prior_sd: Array
    """Prior of the coordinates, the slabs at their likeliest scales; see `Prior.root`."""
    marginal: Marginal
    """Posterior of the coordinates at that noise, counted from the prior's centre, whatever their ranges."""
    inside: "InsideRange"
    """Posterior of the coordinates themselves, cut to their ranges."""


def integrated(
    log_joint: Callable[[Array], Array], marginal_of: Callable[[int, Array], Marginal], prior: Prior
) -> Integrated:
    """Integrate a linear model: coordinates exactly, the noise by a sum over a grid, the scales by Laplace's method.

    The scales are those at the likeliest noise. Raises numpy.linalg.LinAlgError when the coordinates have no posterior.

    `log_joint`: of `Prior.root`: log density of the data at each noise, its log prior added, shape (g,). `marginal_of`:
    of the number of a noise and of `Prior.root`: the model with its coordinates integrated out. `prior`: of the
    coordinates; those of `Marginal` are counted from its centre.
    """
    likely = int(np.argmax(log_joint(prior.root(prior.sd))))
    scales = likeliest_scales(partial(marginal_of, likely), prior)
    root = prior.root(scales.sd)
    logs = log_joint(root)
    noise = int(np.argmax(logs))
    marginal = marginal_of(noise, root)
    inside = inside_range(prior.centre + marginal.mean, marginal.covariance, *prior.bounds)
    evidence = float(logsumexp(logs)) + scales.log_factor + inside.log_mass - prior.log_mass
    return Integrated(evidence, noise, root, marginal, inside)


@dataclass(frozen=True)
class InsideRange:
    """A normal distribution cut to ranges of its coordinates."""

    log_mass: float
    """Log probability of the ranges."""
    mean: Array
    covariance: Array
    """Moments inside them, shape (k,)."""


def inside_range(mean: Array, covariance: Array, low: Array, high: Array) -> InsideRange:
    """Cut a normal distribution to ranges, one coordinate after the other.

    After each the distribution is replaced by the normal one with its moments (assumed density filtering; Minka 2001,
    *Expectation Propagation for Approximate Bayesian Inference*): exact for one range.

    `mean`, `covariance`, shape (k,) and (k, k). `low`, `high`, shape (k,): ends of the ranges, which may be infinite.
    """
    mean, covariance, total = mean.copy(), covariance.copy(), 0.0
    for index in np.flatnonzero(np.isfinite(low) | np.isfinite(high)):
        variance = float(covariance[index, index])
        if variance <= 0.0:
            continue
        sd = math.sqrt(variance)
        log_mass, shift, share = _cut((low[index] - mean[index]) / sd, (high[index] - mean[index]) / sd)
        along = covariance[:, index] / sd
        mean += along * shift
        covariance -= np.outer(along, along) * (1.0 - share)
        total += log_mass
    return InsideRange(total, np.clip(mean, low, high), covariance)


def log_normal_mass(low: Array, high: Array) -> Array:
    """Log probability that a standard normal distribution gives to what lies between two ends."""
    above, below = np.where(low > 0.0, -low, high), np.where(low > 0.0, -high, low)
    return np.asarray(log_ndtr(above) + np.log1p(-np.exp(np.minimum(log_ndtr(below) - log_ndtr(above), -1e-12))))


def _cut(low: float, high: float) -> tuple[float, float, float]:
    """Log probability, mean and variance of a standard normal distribution between two ends."""
    log_mass = float(log_normal_mass(np.array(low), np.array(high)))
    ends = [end for end in (low, high) if math.isfinite(end)]
    signs = [1.0 if end == low else -1.0 for end in ends]
    densities = [
        sign * math.exp(-0.5 * end * end - 0.5 * LOG_2PI - log_mass) for sign, end in zip(signs, ends, strict=True)
    ]
    mean = sum(densities)
    variance = 1.0 + sum(end * density for end, density in zip(ends, densities, strict=True)) - mean * mean
    nearest, width = min(abs(low), abs(high)), high - low
    least = min(0.25 / (1.0 + nearest * nearest), width * width / 24.0)  # rounding may leave less, far from the middle
    return log_mass, mean, max(variance, least)
