"""Model of a navigation log for the diagnosis: fits of sets of causes, their residuals and predictions, and designs."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from missionplan.arrays import Array
from missionplan.datasets.records import TransitData
from missionplan.diagnosis.inference.axes import Axis
from missionplan.diagnosis.inference.block_covariance import BlockCovariance
from missionplan.diagnosis.inference.marginal_likelihood import QUANTILE_95, Normal
from missionplan.diagnosis.inference.model import CauseFit, FailedFit, FitRequest, HeldOutScore
from missionplan.diagnosis.inference.residual_tests import Residuals
from missionplan.diagnosis.inference.selection import Progress, Selection, no_progress
from missionplan.diagnosis.legs.axes import transit_axes
from missionplan.diagnosis.legs.designs import DESIGNS, designs_for, with_further_legs
from missionplan.diagnosis.legs.fitting import TransitFitting
from missionplan.diagnosis.legs.likelihood.covariance import ALL_LEGS
from missionplan.diagnosis.legs.likelihood.linearised import LinearisedLegs
from missionplan.diagnosis.legs.search import beside_terms, infer, with_forms
from missionplan.diagnosis.legs.set_density import LegInference
from missionplan.diagnosis.legs.terms import terms_of
from missionplan.effects import exclusive_groups

ALTERNATIVES = exclusive_groups("transit")
"""Effects of which a set holds at most one: each describes how the errors are random."""


@dataclass(frozen=True)
class TransitModel(TransitFitting):
    """Base model of a mission's transit with every cause that the record could show."""

    @property
    def alternatives(self) -> Sequence[frozenset[str]]:
        """Groups of effects of which a set holds at most one."""
        return ALTERNATIVES

    def fit_all(self, wanted: Sequence[FitRequest]) -> list[CauseFit | FailedFit]:
        """Fit several sets of causes; one that cannot be fitted says why."""
        found: list[CauseFit | FailedFit] = []
        for causes, near in wanted:
            try:
                found.append(self.fit(causes, near))
            except np.linalg.LinAlgError as error:
                found.append(FailedFit(causes, str(error)))
        return found

    def all_sets(self, progress: Progress = no_progress, jobs: int = 1) -> Selection:
        """Return all sets of causes with their probabilities."""
        progress("weighing all sets of causes", 0, 1)
        return with_forms(beside_terms(infer(LegInference(self, terms_of(self))))).selection()

    def residuals(self, fit: CauseFit) -> Residuals:
        """Velocity errors leg by leg (first axis, second axis, next leg) and their covariance under a fit."""
        return self.residuals_along(fit, transit_axes(self.data, self.leg, self.axes))

    def residuals_along(self, fit: CauseFit, axes: Sequence[Axis]) -> Residuals:
        """Return the residuals with other axes to look along."""
        series, groups = np.tile([0, 1], self.data.n), np.repeat(self.data.labels, 2)
        covariance = self.error_covariance(fit, fit.state.linear)
        return Residuals(leg_by_leg(fit.state.linear.y), covariance, series, axes, groups)

    def error_covariance(self, fit: CauseFit, linear: LinearisedLegs) -> BlockCovariance:
        """Covariance of errors leg by leg under a fit's noise and the coefficients' priors: axes are independent."""
        values = fit.state.values
        noise, both = self.noise(values), 2 * np.arange(self.data.n)
        columns = linear.columns * linear.prior_sd(values)
        return BlockCovariance((both, both + 1), (noise[0], noise[1]), leg_by_leg(columns))

    def predicted(self, fit: CauseFit, seen: NDArray[np.int_], wanted: NDArray[np.int_]) -> Normal:
        """Predict legs from others under a fit, by the precision of all of them (Rue & Held 2005, Theorem 2.5).

        Parameters
        ----------
        fit : CauseFit
            Hyperparameters to use: those of a fit to the legs seen, or of an earlier part of them.
        seen, wanted : array of int
            The legs seen and the m legs predicted.

        Returns
        -------
        tuple of array
            Mean, shape (2, m), and covariance, shape (2m, 2m), leg by leg, of the velocity errors beyond the base
            model's mean [m/s].
        """
        linear, noise = fit.state.linear, self.noise_components(fit.state.values)
        rows = np.union1d(seen, wanted)
        legs, own = self.markov_covariance(rows), np.searchsorted(rows, wanted)
        ones = np.zeros((2, len(rows), 2 * len(own)))
        for axis in (0, 1):
            ones[axis, own, 2 * np.arange(len(own)) + axis] = 1.0
        columns = linear.columns[:, rows] * linear.prior_sd(fit.state.values)
        joined = np.concatenate([columns, ones, linear.y[:, rows, None]], axis=2)
        gram, _ = legs.gram(joined, noise.independent(legs.under_way), noise.fix_sd, noise.process)
        k = columns.shape[2]
        factor = np.linalg.cholesky(gram[:k, :k] + np.eye(k))
        half = solve_triangular(factor, gram[:k, k:], lower=True, check_finite=False)
        precision = gram[k:, k:] - half.T @ half
        covariance = np.asarray(np.linalg.inv(precision[:-1, :-1]), dtype=float)
        return self.y[:, wanted] - (covariance @ precision[:-1, -1]).reshape(-1, 2).T, covariance

    def one_step_errors(self, fit: CauseFit) -> Array:
        """Error of each leg's prediction from the legs before it, on the principal axes, shape (2, n) [m/s]."""
        linear = fit.state.linear
        errors = self.error_covariance(fit, linear).errors_ahead(leg_by_leg(linear.y), 2)
        return errors.reshape(-1, 2).T

    def blocks(self) -> list[NDArray[np.int_]]:
        """Blocks of consecutive legs to hold out: neighbours' errors are correlated (Roberts et al. 2017)."""
        count = int(np.clip(self.data.n // 5, 4, 8))
        return [np.asarray(block) for block in np.array_split(np.arange(self.data.n), count)]

    def held_out(self, fits: Sequence[CauseFit]) -> list[list[HeldOutScore]]:
        """Predict each block of legs from the others, with hyperparameters fitted to the others alone."""
        return [[self._block_score(fit, block) for block in self.blocks()] for fit in fits]

    def last_part_ahead(self, fit: CauseFit) -> HeldOutScore:
        """Predict the last third of the legs, all the way, with a fit to those before."""
        return self._block_score(fit, np.arange(self.data.n - self.data.n // 3, self.data.n))

    def _block_score(self, fit: CauseFit, block: NDArray[np.int_]) -> HeldOutScore:
        others = np.setdiff1d(np.arange(self.data.n), block)
        trained, model = self.refitted(fit, others), self.with_term(fit.state.term)
        state = trained.state
        whole, seen = (
            model.marginal(state.hyperparameters, state.posterior.mode, state.linear, rows)
            for rows in (ALL_LEGS, others)
        )
        log_score = whole.log_density - seen.log_density
        mean, covariance = model.predicted(trained, others, block)
        error = leg_by_leg(self.y[:, block] - mean)
        standardised = error / np.sqrt(np.diag(covariance))
        name = f"legs {self.data.labels[block[0]]} to {self.data.labels[block[-1]]}"
        inside = int((np.abs(standardised) <= QUANTILE_95).sum())
        return HeldOutScore(name, log_score, float(error @ error), inside, error.size, tuple(standardised.tolist()))

    @property
    def designs(self) -> Sequence[str]:
        """Further legs, in words, cheapest first."""
        return [DESIGNS[index][0] for index in designs_for(self.data)]

    def discrimination(self, first: CauseFit, second: CauseFit, entry: int | None) -> float:
        """Expected log Bayes factor of the first fit over the second, were the first true.

        Parameters
        ----------
        first, second : CauseFit
            Fits to compare.
        entry : int or None
            Of `designs`, added to the log; None for the log alone.
        """
        model = self if entry is None else self._with_design(entry)
        acting = model.with_term(first.state.term)
        own = np.array([coordinate.effect in first.causes for coordinate in acting.coordinates])
        signal = acting.columns_at(first) @ np.where(own, first.state.mean - acting.expected, 0.0)
        truth = model.error_covariance(first, model.linearised(()))
        entropies = []
        for fit in (first, second):
            acting = model.with_term(fit.state.term)
            linear = acting.linearised(fit.causes, fit.state.linear.about, fit.state.forms)
            usual = acting.columns_at(fit) @ (linear.prior.mean - acting.expected)
            covariance = acting.error_covariance(fit, linear)
            entropies.append(covariance.cross_entropy(truth, leg_by_leg(signal - usual)))
        return max(entropies[1] - entropies[0], 0.0)

    def columns_at(self, fit: CauseFit) -> Array:
        """Columns of the coordinates, where a term has to be linearised about a fit as this has it, shape (2, n, k)."""
        return self.columns_as_expected if self.acting is None else self.columns(fit.state.linear.about)

    def _with_design(self, entry: int) -> "TransitModel":
        """The model of the log with the legs of a design after it."""
        return self.of_longer(with_further_legs(self.data, designs_for(self.data)[entry]))

    def of_longer(self, data: TransitData) -> "TransitModel":
        """Return the model of the log with further legs after it."""
        added = np.repeat(self.base.mean(axis=1, keepdims=True), data.n - self.data.n, axis=1)
        current = np.broadcast_to(self.site_current, (2, self.data.n))
        current = np.concatenate(
            [current, np.repeat(current.mean(axis=1, keepdims=True), added.shape[1], axis=1)], axis=1
        )
        base = np.concatenate([self.base, added], axis=1)
        return replace(self, data=data, base=base, site_current=current, only=self.with_term(None).coordinates)


def leg_by_leg(values: Array) -> Array:
    """Values on both axes, shape (2, n, …), leg by leg: (2n, …)."""
    return values.swapaxes(0, 1).reshape(-1, *values.shape[2:])
