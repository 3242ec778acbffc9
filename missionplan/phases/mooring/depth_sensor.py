"""Readings of a depth sensor during a descent: the model that is fitted to measured dives."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, over_trials, row_and_next
from missionplan.phases.hooks import DescentEffect
from missionplan.phases.mooring.descent import MIN_MEAN_SPEED, STAGE_TIME_MARGIN, DescentStages, descent_stages
from missionplan.phases.mooring.forces import DescentHooks, Dive, FreeVehicle
from missionplan.phases.mooring.vertical_motion import STEP, Stage, Stop, integrate_stage

CHUNK_SIZE = 1 << 16
"""Numbers of an array that are processed at once, so that temporaries stay in the processor's cache."""


@dataclass(frozen=True)
class SensorHistory:
    """Readings of the depth sensor in n dives on a uniform time grid."""

    step: float
    """Of the grid, which starts at the separation [s]."""
    depths: Array
    """Readings, shape (m, n) [m]."""
    delay: Array
    """Of the dive on the clock of its log, shape (n,) [s]."""

    def at(self, times: Array) -> Array:
        """Readings at times of each dive's log since the separation, shape (k, n) [s]; nan where `times` is [m].

        Interpolated linearly, with an error of step²/8 times the acceleration, 1 mm for the prototype; constant beyond
        the grid's ends.
        """
        return np.concatenate([self._at(part) for part in _chunks(times)])

    def _at(self, times: Array) -> Array:
        place = np.clip(np.nan_to_num(times - self.delay) / self.step, 0.0, len(self.depths) - 1.000001)
        row = place.astype(np.intp)
        low, high = row_and_next(self.depths, row)
        return np.where(np.isnan(times), np.nan, low + (high - low) * (place - row))

    def take(self, trials: NDArray[np.intp] | slice) -> "SensorHistory":
        """Select dives."""
        return SensorHistory(self.step, self.depths[:, trials], self.delay[trials])


def sensor_history(
    dive: Dive, trials: int, until: float, *, effects: Iterable[DescentEffect] = (), step: float = STEP
) -> SensorHistory:
    """Simulate dives and the readings of the vehicle's depth sensor on a time grid.

    Parameters
    ----------
    dive : Dive
        Each trial may have its own weights, line length, depth and effects' parameters.
    trials : int
        n.
    until : float
        Last time since the separation that is needed, by the log's clock [s].
    step : float
        Of the integration, and of the grid on which the sensor reads [s].

    Returns
    -------
    SensorHistory
        0 before the line is taut.
    """
    hooks = DescentHooks(effects)
    delay = over_trials(hooks.delay(over_trials(dive.line_length, trials)), trials)
    last = max(until - float(np.min(delay)), 0.0)
    grid = np.arange(int(np.ceil(last / step)) + 2, dtype=np.float64) * step
    stages = descent_stages(dive, hooks, trials, step=step, keep=True, until=float(grid[-1]))
    since = np.broadcast_to(grid[:, None], (grid.size, trials))
    return SensorHistory(step, hooks.reading(grid, true_depth(dive, hooks, stages, since, step=step)), delay)


def true_depth(dive: Dive, hooks: DescentHooks, stages: DescentStages, since: Array, *, step: float = STEP) -> Array:
    """Depth of the vehicle's nose from the anchor's free fall to the mooring.

    Parameters
    ----------
    stages : DescentStages
        With their histories kept.
    since : array, shape (k, n)
        Since the start of the anchor's free fall [s].
    step : float
        [s].

    Returns
    -------
    array, shape (k, n)
        [m], never below the seafloor.
    """
    turned = stages.lone.time + stages.pull_down.time + stages.coast.time
    left = float(np.max(since[-1] - turned))
    rise = _rise(dive, hooks, stages, left, step) if left > 0.0 else None
    parts = _chunks(since)
    return np.concatenate([np.clip(_depth(stages, rise, part), 0.0, dive.site_depth) for part in parts])


def _chunks(times: Array) -> Iterator[Array]:
    """Yield the rows of an array, some at a time."""
    rows = max(1, CHUNK_SIZE // max(times.shape[1], 1))
    return (times[first : first + rows] for first in range(0, len(times), rows))


def _depth(stages: DescentStages, rise: Stage | None, since: Array) -> Array:
    """Depth of the nose in the stages of the descent, and in the rise after them if there is one [m]."""
    down = stages.lone.time + stages.pull_down.time
    depth = stages.pull_down.depth_at(since - stages.lone.time)
    if np.any(since[-1] > down):
        depth = np.where(since > down, stages.coast.depth_at(since - down), depth)
    if rise is not None:
        turned = down + stages.coast.time
        depth = np.where(since > turned, rise.depth_at(since - turned), depth)
    return depth


def _rise(dive: Dive, hooks: DescentHooks, stages: DescentStages, duration: float, step: float) -> Stage:
    """Simulate the rise from the lowest point until the line is taut again, for at most a duration [s]."""
    coast = stages.coast
    moored = np.maximum(over_trials(dive.site_depth, coast.depth.size) - dive.line_length, 0.0)
    limit = STAGE_TIME_MARGIN + float(np.max(dive.line_length)) / MIN_MEAN_SPEED
    return integrate_stage(
        FreeVehicle(dive, hooks, stages.pull_down.time + coast.time),
        np.minimum(coast.depth, dive.site_depth),
        np.where(coast.ended, -over_trials(hooks.water_velocity, coast.depth.size), 0.0),
        Stop(shallowest=moored),
        time_limit=float(np.clip(duration + step, step, limit)),
        step=step,
        keep=True,
    )
