"""A grid of heights or depths as a file has it, and one made of soundings."""

import math
from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array
from missionplan.scenario.place.positions import LOCAL

_MOST_CELLS = 1_000_000
"""Of the grid that is made of soundings."""


@dataclass(frozen=True)
class Grid:
    """Heights or depths at the centres of cells, as a file has them.

    Attributes
    ----------
    x, y : array, shape (columns,) and (rows,)
        Coordinates, in either direction.
    values : array, shape (rows, columns)
        nan where missing [m].
    is_up : bool
        Whether values count up.
    system : str or None
        Reference system that the file names.
    """

    x: Array
    y: Array
    values: Array
    is_up: bool
    system: str | None = None


def of_soundings(places: Array, depths: Array) -> Grid:
    """Make a grid of scattered depths: linear within Delaunay's triangles of them, missing outside.

    Parameters
    ----------
    places : array, shape (2, k)
        East and north of the origin [m].
    depths : array, shape (k,)
        [m]
    """
    from scipy.interpolate import LinearNDInterpolator
    from scipy.spatial import cKDTree

    span = places.max(axis=1) - places.min(axis=1)
    nearest = np.asarray(cKDTree(places.T).query(places.T, k=2)[0])[:, 1]
    step = max(float(np.median(nearest[nearest > 0.0])), math.sqrt(float(np.prod(span)) / _MOST_CELLS))
    x, y = (np.arange(low, high + step, step) for low, high in zip(places.min(axis=1), places.max(axis=1), strict=True))
    fit = LinearNDInterpolator(places.T, depths)
    return Grid(x, y, np.asarray(fit(*np.meshgrid(x, y)), dtype=float), is_up=False, system=LOCAL)
