"""Tank data about a fit, linear with normal priors: coordinates marginalised, and groups predicted from the others."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from missionplan.arrays import Array
from missionplan.diagnosis.inference.marginal_likelihood import LOG_2PI, Marginal


def marginal(y: Array, columns: Array, prior: Array, sd: Array) -> Marginal:
    """Marginalise the coordinates of y = columns·z + noise with z ~ N(0, prior²) and independent noise.

    Parameters
    ----------
    y : array, shape (N,)
        Data, less what the model predicts at the priors' centres.
    columns : array, shape (N, a)
        Derivatives along the coordinates.
    prior : array, shape (a,)
        Standard deviations of the coordinates.
    sd : array, shape (N,)
        Standard deviations of the noise.

    Raises
    ------
    numpy.linalg.LinAlgError
        When the posterior has no covariance.
    """
    white, data = columns * prior / sd[:, None], y / sd
    precision = np.eye(len(prior)) + white.T @ white
    factor = np.linalg.cholesky(precision)
    inverse = np.linalg.inv(precision)
    mean = inverse @ (white.T @ data)
    log_density = -0.5 * (float(data @ data) - float(mean @ (white.T @ data)))
    log_density -= float(np.log(np.diag(factor)).sum()) + float(np.log(sd).sum()) + 0.5 * len(y) * LOG_2PI
    return Marginal(log_density, prior * mean, prior[:, None] * inverse * prior)


@dataclass(frozen=True)
class Predicted:
    """A group as the others predict it.

    Attributes
    ----------
    rows : array of bool, shape (N,)
        Which data are its own.
    learnt : array, shape (l,)
        Coordinates learnt from the others, less their centres.
    log_score : float
        ln p(group | the others).
    inside : int
        Its data inside their 90 % predictive interval.
    """

    rows: NDArray[np.bool_]
    learnt: Array
    log_score: float
    inside: int


@dataclass(frozen=True)
class LinearData:
    """Data as a fitted set of causes sees them, linear about the fit.

    Attributes
    ----------
    y, sd : array, shape (N,)
        Data less the prediction at the priors' centres, and the standard deviation of their noise.
    columns : array, shape (N, a)
        Derivatives along the coordinates.
    prior : array, shape (a,)
        Standard deviations of the coordinates about their centres.
    learnt : array of bool, shape (a,)
        Constants of the base model and causes of the set; the others are doubts about what is no cause.
    groups : array of str, shape (N,)
        Group of each datum.
    """

    y: Array
    sd: Array
    columns: Array
    prior: Array
    learnt: NDArray[np.bool_]
    groups: NDArray[np.str_]

    def predicted(self) -> list[Predicted]:
        """Predict each group from the others.

        A set of causes says that they are the same in every group: they are learnt from the others, as are the base
        model's constants. What is no cause of the set stays what was believed before any data, a doubt of each group
        by itself. Were doubts learnt too, a record that fixes one sharply would teach it to every set alike, and no
        set would gain, however far from belief it lies.
        """
        rows = [self.groups == name for name in dict.fromkeys(self.groups.tolist())]
        known, doubts = self.columns[:, self.learnt], self.columns[:, ~self.learnt] * self.prior[~self.learnt]
        noises = [np.diag(self.sd[own] ** 2) + doubts[own] @ doubts[own].T for own in rows]
        both = np.concatenate([known, self.y[:, None]], axis=1)
        whites = [np.linalg.solve(np.linalg.cholesky(n), both[own]) for n, own in zip(noises, rows, strict=True)]
        found = []
        for k, own in enumerate(rows):
            seen = np.concatenate(whites[:k] + whites[k + 1 :])
            rest = marginal(seen[:, -1], seen[:, :-1], self.prior[self.learnt], np.ones(len(seen)))
            covariance = known[own] @ rest.covariance @ known[own].T + noises[k]
            error = self.y[own] - known[own] @ rest.mean
            inside = np.abs(error) <= norm.ppf(0.95) * np.sqrt(np.diag(covariance))
            found.append(Predicted(own, rest.mean, _log_density(error, covariance), int(inside.sum())))
        return found


def _log_density(error: Array, covariance: Array) -> float:
    factor = np.linalg.cholesky(covariance)
    white = np.linalg.solve(factor, error)
    return -0.5 * float(white @ white) - float(np.log(np.diag(factor)).sum()) - 0.5 * LOG_2PI * len(error)
