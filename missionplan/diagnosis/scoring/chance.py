"""What chance allows: coverages that a mission would have on records of its own making."""

import numpy as np

from missionplan.arrays import Array
from missionplan.diagnosis.scoring.ensemble import Ensemble
from missionplan.diagnosis.scoring.predictive import Mixture, OneStep, paired

RECORDS = 2000
"""Records drawn."""


def one_step_coverages(ensemble: Ensemble, found: OneStep, low: Array, high: Array, seed: int) -> Array:
    """Shares of values inside intervals, one step ahead, in records drawn from the predictions, shape (r,).

    Given its past, whether a group is inside is independent of whether the earlier ones were, if the mission is true
    (Rosenblatt 1952); values of one group are drawn together.
    """
    generator = np.random.default_rng([seed, 1])
    mixture, inside = found.mixture, np.zeros(RECORDS)
    for group, rows in enumerate(ensemble.slices()):
        weights = mixture.weights[:, rows.start]
        counts = generator.multinomial(RECORDS, weights / weights.sum())
        drawn = []
        for index in np.flatnonzero(counts).tolist():
            root = found.roots[index][group]
            wider = mixture.sds[index, rows] / np.sqrt(np.sum(root**2, axis=1))
            normals = generator.standard_normal((counts[index], len(root)))
            drawn.append(mixture.means[index, rows] + normals @ root.T * wider)
        together = generator.permutation(np.concatenate(drawn))
        inside += np.sum((together >= low[rows]) & (together <= high[rows]), axis=1)
    return np.asarray(inside / len(ensemble.values))


def whole_coverages(ensemble: Ensemble, low: Array, high: Array, seed: int) -> Array:
    """Shares of values inside intervals in whole records drawn from the mission, shape (about r,)."""
    generator = np.random.default_rng([seed, 2])
    found = []
    for part in ensemble.parts:
        noises = {id(noise): noise for noise in part.noises}
        roots = {
            key: np.linalg.cholesky(noise.covariance + 1e-10 * np.mean(np.diag(noise.covariance)) * np.eye(len(low)))
            for key, noise in noises.items()
        }
        for share, mean, noise in paired(part, RECORDS):
            count = max(1, round(RECORDS * part.probability * share))
            y = mean + generator.standard_normal((count, len(mean))) @ roots[id(noise)].T
            found.append(np.mean((y >= low) & (y <= high), axis=1))
    return np.concatenate(found)


def intervals(mixture: Mixture, probability: float) -> tuple[Array, Array]:
    """Central intervals of a probability of all values."""
    return mixture.quantile(0.5 * (1.0 - probability)), mixture.quantile(0.5 * (1.0 + probability))
