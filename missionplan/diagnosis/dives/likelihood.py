"""Likelihood of dives under a linearised model: linear and Gaussian, coordinates integrated out, on a grid of noises.

Dives are independent given the coordinates and what all dives share. Whitened inner products of their columns are
computed once and serve all priors and any choice of dives: the marginal likelihood and the posterior of a linear
Gaussian model need no more (Bishop 2006, *Pattern Recognition and Machine Learning*, section 3.5).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag, lapack

from missionplan.arrays import Array
from missionplan.diagnosis.dives.linearised import DiveLinearisation, LinearisedDescent
from missionplan.diagnosis.dives.noise import (
    Noise,
    dive_to_dive_covariance,
    noise_grid,
    sensor_and_turbulence_covariance,
    shape_error_covariance,
)
from missionplan.diagnosis.inference.block_covariance import BlockCovariance, InnerProducts
from missionplan.diagnosis.inference.marginal_likelihood import (
    Marginal,
    gaussian_log_density,
    gaussian_marginal,
    standardised,
)

ALL_DIVES = slice(None)


@dataclass(frozen=True)
class NoiseGridLikelihood:
    """Likelihood of a linearisation at each of the grid's g noises, for any of the d dives."""

    grams: Array
    """Whitened inner products of the k coordinates' columns, the curvature's, and the data, shape (g, d, k + 2, k + 2).
    """
    log_determinants: Array
    """Ln |covariance| of each dive's readings, shape (g, d)."""
    counts: NDArray[np.int_]
    """Readings of each dive, shape (d,)."""

    @property
    def as_one(self) -> "NoiseGridLikelihood":
        """That of all dives as of one."""
        grams, log_determinants = (terms.sum(axis=1, keepdims=True) for terms in (self.grams, self.log_determinants))
        return NoiseGridLikelihood(grams, log_determinants, self.counts.sum(keepdims=True))

    def log_joint(self, prior_sd: Array, dives: NDArray[np.int_] | slice = ALL_DIVES) -> Array:
        """Log density of the data at each noise of the grid, plus the log prior of the noise, shape (g,).

        Parameters
        ----------
        prior_sd : array, shape (k,)
            Of the coordinates, which are integrated out.
        dives : array of int or slice
            Dives to use; default all.
        """
        noises = enumerate(noise_grid())
        return np.array([noise.log_prior + gaussian_log_density(*self._at(i, prior_sd, dives)) for i, noise in noises])

    def marginal(self, index: int, prior_sd: Array) -> Marginal:
        """Marginalise all coordinates, shape (k,), and the curvature, at one noise of the grid."""
        marginal = gaussian_marginal(*self._at(index, prior_sd, ALL_DIVES))
        return Marginal(marginal.log_density, marginal.mean[:-1], marginal.covariance[:-1, :-1])

    def _at(self, index: int, prior_sd: Array, dives: NDArray[np.int_] | slice) -> tuple[Array, Array, float, int]:
        """Inner products of some dives at a noise, prior with the curvature's, ln |covariance|, number of readings."""
        gram, log_determinant = self.grams[index, dives].sum(axis=0), float(self.log_determinants[index, dives].sum())
        # the scatter of the release delay smooths the jerk of every dive to the same side: one coefficient for all
        scatter, is_diagonal = noise_grid()[index].scatter, prior_sd.ndim == 1
        prior = np.append(prior_sd, scatter) if is_diagonal else np.asarray(block_diag(prior_sd, [scatter]))
        return gram, prior, log_determinant, int(self.counts[dives].sum())


@dataclass(frozen=True)
class DescentLikelihood(LinearisedDescent):
    """The linearised descent with the covariance of its residuals."""

    def covariances(self, linear: DiveLinearisation, noises: tuple[Noise, ...]) -> list[Array]:
        """Covariance of each dive's readings beside the catalogue's coordinates, at each of g noises: (g, m, m) [m²].

        The part of the readings due to causes with shape parameters is uncertain by a smooth factor, `SHAPE_SD`.
        """
        cache = self._known_fixed_covariances  # of the readings, which no fit changes
        if noises not in cache:
            cache[noises] = [sensor_and_turbulence_covariance(log.t, log.sd, noises) for log in self.forward.logs]
        return [
            fixed
            + dive_to_dive_covariance(linear.sensitivities[rows], linear.curvature[rows], noises)
            + shape_error_covariance(log.t, linear.shaped[rows])
            for fixed, log, rows in zip(cache[noises], self.forward.logs, self.parts, strict=True)
        ]

    @cached_property
    def _known_fixed_covariances(self) -> dict[tuple[Noise, ...], list[Array]]:
        return {}

    def covariance(self, linear: DiveLinearisation, noise: Noise, prior_sd: Array) -> BlockCovariance:
        """Covariance of all readings with the coordinates' priors [m²]."""
        columns = standardised(linear.columns, prior_sd)
        root = np.concatenate([columns, noise.scatter * linear.curvature[:, None]], axis=1)
        return BlockCovariance(self.parts, tuple(block[0] for block in self.covariances(linear, (noise,))), root)

    def likelihood(self, linear: DiveLinearisation) -> NoiseGridLikelihood:
        """Likelihood of a linearisation at every noise of the grid.

        Raises
        ------
        numpy.linalg.LinAlgError
            When a covariance is not positive definite.
        """
        both = np.concatenate([linear.columns, linear.curvature[:, None], linear.y[:, None]], axis=1)
        of_dives = zip(self.parts, self.covariances(linear, noise_grid()), strict=True)
        grams, log_determinants = zip(*(inner_products(block, both[rows]) for rows, block in of_dives), strict=True)
        counts = np.array([len(rows) for rows in self.parts])
        return NoiseGridLikelihood(np.stack(grams, axis=1), np.stack(log_determinants, axis=1), counts)

    def products(
        self, linear: DiveLinearisation, prior_sd: Array, columns: Array, noises: tuple[Noise, ...]
    ) -> Iterator[InnerProducts]:
        """Inner products of columns, shape (N, m), and the data, the coordinates integrated out, at noises."""
        for noise in noises:
            yield self.covariance(linear, noise, prior_sd).products(columns, linear.y, noise.log_prior)

    def log_densities(
        self, linear: DiveLinearisation, prior_sd: Array, residuals: Array, noises: tuple[Noise, ...]
    ) -> Array:
        """Log density of residuals, shape (N, s), by a linearisation's covariance at each noise, shape (g, s)."""
        finite = np.all(np.isfinite(residuals), axis=0)
        finite_residuals = np.where(finite, residuals, 0.0)
        logs = np.stack([self.covariance(linear, noise, prior_sd).log_densities(finite_residuals) for noise in noises])
        return np.where(finite, logs, -np.inf)


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
