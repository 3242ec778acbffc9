"""What chance allows: probability integral transforms that a mission would have on records of its own making.

The whole distribution of the transforms is tested, by the statistic of Anderson & Darling (1954, *J. Am. Stat. Assoc.*
49), which is sensitive to the tails and to a spread that is too small or too large. Values of one record depend on each
other, so that its law is that of records drawn from the mission itself, and no table's.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri

from missionplan.arrays import Array
from missionplan.diagnosis.scoring.ensemble import Ensemble
from missionplan.diagnosis.scoring.predictive import Mixture, OneStep, paired
from missionplan.results.score import STATED

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


def one_step_chance(ensemble: Ensemble, found: OneStep, seed: int, level: float) -> Chance:
    """Compare a record, one step ahead, with records drawn from the predictions.

    Given its past, the transforms of a group are independent of those of earlier ones, if the mission is true
    (Rosenblatt 1952); values of one group are drawn together.

    Parameters
    ----------
    ensemble : Ensemble
    found : OneStep
    seed : int
    level : float
        Probability with which the coverage of a true mission is outside of what is said to be allowed.
    """
    generator = np.random.default_rng([seed, 1])
    mixture, drawn = found.mixture, np.empty((RECORDS, len(ensemble.values)))
    for group, rows in enumerate(ensemble.slices()):
        weights = mixture.weights[:, rows.start]
        counts = generator.multinomial(RECORDS, weights / weights.sum())
        parts = []
        for index in np.flatnonzero(counts).tolist():
            root = found.roots[index][group]
            wider = mixture.sds[index, rows] / np.sqrt(np.sum(root**2, axis=1))
            normals = generator.standard_normal((counts[index], len(root)))
            parts.append(mixture.means[index, rows] + normals @ root.T * wider)
        drawn[:, rows] = generator.permutation(np.concatenate(parts))
    return _compared(mixture, ensemble.values, drawn, level)


def whole_chance(ensemble: Ensemble, mixture: Mixture, seed: int, level: float) -> Chance:
    """Compare a record, all the way, with whole records drawn from the mission; parameters as of `one_step_chance`."""
    generator = np.random.default_rng([seed, 2])
    found = []
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
                found.append(mean + generator.standard_normal((count, len(mean))) @ roots[id(noise)].T)
    return _compared(mixture, ensemble.values, np.concatenate(found), level)


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
