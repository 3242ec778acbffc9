"""What a covariance in blocks says without being written out is what it says written out."""

import numpy as np
import pytest
from scipy import stats

from missionplan.diagnosis.inference.block_covariance import BlockCovariance, errors_ahead

N = 150
RNG = np.random.default_rng(5)


def in_blocks(coefficients):
    rows = (np.arange(0, N, 2), np.arange(1, N, 2))
    roots = [RNG.normal(size=(len(own), len(own))) for own in rows]
    blocks = tuple(root @ root.T / len(root) + np.eye(len(root)) for root in roots)
    return BlockCovariance(rows, blocks, 3.0 * RNG.normal(size=(N, coefficients)))


@pytest.fixture(params=[0, 7], ids=["blocks alone", "tied blocks"])
def covariance(request):
    return in_blocks(request.param)


Y, COLUMNS = RNG.normal(size=N), RNG.normal(size=(N, 3))


def test_densities_and_inner_products(covariance):
    dense = covariance.dense()
    expected = COLUMNS.T @ np.linalg.solve(dense, COLUMNS)
    np.testing.assert_allclose(covariance.gram(COLUMNS), expected, atol=1e-9)
    white = covariance.whitened(COLUMNS)
    np.testing.assert_allclose(white.T @ white, expected, atol=1e-9)
    logs = stats.multivariate_normal(np.zeros(N), dense).logpdf(COLUMNS.T)
    np.testing.assert_allclose(covariance.log_densities(COLUMNS), logs, atol=1e-8)
    np.testing.assert_allclose(covariance.variances, np.diag(dense), atol=1e-12)


def test_predictions_from_what_came_before(covariance):
    factor = np.linalg.cholesky(covariance.dense())
    white = np.linalg.solve(factor, Y)
    np.testing.assert_allclose(covariance.innovations(Y), white, atol=1e-9)
    pairs = [factor[k : k + 2, k : k + 2] @ white[k : k + 2] for k in range(0, N, 2)]
    by_blocks = np.linalg.cholesky(BlockCovariance(covariance.rows, covariance.blocks, np.zeros((N, 0))).dense())
    white_root, sd = np.linalg.solve(by_blocks, covariance.root), np.diag(by_blocks)
    errors = errors_ahead(white_root, np.linalg.solve(by_blocks, Y), 2)
    np.testing.assert_allclose(sd * errors, np.concatenate(pairs), atol=1e-9)


def test_a_group_left_out_has_the_conditional_law(covariance):
    """Rasmussen & Williams (2006), Eq. A.6."""
    dense, group = covariance.dense(), np.array([3, 4, 10])
    rest = np.setdiff1d(np.arange(N), group)
    weights = np.linalg.solve(dense[np.ix_(rest, rest)], dense[np.ix_(rest, group)]).T
    ((error, left),) = covariance.left_out(Y, [group])
    np.testing.assert_allclose(error, Y[group] - weights @ Y[rest], atol=1e-9)
    np.testing.assert_allclose(left, dense[np.ix_(group, group)] - weights @ dense[np.ix_(rest, group)], atol=1e-9)
    np.testing.assert_allclose(covariance.restricted(rest).dense(), dense[np.ix_(rest, rest)], atol=1e-12)


def test_data_that_are_much_better_than_their_priors():
    """Coordinates nearly alike: normal equations have no Cholesky factor."""
    columns = 1e8 * np.column_stack([np.ones(N), 1.0 + 1e-9 * np.arange(N)])
    covariance = BlockCovariance.independent(np.ones(N), columns)
    along = np.linalg.svd(columns, full_matrices=False)[0]
    left = Y - along @ (along.T @ Y)
    assert covariance.gram(Y[:, None])[0, 0] == pytest.approx(left @ left, rel=1e-3)


def test_difference_of_cross_entropies_is_the_mean_over_draws():
    """Ln p₁(y) − ln p₂(y) over y from the truth, whose mean is not that of the laws."""
    first, second, truth = in_blocks(2), in_blocks(3), in_blocks(1)
    mean = 0.3 * RNG.normal(size=N)
    draws = mean + RNG.normal(size=(10_000, N)) @ np.linalg.cholesky(truth.dense()).T
    sampled = first.log_densities(draws.T) - second.log_densities(draws.T)
    found = second.cross_entropy(truth, mean) - first.cross_entropy(truth, mean)
    assert found == pytest.approx(sampled.mean(), abs=4.0 * sampled.std() / 100.0)
