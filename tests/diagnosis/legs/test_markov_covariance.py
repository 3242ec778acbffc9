"""Whitening by the banded factor against a dense covariance."""

import numpy as np
import pytest

from missionplan.diagnosis.legs.likelihood.markov_covariance import MarkovCovariance
from missionplan.effects.persistent_error import PersistentError
from missionplan.effects.random_walk import RandomWalk

RNG = np.random.default_rng(8)
LEGS = 9
MIDDLE = np.cumsum(RNG.uniform(900.0, 4000.0, LEGS))
UNDER_WAY = RNG.uniform(600.0, 2000.0, LEGS)
SHARES = np.array([False, True, True, False, True, False, True, True, True])


QUALITY = RNG.uniform(0.3, 4.0, LEGS)
"""Standard deviation of the fix after each leg, over the typical one."""


def covariance_of_legs(in_common, begins, start=1.0, end=1.0):
    """Legs whose runs begin at those given, and the run of each."""
    run = np.cumsum(np.isin(np.arange(LEGS), begins))
    since = MIDDLE - MIDDLE[np.searchsorted(run, run)]
    elapsed = np.append(np.nan, np.diff(MIDDLE))
    elapsed[list(begins)] = np.nan
    return MarkovCovariance(UNDER_WAY, since, elapsed, np.asarray(in_common, dtype=float), start, end), run


def dense(process, in_common, run, white, fix, start=1.0, end=1.0):
    """Covariance of one axis, written down leg by leg."""
    start, end = np.broadcast_to(start, LEGS), np.broadcast_to(end, LEGS)
    total = np.diag(white + fix**2 * (start**2 + end**2) / UNDER_WAY**2)
    for k in np.flatnonzero(in_common):
        shared = in_common[k] * fix**2 * start[k] * end[k - 1]
        total[k, k - 1] = total[k - 1, k] = -shared / (UNDER_WAY[k] * UNDER_WAY[k - 1])
    for number in np.unique(run):
        legs = np.flatnonzero(run == number)
        if process is not None:
            total[np.ix_(legs, legs)] += process.covariance(MIDDLE[legs])
    return total


GATHERED = tuple(np.array([[9e-4], [1e-4]]) + 0.5 / UNDER_WAY)
"""Variances on either axis of which a part falls as one over the time."""


@pytest.mark.parametrize(
    "white", [(9e-4, 9e-4), (9e-4, 1e-4), GATHERED], ids=["isotropic", "anisotropic", "by the leg"]
)
@pytest.mark.parametrize("stated", [False, True], ids=["alike", "stated one by one"])
@pytest.mark.parametrize("shared", [0.0, 0.3, 1.0], ids=["own fixes", "fixes alike in part", "shared fixes"])
@pytest.mark.parametrize("begins", [(0,), (0, 3, 5)], ids=["one run", "three runs"])
@pytest.mark.parametrize("process", [None, PersistentError(0.07, 5000.0), RandomWalk(6e-4)], ids=["none", "ou", "walk"])
def test_gram_is_that_of_the_dense_covariance(process, begins, shared, stated, white):
    in_common = shared * (SHARES & ~np.isin(np.arange(LEGS), begins))
    end = QUALITY if stated else np.ones(LEGS)
    start = np.where(in_common == 1.0, np.append(1.0, end[:-1]), 1.0)
    legs, run = covariance_of_legs(in_common, begins, start, end)
    values = RNG.normal(size=(2, LEGS, 4))
    gram, log_determinant = legs.gram(values, np.array(white), 7.0, process)
    covariances = [dense(process, in_common, run, variance, 7.0, start, end) for variance in white]
    expected = sum(own.T @ np.linalg.solve(matrix, own) for own, matrix in zip(values, covariances, strict=True))
    np.testing.assert_allclose(gram, expected, rtol=1e-9)
    assert log_determinant == pytest.approx(sum(np.linalg.slogdet(matrix)[1] for matrix in covariances), rel=1e-12)


@pytest.mark.parametrize("process", [PersistentError(0.07, 5000.0), RandomWalk(6e-4)], ids=["ou", "walk"])
def test_covariance_follows_from_the_transition(process):
    """Cov(v(t), v(t′)) = kept(t′ − t)·Var v(t), and the variance grows by what the transition says."""
    covariance = process.covariance(MIDDLE)
    for first, second in ((0, 1), (2, 6)):
        kept, added = process.transition(np.array([MIDDLE[second] - MIDDLE[first]]))
        assert covariance[first, second] == pytest.approx(kept[0] * covariance[first, first])
        assert covariance[second, second] == pytest.approx(kept[0] ** 2 * covariance[first, first] + added[0])
    assert covariance[0, 0] == pytest.approx(process.first_variance)


def test_negative_variances_are_refused():
    legs, _ = covariance_of_legs(SHARES, (0,))
    with pytest.raises(np.linalg.LinAlgError, match="not positive"):
        legs.gram(np.ones((2, LEGS, 1)), np.array([-1.0, -1.0]), 0.0, None)
