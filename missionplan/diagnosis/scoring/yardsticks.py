"""What a score is held against: predictions of the same values without the mission, and what chance allows.

Yardsticks predict by the past in several ways, or by a plain wider σ: each from the groups before, with the spread of
its own errors so far. Values are taken as a rate (a leg's error over its time under way) or as a curve (a dive's
departure from the bare mission, at the same times).

Chance is the probability integral transforms that a mission would have on records of its own making. Their whole
distribution is tested, by the statistic of Anderson & Darling (1954, *J. Am. Stat. Assoc.* 49), which is sensitive to
the tails and to a spread that is too small or too large. Values of one record depend on each other, so that its law is
that of records drawn from the mission itself, and no table's.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.special import ndtri

from missionplan.arrays import Array
from missionplan.diagnosis.scoring.predictive import Ensemble, Mixture, OneStep, paired
from missionplan.results.score import STATED

GAINS = np.array([0.05, 0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0])
"""Gains of the random walk seen through noise: what of the last error is taken over."""
MEMORIES = (0.5, 0.8, 0.95)
"""What a stationary persistent error keeps of itself from one group to the next."""

Past = Callable[[int, int], Array]
"""The values of an earlier group as a prediction of those of a later one: of (later, earlier)."""


@dataclass(frozen=True)
class Point:
    """Predictions of all values, with the standard deviation of each."""

    mean: Array
    sd: Array


def yardsticks(values: Sequence[Array], past: Past, scales: Sequence[Array], first_sd: float) -> dict[str, Point]:
    """Predict every group from those before it, or by the size of their errors alone.

    Parameters
    ----------
    values : sequence of array
        Of each group, as departures from what is expected without effects.
    past : callable
        The values of an earlier group, carried over to the times of a later one.
    scales : sequence of array
        Of the values of each group: an error over its scale has the same spread in all groups (a leg's time under way).
    first_sd : float
        Spread of an error over its scale before any is seen; it counts as one.
    """
    carried = [[past(later, earlier) for earlier in range(later)] for later in range(len(values))]
    nothing = np.zeros_like(values[0])

    def by(weights: Callable[[int], Array]) -> list[Point]:
        means = [_weighted(series, weights, value) for series, value in zip(carried, values, strict=True)]
        return _with_spread(values, means, scales, first_sd)

    by_gain = [by(partial(random_walk, gain)) for gain in GAINS.tolist()]
    by_memory = [by(partial(persistent, gain, kept)) for gain in GAINS[1::2].tolist() for kept in MEMORIES]
    averages = [np.asarray(np.mean(series, axis=0)) if series else nothing for series in carried]
    by_name = {
        "mean_of_past": _with_spread(values, averages, scales, first_sd),
        "last_leg": _with_spread(values, [series[-1] if series else nothing for series in carried], scales, first_sd),
        "random_walk": _best_so_far(values, by_gain),
        "persistent": _best_so_far(values, by_memory),
        "wider_sigma": _with_spread(values, [np.zeros_like(value) for value in values], scales, first_sd),
    }
    return {name: _joined(points) for name, points in by_name.items()}


def with_spread(values: Sequence[Array], means: Sequence[Array], scales: Sequence[Array], first_sd: float) -> Point:
    """Add to predictions of every group the spread of their errors before it; as in `yardsticks`."""
    return _joined(_with_spread(values, means, scales, first_sd))


def _joined(points: Sequence[Point]) -> Point:
    return Point(np.concatenate([p.mean for p in points]), np.concatenate([p.sd for p in points]))


def _weighted(past: Sequence[Array], weights: Callable[[int], Array], like: Array) -> Array:
    """Sum of the past with weights by their number, the last the latest; nil where there is none."""
    if not past:
        return np.zeros_like(like)
    return np.asarray(np.tensordot(weights(len(past)), np.array(past), axes=1))


def random_walk(gain: float, count: int) -> Array:
    """Weights of the past in the prediction of a random walk seen through noise, its exponential mean (Muth 1960)."""
    weights = gain * (1.0 - gain) ** np.arange(count - 1, -1, -1.0)
    weights[0] += max(1.0 - weights.sum(), 0.0)
    return np.asarray(weights / weights.sum())


def persistent(gain: float, kept: float, count: int) -> Array:
    """Weights for a stationary persistent error seen through noise, which forgets: the steady Kalman filter's."""
    return np.asarray(kept * gain * (kept * (1.0 - gain)) ** np.arange(count - 1, -1, -1.0))


def _with_spread(
    values: Sequence[Array], means: Sequence[Array], scales: Sequence[Array], first_sd: float
) -> list[Point]:
    """Add the spread of the errors before each group."""
    total, count, points = first_sd**2, 1, []
    for value, mean, scale in zip(values, means, scales, strict=True):
        points.append(Point(mean, scale * np.sqrt(total / count)))
        if len(points) > 1:  # the first has no past: its error is not that of the method
            total, count = total + float(np.sum(((value - mean) / scale) ** 2)), count + value.size
        if len(points) == 2:
            total, count = total - first_sd**2, count - 1
    return points


def _best_so_far(values: Sequence[Array], by_gain: Sequence[list[Point]]) -> list[Point]:
    """For each group the gain that has predicted those before it best."""
    scores, best_points = np.zeros(len(by_gain)), []
    for group, value in enumerate(values):
        best_points.append(by_gain[int(np.argmax(scores))][group])
        for index, points in enumerate(by_gain):
            scores[index] += float(np.sum(log_density(value, points[group])))
    return best_points


def log_density(value: Array, point: Point) -> Array:
    """Ln density of normal predictions at what was measured."""
    sd = np.maximum(point.sd, 1e-9)
    return np.asarray(-0.5 * ((value - point.mean) / sd) ** 2 - np.log(sd) - 0.5 * np.log(2.0 * np.pi))


RECORDS = 1000
"""Records drawn."""
EDGE = 1e-9
"""Least distance of a transform from 0 and 1."""
_TAIL = np.array([4.2, 5.5, 7.0, 9.0, 12.0])
GRID = np.concatenate([-_TAIL[::-1], ndtri(np.linspace(5e-4, 1.0 - 5e-4, 101)), _TAIL])
"""Places at which distributions are tabulated [standard deviations]."""


@dataclass(frozen=True)
class Chance:
    """What a record is beside those that chance would make, were the mission true."""

    p_value: float
    """Share of them whose transforms are as far from uniform, or farther."""
    coverage_90: tuple[float, float]
    """Shares of values inside 90 % intervals that chance allows."""


def one_step_chance(ensemble: Ensemble, predictions: OneStep, seed: int, level: float) -> Chance:
    """Compare a record, one step ahead, with records drawn from the predictions.

    Given its past, the transforms of a group are independent of those of earlier ones, if the mission is true
    (Rosenblatt 1952); values of one group are drawn together.

    `level` is the probability with which the coverage of a true mission is outside of what is said to be allowed.
    """
    generator = np.random.default_rng([seed, 1])
    mixture, drawn = predictions.mixture, np.empty((RECORDS, len(ensemble.values)))
    for group, rows in enumerate(ensemble.slices()):
        weights = mixture.weights[:, rows.start]
        counts = generator.multinomial(RECORDS, weights / weights.sum())
        parts = []
        for index in np.flatnonzero(counts).tolist():
            root = predictions.roots[index][group]
            wider = mixture.sds[index, rows] / np.sqrt(np.sum(root**2, axis=1))
            normals = generator.standard_normal((counts[index], len(root)))
            parts.append(mixture.means[index, rows] + normals @ root.T * wider)
        drawn[:, rows] = generator.permutation(np.concatenate(parts))
    return _compared(mixture, ensemble.values, drawn, level)


def whole_chance(ensemble: Ensemble, mixture: Mixture, seed: int, level: float) -> Chance:
    """Compare a record, all the way, with whole records drawn from the mission; parameters as of `one_step_chance`."""
    generator = np.random.default_rng([seed, 2])
    records = []
    for part in ensemble.parts:
        noises = {id(noise): noise for noise in part.noises}
        jitter = 1e-10 * np.eye(len(ensemble.values))
        roots = {
            key: np.linalg.cholesky(noise.covariance + float(np.mean(np.diag(noise.covariance))) * jitter)
            for key, noise in noises.items()
        }
        for share, mean, noise in paired(part, RECORDS):
            count = generator.poisson(RECORDS * part.probability * share)
            if count:
                records.append(mean + generator.standard_normal((count, len(mean))) @ roots[id(noise)].T)
    return _compared(mixture, ensemble.values, np.concatenate(records), level)


def _compared(mixture: Mixture, y: Array, drawn: Array, level: float) -> Chance:
    """Compare values with drawn ones, shape (r, v), all transformed by the same tables."""
    centre, sd = mixture.mean, mixture.sd
    table = np.stack([mixture.cdf(centre + place * sd) for place in GRID.tolist()])
    rows = np.vstack([y, drawn])
    pit = np.empty_like(rows)
    for index in range(len(y)):
        pit[:, index] = np.interp((rows[:, index] - centre[index]) / sd[index], GRID, table[:, index])
    distance = anderson_darling(pit)
    inside = np.mean(np.abs(pit[1:] - 0.5) <= 0.5 * STATED, axis=1)
    low, high = np.quantile(inside, [0.5 * level, 1.0 - 0.5 * level]).tolist()
    return Chance(float((1 + np.count_nonzero(distance[1:] >= distance[0])) / len(distance)), (low, high))


def anderson_darling(pit: Array) -> Array:
    """Distance A² of transforms from the uniform distribution, by rows, shape (r, n) → (r,)."""
    ordered = np.clip(np.sort(pit, axis=1), EDGE, 1.0 - EDGE)
    count = ordered.shape[1]
    weights = (2.0 * np.arange(1, count + 1) - 1.0) / count
    return np.asarray(-count - (np.log(ordered) + np.log1p(-ordered[:, ::-1])) @ weights)
