"""Gaps between the fix after a leg and the one before the next, against normal distributions written down in full."""

import numpy as np
import pytest

from missionplan.datasets.records import TransitData
from missionplan.diagnosis.legs.kind import with_fix_share
from missionplan.diagnosis.legs.likelihood.fix_gaps import FixGaps, fix_gaps, share_of_fix_errors
from missionplan.diagnosis.legs.model import TransitModel

LEGS, SPEED, SIGMA, FIX = 240, 0.5, 0.02, 20.0


@pytest.fixture
def rng():
    return np.random.default_rng(31)


def sailed(rng, *, drift=0.0, fix=FIX, same_fix=False, missing=()):
    """A vehicle on one heading that steers from each fix to the next of its targets."""
    under_way = np.exp(rng.uniform(np.log(500.0), np.log(2000.0), LEGS))
    targets = np.stack([np.cumsum(SPEED * under_way), np.zeros(LEGS)])
    start, reckoned, end, here = [], [], [], np.zeros(2)
    times, t, last = [], 0.0, None
    for k in range(LEGS):
        before = last if same_fix and last is not None else here + fix * rng.standard_normal(2)
        way = targets[:, k] - before
        way *= SPEED * under_way[k] / np.hypot(*way)
        here = here + way + SIGMA * under_way[k] * rng.standard_normal(2)
        last = here + fix * rng.standard_normal(2)
        for values, value in zip((start, reckoned, end), (before, before + way, last), strict=True):
            values.append(value)
        times.append(t)
        here, t = here + drift * 40.0 * rng.standard_normal(2), t + under_way[k] + 40.0
    data = TransitData(
        "log",
        "made up",
        np.arange(LEGS).astype(str),
        np.zeros(LEGS, dtype=int),
        np.array(times),
        under_way,
        np.zeros(LEGS),
        np.array(start).T,
        np.array(reckoned).T,
        np.array(end).T,
        None,
        None,
        False,
        (),
    )
    return data.subset(np.setdiff1d(np.arange(LEGS), missing))


def share(data, fix=FIX):
    return share_of_fix_errors(fix_gaps(data), data.velocity_error, data.under_way, SIGMA, fix)


def test_without_drift_half_a_gap_is_the_error_of_either_fix(rng):
    assert share(sailed(rng)) == 0.5


def test_with_drift_it_is_the_share_of_the_variance(rng):
    """κ = σ²/(2σ² + q), q = (1 m/s·40 s)²."""
    assert share(sailed(rng, drift=1.0)) == pytest.approx(20.0**2 / (2.0 * 20.0**2 + 40.0**2), abs=0.06)


@pytest.mark.parametrize("conditions", [{"drift": 20.0}, {"fix": 0.5}, {"same_fix": True}], ids=str)
def test_gaps_that_tell_nothing_are_left_alone(conditions, rng):
    assert share(sailed(rng, **conditions)) == 0.0


def test_the_way_of_a_missing_leg_is_no_gap(rng):
    data = sailed(rng, missing=range(5, LEGS, 12))
    gaps = fix_gaps(data)
    assert np.hypot(*gaps.before).max() < 8.0 * FIX
    assert not gaps.is_gap[5]
    assert share(data) == 0.5


def test_errors_given_the_gaps_are_those_of_the_joint_distribution(rng):
    """The errors' mean and covariance, the gaps known, against the conditional of errors and gaps in one covariance."""
    data = sailed(rng, missing=range(14, LEGS))
    model = TransitModel(data, np.zeros((2, data.n)), SIGMA**2 * np.eye(2), FIX, fix_share=0.3)
    assert model.gaps.is_gap[1:].all()
    n, q = data.n, FIX**2 / 0.3 - 2.0 * FIX**2
    after, before = np.eye(n), np.eye(n)
    loads = np.block([after, -before, np.zeros((n, n - 1))]) / data.under_way[:, None]
    gaps = np.block([-after[:-1], before[1:], np.eye(n - 1)])
    variance = np.diag(np.concatenate([np.full(2 * n, FIX**2), np.full(n - 1, q)]))
    weights = loads @ variance @ gaps.T @ np.linalg.inv(gaps @ variance @ gaps.T)
    told = (weights @ model.gaps.before[:, 1:].T).T
    covariance = loads @ variance @ loads.T - weights @ gaps @ variance @ loads.T + SIGMA**2 * np.eye(n)
    np.testing.assert_allclose(model.data.velocity_error - model.y, told, rtol=1e-9)
    found = model.noise({("", "sigma_v"): SIGMA, ("", "fix_sd"): FIX})
    np.testing.assert_allclose(found[0], covariance, rtol=1e-9, atol=1e-15)
    white = np.full(2, SIGMA**2)
    gram, log_determinant = model.markov_covariance().gram(model.y[:, :, None], white, FIX, None)
    expected = sum(row @ np.linalg.solve(covariance, row) for row in model.y)
    assert gram[0, 0] == pytest.approx(expected, rel=1e-9)
    assert log_determinant == pytest.approx(2.0 * np.linalg.slogdet(covariance)[1], rel=1e-9)


def test_poor_fixes_on_one_heading_are_no_speed_scale(rng):
    """Steering by a fix that errs is taken for a speed scale with a current against it, were the gaps not looked at."""
    data = sailed(rng, fix=30.0)
    blind = TransitModel(data, np.zeros((2, data.n)), SIGMA**2 * np.eye(2), 5.0)
    told = with_fix_share(blind)
    rivals = [("fix-error", "speed-scale", "mean-current"), ("fix-error",)]
    gains = [model.fit(rivals[0]).log_evidence - model.fit(rivals[1]).log_evidence for model in (blind, told)]
    assert gains[0] > 4.0
    assert gains[1] < 0.0
    assert any("gaps between the fix after a leg" in notice for notice in told.data.notices)


def test_the_share_weighs_each_leg_by_its_own_variance_with_a_fix_on_either_side():
    before = np.array([[0.0, 30.0, -20.0, 25.0], [0.0, 10.0, 15.0, -12.0]])
    gaps = FixGaps(before, np.array([False, True, True, True]))
    under_way = np.array([300.0, 3000.0, 400.0, 2500.0])
    column = gaps.velocity_error(under_way)
    error = 0.5 * column + np.array([[0.002, -0.001, 0.003, 0.001], [0.001, 0.002, -0.002, 0.001]])
    weight = 1.0 / (0.01**2 + 2.0 * 3.0**2 / under_way**2)
    share = np.sum(weight * column * error) / np.sum(weight * column**2)
    assert share_of_fix_errors(gaps, error, under_way, 0.01, 3.0) == pytest.approx(share, rel=1e-9)
    assert 0.3 < share < 0.7
