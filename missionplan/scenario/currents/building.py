"""From a model's values to the current that a mission takes: depths of the layers, and how deep each column is good.

The current of a block of trials: a recorded one or a member of an ensemble, with the error expected of it.

The members of a current's ensemble one by one: what is expected stays, and all trials sail in one of them.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars
from missionplan.errors import InputError
from missionplan.mission import Mission
from missionplan.mission.views import forecast_error
from missionplan.montecarlo.streams import BLOCK, CommonStreams, NormalSource, block_count, block_size
from missionplan.phases.currents import Current
from missionplan.phases.fields.ensemble import NORMALS, WAVES, Ensemble, ErringCurrent, ErrorWaves, Statistics
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


ERROR = "site.current.error"
"""Key path of the error, and name of its stream."""
MEMBER = "site.current.member"
"""Name of which member of an ensemble a trial sails in, and of its stream."""


def error_statistics(mission: Mission[Scalars]) -> Statistics | None:
    """Return the statistics of a forecast's error, as drawn; None where the mission expects none."""
    error = forecast_error(mission)
    return None if error is None else Statistics(error.sigma, error.time, error.length)


def with_member(recorded: Current, source: NormalSource, size: int) -> Current:
    """Return an ensemble with a member drawn for each trial; any other current as it is."""
    if not isinstance(recorded, Ensemble):
        return recorded
    return recorded.drawn(source.legs(MEMBER).leg(0)[0, :size])


def with_error(forecast: Current, statistics: Statistics | None, source: NormalSource, size: int) -> Current:
    """Return a forecast with an error drawn for each trial; itself where there is none."""
    if statistics is None:
        return forecast
    stream = source.legs(ERROR)
    pairs = NORMALS // 2
    normals = np.concatenate([stream.leg(number)[:, :size] for number in range(pairs * WAVES)])
    waves = normals.reshape(WAVES, NORMALS, size).transpose(1, 0, 2)
    return ErringCurrent(forecast, ErrorWaves.drawn(statistics, waves))


def members_of(recorded: Current | None) -> tuple[tuple[str, float], ...]:
    """Names and probabilities of the members of an ensemble; none where the current is none."""
    if not isinstance(recorded, Ensemble):
        return ()
    return tuple(zip(recorded.names, recorded.weights.tolist(), strict=True))


def under_each_member(recorded: Current | None) -> Iterator[tuple[str, float, Ensemble]]:
    """Yield name and probability of each member, and the ensemble whose trials all sail in it."""
    if isinstance(recorded, Ensemble):
        for number, (name, weight) in enumerate(members_of(recorded)):
            yield name, weight, replace(recorded, given=number)


def trials_of_each(trials: int, members: int) -> int:
    """Trials of each member that together take about as long as the trials of the mission; at least one block."""
    return min(trials, max(trials // members, BLOCK))


def members_drawn(recorded: Current | None, seed: int, trials: int) -> NDArray[np.intp] | None:
    """Return which member each trial of a run sails in, shape (n,); None where there is no ensemble."""
    if not isinstance(recorded, Ensemble):
        return None
    streams, found = CommonStreams(seed), []
    for block in range(block_count(trials)):
        drawn = with_member(recorded, streams.of_block(block), block_size(trials, block))
        if isinstance(drawn, Ensemble) and drawn.chosen is not None:
            found.append(drawn.chosen)
    return np.concatenate(found)
