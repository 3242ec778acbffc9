"""Fits of sets of causes to tank data: most likely coordinates, then evidence about them, summed over noise sizes.

About a fit the data are linear with normal priors: coordinates are marginalised, groups predicted from the others
(linear Gaussian models, as in Bishop 2006, *Pattern Recognition and Machine Learning*, sections 2.3.3 and 3.5).
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack
from scipy.special import logsumexp

from missionplan.arrays import Array
from missionplan.diagnosis.coordinates import Coordinate, coordinates_of, estimates, is_possible, parameters_from
from missionplan.diagnosis.given import GivenEffect, RecordPosterior, coordinate_prior, held
from missionplan.diagnosis.inference.block_covariance import BlockCovariance
from missionplan.diagnosis.inference.gauss_newton import (
    GaussNewtonOptions,
    GaussNewtonResult,
    LeastSquares,
    Start,
    gauss_newton,
)
from missionplan.diagnosis.inference.marginal_likelihood import LOG_2PI, QUANTILE_95, Marginal
from missionplan.diagnosis.inference.model import CauseFit, FailedFit, FitRequest
from missionplan.diagnosis.inference.prior import Prior, integrated
from missionplan.diagnosis.tank.forward import TankForward
from missionplan.effects import CATALOGUE
from missionplan.results.learned.evidence import Causes


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
        errors = [BlockCovariance.independent(self.sd[group], random[group]) for group in rows]
        white = [covariance.whitened(both[group]) for group, covariance in zip(rows, errors, strict=True)]
        predictions = []
        for k, group in enumerate(rows):
            seen = np.concatenate(white[:k] + white[k + 1 :])
            _, mean, root = _posterior(seen[:, -1], seen[:, :-1])
            columns, values = white[k][:, :-1], white[k][:, -1]
            expected = BlockCovariance.independent(np.ones(len(values)), columns @ root)
            log_score = float(expected.log_densities((values - columns @ mean)[:, None])[0])
            log_score -= 0.5 * errors[k].log_determinant
            fixed, free = (self.columns[group][:, part] * self.prior[part] for part in (self.shared, ~self.shared))
            variance = np.sum((fixed @ root) ** 2, axis=1) + np.sum(free**2, axis=1) + self.sd[group] ** 2
            inside = int(np.sum(np.abs(self.y[group] - fixed @ mean) <= QUANTILE_95 * np.sqrt(variance)))
            predictions.append(GroupPrediction(group, self.prior[self.shared] * mean, log_score, inside))
        return predictions


SEARCH = GaussNewtonOptions(
    iterations=40,
    tolerance=1e-3,
    difference=1e-4,
    central=True,
    step_lengths=tuple(0.5**k for k in range(8)),
)
"""The derivatives at its end are those of the linearised model, hence central differences."""
STATED_NOISE_LOG_SD, UNSTATED_NOISE_LOG_SD = 0.4, 2.3
"""Prior standard deviation of ln(noise factor), where the noise is stated and where it is not."""
SHAPE_SHIFTS = (-1.2, 0.0, 1.2)
"""Starts of a shape parameter about its prior mean, in its logarithm: from a third to three times its usual size."""


@dataclass(frozen=True)
class TankState:
    """State of a fit."""

    at: Array
    """Coordinates, shape (k,)."""
    residuals: Array
    """Data less the model there, shape (N,) [SI]."""
    columns: Array
    """Derivatives along the active coordinates, shape (N, a)."""
    active: NDArray[np.int_]
    """Coordinates with a prior of some width, shape (a,)."""
    factor: float
    """Most likely factor on the noise."""
    prior_sd: Array
    """Prior standard deviations of the active coordinates, the slabs at their likeliest scales, shape (a,)."""
    marginal: Marginal
    """Posterior of the active coordinates at that factor."""


@dataclass(frozen=True)
class TankFitting:
    """Base model of a tank experiment and the effects that it may lack, bound to data.

    Every array of k coordinates begins with the nuisance parameters of the base model, about their prior means.
    """

    forward: TankForward
    """Data and base model."""
    noise_known: bool = False
    """Whether the noise is exactly as stated."""
    given: tuple[GivenEffect, ...] = ()
    """What the mission knows of the candidates."""

    @property
    def candidates(self) -> Causes:
        """Effects that these data could show."""
        return self.forward.candidates

    @cached_property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Coordinates of the candidates, without the nuisance parameters."""
        originals = (c for name in self.candidates for c in coordinates_of(CATALOGUE[name]))
        return tuple(replace(c, spike=CATALOGUE[c.effect].parameters[c.name].tank_spike or c.spike) for c in originals)

    @property
    def fixed(self) -> int:
        """Number of nuisance parameters."""
        return len(self.forward.nuisances)

    def prior(self, causes: Causes) -> Prior:
        """Prior of the coordinates; what the mission knows of several together it knows of each."""
        prior = replace(coordinate_prior(self.coordinates, causes, self.given), tied=())
        nuisances = self.forward.nuisances
        return prior.preceded(np.array([n.centre for n in nuisances]), np.array([n.sd for n in nuisances]))

    def is_of(self, causes: Causes, index: int) -> bool:
        """Whether a coordinate is one of the causes'."""
        return index >= self.fixed and self.coordinates[index - self.fixed].effect in causes

    def predict(self, causes: Causes, settings: Array) -> Array:
        """Predict the data under m settings of the coordinates, (k, m) → (N, m).

        An effect without a strength is present as a cause, or as the mission's own, only.
        """
        shown = {*causes, *(prior.effect for prior in held(self.given, causes))}
        parameters = parameters_from(self.coordinates, list(settings[self.fixed :]))
        present = {
            name: values
            for name, values in parameters.items()
            if name in shown or any(c.kind != "shape" for c in self.coordinates if c.effect == name)
        }
        effects = [CATALOGUE[name].make(values) for name, values in present.items()]
        return self.forward.predict(settings[: self.fixed], effects)

    def fit_all(self, wanted: Sequence[FitRequest]) -> list[CauseFit | FailedFit]:
        """Fit several sets, one after the other."""
        return [self._fit(causes, near) for causes, near in wanted]

    def _fit(self, causes: Causes, near: Sequence[CauseFit]) -> CauseFit | FailedFit:
        prior = self.prior(causes)
        active = np.flatnonzero(prior.sd > 0.0)
        starts = [Start(at, active, group, prior=prior) for group, at in enumerate(self._starting_points(causes, near))]
        best = min(self._search(causes, starts), key=lambda result: result.objective)
        if not np.isfinite(best.objective):
            return FailedFit(causes, "the model has no value at any of its starts")
        chosen = prior.of(active)
        y = self.forward.y - best.prediction + best.jacobian @ (best.at[active] - chosen.centre)

        def of_noise(index: int, root: Array) -> Marginal:
            return marginal(y, best.jacobian, root, self.noise_factors[index] * self.forward.sd)

        def log_joint(root: Array) -> Array:
            noises = range(len(self.noise_factors))
            return np.asarray(self.noise_log_prior + [of_noise(index, root).log_density for index in noises])

        try:
            whole = integrated(log_joint, of_noise, chosen)
        except np.linalg.LinAlgError as error:
            return FailedFit(causes, str(error))
        residuals, factor = self.forward.y - best.prediction, float(self.noise_factors[whole.noise])
        posterior = replace(whole.marginal, mean=chosen.centre + whole.marginal.mean)
        state = TankState(best.at, residuals, best.jacobian, active, factor, whole.prior_sd, posterior)
        cut = self._posterior(active, whole.inside.mean, whole.inside.covariance)
        record = self._posterior(active, posterior.mean, posterior.covariance)
        rows = [k for k, coordinate in enumerate(cut.coordinates) if coordinate.effect in causes]
        parameters = estimates([cut.coordinates[k] for k in rows], cut.mean[rows], cut.covariance[np.ix_(rows, rows)])
        priors = held(self.given, causes)
        after, together, possible = record.known(priors), record.afterwards(priors, rows), is_possible(parameters)
        constants = {n.name: float(v) for n, v in zip(self.forward.nuisances, state.at, strict=False)}
        noise = float(np.median(self.forward.sd)) * state.factor
        calibration = constants | {f"noise_{self.forward.quantity}": noise}
        return CauseFit(causes, whole.log_evidence, parameters, calibration, possible, state, after, together)

    def _search(self, causes: Causes, starts: Sequence[Start]) -> list[GaussNewtonResult]:
        """Search from every start; each is a group of its own, so that none is abandoned."""
        forward, factors = self.forward, (float(self.noise_factors[0]), float(self.noise_factors[-1]))
        model = partial(self.predict, causes)
        prior = self.prior(causes)
        problem = LeastSquares(model, forward.y, forward.sd, prior.centre, prior.sd, factors)
        return gauss_newton(problem, starts, SEARCH)

    def plain_residuals(self) -> Array:
        """Residuals of the base model, its nuisance parameters fitted, shape (N,) [SI]."""
        (result,) = self._search((), [Start(self.prior(()).centre, np.arange(self.fixed), 0)])
        return np.asarray(self.forward.y - result.prediction)

    def _starting_points(self, causes: Causes, near: Sequence[CauseFit]) -> list[Array]:
        """Points to search from: where fits of the set's parts ended, and every start of the causes' parameters."""
        begin = self.prior(causes).centre
        for fit in reversed(near):
            begin[fit.state.active] = fit.state.at[fit.state.active]
        choices = []
        for here, c in zip(begin[self.fixed :], self.coordinates, strict=True):
            starts = self.forward.starts.get((c.effect, c.name), ())
            if c.kind == "shape":
                starts = tuple(c.centre + shift for shift in SHAPE_SHIFTS)
            choices.append((*starts, here) if c.effect in causes else (here,))
        return [np.concatenate([begin[: self.fixed], choice]) for choice in itertools.product(*choices)]

    @property
    def _noise_log_sd(self) -> float:
        return STATED_NOISE_LOG_SD if self.forward.stated else UNSTATED_NOISE_LOG_SD

    @cached_property
    def noise_factors(self) -> Array:
        """Factors on the sensor's noise over which the evidence is summed, evenly in their logarithm, shape (g,)."""
        if self.noise_known:
            return np.ones(1)
        reach = 5.0 if self.forward.stated else 3.0
        count = 121 if self.forward.stated else 241
        return np.exp(np.linspace(-reach * self._noise_log_sd, reach * self._noise_log_sd, count))

    @property
    def noise_log_prior(self) -> Array:
        """Log prior weight of each noise factor, normalised, shape (g,)."""
        log_prior = -0.5 * (np.log(self.noise_factors) / self._noise_log_sd) ** 2
        return np.asarray(log_prior - logsumexp(log_prior))

    def _posterior(self, active: NDArray[np.int_], mean: Array, covariance: Array) -> RecordPosterior:
        """Posterior of the active coordinates without the nuisance parameters."""
        rows = np.flatnonzero(active >= self.fixed)
        coordinates = [self.coordinates[index - self.fixed] for index in active[rows]]
        return RecordPosterior(coordinates, mean[rows], covariance[np.ix_(rows, rows)])
