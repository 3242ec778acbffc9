"""Neutral responses: smooth errors that no effect of the catalogue has, in the model while parameters are estimated.

Each is a smooth random function along an axis (Kennedy & O'Hagan 2001, *J. R. Stat. Soc. B* 63; Brynjarsdóttir &
O'Hagan 2014, *Inverse Problems* 30), by its leading principal components over the legs. A velocity fixed to the Earth
that changes with time is not among them: random effects of the catalogue describe it.
"""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array
from missionplan.diagnosis.inference.adequacy.axes import Axis

SIZE = 0.04
"""Usual size of a response [m/s]: as of the catalogue's effects in the middle of their sizes."""
LENGTH = 0.4
"""Correlation length, of the record's extent along the axis."""
MOST_COLUMNS = 8
LEAST_SHARE = 0.01
"""Principal components kept at most, and least share of the first one's variance that one has."""
SAME = 1e-3
"""Size of a combination of the catalogue's effects, over the greatest, below which it is none."""
IS_DESCRIBED = ("time", "a velocity that changes with time")
"""What random effects of the catalogue describe."""


@dataclass(frozen=True)
class Response:
    """A smooth error along an axis.

    Attributes
    ----------
    axis, description : str
        Name of the axis; in words.
    columns : array, shape (2, n, q)
        Velocity errors for standard normal coefficients [m/s].
    """

    axis: str
    description: str
    columns: Array


def responses_along(axes: list[Axis], catalogue: Array) -> tuple[Response, ...]:
    """Return the responses along the axes of a log, less what effects of the catalogue do to the legs.

    Parameters
    ----------
    axes : list of Axis
        Values leg by leg.
    catalogue : array, shape (2, n, k)
        Velocity errors of the catalogue's effects at their usual sizes [m/s].
    """
    named = np.moveaxis(catalogue, 0, 1).reshape(2 * catalogue.shape[1], -1)
    left, sizes, _ = np.linalg.svd(named, full_matrices=False)
    span = left[:, sizes > SAME * sizes[0]]
    wanted = [axis for axis in axes if (axis.name, axis.description) != IS_DESCRIBED]
    return tuple(_response(axis, span) for axis in wanted)


def _response(axis: Axis, span: Array) -> Response:
    smooth = axis.smooth(LENGTH)
    functions = axis.response.shape[1] // len(smooth)
    values = axis.response @ np.kron(np.eye(functions), smooth)
    left, sizes, _ = np.linalg.svd(values - span @ (span.T @ values), full_matrices=False)
    kept = np.flatnonzero(sizes**2 > LEAST_SHARE * sizes[0] ** 2)[:MOST_COLUMNS]
    columns = SIZE * left[:, kept] * sizes[kept]
    return Response(axis.name, axis.description, np.moveaxis(columns.reshape(len(span) // 2, 2, -1), 1, 0))
