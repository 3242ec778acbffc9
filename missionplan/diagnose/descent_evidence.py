"""Evidence of dives about a linearised model, from inner products that serve all priors and any of the dives."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.diagnose.descent_noise import grid
from missionplan.diagnose.likelihood import Marginal, marginal_of

Array = NDArray[np.float64]


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
        prior = np.append(prior_sd, [grid()[index].scatter, 1.0])
        found = marginal_of(gram, prior, log_determinant, int(self.counts[dives].sum()))
        return Marginal(found.log_density, found.mean[:-2], found.covariance[:-2, :-2])
