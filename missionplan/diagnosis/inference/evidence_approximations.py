"""Evidence without a closed form: Laplace's method about the mode of a few hyperparameters, and importance sampling.

Kass & Raftery (1995), *J. Am. Stat. Assoc.* 90, section 4.1; MacKay (2003), *Information Theory, Inference, and
Learning Algorithms*, chapter 27; Nocedal & Wright (2006), *Numerical Optimization*. Importance sampling assumes neither
linearity nor a normal posterior: Geweke (1989), *Econometrica* 57; Owen (2013), *Monte Carlo Theory, Methods and
Examples*, chapter 9.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy
from scipy.linalg import lapack, solve_triangular
from scipy.special import gammaln

from missionplan.arrays import Array
from missionplan.diagnosis.inference.marginal_likelihood import LOG_2PI, Marginal
from missionplan.montecarlo.streams import stream

SEARCH_STEP = 1e-4
"""Step of the gradient's forward differences."""
GRADIENT = 0.1
"""Gradient at which the search ends: within 0.005 nats of the mode where the posterior's standard deviation is 1."""
STEPS = 60
"""Most steps of the search."""
CURVATURE_STEP = 0.05
"""Step of the second differences."""
HALVINGS = 8
"""Most times that step is halved where the function does not exist on both sides."""
IMPOSSIBLE = 1e12
"""Minus the log of a density of zero."""
LEAST_CURVATURE = 1e-2
"""Least second derivative: along some direction the data may hold no information."""


@dataclass(frozen=True)
class Laplace:
    """Evidence of a model with a few hyperparameters, and a normal approximation of their posterior."""

    log_evidence: float
    """ln ∫ exp(log posterior)."""
    mode: Array
    """Where it is greatest, shape (h,)."""
    covariance: Array
    """Inverse of the negative curvature there, shape (h, h)."""


def laplace(
    log_posterior: Callable[[Array], float],
    starts: list[Array],
    spread: Array,
    *,
    integrate: bool = True,
    keep_inside: bool = False,
) -> Laplace:
    """Maximise a log posterior (normalised prior times likelihood) and integrate it about its mode.

    The mode by BFGS with gradients from forward differences (Nocedal & Wright 2006, sections 6.1 and 8.1), the evidence
    by Laplace's method, ln p(mode) + (h/2) ln 2π − ½ ln |A| with A the negative curvature (MacKay 2003, chapter 27).
    Raises numpy.linalg.LinAlgError when the mode lies on the boundary of the support, where there is no curvature.

    `log_posterior`: smooth, of an array of shape (h,). `starts`: the search goes on from the best of them. `spread`,
    shape (h, h): a guess of the posterior covariance, the first inverse Hessian of the search. `integrate`: whether the
    curvature is wanted; without it the evidence is nan and the covariance is the guess. `keep_inside`: take a mode on
    the boundary of the support just inside it, which serves to draw about it: the evidence is that of a normal law that
    the boundary does not cut.
    """
    cache: dict[bytes, float] = {}

    def negative(at: Array) -> float:
        key = at.tobytes()
        if key not in cache:
            cache[key] = _negative(log_posterior, at)
        return cache[key]

    def gradient(at: Array) -> Array:
        here, ahead = negative(at), at + SEARCH_STEP * np.eye(len(at))
        return np.array([(negative(moved) - here) / (moved[i] - at[i]) for i, moved in enumerate(ahead)])

    best = min(starts, key=negative)
    optimum = scipy.optimize.minimize(
        negative,
        best,
        method="BFGS",
        jac=gradient,
        options={"gtol": GRADIENT, "maxiter": STEPS, "hess_inv0": spread},
    )
    mode = optimum.x if optimum.fun <= negative(best) else best
    if not integrate:
        return Laplace(math.nan, mode, spread)
    if keep_inside:
        mode = _inside(negative, mode)
    curvature = _curvature(negative, mode)
    values, vectors = np.linalg.eigh(curvature)
    values = np.maximum(values, LEAST_CURVATURE)
    evidence = -negative(mode) + 0.5 * len(mode) * LOG_2PI - 0.5 * float(np.log(values).sum())
    covariance = (vectors / values) @ vectors.T
    return Laplace(evidence, mode, 0.5 * (covariance + covariance.T))


def _negative(log_posterior: Callable[[Array], float], at: Array) -> float:
    try:
        value = log_posterior(at)
    except np.linalg.LinAlgError:
        return IMPOSSIBLE
    return -value if math.isfinite(value) else IMPOSSIBLE


