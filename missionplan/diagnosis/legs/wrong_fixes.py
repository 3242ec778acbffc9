"""Fixes that are wrong: a leg errs by as much as the next one errs the other way."""

import math

import numpy as np

from missionplan.arrays import Array
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.legs.model import TransitModel, leg_by_leg
from missionplan.results.learned.evidence import WrongFix

OFF = 100.0
"""Usual size of the error of a wrong fix, each axis [m]: a receiver that has just surfaced, or hears reflections."""
ARE_WRONG = 0.01
"""Share of the fixes that are expected to be wrong, and of the legs that err alone."""
IS_SURE = 0.9
"""Probability from which a fix is called wrong."""
IS_LARGE = 3.0
"""Errors of both legs beside a wrong fix, of the median's size, from which it is looked at."""


def wrong_fixes(model: TransitModel, fit: CauseFit) -> tuple[WrongFix, ...]:
    """Return fixes that are probably wrong under a fit: what one leg errs by, the next errs the other way.

    Each fix within a run, its two legs predicted from all others, is weighed against one of the legs erring alone: all
    by an unknown displacement, normal with `OFF` each axis.

    Parameters
    ----------
    model : TransitModel
    fit : CauseFit
        The claimed set.
    """
    data, found = model.data, []
    size = np.hypot(*(model.y - np.median(model.y, axis=1, keepdims=True)))
    large = size > IS_LARGE * np.median(size)
    pairs = large[:-1] & large[1:] & (data.run[:-1] == data.run[1:])
    for k in np.flatnonzero(pairs).tolist():
        pair = np.array([k, k + 1])
        mean, covariance = model.predicted(fit, np.setdiff1d(np.arange(data.n), pair), pair)
        error = leg_by_leg(model.y[:, pair] - mean)
        one, other = (OFF * np.kron(side, np.eye(2)) for side in np.diag(1.0 / data.under_way[pair])[:, :, None])
        weights = [_log_evidence(error, covariance, columns) for columns in (one - other, one, other)]
        odds = np.exp(np.array([*weights, -math.log(ARE_WRONG)]) - max(weights))
        east, north = model.axes @ _displacement(error, covariance, one - other)
        found.append(WrongFix(str(data.labels[k]), float(east), float(north), float(odds[0] / odds.sum())))
    return tuple(each for each in found if each.probability >= IS_SURE)


def _displacement(error: Array, covariance: Array, columns: Array) -> Array:
    """Posterior mean of an unknown displacement with these columns for one of `OFF`, shape (2,) [m]."""
    weighted = np.linalg.solve(covariance, columns)
    return np.asarray(OFF * np.linalg.solve(np.eye(2) + columns.T @ weighted, weighted.T @ error))


def _log_evidence(error: Array, covariance: Array, columns: Array) -> float:
    """Log Bayes factor of errors with an unknown displacement over those without."""
    weighted = np.linalg.solve(covariance, columns)
    precision, along = np.eye(2) + columns.T @ weighted, weighted.T @ error
    return 0.5 * float(along @ np.linalg.solve(precision, along) - np.linalg.slogdet(precision)[1])
