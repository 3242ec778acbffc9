"""Evidence of dives about a linearised model, from inner products that serve all priors and any of the dives."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack, solve_triangular

from missionplan.arrays import Array
from missionplan.diagnosis.dives.noise import noise_grid
from missionplan.diagnosis.inference.marginal_likelihood import Marginal, gaussian_marginal
from missionplan.diagnosis.inference.residuals import InnerProducts


@dataclass(frozen=True)
class Evidence:
    """Whitened inner products of a linearisation: its likelihood at each noise of the grid, for any of the dives.

    Attributes
    ----------
    grams : array, shape (g, d, k + 3, k + 3)
        For g noises and d dives: of the columns, what the dives share beside them and the data.
    log_determinants : array, shape (g, d)
        Of each dive's covariance.
    counts : array of int, shape (d,)
        Readings of each dive.
    """

    grams: Array
    log_determinants: Array
    counts: NDArray[np.int_]

    def marginals(self, prior_sd: Array, dives: NDArray[np.int_] | slice = slice(None)) -> list[Marginal]:
        """Marginalise all coordinates at each noise; dives are independent given them.

        The scatter of the separation smooths the jerk of every dive to the same side, and a lag's filter is of the
        same order in all: columns that they share.

        Parameters
        ----------
        prior_sd : array, shape (k,)
            Of the coordinates.
        dives : array of int or slice
            Dives to use; default all.
        """
        return [self.marginal(index, prior_sd, dives) for index in range(len(self.grams))]

    def marginal(self, index: int, prior_sd: Array, dives: NDArray[np.int_] | slice = slice(None)) -> Marginal:
        """Marginalise all coordinates at one noise of the grid."""
        gram, log_determinant = self.grams[index, dives].sum(axis=0), float(self.log_determinants[index, dives].sum())
        prior = np.append(prior_sd, [noise_grid()[index].scatter, 1.0])
        found = gaussian_marginal(gram, prior, log_determinant, int(self.counts[dives].sum()))
        return Marginal(found.log_density, found.mean[:-2], found.covariance[:-2, :-2])


def inner_products(covariance: Array, columns: Array) -> tuple[Array, Array]:
    """Inner products Xᵀ C⁻¹ X of a dive's columns, shape (m, c), and ln |C| at each of g noises: (g, c, c), (g,).

    Raises
    ------
    numpy.linalg.LinAlgError
        When a covariance, shape (g, m, m), is not positive definite.
    """
    factor = np.linalg.cholesky(covariance)
    white = np.stack([lapack.dtrtrs(one.T, columns, trans=1)[0] for one in factor])
    return np.swapaxes(white, 1, 2) @ white, 2.0 * np.log(np.diagonal(factor, axis1=1, axis2=2)).sum(axis=1)


def integrated(grams: Array, log_determinants: Array, prior_sd: Array) -> list[InnerProducts]:
    """Integrate the coordinates out of the inner products of other columns and the data, at each noise of the grid.

    Parameters
    ----------
    grams : array, shape (g, c, c)
        Of k coordinates' columns, what the dives share beside them, other columns and the data.
    log_determinants : array, shape (g,)
        Of the covariance.
    prior_sd : array, shape (k,)
        Of the coordinates.
    """
    found, inner = [], len(prior_sd) + 2
    for noise, gram, log_determinant in zip(noise_grid(), grams, log_determinants, strict=True):
        prior = np.append(prior_sd, [noise.scatter, 1.0])
        factor = np.linalg.cholesky(prior[:, None] * gram[:inner, :inner] * prior + np.eye(inner))
        known = solve_triangular(factor, prior[:, None] * gram[:inner, inner:], lower=True)
        total = float(log_determinant + 2.0 * np.log(np.diag(factor)).sum())
        found.append(InnerProducts(noise.log_prior, total, gram[inner:, inner:] - known.T @ known))
    return found
