"""What a block of further columns adds to many sets' evidence, against the density with all columns at once."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from missionplan.diagnosis.inference.set_evidence import Block, GramMatrix, SetPriors


@pytest.mark.parametrize("scale", [0.75, 1.9])
def test_gains_are_those_of_the_normal_density(scale):
    rng = np.random.default_rng(1)
    n, k = 30, 4
    core, further, y = rng.normal(size=(n, k)), rng.normal(size=(n, 6)), rng.normal(size=n)
    joined = np.column_stack([core, further, y])
    gram = GramMatrix.of(joined.T @ joined, 0.0, n)
    means = rng.normal(size=(3, k))
    factors = np.stack([np.tril(rng.normal(size=(k, k))) for _ in range(3)])
    blocks = [Block(0, 1), Block(1, 2), Block(3, 3)]
    priors = SetPriors(means, factors)
    plain = priors.log_densities([gram.part(np.arange(k))])[0]
    found = priors.gains([gram, gram], blocks, scale)
    assert found.shape == (2, 3, 3)
    for s in range(3):
        spread = np.eye(n) + core @ factors[s] @ factors[s].T @ core.T
        for b, block in enumerate(blocks):
            own = further[:, block.first : block.first + block.size]
            exact = multivariate_normal(core @ means[s], spread + scale**2 * own @ own.T).logpdf(y)
            assert plain[s] + found[1, s, b] == pytest.approx(exact, abs=1e-9)
