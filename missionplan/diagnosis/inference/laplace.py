"""Laplace's approximation of the evidence, about the mode of a few hyperparameters.

Kass & Raftery (1995), *J. Am. Stat. Assoc.* 90, section 4.1; MacKay (2003), *Information Theory, Inference, and
Learning Algorithms*, chapter 27; Nocedal & Wright (2006), *Numerical Optimization*.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy  # its part for optimisation is loaded when first used

from missionplan.arrays import Array
from missionplan.diagnosis.inference.marginal_likelihood import LOG_2PI

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

    Parameters
    ----------
    log_posterior : callable
        Of an array of shape (h,), smooth.
    starts : list of array
        Where to start; the search goes on from the best of them.
    spread : array, shape (h, h)
        A guess of the posterior covariance: the first inverse Hessian of the search.
    integrate : bool
        Whether the curvature is wanted; without it the evidence is nan and the covariance is the guess.
    keep_inside : bool
        Take a mode on the boundary of the support just inside it, which serves to draw about it: the evidence is that
        of a normal law that the boundary does not cut.

    Raises
    ------
    numpy.linalg.LinAlgError
        When the mode lies on the boundary of the support, where there is no curvature.
    """
    known: dict[bytes, float] = {}

    def negative(at: Array) -> float:
        key = at.tobytes()
        if key not in known:
            known[key] = _negative(log_posterior, at)
        return known[key]

    best = min(starts, key=negative)
    found = scipy.optimize.minimize(
        negative,
        best,
        method="BFGS",
        options={"gtol": GRADIENT, "eps": SEARCH_STEP, "maxiter": STEPS, "hess_inv0": spread},
    )
    mode = found.x if found.fun <= negative(best) else best
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
    found = [_either_side(negative, mode, unit) for unit in CURVATURE_STEP * np.eye(count)]
    unit, ahead, behind = (np.array(values) for values in zip(*found, strict=True))
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
