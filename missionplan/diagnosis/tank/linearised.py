"""Tank data about a fit, linear with normal priors: coordinates marginalised, groups predicted from the others.

Linear Gaussian models, as in Bishop (2006), *Pattern Recognition and Machine Learning*, sections 2.3.3 and 3.5.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from missionplan.arrays import Array
from missionplan.diagnosis.inference.block_covariance import BlockCovariance
from missionplan.diagnosis.inference.marginal_likelihood import LOG_2PI, QUANTILE_95, Marginal


def marginal(y: Array, columns: Array, prior: Array, sd: Array) -> Marginal:
    """Marginalise the coordinates of y = columns·z + noise with z ~ N(0, prior²) and independent noise.

    By a QR decomposition of the columns with the prior's rows below them. Normal equations would square the condition
    number: with data much better than the prior and coordinates nearly alike they have no Cholesky factor.

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
    """
    log_density, mean, root = _posterior(y / sd, columns * prior / sd[:, None])
    root = prior[:, None] * root
    return Marginal(log_density - float(np.log(sd).sum()), prior * mean, root @ root.T)


def _posterior(y: Array, columns: Array) -> tuple[float, Array, Array]:
    """Log density of y = columns·z + e, all standard normals; mean of z given y, and a root of its covariance."""
    n, count = columns.shape
    bordered = np.zeros((n + count, count + 1))
    bordered[:n, :count], bordered[:n, count] = columns, y
    bordered[n:, :count] = np.eye(count)
    triangle = np.asarray(np.linalg.qr(bordered, mode="r"))
    upper, right = triangle[:count, :count], triangle[:count, count]
    log_determinant = float(np.log(np.abs(np.diag(upper))).sum())
    log_density = -0.5 * float(triangle[count, count] ** 2) - log_determinant - 0.5 * n * LOG_2PI
    if not count:  # which LAPACK calls an illegal value
        return log_density, right, upper
    return log_density, np.asarray(lapack.dtrtrs(upper, right)[0]), np.asarray(lapack.dtrtri(upper)[0])


def fitted_root(columns: Array, prior: Array, sd: Array) -> Array:
    """Return a root of the covariance of what is fitted, columns·C·columnsᵀ with C as by `marginal`, shape (N, m).

    By singular values: between coordinates that are nearly alike C itself loses its digits.
    """
    directions, values, _ = np.linalg.svd(columns * prior / sd[:, None], full_matrices=False)
    return np.asarray(sd[:, None] * directions * (values / np.hypot(1.0, values)))


@dataclass(frozen=True)
class GroupPrediction:
    """A group as the others predict it."""

    rows: NDArray[np.bool_]
    """Data of the group, shape (N,)."""
    estimated: Array
    """Shared coordinates estimated from the others, less their prior means, shape (l,)."""
    log_score: float
    """ln p(group | the others)."""
    inside: int
    """Data of the group inside their 90 % predictive interval."""


@dataclass(frozen=True)
class LinearData:
    """Data as a fitted set of causes predicts them, linear about the fit."""

    y: Array
    sd: Array
    """Data less the prediction at the prior means, and the standard deviation of their noise, shape (N,)."""
    columns: Array
    """Derivatives along the coordinates, shape (N, a)."""
    prior: Array
    """Prior standard deviations of the coordinates, shape (a,)."""
    shared: NDArray[np.bool_]
    """Shape (a,). Constants of the base model and causes of the set, the same in all groups; the others are random
    effects."""
    groups: NDArray[np.str_]
    """Group of each datum, shape (N,)."""

    def predicted(self) -> list[GroupPrediction]:
        """Predict each group from the others.

        Causes of a set are the same in every group, as are the base model's constants: both are estimated from the
        other groups. Effects that are no causes are random effects of each group by itself (Laird & Ware 1982) with
        their prior, the spike. Were they estimated too, a record that fixes one sharply would fix it under every set
        alike, and no set would gain, however far it lies outside its spike.
        """
        rows = [self.groups == name for name in dict.fromkeys(self.groups.tolist())]
        both = np.concatenate([(self.columns * self.prior)[:, self.shared], self.y[:, None]], axis=1)
        random = (self.columns * self.prior)[:, ~self.shared]
        errors = [BlockCovariance.independent(self.sd[own], random[own]) for own in rows]
        white = [each.whitened(both[own]) for own, each in zip(rows, errors, strict=True)]
        found = []
        for k, own in enumerate(rows):
            seen = np.concatenate(white[:k] + white[k + 1 :])
            _, mean, root = _posterior(seen[:, -1], seen[:, :-1])
            columns, values = white[k][:, :-1], white[k][:, -1]
            expected = BlockCovariance.independent(np.ones(len(values)), columns @ root)
            log_score = float(expected.log_densities((values - columns @ mean)[:, None])[0])
            log_score -= 0.5 * errors[k].log_determinant
            inside = self._inside(own, mean, root)
            found.append(GroupPrediction(own, self.prior[self.shared] * mean, log_score, inside))
        return found

    def _inside(self, own: NDArray[np.bool_], mean: Array, root: Array) -> int:
        """Number of a group's data inside their 90 % predictive interval."""
        shared, random = (self.columns[own][:, part] * self.prior[part] for part in (self.shared, ~self.shared))
        variance = np.sum((shared @ root) ** 2, axis=1) + np.sum(random**2, axis=1) + self.sd[own] ** 2
        return int(np.sum(np.abs(self.y[own] - shared @ mean) <= QUANTILE_95 * np.sqrt(variance)))
