"""The radial kernel: the Rice density, expectations as a matrix, and the ascending solution."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_array
from scipy.stats import rice

from missionplan.phases.transit.rice_panels import (
    Panels,
    expectation_matrix,
    graded_panels,
    rice_density,
    solve_ascending,
)


def uniform(low: float, high: float, panels: int) -> Panels:
    return Panels(np.linspace(low, high, panels + 1))


def test_density_is_scipys_rice():
    x = np.linspace(0.0, 400.0, 101)
    for centre, scale in [(0.0, 30.0), (20.0, 40.0), (200.0, 25.0)]:
        ours = rice_density(x, np.full_like(x, centre), np.full_like(x, scale))
        np.testing.assert_allclose(ours, rice.pdf(x, centre / scale, scale=scale), rtol=1e-10, atol=1e-15)


def test_density_does_not_overflow_far_from_the_target():
    peak = rice_density(np.array([1e6]), np.array([1e6]), np.array([0.1]))
    assert peak[0] == pytest.approx(1 / (0.1 * np.sqrt(2 * np.pi)), rel=1e-6)


@given(centre=st.floats(0.0, 500.0), scale=st.floats(0.01, 80.0))
def test_moments_of_the_whole_distribution(centre, scale):
    panels = uniform(0.0, 1100.0, 12)
    d = panels.nodes
    matrix = expectation_matrix(panels, np.array([centre]), np.array([scale]))
    assert (matrix @ np.ones_like(d))[0] == pytest.approx(1.0, abs=1e-6)
    assert (matrix @ d**2)[0] == pytest.approx(centre**2 + 2 * scale**2, rel=1e-6)


def test_expectation_is_cut_at_the_first_edge():
    panels = uniform(50.0, 700.0, 9)
    centre, scale = np.array([0.0, 60.0, 20.0]), np.array([40.0, 5.0, 2.0])
    outside = expectation_matrix(panels, centre, scale) @ np.ones_like(panels.nodes)
    np.testing.assert_allclose(outside, rice.sf(50.0, centre / scale, scale=scale), atol=3e-7)
    assert outside[2] == 0.0


def test_panels_are_graded_and_keep_the_edges_given():
    panels = graded_panels(np.array([500.0, 50.0, 120.0]), lambda d: np.maximum(0.2 * np.abs(d - 120.0), 3.0))
    assert {50.0, 120.0, 500.0} <= set(panels.edges)
    middle, width = 0.5 * (panels.edges[1:] + panels.edges[:-1]), np.diff(panels.edges)
    assert np.all(width > 0)
    assert np.all(width <= np.maximum(0.2 * np.abs(middle - 120.0), 3.0))


def test_too_fine_a_grid_is_refused():
    with pytest.raises(ValueError, match="panels"):
        graded_panels(np.array([1.0, 1e9]), lambda d: np.full_like(d, 1e-3))


@pytest.mark.parametrize("above_diagonal", [0.0, 0.02])
def test_ascending_solution_is_the_dense_one(above_diagonal):
    rng = np.random.default_rng(3)
    n = 60
    dense = np.tril(rng.random((n, n)), -7) / n + above_diagonal * (np.arange(n)[:, None] > 30) * rng.random((n, n))
    right = rng.random((n, 2))
    solution = solve_ascending(csr_array(dense), right)
    np.testing.assert_allclose(solution, np.linalg.solve(np.eye(n) - dense, right), rtol=1e-12)
