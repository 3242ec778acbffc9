"""Model of a navigation log: fits of causes, what they leave, what they predict.

`transit_mean` holds the causes' columns, `transit_noise` the covariance: nothing is modelled here twice.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.stats import norm

from missionplan.arrays import Array
from missionplan.diagnosis.coordinates import Coordinate, estimates, has_shape, is_possible
from missionplan.diagnosis.inference.importance_sampling import SampledEvidence, sampled_evidence
from missionplan.diagnosis.inference.laplace import Laplace, laplace
from missionplan.diagnosis.inference.marginal_likelihood import LOG_2PI, Marginal, expected_log_ratio
from missionplan.diagnosis.inference.model import CauseFit, FailedFit, FitRequest, HeldOutScore
from missionplan.diagnosis.inference.residuals import Residuals
from missionplan.diagnosis.legs import designs as leg_designs
from missionplan.diagnosis.legs.axes import transit_axes
from missionplan.diagnosis.legs.chain import Rows
from missionplan.diagnosis.legs.mean import RANDOM, TURNING, WAVERING, Linear
from missionplan.diagnosis.legs.noise import ALL, Hyper, TransitNoise
from missionplan.results.diagnosis import Causes, ParameterEstimate

ALTERNATIVES = (frozenset({"persistent-error", "random-walk", "heavy-tails"}),)
ROUNDS, SETTLED = 5, 0.005
"""Times that angles and wavering currents are linearised, at most: until they move by less than this of a slab."""


@dataclass(frozen=True)
class TransitState:
    """A fitted transit: hyperparameters by Laplace, coefficients of all coordinates at their mode."""

    hypers: tuple[Hyper, ...]
    posterior: Laplace
    marginal: Marginal
    linear: Linear


@dataclass(frozen=True)
class TransitModel(TransitNoise):
    """Base model of a mission's transit and every cause that the record could show."""

    @property
    def alternatives(self) -> Sequence[frozenset[str]]:
        """Descriptions of the errors' randomness that exclude each other."""
        return ALTERNATIVES

    def fit(
        self, causes: Causes, near: Sequence[CauseFit] = (), rows: Rows = ALL, *, integrate: bool = True
    ) -> CauseFit:
        """Fit a set of causes: hyperparameters by Laplace, coefficients exactly, linearised where they end up.

        Parameters
        ----------
        causes : tuple of str
            The set.
        near : sequence of CauseFit
            Fits to start from.
        rows : slice or array
            Legs to fit; default all.
        integrate : bool
            Whether the evidence is wanted; without it only the mode is.

        Raises
        ------
        numpy.linalg.LinAlgError
            When no covariance near the start is positive definite.
        """
        hypers = self.hypers(causes)
        starts, spread = _starts(hypers, near)
        slabs = np.array([coordinate.slab for coordinate in self.coordinates])
        bends = bool({*TURNING, *WAVERING} & set(causes))
        about = self._guessed(causes, near) if bends else np.zeros(len(slabs))
        for turn in range(ROUNDS):
            linear = self.linearised(causes, about)
            found = self._climb(causes, hypers, starts, spread, linear, rows, integrate=integrate)
            best = self.marginal(causes, found.mode, linear, rows)
            state = TransitState(hypers, found, best, linear)
            moved, about = np.abs(best.mean[: len(about)] - about), best.mean[: len(about)]
            starts, spread = [found.mode], found.covariance
            if not bends or (turn and np.max(moved / slabs) < SETTLED):
                break
        return self._described(causes, state)

    def _guessed(self, causes: Causes, near: Sequence[CauseFit]) -> Array:
        """Coordinates of a set's causes as the fits of its parts have them; else zero."""
        guess = np.zeros(len(self.coordinates))
        for fit in reversed(near):
            own = [i for i, c in enumerate(self.coordinates) if c.effect in fit.causes and c.effect in causes]
            guess[own] = fit.state.marginal.mean[own]
        return guess

    def fit_all(self, wanted: Sequence[FitRequest]) -> list[CauseFit | FailedFit]:
        """Fit several sets of causes; one that cannot be fitted says why."""
        found: list[CauseFit | FailedFit] = []
        for causes, near in wanted:
            try:
                found.append(self.fit(causes, near))
            except np.linalg.LinAlgError as error:
                found.append(FailedFit(causes, str(error)))
        return found

    def relinearised(self, fits: Sequence[CauseFit | FailedFit], best: float) -> list[CauseFit | FailedFit]:
        """Fits are where they should be."""
        return list(fits)

    def estimated_gain(self, causes: Causes, parent: CauseFit) -> float:
        """What the causes beyond a parent's would add to its log density, its hyperparameters held; inf if unknown."""
        if any(name in (*RANDOM, *WAVERING) for name in causes if name not in parent.causes):
            return math.inf
        mode, nowhere = parent.state.posterior.mode, np.zeros(len(self.coordinates))
        with_it, without = (
            self.marginal(names, mode, self.linearised(names, nowhere)) for names in (causes, parent.causes)
        )
        return with_it.log_density - without.log_density

    def may_be_multimodal(self, causes: Causes) -> bool:
        """Whether a cause has a shape of its own."""
        return has_shape(causes)

    def residuals(self, fit: CauseFit) -> Residuals:
        """Velocity errors leg by leg (first axis, second axis, next leg) and their covariance under a fit."""
        linear = fit.state.linear
        covariance = self._total_covariance(fit, linear)
        n = self.data.n
        order = np.arange(2 * n).reshape(2, n).T.ravel()
        return Residuals(
            linear.y.ravel()[order],
            covariance[np.ix_(order, order)],
            np.tile([0, 1], n),
            transit_axes(self.data, self.leg, self.axes),
            np.repeat(self.data.labels, 2),
        )

    def _total_covariance(self, fit: CauseFit, linear: Linear) -> Array:
        """Covariance of all errors under a fit's noise and the coefficients' priors, first axis then second."""
        noise = self.noise(self.values(fit.causes, fit.state.posterior.mode))
        n = self.data.n
        scaled = (linear.columns * linear.prior_sd).reshape(2 * n, -1)
        total = scaled @ scaled.T
        total[:n, :n] += noise[0]
        total[n:, n:] += noise[1]
        return total

    def predictor(self, fit: CauseFit) -> Callable[[NDArray[np.int_], NDArray[np.int_]], tuple[Array, Array]]:
        """Predict legs from others under a fit.

        Parameters
        ----------
        fit : CauseFit
            Hyperparameters to use: those of a fit to the legs seen, or of an earlier part of them.

        Returns
        -------
        callable
            Of the legs seen and the legs asked for: mean, shape (2, m), and covariance, shape (2m, 2m), first axis
            then second, of the velocity errors beyond the base model's mean [m/s].
        """
        y = fit.state.linear.y
        total = self._total_covariance(fit, fit.state.linear)
        n = self.data.n

        def predict(seen: NDArray[np.int_], asked: NDArray[np.int_]) -> tuple[Array, Array]:
            have, want = (np.concatenate([legs, legs + n]) for legs in (seen, asked))
            weights = np.linalg.solve(total[np.ix_(have, have)], total[np.ix_(have, want)]).T
            mean = (weights @ y.ravel()[have]).reshape(2, -1) + (self.y - y)[:, asked]
            return mean, total[np.ix_(want, want)] - weights @ total[np.ix_(have, want)]

        return predict

    def one_step_errors(self, fit: CauseFit) -> Array:
        """Error of each leg's prediction from the legs before it, on the principal axes, shape (2, n) [m/s]."""
        residuals = self.residuals(fit)
        factor = np.linalg.cholesky(residuals.covariance)
        innovations = solve_triangular(factor, residuals.values, lower=True, check_finite=False).reshape(-1, 2)
        places = 2 * np.arange(self.data.n)
        own = np.stack([[factor[places + i, places + j] for j in (0, 1)] for i in (0, 1)])
        return np.asarray(np.einsum("ijn,nj->in", own, innovations))

    def blocks(self) -> list[NDArray[np.int_]]:
        """Blocks of consecutive legs that are held out in turn."""
        count = int(np.clip(self.data.n // 5, 4, 8))
        return [np.asarray(block) for block in np.array_split(np.arange(self.data.n), count)]

    def held_out(self, fits: Sequence[CauseFit]) -> list[list[HeldOutScore]]:
        """Predict each block of legs from the others, hyperparameters fitted to the others alone."""
        return [self._block_scores(fit) for fit in fits]

    def _block_scores(self, fit: CauseFit) -> list[HeldOutScore]:
        scores = []
        for block in self.blocks():
            others = np.setdiff1d(np.arange(self.data.n), block)
            trained = self.fit(fit.causes, (fit,), others, integrate=False)
            linear = trained.state.linear
            mode = trained.state.posterior.mode
            log_score = (
                self.marginal(fit.causes, mode, linear).log_density
                - self.marginal(fit.causes, mode, linear, others).log_density
            )
            mean, covariance = self.predictor(trained)(others, block)
            error = (self.y[:, block] - mean).ravel()
            half = norm.ppf(0.95) * np.sqrt(np.diag(covariance))
            name = f"legs {self.data.labels[block[0]]} to {self.data.labels[block[-1]]}"
            inside = int((np.abs(error) <= half).sum())
            scores.append(HeldOutScore(name, log_score, float(error @ error), inside, error.size))
        return scores

    @property
    def designs(self) -> Sequence[str]:
        """Further legs, in words, cheapest first."""
        names = [what for what, _ in leg_designs.DESIGNS]
        return names if self.data.has_surface_time else [name for name in names if "fix 15" not in name]

    def discrimination(self, first: CauseFit, second: CauseFit, entry: int | None) -> float:
        """Expected ln Bayes factor under the first set's fit; see `expected_log_ratio`."""
        model = self
        if entry is not None:
            names = [what for what, _ in leg_designs.DESIGNS]
            data = leg_designs.planned(self.data, names.index(self.designs[entry]))
            added = np.repeat(self.base.mean(axis=1, keepdims=True), data.n - self.data.n, axis=1)
            model = replace(self, data=data, base=np.concatenate([self.base, added], axis=1), only=self.coordinates)
        own = np.array([coordinate.effect in first.causes for coordinate in self.coordinates])
        found = np.where(own, first.state.marginal.mean[: len(own)], 0.0)
        nowhere = model.linearised((), np.zeros(len(own)))
        mean = (nowhere.columns @ found).ravel()
        truth = model._total_covariance(first, nowhere)
        wide = [
            model._total_covariance(fit, model.linearised(fit.causes, fit.state.linear.about))
            for fit in (first, second)
        ]
        return max(expected_log_ratio(mean, truth, *wide), 0.0)

    def _climb(
        self,
        causes: Causes,
        hypers: tuple[Hyper, ...],
        starts: list[Array],
        guess: Array,
        linear: Linear,
        rows: Rows,
        *,
        integrate: bool,
    ) -> Laplace:
        def log_posterior(at: Array) -> float:
            return _log_prior(hypers, at) + self.marginal(causes, at, linear, rows).log_density

        return laplace(log_posterior, starts, guess, integrate=integrate)

    def sampled_evidence(self, fit: CauseFit) -> SampledEvidence:
        """Integrate over the hyperparameters; the causes of the mean exactly, as in the fit."""
        state, linear = fit.state, fit.state.linear

        def log_joint(at: Array) -> float:
            try:
                return _log_prior(state.hypers, at) + self.marginal(fit.causes, at, linear).log_density
            except np.linalg.LinAlgError:
                return -math.inf

        def all_of(draws: Array) -> Array:
            return np.array([log_joint(at) for at in draws])

        return sampled_evidence(all_of, state.posterior.mode, state.posterior.covariance)

    def _described(self, causes: Causes, state: TransitState) -> CauseFit:
        chosen = [i for i, coordinate in enumerate(self.coordinates) if coordinate.effect in causes]
        own, marginal = [self.coordinates[i] for i in chosen], state.marginal
        # the cause lies beside what one is unsure of from record to record anyway
        unsure = np.diag([coordinate.spike**2 for coordinate in own])
        found = estimates(own, marginal.mean[chosen], marginal.covariance[np.ix_(chosen, chosen)] + unsure)
        found += _hyper_estimates(state)
        calibration = {
            f"{h.name}_{'m' if h.name == 'fix_sd' else 'm_s'}": math.exp(value)
            for h, value in zip(state.hypers, state.posterior.mode, strict=True)
            if not h.effect
        }
        return CauseFit(causes, state.posterior.log_evidence, found, calibration, is_possible(found), state)


def _log_prior(hypers: tuple[Hyper, ...], at: Array) -> float:
    """Of the hyperparameters' logarithms."""
    spread = np.array([hyper.spread for hyper in hypers])
    scaled = (at - np.array([hyper.centre for hyper in hypers])) / spread
    return -0.5 * float(scaled @ scaled) - float(np.log(spread).sum()) - 0.5 * len(at) * LOG_2PI


def _starts(hypers: tuple[Hyper, ...], near: Sequence[CauseFit]) -> tuple[list[Array], Array]:
    """Where to climb from, and a guess of the posterior covariance.

    The parts' fits where there are any, else the priors' centres; a new hyperparameter also a spread up and down.
    """
    known: dict[tuple[str, str], tuple[float, float]] = {}
    for fit in near:
        modes, variances = fit.state.posterior.mode, np.diag(fit.state.posterior.covariance)
        for hyper, mode, variance in zip(fit.state.hypers, modes, variances, strict=True):
            known.setdefault((hyper.effect, hyper.name), (float(mode), float(variance)))
    guesses = [known.get((h.effect, h.name), (h.centre, min(0.1, h.spread**2))) for h in hypers]
    first = np.array([guess[0] for guess in guesses])
    starts = [first]
    for index, hyper in enumerate(hypers):
        if hyper.effect and (hyper.effect, hyper.name) not in known:
            for shift in (-1.0, 1.0):
                moved = first.copy()
                moved[index] += shift * hyper.spread
                starts.append(moved)
    return starts, np.diag([guess[1] for guess in guesses])


def _hyper_estimates(state: TransitState) -> tuple[ParameterEstimate, ...]:
    chosen = [i for i, hyper in enumerate(state.hypers) if hyper.effect]
    shapes = [Coordinate(h.effect, h.name, "shape", h.centre, h.spread, 0.0) for h in (state.hypers[i] for i in chosen)]
    return estimates(shapes, state.posterior.mode[chosen], state.posterior.covariance[np.ix_(chosen, chosen)])
