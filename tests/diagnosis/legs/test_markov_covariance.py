"""Whitening leg by leg against a dense covariance."""

from functools import cache

import numpy as np
import pytest

from missionplan.diagnosis.legs.likelihood.markov_covariance import MANY, MarkovCovariance
from missionplan.effects.random_errors import PersistentError, RandomWalk

RNG = np.random.default_rng(8)
LEGS = 9
UNDER_WAY = RNG.uniform(600.0, 2000.0, LEGS)
START = np.cumsum(UNDER_WAY + RNG.uniform(60.0, 2000.0, LEGS)) - UNDER_WAY
SHARES = np.array([False, True, True, False, True, False, True, True, True])


QUALITY = RNG.uniform(0.3, 4.0, LEGS)
"""Standard deviation of the fix after each leg, over the typical one."""


def covariance_of_legs(in_common, begins, start=1.0, end=1.0):
    """Legs whose runs begin at those given, and the run of each."""
    run = np.cumsum(np.isin(np.arange(LEGS), begins))
    since = START - START[np.searchsorted(run, run)]
    elapsed = np.append(np.nan, START[1:] - (START + UNDER_WAY)[:-1])
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
            total[np.ix_(legs, legs)] += over_legs(process, legs[0], legs[-1] + 1)
    return total


STEPS = 400


@cache
def over_legs(process, first, after):
    """Covariance of the means over legs of a process that begins with the first, by midpoint sums in time."""
    start, under_way = START[first:after], UNDER_WAY[first:after]
    t = (start[:, None] + under_way[:, None] * (np.arange(STEPS) + 0.5) / STEPS).ravel()
    if isinstance(process, RandomWalk):
        pointwise = process.rate**2 * (np.minimum.outer(t, t) - start[0])
    else:
        pointwise = process.sigma**2 * np.exp(-np.abs(t[:, None] - t) / process.time)
    return pointwise.reshape(len(start), STEPS, len(start), STEPS).mean(axis=(1, 3))


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
    exact = 1e-9 if process is None else 2e-3  # the sums in time
    np.testing.assert_allclose(gram, expected, rtol=exact, atol=exact * np.abs(expected).max())
    of_many, _ = legs.gram(np.tile(values, MANY), np.array(white), 7.0, process)
    np.testing.assert_allclose(of_many[:4, -4:], gram, rtol=1e-9, atol=1e-12 * np.abs(gram).max())
    determinants = sum(np.linalg.slogdet(matrix)[1] for matrix in covariances)
    assert log_determinant == pytest.approx(determinants, rel=1e-12 if process is None else 1e-5)
    if process is not None:
        by_states = [legs.dense(np.zeros(2), 0.0, process)[0] - dense(process, 0.0 * in_common, run, 0.0, 0.0)]
        assert np.abs(by_states).max() < 1e-4 * legs.dense(np.zeros(2), 0.0, process).max()


@pytest.mark.parametrize("process", [PersistentError(0.07, 5000.0), RandomWalk(6e-4)], ids=["ou", "walk"])
def test_the_mean_over_a_leg_follows_from_the_transition(process):
    """A leg in two halves: the bridge over the whole, given the middle, is those over the halves."""
    whole, half = np.array([1800.0]), np.array([900.0])
    (share,), (rest,) = process.mean_over(whole)
    (part,), (part_rest,) = process.mean_over(half)
    (kept,), (added,) = process.transition(half)
    middle = kept / (kept**2 + 1.0)  # of the sum of both ends
    spread = added / (kept**2 + 1.0)
    assert share == pytest.approx(0.5 * part * (1.0 + 2.0 * middle))
    assert rest == pytest.approx(0.5 * part_rest + part**2 * spread)


def test_means_over_short_times_are_those_of_a_walk():
    """Where the time is short of the correlation time, the process is a random walk of rate² = 2 sigma²/time."""
    process, duration = PersistentError(0.07, 1e6), np.array([1.0, 900.0, 1100.0])
    walk = RandomWalk(0.07 * np.sqrt(2e-6))
    for found, expected in zip(process.mean_over(duration), walk.mean_over(duration), strict=True):
        np.testing.assert_allclose(found, expected, rtol=2e-6)


def test_negative_variances_are_refused():
    legs, _ = covariance_of_legs(SHARES, (0,))
    with pytest.raises(np.linalg.LinAlgError, match="not positive"):
        legs.gram(np.ones((2, LEGS, 1)), np.array([-1.0, -1.0]), 0.0, None)
