"""What a block of further columns adds to many sets' evidence, against the density with all columns at once."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from missionplan.diagnosis.inference.marginal_likelihood import LOG_2PI, GramMatrix, SetPriors, blocks_by_size


@pytest.mark.parametrize("scale", [0.75, 1.9])
def test_gains_are_those_of_the_normal_density(scale):
    rng = np.random.default_rng(1)
    n, k = 30, 4
    core, further, y = rng.normal(size=(n, k)), rng.normal(size=(n, 6)), rng.normal(size=n)
    joined = np.column_stack([core, y])
    inner = tuple((own.T @ own)[None] for own in (further[:, :1], further[:, 1:3], further[:, 3:]))
    gram = GramMatrix(joined.T @ joined, -0.5 * n * LOG_2PI, joined.T @ further, inner)
    means = rng.normal(size=(3, k))
    factors = np.stack([np.tril(rng.normal(size=(k, k))) for _ in range(3)])
    blocks = blocks_by_size(np.array([3, 1, 2]))
    priors = SetPriors(means, factors)
    found = priors.log_densities([gram, gram], blocks, np.full(3, scale))
    assert found.shape == (2, 3, 4)
    for s in range(3):
        spread = np.eye(n) + core @ factors[s] @ factors[s].T @ core.T
        without = multivariate_normal(core @ means[s], spread).logpdf(y)
        assert found[:, s, 0] == pytest.approx(without, abs=1e-9)
        for b, (first, size) in enumerate(blocks.tolist()):
            own = further[:, first : first + size]
            exact = multivariate_normal(core @ means[s], spread + scale**2 * own @ own.T).logpdf(y)
            assert found[1, s, 1 + b] == pytest.approx(exact, abs=1e-9)
            beside = SetPriors(np.append(means[s], np.zeros(size))[None], _with_block(factors[s], size, scale))
            assert beside.log_densities([gram.joined(first, size)])[0, 0, 0] == pytest.approx(exact, abs=1e-9)


def _with_block(factor, size, scale):
    """Factor of the prior of coefficients and a block's, as that of one set."""
    k = len(factor)
    found = scale * np.eye(k + size)
    found[:k, :k] = factor
    return found[None]
