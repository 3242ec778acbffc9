"""Levels of a vehicle's parameter from mission to mission, which drift, jump and are drawn anew, from measurements.

The value in mission i, at the time tᵢ counted in missions, is

> vᵢ = first level + trend·(tᵢ − t₀) + walk(tᵢ) + jumps up to i + what mission i has of its own,

all of it normal, and a measurement is vᵢ with an error. Which missions jump, whether there is a trend, and the sizes of
the walk and of what is drawn anew are weighed by their evidence, and all that is told is a mean over them: a mixture
of linear Gaussian models (Harrison & Stevens 1976, *J. R. Stat. Soc. B* 38, 205–247).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np
import scipy
from numpy.typing import NDArray

from missionplan.arrays import Array

MOST = 24
"""Measurements that tell of a level, the last."""
MOST_JUMPS, KEPT, APART = 3, 8, 9.0
"""Jumps of a history, sets of jumps to which a further one is added, and nats below the best beyond which none is."""
REDRAWN = ((0.0, 0.75), (3.5, 0.1), (12.0, 0.15))
"""Sizes of what a mission has of its own beyond the usual, over the usual one, and their prior probabilities."""
WALKS = ((0.0, 0.97), (1.0, 0.03))
"""Likewise of the walk."""
DAY = 86400.0
"""Time within which records are of one mission [s]."""
LevelKey = tuple[str, str, str]
"""Effect, parameter (of a polar pair the amplitude) and kind of coordinate."""


@dataclass(frozen=True)
class Ageing:
    """How the levels of a kind of parameter go from mission to mission, before its own missions tell."""

    trend: float
    walk: float
    """Standard deviation of the change a mission where there is a trend, and of that of a walk."""
    redrawn: float
    """Usual standard deviation of what each mission has of its own, which the errors of measurements hold."""
    jump: float
    """Standard deviation of a jump."""
    is_trend: float
    """Probability that there is a trend."""
    is_jump: float
    """Probability that a mission jumps."""


@dataclass(frozen=True)
class Seen:
    """What one record tells of a level by itself, or what was known of it before the first."""

    of: LevelKey
    record: str
    """Hash of its legs, dives or runs; empty for what was known before the first."""
    date: float
    """Of the record [s since 1970]; nan where it is not known."""
    value: float
    sd: float


@dataclass(frozen=True)
class Measured:
    """Measurements of a level, n of them."""

    times: Array
    """Shape (n,). Counted in missions, ascending; those of one mission have the same."""
    values: Array
    sds: Array
    """Shape (n,)."""
    first: float
    first_sd: float
    """Mean and standard deviation of the level of the first, before its measurement."""

    @property
    def begins(self) -> NDArray[np.bool_]:
        """Whether each is the first of a mission that follows another, shape (n,)."""
        return np.diff(self.times, prepend=self.times[0]) > 0.0


@dataclass(frozen=True)
class _Models:
    """Linear Gaussian models that were weighed, m of them."""

    log_weights: Array
    redrawn: Array
    walk: Array
    trend: Array
    """Variances of what is drawn anew, of a walk in one mission and of a trend; shape (m,), as the weights."""
    jumps: NDArray[np.bool_]
    """At which measurement each jumps, shape (m, n)."""

    @property
    def likely(self) -> "_Models":
        """Those that are not far below the best."""
        is_likely = self.log_weights > self.log_weights.max() - APART
        return _Models(*(values[is_likely] for values in vars(self).values()))


@dataclass(frozen=True)
class Levels:
    """What is known of a level at any time, after its measurements."""

    measured: Measured
    ageing: Ageing
    models: _Models

    @property
    def weights(self) -> Array:
        """Probabilities of the models, shape (m,)."""
        shares = np.exp(self.models.log_weights - self.models.log_weights.max())
        return np.asarray(shares / shares.sum())

    @cached_property
    def _inverse(self) -> Array:
        return np.asarray(np.linalg.inv(_of_measurements(self.measured, self.ageing, self.models)))

    def under_each(self, times: Array) -> tuple[Array, Array]:
        """Mean and variance of the value at times under each model, (m, q) each.

        At the time of a measurement it is the value that was measured, else that of a mission yet unseen.
        """
        measured = self.measured
        across = _covariance(times, measured.times, measured, self.ageing, self.models)
        across = across + self.models.redrawn[:, None, None] * (times[:, None] == measured.times)
        gain = across @ self._inverse
        mean = measured.first + gain @ (measured.values - measured.first)
        before = _covariance(times, times, measured, self.ageing, self.models)
        alone = np.diagonal(before, axis1=1, axis2=2) + self.models.redrawn[:, None]
        return np.asarray(mean), np.asarray(np.maximum(alone - np.sum(gain * across, axis=2), 1e-300))

    def at(self, times: Array) -> tuple[Array, Array]:
        """Mean and standard deviation of the value at times, shape (q,) each."""
        mean, variance = self.under_each(times)
        return _mixed(self.weights, mean, variance)

    @property
    def jumps(self) -> Array:
        """Probability that the level jumped between each measurement and the one before, shape (n,)."""
        return np.asarray(self.weights @ self.models.jumps)

    @property
    def trend(self) -> tuple[float, float, float]:
        """Trend a mission, its standard deviation, and the probability that there is one of this sign."""
        measured, models = self.measured, self.models
        since = measured.times - measured.times[0]
        gain = np.einsum("m,j,mjk->mk", models.trend, since, self._inverse)
        means = gain @ (measured.values - measured.first)
        variances = np.maximum(models.trend * (1.0 - gain @ since), 0.0)
        has_trend = models.trend > 0.0
        share = self.weights * has_trend
        if not share.sum() > 0.0:
            return 0.0, 0.0, 0.0
        mean, sd = _mixed(share / share.sum(), means[:, None], variances[:, None])
        side = math.copysign(1.0, mean[0])
        towards = scipy.special.ndtr(side * means[has_trend] / np.sqrt(np.maximum(variances[has_trend], 1e-300)))
        return float(mean[0]), float(sd[0]), float(share[has_trend] @ towards)


def levels(measured: Measured, ageing: Ageing) -> Levels:
    """Weigh all ways in which a level may have gone, given its measurements."""
    n = len(measured.times)
    sets, families = np.zeros((1, n), dtype=bool), [_weighed(measured, ageing, np.zeros((1, n), dtype=bool))]
    for _ in range(min(MOST_JUMPS, n - 1) if ageing.is_jump > 0.0 else 0):
        logs = np.logaddexp.reduce(families[-1].log_weights.reshape(len(sets), -1), axis=1)
        sets = _with_one_more(np.asarray(sets[np.argsort(-logs)[:KEPT]]), measured.begins)
        if not len(sets):
            break
        families.append(_weighed(measured, ageing, sets))
        if families[-1].log_weights.max() < max(family.log_weights.max() for family in families) - APART:
            break
    models = _Models(*map(np.concatenate, zip(*(vars(family).values() for family in families), strict=True)))
    return Levels(measured, ageing, models.likely)


def _weighed(measured: Measured, ageing: Ageing, sets: NDArray[np.bool_]) -> _Models:
    """Weigh each set of jumps, (c, n), under each law of trend, walk and what is drawn anew."""
    trends = ((0.0, 1.0 - ageing.is_trend), (1.0, ageing.is_trend))
    laws = [law for law in product(REDRAWN, WALKS, trends) if all(share > 0.0 for _, share in law)]
    sizes = np.array([[size for size, _ in law] for law in laws])
    priors = np.log([math.prod(share for _, share in law) for law in laws])
    variances = np.square(sizes * [ageing.redrawn, ageing.walk, ageing.trend]).T
    count, n = len(laws), sets.shape[1]
    jumped = sets.sum(axis=1)
    could = np.count_nonzero(measured.begins) - jumped
    chances = scipy.special.xlogy(jumped, ageing.is_jump) + could * math.log1p(-ageing.is_jump)
    log_priors = np.repeat(chances, count) + np.tile(priors, len(sets))
    redrawn, walk, trend = np.tile(variances, len(sets))
    models = _Models(log_priors, redrawn, walk, trend, np.repeat(sets, count, axis=0))
    factor = np.linalg.cholesky(_of_measurements(measured, ageing, models))
    white = np.linalg.solve(factor, np.broadcast_to((measured.values - measured.first)[:, None], (len(factor), n, 1)))
    logs = np.log(np.diagonal(factor, axis1=1, axis2=2)).sum(axis=1)
    evidence = -0.5 * np.square(white).sum(axis=(1, 2)) - logs
    return replace(models, log_weights=log_priors + evidence)


def _covariance(first: Array, second: Array, measured: Measured, ageing: Ageing, models: _Models) -> Array:
    """Covariance of the levels at times, without what each mission has of its own, shape (m, p, q)."""
    since = [times - measured.times[0] for times in (first, second)]
    product_of, least = np.multiply.outer(*since), np.maximum(np.minimum.outer(*since), 0.0)
    # a level before the first measurement walks backwards from it
    both = np.minimum.outer(*(-elapsed for elapsed in since))
    least = least + np.maximum(both, 0.0)
    after = [(times[:, None] >= measured.times).astype(float) for times in (first, second)]
    steps = np.einsum("pn,mn,qn->mpq", after[0], models.jumps.astype(float), after[1])
    walked = models.walk[:, None, None] * least + models.trend[:, None, None] * product_of
    return np.asarray(measured.first_sd**2 + walked + ageing.jump**2 * steps)


def _of_measurements(measured: Measured, ageing: Ageing, models: _Models) -> Array:
    """Covariance of the measurements, shape (m, n, n)."""
    times = measured.times
    of_mission = models.redrawn[:, None, None] * (times[:, None] == times)
    return np.asarray(_covariance(times, times, measured, ageing, models) + of_mission + np.diag(measured.sds**2))


def _with_one_more(sets: NDArray[np.bool_], begins: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Every set with one further jump, each once: at the first measurement of a mission, but for the first of all."""
    n = sets.shape[1]
    more = [jumps | (np.arange(n) == place) for jumps in sets for place in np.flatnonzero(begins & ~jumps)]
    return np.unique(np.array(more, dtype=bool).reshape(-1, n), axis=0)


