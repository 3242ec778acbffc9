"""Axes along which a remainder may be smooth: functions of a place on the axis, and what the data feel of them."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.linalg import lapack
from scipy.spatial.distance import cdist

from missionplan.arrays import Array

NODES = 33
"""Places along an axis of one dimension at which its functions are given; between them they are linear."""
NEGLIGIBLE = 1e-4
"""Share of the variance of a smooth function that may be lost."""


@dataclass(frozen=True)
class AxisScale:
    """What the numbers of an axis of one dimension mean.

    Attributes
    ----------
    low, high : float
        Where it begins and ends [unit].
    place, value : str
        What is laid off along it, and what would be smooth, with units, for a figure.
    factor : float
        From a value of the function to the value shown.
    """

    low: float
    high: float
    place: str
    value: str
    factor: float = 1.0


@dataclass(frozen=True)
class Axis:
    """An axis along which a remainder may be smooth.

    Attributes
    ----------
    name : str
        As `diagnosis.json` names it.
    words : str
        What would be smooth, and along what, in words.
    places : array, shape (m, d)
        Where its functions are given, scaled so that the record spans about one.
    response : array, shape (N, p·m)
        What each value feels of p independent functions at the places, function by function.
    measure : AxisScale, optional
        Of a single function that can be drawn.
    """

    name: str
    words: str
    places: Array
    response: Array
    measure: AxisScale | None = None

    def smooth(self, length: float) -> Array:
        """Columns B, shape (m, r), with B Bᵀ the squared-exponential covariance of a function at the places."""
        return _smooth(self.places.tobytes(), self.places.shape, length)


@lru_cache(maxsize=64)
def _smooth(places: bytes, shape: tuple[int, int], length: float) -> Array:
    at = np.frombuffer(places).reshape(shape)
    factor, pivots, rank, _ = lapack.dpstrf(
        np.exp(-0.5 * cdist(at, at, "sqeuclidean") / length**2), tol=NEGLIGIBLE, lower=1
    )
    basis = np.empty((shape[0], rank))
    basis[pivots - 1] = np.tril(factor)[:, :rank]
    return basis


def pointwise(name: str, words: str, inputs: Array, directions: Array | None = None) -> Axis:
    """Axis of functions that each value feels where it lies itself.

    Parameters
    ----------
    name, words : str
        Of the axis.
    inputs : array, shape (N, d)
        Where each value lies.
    directions : array, shape (N, p), optional
        How much each value feels of each of p functions; default one function that all feel alike.
    """
    places, weights = _between_nodes(inputs[:, 0]) if inputs.shape[1] == 1 else _unique(inputs)
    if directions is None:
        return Axis(name, words, places, weights)
    return Axis(name, words, places, np.concatenate([weights * one[:, None] for one in directions.T], axis=1))


def _between_nodes(inputs: Array) -> tuple[Array, Array]:
    """Nodes along the inputs, shape (m, 1), and the weights of linear interpolation, shape (N, m)."""
    nodes = np.unique(inputs)
    if len(nodes) > NODES:
        nodes = np.linspace(nodes[0], nodes[-1], NODES)
    return nodes[:, None], hat_basis(inputs, nodes)


def hat_basis(inputs: Array, nodes: Array) -> Array:
    """Values at inputs, shape (N,), of the hat functions of increasing nodes, shape (m,): (N, m)."""
    return np.stack([np.interp(inputs, nodes, one) for one in np.eye(len(nodes))], axis=1)


def _unique(inputs: Array) -> tuple[Array, Array]:
    places, index = np.unique(inputs, axis=0, return_inverse=True)
    return places, np.asarray(np.eye(len(places))[index.ravel()])


def scaled(values: Array) -> Array:
    """Values scaled to span one, shape (n,) → (n, 1)."""
    return np.asarray((values - values.min()) / max(float(np.ptp(values)), 1e-12))[:, None]
