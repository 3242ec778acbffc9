"""From a model's values to the current that a mission takes: depths of the layers, and how deep each column is good."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.errors import InputError
from missionplan.phases.fields.gridded_current import GriddedCurrent
from missionplan.phases.fields.grids import Grid
from missionplan.scenario.currents.files import FieldFiles, Moments, Window
from missionplan.scenario.currents.vertical import SKIN, At, good_down_to, level_depths


def at_columns(
    files: FieldFiles,
    moments: Moments,
    window: Window,
    dims: Sequence[str],
    picked: tuple[Array, Array] | tuple[()] = (),
) -> At:
    """Return what reads a variable at the columns of a grid of rows and columns.

    Parameters
    ----------
    files : FieldFiles
    moments : array of datetime64
    window : mapping of str to slice
        Part of each horizontal dimension.
    dims : sequence of str
        Horizontal dimensions of the columns.
    picked : tuple of array
        Rows and columns of that part; default: all.
    """

    def read(name: str) -> Array:
        found = files.variable(name)
        if files.has_times(name):
            values = files.series(name, moments, window, dims).astype(float)
        elif set(found.dims) == set(dims):
            order = [str(dim) for dim in found.dims]
            values = files.fixed(name, window).transpose([order.index(dim) for dim in dims])
        else:
            raise files.problem(
                f"{name} has the dimensions {', '.join(map(str, found.dims))}; expected {', '.join(dims)}"
            )
        values = values[(..., *picked)]
        return values.reshape(*values.shape[:-2], -1)

    return read


def layer_depths(files: FieldFiles, along: Sequence[str], at: At, times: int, columns: int) -> tuple[Array, Array]:
    """Depths of the layers, shape (d,) or (t, c, d), and to what depth each column is good, shape (c,) [m].

    Parameters
    ----------
    files : FieldFiles
    along : sequence of str
        Dimension of the layers; none where the field holds the surface alone.
    at : callable
        See `vertical.At`.
    times, columns : int
        Of the field.

    Raises
    ------
    InputError, FieldAttributeError
        See `vertical.level_depths`.
    """
    if len(along) > 1:
        raise files.problem(f"cannot tell which of {', '.join(along)} is the depth")
    if not along:
        return np.zeros(1), np.full(columns, SKIN)
    levels, bottom = level_depths(files, along[0], at, times)
    if bottom is not None:
        return levels, bottom
    alone = levels.size == 1 and float(levels[0]) <= SKIN
    return levels, np.full(columns, SKIN if alone else np.nan)


def assembled(
    files: FieldFiles, time: Array, grid: Grid, levels: Array, velocity: NDArray[np.complex64], bottom: Array
) -> GriddedCurrent:
    """Return the current of levels in either order; where `bottom` is nan it is that of the deepest value.

    Raises
    ------
    InputError
        When nothing near the mission is water.
    """
    values = np.ascontiguousarray(velocity.transpose(0, 2, 1))
    if levels.shape[-1] > 1 and float(np.nanmean(levels[..., 0])) > float(np.nanmean(levels[..., -1])):
        levels, values = np.ascontiguousarray(levels[..., ::-1]), np.ascontiguousarray(values[..., ::-1])
    if np.isnan(bottom).any():
        bottom = np.where(np.isnan(bottom), _deepest(levels, values), bottom)
    try:
        return GriddedCurrent.of(time, grid, levels, values, bottom)
    except InputError as error:
        raise files.problem(str(error)) from None


def _deepest(levels: Array, values: NDArray[np.complex64]) -> Array:
    """Depth to which columns are good that have values down to some of the fixed levels [m].

    The bottom lies between the deepest level with a value and the next one.
    """
    known: NDArray[np.bool_] = np.any(np.isfinite(values), axis=0)
    last = levels.size - 1 - np.argmax(known[:, ::-1], axis=1)
    below = levels[np.minimum(last + 1, levels.size - 1)]
    if levels.size == 1 and float(levels[0]) <= SKIN:
        return np.full(known.shape[0], SKIN)
    return np.asarray(np.maximum(good_down_to(levels[last]), below))
