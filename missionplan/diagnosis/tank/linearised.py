"""Tank data about a fit, linear with normal priors: coordinates marginalised, groups predicted from the others.

Linear Gaussian models, as in Bishop (2006), *Pattern Recognition and Machine Learning*, sections 2.3.3 and 3.5.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.diagnosis.inference.marginal_likelihood import LOG_2PI, QUANTILE_95, Marginal


def marginal(y: Array, columns: Array, prior: Array, sd: Array) -> Marginal:
    """Marginalise the coordinates of y = columns·z + noise with z ~ N(0, prior²) and independent noise.

    Parameters
    ----------
    y : array, shape (N,)
        Data, less the prediction at the prior means.
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
class GroupPrediction:
    """A group as the others predict it.

    Attributes
    ----------
    rows : array of bool, shape (N,)
        Data of the group.
    estimated : array, shape (l,)
        Shared coordinates estimated from the others, less their prior means.
    log_score : float
        ln p(group | the others).
    inside : int
        Data of the group inside their 90 % predictive interval.
    """

    rows: NDArray[np.bool_]
    estimated: Array
    log_score: float
    inside: int


@dataclass(frozen=True)
class LinearData:
    """Data as a fitted set of causes predicts them, linear about the fit.

    Attributes
    ----------
    y, sd : array, shape (N,)
        Data less the prediction at the prior means, and the standard deviation of their noise.
    columns : array, shape (N, a)
        Derivatives along the coordinates.
    prior : array, shape (a,)
        Prior standard deviations of the coordinates.
    shared : array of bool, shape (a,)
        Constants of the base model and causes of the set, the same in all groups; the others are random effects.
    groups : array of str, shape (N,)
        Group of each datum.
    """

    y: Array
    sd: Array
    columns: Array
    prior: Array
    shared: NDArray[np.bool_]
    groups: NDArray[np.str_]

    def predicted(self) -> list[GroupPrediction]:
        """Predict each group from the others.

        Causes of a set are the same in every group, as are the base model's constants: both are estimated from the
        other groups. Effects that are no causes are random effects of each group by itself (Laird & Ware 1982) with
        their prior, the spike. Were they estimated too, a record that fixes one sharply would fix it under every set
        alike, and no set would gain, however far it lies outside its spike.
        """
        rows = [self.groups == name for name in dict.fromkeys(self.groups.tolist())]
        shared, random = self.columns[:, self.shared], self.columns[:, ~self.shared] * self.prior[~self.shared]
        noises = [np.diag(self.sd[own] ** 2) + random[own] @ random[own].T for own in rows]
        both = np.concatenate([shared, self.y[:, None]], axis=1)
        whites = [np.linalg.solve(np.linalg.cholesky(n), both[own]) for n, own in zip(noises, rows, strict=True)]
        found = []
        for k, own in enumerate(rows):
            seen = np.concatenate(whites[:k] + whites[k + 1 :])
            others = marginal(seen[:, -1], seen[:, :-1], self.prior[self.shared], np.ones(len(seen)))
            covariance = shared[own] @ others.covariance @ shared[own].T + noises[k]
            error = self.y[own] - shared[own] @ others.mean
            inside = np.abs(error) <= QUANTILE_95 * np.sqrt(np.diag(covariance))
            found.append(GroupPrediction(own, others.mean, _log_density(error, covariance), int(inside.sum())))
        return found


def _log_density(error: Array, covariance: Array) -> float:
    """Ln N(error; 0, covariance)."""
    factor = np.linalg.cholesky(covariance)
    white = np.linalg.solve(factor, error)
    return -0.5 * float(white @ white) - float(np.log(np.diag(factor)).sum()) - 0.5 * LOG_2PI * len(error)
