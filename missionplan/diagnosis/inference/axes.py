"""Axes along which a discrepancy may be smooth: functions of a place on the axis, and how the data respond to them."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array

NODES = 33
"""Most places along an axis of one dimension at which its functions are given; between them they are linear."""
NEGLIGIBLE = 1e-4
"""Share of a smooth function's variance that the low-rank factor may lose."""


@dataclass(frozen=True)
class AxisScale:
    """Ends and labels of an axis of one dimension, for a figure."""

    low: float
    high: float
    """Its ends [unit]."""
    place: str
    value: str
    """Labels of the axis and of the function, with units."""
    factor: float = 1.0
    """From a value of the function to the value shown."""
    unit: float | None = None
    """Where the ends are of the logarithm of one and the axis over this unit."""

    def at(self, places: Array) -> Array:
        """Return where on the axis the places between 0 and 1 are."""
        ends = self.low + (self.high - self.low) * places
        return ends if self.unit is None else self.unit * np.expm1(ends)


@dataclass(frozen=True)
class Axis:
    """An axis along which a discrepancy may be smooth."""

    name: str
    """As `diagnosis.json` names it."""
    description: str
    """What would be smooth, and along what, in words."""
    places: Array
    """Where its functions are given, scaled so that the record spans about one, shape (m, d)."""
    response: Array
    """Response of each value to p independent functions at the places, function by function, shape (N, p·m)."""
    scale: AxisScale | None = None
    """For a single function, which can be drawn."""
    size: float = 1.0
    """Usual size of the functions, in their unit."""
    in_some_runs: bool = False
    """Whether some of the functions act, and none knows which."""
    at: NDArray[np.int_] | None = None
    """Shape (N,). The one place to which each value responds, where that is so: `response` is then to p functions
    there, shape (N, p)."""

    def smooth(self, length: float) -> Array:
        """Return `smooth_functions` of the places."""
        return smooth_functions(self.places, length)

    @property
    def functions(self) -> int:
        """Number of its functions, p."""
        return int(self.response.shape[1]) // (len(self.places) if self.at is None else 1)

    def smooth_columns(self, length: float) -> Array:
        """Return responses to smooth functions for standard normal coefficients, function by function, (N, p·r)."""
        smooth, count = self.smooth(length), len(self.response)
        if self.at is not None:
            return np.asarray((self.response[:, :, None] * smooth[self.at][:, None]).reshape(count, -1))
        return np.asarray((self.response.reshape(count, self.functions, -1) @ smooth).reshape(count, -1))


def smooth_functions(places: Array, length: float) -> Array:
    """Return columns B, shape (m, r), with B Bᵀ ≈ exp(−½(d/length)²) between places, shape (m, d).

    The squared-exponential covariance (Rasmussen & Williams 2006, Eq. 4.9) by a Cholesky factorisation with pivoting,
    stopped where the remaining variance is negligible, of which the pivots' columns alone are computed (Harbrecht,
    Peters & Schneider 2012, *Appl. Numer. Math.* 62).
    """
    return _smooth(places.tobytes(), places.shape, length)


@lru_cache(maxsize=64)
def _smooth(places: bytes, shape: tuple[int, int], length: float) -> Array:
    at = np.frombuffer(places).reshape(shape)
    remaining, rank, rows = np.ones(len(at)), 0, np.empty((0, len(at)))
    while remaining[pivot := int(np.argmax(remaining))] > NEGLIGIBLE:
        if rank == len(rows):
            rows = np.concatenate([rows, np.empty((rank + 32, len(at)))])
        covariance = np.exp(-0.5 * np.sum((at - at[pivot]) ** 2, axis=1) / length**2)
        rows[rank] = (covariance - rows[:rank, pivot] @ rows[:rank]) / np.sqrt(remaining[pivot])
        remaining = remaining - rows[rank] ** 2
        remaining[pivot], rank = 0.0, rank + 1
    return np.ascontiguousarray(rows[:rank].T)


def principal_components(columns: Array, most: int, least: float, white: Array | None = None) -> Array:
    """Principal components of columns, shape (N, c), as columns: (N, q).

    `columns`, shape (N, c). `most`: so many at most. `least`: share of the first one's variance that each has at least,
    well above rounding. `white`: the columns in the metric in which they are taken; default as they are.
    """
    measured = columns if white is None else white
    values, vectors = np.linalg.eigh(measured.T @ measured)
    kept = np.flatnonzero(values > least * values[-1])[::-1][:most]
    return np.asarray(columns @ vectors[:, kept])


def pointwise(name: str, description: str, inputs: Array, directions: Array | None = None) -> Axis:
    """Return the axis of functions to which each value responds where it lies itself.

    `name`, `description`: of the axis. `inputs`, shape (N, d): where each value lies. `directions`, shape (N, p),
    optional: response of each value to each of p functions; default one function, to which all respond alike.
    """
    responses = np.ones((len(inputs), 1)) if directions is None else directions
    if inputs.shape[1] > 1:
        places, at = np.unique(inputs, axis=0, return_inverse=True)
        return Axis(name, description, places, responses, at=at.ravel())
    places, weights = _between_nodes(inputs[:, 0])
    return Axis(name, description, places, directed(weights, responses))


def around(name: str, description: str, angles: Array, directions: Array) -> Axis:
    """Return the axis of functions of angles, (N, 1) [rad], on a circle of diameter one; else as `pointwise`."""
    nodes = np.unique(angles)
    if len(nodes) > NODES:
        nodes = np.linspace(-np.pi, np.pi, NODES, endpoint=False)
    weights = np.stack([np.interp(angles[:, 0], nodes, one, period=2.0 * np.pi) for one in np.eye(len(nodes))], axis=1)
    places = 0.5 * np.stack([np.sin(nodes), np.cos(nodes)], axis=1)
    return Axis(name, description, places, directed(weights, directions))


def directed(weights: Array, directions: Array) -> Array:
    """Responses (N, p·m) to p functions of which each value has a share, (N, p): (N, m), function by function."""
    return np.concatenate([weights * one[:, None] for one in directions.T], axis=1)


def differing(description: str, directions: Array) -> Axis:
    """Return the axis of one number for each run, independent of those of the others.

    `description`: of the axis. `directions`, shape (N, p): response of each value to the number of each of p runs.
    """
    return Axis("run", description, np.zeros((1, 1)), directions)


def _between_nodes(inputs: Array) -> tuple[Array, Array]:
    """Nodes along the inputs, shape (m, 1), and the weights of linear interpolation, shape (N, m)."""
    nodes = np.unique(inputs)
    if len(nodes) > NODES:
        nodes = np.linspace(nodes[0], nodes[-1], NODES)
    return nodes[:, None], np.stack([np.interp(inputs, nodes, one) for one in np.eye(len(nodes))], axis=1)


def scaled(values: Array) -> Array:
    """Return values scaled to the range 0 to 1, shape (n,) → (n, 1)."""
    return np.asarray((values - values.min()) / max(float(np.ptp(values)), 1e-12))[:, None]