def _curvature(negative: Callable[[Array], float], mode: Array) -> Array:
    """Second derivatives by central differences (Nocedal & Wright 2006, section 8.1), shorter steps at a boundary."""
    count = len(mode)
    centre = negative(mode)
    sides = [_either_side(negative, mode, unit) for unit in CURVATURE_STEP * np.eye(count)]
    unit, ahead, behind = (np.array(values) for values in zip(*sides, strict=True))
    steps = np.diag(unit)
    result = np.empty((count, count))
    for i in range(count):
        result[i, i] = (ahead[i] - 2.0 * centre + behind[i]) / steps[i] ** 2
        for j in range(i):
            both, neither = negative(mode + unit[i] + unit[j]), negative(mode - unit[i] - unit[j])
            mixed = both + neither - ahead[i] - ahead[j] - behind[i] - behind[j] + 2.0 * centre
            result[i, j] = result[j, i] = mixed / (2.0 * steps[i] * steps[j])
    return result


def _inside(negative: Callable[[Array], float], mode: Array) -> Array:
    """A mode with room on both sides of each coordinate for the shortest step of the curvature's differences."""
    for step in 2.0 * CURVATURE_STEP * 0.5**HALVINGS * np.eye(len(mode)):
        ahead, behind = (negative(mode + sign * step) < IMPOSSIBLE for sign in (1.0, -1.0))
        if ahead != behind:
            mode = mode + (step if ahead else -step)
    return mode


def _either_side(negative: Callable[[Array], float], mode: Array, step: Array) -> tuple[Array, float, float]:
    """Step, halved until both sides are possible, and the function there."""
    for _ in range(HALVINGS):
        ahead, behind = negative(mode + step), negative(mode - step)
        if max(ahead, behind) < IMPOSSIBLE:
            return step, ahead, behind
        step = 0.5 * step
    raise np.linalg.LinAlgError("the best fit lies on the edge of what is possible")


DRAWS = 128

RAISED = (0.0, 1e-14, 1e-12, 1e-10)
"""Shares by which variances are raised in turn until their matrix has a factor."""


TAILS, WIDENED = 5, 1.2
"""Degrees of freedom of the law from which draws are made, and factor on the posterior's standard deviations: tails
heavier than the posterior's keep the weights bounded (Geweke 1989)."""


@dataclass(frozen=True)
class SampledEvidence:
    """Evidence by importance sampling."""

    log_evidence: float
    """ln p(data)."""
    effective: float
    """Effective number of draws, (Σw)²/Σw² (Owen 2013, section 9.3): small where the posterior is unlike the one
    assumed."""


def sampled_evidence(log_joint: Callable[[Array], Array], mean: Array, covariance: Array) -> SampledEvidence:
    """Integrate a joint density of data and parameters with draws from a Student-t about the assumed posterior.

    The evidence is the mean of the weights, joint density over proposal density (Owen 2013, section 9.1). Raises
    numpy.linalg.LinAlgError when the covariance is not positive definite.

    `log_joint`: ln p(data, parameters) of parameters, shape (s, k) → (s,); a value that is not finite counts as −∞.
    `mean`, shape (k,): of the assumed posterior. `covariance`, shape (k, k): of the assumed posterior.
    """
    logs = _weighed(log_joint, mean, covariance)
    if np.all(np.isneginf(logs)):
        return SampledEvidence(-np.inf, 0.0)
    weights = np.exp(logs - logs.max())
    evidence = float(logs.max() + np.log(weights.mean()))
    return SampledEvidence(evidence, float(weights.sum() ** 2 / np.sum(weights**2)))


def _weighed(log_joint: Callable[[Array], Array], mean: Array, covariance: Array) -> Array:
    """Logs of the weights of draws from the proposal, shape (s,)."""
    shape, factor = _with_factor(WIDENED**2 * covariance)
    generator = stream(0, "diagnose.importance", 0)
    scale = generator.chisquare(TAILS, DRAWS) / TAILS
    normals = generator.multivariate_normal(np.zeros(len(mean)), shape, DRAWS)
    at: Array = mean + normals / np.sqrt(scale)[:, None]
    logs = log_joint(at) - log_student_density(at, mean, factor, TAILS)
    return np.where(np.isfinite(logs), logs, -np.inf)


def even_points(count: int, dimension: int) -> Array:
    """Points that fill the unit cube evenly, shape (count, dimension): a Kronecker sequence.

    Its steps are powers of the root of x^(d+1) = x + 1, the golden ratio in one dimension, of which fractions are poor
    approximations (Roberts 2018, *The Unreasonable Effectiveness of Quasirandom Sequences*).
    """
    root = 1.5
    for _ in range(60):
        root = (1.0 + root) ** (1.0 / (dimension + 1.0))
    steps = root ** -np.arange(1.0, dimension + 1.0)
    return np.asarray((0.5 + np.arange(1.0, count + 1.0)[:, None] * steps) % 1.0)