def _mixed(weights: Array, means: Array, variances: Array) -> tuple[Array, Array]:
    """Mean and standard deviation of a mixture, from (m,), (m, q) and (m, q)."""
    mean = weights @ means
    return mean, np.sqrt(weights @ (variances + np.square(means - mean)))


def in_missions(dates: Sequence[float], ahead: float = math.nan, missions: float = 1.0) -> tuple[Array, float]:
    """Count dates [s], ascending, in missions: one for each as they follow each other on average.

    What is of one day is of one mission. Where a date is not known (nan) they are counted as they come; a date ahead
    that is not known is so many missions later.
    """
    if not np.isfinite(dates).all():
        return np.arange(len(dates), dtype=float), len(dates) - 1.0 + missions
    begun = [dates[0]]
    for date in dates[1:]:
        begun.append(begun[-1] if date - begun[-1] < DAY else date)
    starts = np.array(begun)
    then = next((start for start in begun[::-1] if abs(ahead - start) < DAY), ahead)
    every = np.unique(np.append(starts, then) if math.isfinite(then) else starts)
    spacing = float(np.ptp(every)) / max(len(every) - 1, 1) or 1.0
    times = (starts - starts[0]) / spacing
    return times, (then - starts[0]) / spacing if math.isfinite(then) else float(times[-1]) + missions
