"""Expectation over the distance left after a leg, on a graded grid of panels.

After a leg of length ℓ from distance d the vehicle is a Rice-distributed distance d′ from the target, about |d − ℓ|
with scale s = σℓ/U. Functions of the distance left are polynomials on each panel, given by their values at its
Gauss–Legendre nodes, so that E[f(d′); d′ > r_x] becomes a sparse matrix (`expectation_matrix`).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, eye_array
from scipy.special import i0e

from missionplan.arrays import Array

Indices = NDArray[np.intp]

ORDER = 6
"""Nodes per panel."""
TAIL = 6.0
"""Scales from its centre at which the Rice density is cut: less than 2e-8 of it lies beyond."""
MAX_PIECE = 2.0
"""Longest piece of a quadrature, in scales: Gauss–Legendre with `ORDER` nodes then errs by less than 1e-7."""
MAX_PANELS = 40_000
"""Number of panels above which a grid is refused."""

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(ORDER)
_TO_NODES = np.linalg.inv(np.polynomial.legendre.legvander(_NODES, ORDER - 1))


@dataclass(frozen=True)
class Panels:
    """A grid over the distance left."""

    edges: Array
    """Ascending; the first is the arrival radius; shape (m + 1,) [m]."""

    @property
    def nodes(self) -> Array:
        """Distances at which functions are given, ascending, shape (m * ORDER,) [m]."""
        half = 0.5 * np.diff(self.edges)
        middle = 0.5 * (self.edges[1:] + self.edges[:-1])
        nodes: Array = (middle[:, None] + half[:, None] * _NODES).ravel()
        return nodes


def graded_panels(edges: Array, width: Callable[[Array], Array]) -> Panels:
    """Halve panels until none is wider than `width` at its middle.

    Raises ValueError if more than `MAX_PANELS` would be needed.

    Parameters
    ----------
    edges : array
        Initial edges, in any order; they must include kinks and jumps [m].
    width : callable
        Largest width of a panel about a distance (array to array) [m].
    """
    edges = np.sort(np.asarray(edges, dtype=float))
    edges = edges[np.append(True, np.diff(edges) > 1e-12 * edges[-1])]
    while True:
        middle = 0.5 * (edges[1:] + edges[:-1])
        too_wide = np.diff(edges) > width(middle)
        if not too_wide.any():
            return Panels(edges)
        if len(edges) > MAX_PANELS:
            raise ValueError(
                f"more than {MAX_PANELS} panels: d_max or the legs' error is too small compared with the distance"
            )
        edges = np.insert(edges, np.flatnonzero(too_wide) + 1, middle[too_wide])


def rice_density(x: Array, centre: Array, scale: Array) -> Array:
    """Density of the distance of an isotropic normal point from the origin.

    p(x) = x/s² · exp(−(x² + ν²)/(2s²)) · I₀(xν/s²), with the exponentials combined so that it cannot overflow.

    Parameters
    ----------
    x : array
        Distance, not negative [m].
    centre, scale : array
        Distance ν of the point's mean, and standard deviation s of each coordinate [m].
    """
    inverse = 1.0 / scale
    density: Array = x * inverse**2 * np.exp(-0.5 * ((x - centre) * inverse) ** 2) * i0e(x * centre * inverse**2)
    return density


def _split(start: Array, stop: Array, parts: Indices) -> tuple[Indices, Array, Array]:
    """Cut intervals into equal parts: index of the interval that each part belongs to, its start, its stop."""
    owner = np.repeat(np.arange(len(parts)), parts)
    index = np.arange(len(owner)) - np.repeat(np.cumsum(parts) - parts, parts)
    length: Array = ((stop - start) / parts)[owner]
    left: Array = start[owner] + index * length
    return owner, left, left + length


def expectation_matrix(panels: Panels, centre: Array, scale: Array) -> csr_array:
    """Matrix W with W f = E[f(d′); d′ > panels.edges[0]] for f given at the panels' nodes.

    Probability beyond the last edge is neglected: the caller places that edge far enough.

    Parameters
    ----------
    panels : Panels
        Grid of f.
    centre, scale : array, shape (n,)
        Rice distribution of d′, one per row; scale > 0 [m].

    Returns
    -------
    csr_array, shape (n, nodes)
    """
    edges = panels.edges
    low = np.clip(centre - TAIL * scale, edges[0], edges[-1])
    high = np.clip(centre + TAIL * scale, low, edges[-1])
    first = np.searchsorted(edges, low, side="right") - 1
    last = np.searchsorted(edges, high, side="left")
    count = np.where(high > low, last - first, 0)

    row = np.repeat(np.arange(len(centre)), count)
    panel = np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count) + first[row]
    start, stop = np.maximum(edges[panel], low[row]), np.minimum(edges[panel + 1], high[row])
    parts = np.maximum(np.ceil((stop - start) / (MAX_PIECE * scale[row])), 1).astype(np.intp)
    owner, start, stop = _split(start, stop, parts)
    row, panel = row[owner], panel[owner]

    half = 0.5 * (stop - start)
    x = 0.5 * (start + stop) + half * _NODES[:, None]
    mass = rice_density(x, centre[row], scale[row]) * (_WEIGHTS[:, None] * half)
    left, right = edges[panel], edges[panel + 1]
    # sum of mass times Legendre polynomial over the first axis, shape (pieces, ORDER)
    t = (2.0 * x - left - right) / (right - left)
    moments = np.empty((t.shape[1], ORDER))
    before, now = np.zeros_like(t), np.ones_like(t)
    for degree in range(ORDER):
        moments[:, degree] = np.einsum("qp,qp->p", now, mass)
        before, now = now, ((2 * degree + 1) * t * now - degree * before) / (degree + 1)
    weights = moments @ _TO_NODES

    columns = panel[:, None] * ORDER + np.arange(ORDER)
    starts = np.searchsorted(row, np.arange(len(centre) + 1)) * ORDER
    return csr_array((weights.ravel(), columns.ravel(), starts), shape=(len(centre), ORDER * (len(edges) - 1)))


def solve_ascending(matrix: csr_array, right: Array) -> Array:
    """Solve (I − W) f = right, where rows depend mostly on columns before them.

    Distances left mostly shrink from leg to leg, so W is nearly strictly lower triangular: rows are solved in
    ascending blocks as long as a block depends on earlier ones alone, and the remaining rows by a sparse LU.

    Parameters
    ----------
    matrix : csr_array, shape (n, n)
        W of `expectation_matrix`, one row per node.
    right : array, shape (n, m)
        Right-hand sides.
    """
    n = matrix.shape[0]
    occupied = np.diff(matrix.indptr) > 0
    reach = np.zeros(n, dtype=np.intp)
    reach[occupied] = np.maximum.reduceat(matrix.indices, matrix.indptr[:-1][occupied]) + 1
    reach = np.maximum.accumulate(reach)
    solution = np.array(right, dtype=float)
    done = int(np.searchsorted(reach, 0, side="right"))
    while done < n:
        end = int(np.searchsorted(reach, done, side="right"))
        if end == done:
            from scipy.sparse.linalg import splu  # which legs that are short beside their errors' scale need

            rest = slice(done, n)
            coupled = (eye_array(n - done) - matrix[rest, rest]).tocsc()
            right_side = right[rest] + matrix[rest, :done] @ solution[:done]
            solution[rest] = splu(coupled, permc_spec="NATURAL").solve(right_side)
            return solution
        solution[done:end] += matrix[done:end] @ solution
        done = end
    return solution