def _with_factor(shape: Array) -> tuple[Array, Array]:
    """A matrix with its lower Cholesky factor; where rounding has left none, its diagonal is raised until there is one.

    The draws are then wider than the posterior across the direction in which the data fix the parameters best.
    """
    for share in RAISED:
        try:
            raised = shape + share * np.diag(np.diag(shape)) if share else shape
            return raised, np.asarray(np.linalg.cholesky(raised), dtype=float)
        except np.linalg.LinAlgError:
            continue
    raise np.linalg.LinAlgError("the covariance is not positive definite")


def log_student_density(at: Array, mean: Array, factor: Array, dof: int) -> Array:
    """Log density of the multivariate Student-t distribution at points, shape (s, k) → (s,).

    `mean`, shape (k,). `factor`, shape (k, k): lower Cholesky factor of its shape matrix.
    """
    dimension = len(mean)
    squared = np.sum(solve_triangular(factor, (at - mean).T, lower=True) ** 2, axis=0)
    constant = gammaln(0.5 * (dof + dimension)) - gammaln(0.5 * dof) - 0.5 * dimension * np.log(dof * np.pi)
    density: Array = constant - np.log(np.diag(factor)).sum() - 0.5 * (dof + dimension) * np.log1p(squared / dof)
    return density


NEAR, TOLERANCE = 0.1, 1e-6
"""Last step below which Newton's is tried, and below which the mode is found [prior standard deviations]."""


def student_marginal(y: Array, design: Array, prior_sd: Array, variance: Array, dof: float) -> Marginal:
    """Integrate out the coefficients under bivariate Student-t errors, by Laplace's approximation.

    Errors of covariance diag(variance): ln p is −½(ν+2)·ln(1 + q/(ν−2)) + constant with q = Σ r²/variance. The mode is
    found by iteratively reweighted least squares with weights (ν+2)/(ν−2+q) (Lange, Little & Taylor 1989, *J. Am.
    Stat. Assoc.* 84), near it by Newton's steps where they are shorter than the last step and lead uphill.

    `y`, shape (2, n): data. `design`, shape (2, n, k), and `prior_sd`, shape (k,): columns of the coefficients, and
    their prior standard deviations. `variance`, shape (2, n): for each axis. `dof`: degrees of freedom ν, above 2.
    """
    k, n = len(prior_sd), y.shape[1]
    sd = np.sqrt(variance)
    scaled_y = (y / sd).ravel()
    columns = (design * prior_sd / sd[:, :, None]).reshape(2 * n, k)
    transposed = np.ascontiguousarray(columns.T)
    coefficients, moved = np.zeros(k), math.inf
    for _ in range(60):
        residual = scaled_y - columns @ coefficients
        squared = np.square(residual).reshape(2, n).sum(axis=0)
        weight = (dof + 2.0) / (dof - 2.0 + squared)
        weighted = (transposed.reshape(k, 2, n) * weight).reshape(k, 2 * n)
        gradient = weighted @ residual - coefficients
        hessian = weighted @ columns
        hessian.flat[:: k + 1] += 1.0
        if moved < TOLERANCE:
            break
        _, step, _ = lapack.dposv(hessian, gradient)
        if moved < NEAR:
            newton = np.linalg.solve(_student_curvature(hessian, columns, residual, weight, dof), gradient)
            step = newton if newton @ gradient > 0.0 and np.abs(newton).max(initial=0.0) < moved else step
        coefficients, moved = coefficients + step, float(np.abs(step).max(initial=0.0))
    curvature = _student_curvature(hessian, columns, residual, weight, dof)
    if np.linalg.eigvalsh(curvature)[0] <= 0.0:
        curvature = hessian
    constant = gammaln(0.5 * dof + 1.0) - gammaln(0.5 * dof) - math.log(math.pi * (dof - 2.0))
    log_density = len(squared) * constant - 0.5 * (dof + 2.0) * float(np.log1p(squared / (dof - 2.0)).sum())
    log_density -= 0.5 * float(np.log(variance).sum()) + 0.5 * float(coefficients @ coefficients)
    log_density -= 0.5 * float(np.linalg.slogdet(curvature)[1])
    covariance = prior_sd[:, None] * np.linalg.inv(curvature) * prior_sd[None, :]
    return Marginal(log_density, prior_sd * coefficients, covariance)


def _student_curvature(hessian: Array, columns: Array, residual: Array, weight: Array, dof: float) -> Array:
    """Negative second derivatives of the log density, whose first part, `hessian`, takes the weights as given."""
    along = (residual[:, None] * columns).reshape(2, len(weight), -1).sum(axis=0)
    return np.asarray(hessian - along.T @ (along * (2.0 * weight**2 / (dof + 2.0))[:, None]))
