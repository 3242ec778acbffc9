"""What a depth sensor logs of a descent: the model that measured dives are fitted with."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, over_trials, row_and_next
from missionplan.phases.hooks import DescentEffect
from missionplan.phases.mooring.descent import SLOWEST_DESCENT, STAGE_TIME, Stages, sink
from missionplan.phases.mooring.forces import DescentHooks, Dive, FreeVehicle
from missionplan.phases.mooring.vertical_motion import STEP, Fall, Stop, fall

IN_CACHE = 1 << 16
"""Numbers of an array that are worked on at once, so that what comes between stays near the processor."""


@dataclass(frozen=True)
class SensorHistory:
    """What a depth sensor reads of n dives on a uniform grid of time.

    Attributes
    ----------
    step : float
        Of the grid, which starts at the separation [s].
    depths : array, shape (m, n)
        Readings [m].
    delay : array, shape (n,)
        By how much the dive is late on the clock of its log [s].
    """

    step: float
    depths: Array
    delay: Array

    def at(self, times: Array) -> Array:
        """Readings at times of each dive's log since the separation, shape (k, n) [s]; nan where `times` is [m].

        Between the grid's points linear: within step²/8 times the acceleration, 1 mm for the prototype. Held at the
        grid's ends.
        """
        return np.concatenate([self._at(part) for part in _in_cache(times)])

    def _at(self, times: Array) -> Array:
        place = np.clip(np.nan_to_num(times - self.delay) / self.step, 0.0, len(self.depths) - 1.000001)
        row = place.astype(np.intp)
        low, high = row_and_next(self.depths, row)
        return np.where(np.isnan(times), np.nan, low + (high - low) * (place - row))

    def take(self, trials: NDArray[np.intp] | slice) -> "SensorHistory":
        """The history of some of the dives."""
        return SensorHistory(self.step, self.depths[:, trials], self.delay[trials])


def sensor_history(
    dive: Dive, trials: int, until: float, *, effects: Iterable[DescentEffect] = (), step: float = STEP
) -> SensorHistory:
    """Run dives and read the vehicle's depth sensor on a grid of time.

    Parameters
    ----------
    dive : Dive
        Each trial may have its own weights, line length, depth and effects' parameters.
    trials : int
        n.
    until : float
        Last time since the separation that is asked for, by the log's clock [s].
    effects : iterable of DescentEffect
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
    stages = sink(dive, hooks, trials, step=step, keep=True, until=float(grid[-1]))
    since = np.broadcast_to(grid[:, None], (grid.size, trials))
    return SensorHistory(step, hooks.reading(grid, true_depth(dive, hooks, stages, since, step=step)), delay)


def simulate_readings(dive: Dive, times: Array, *, effects: Iterable[DescentEffect] = (), step: float = STEP) -> Array:
    """Depths that the vehicle's sensor reads at given times of its log, dive by dive.

    Parameters
    ----------
    dive : Dive
        Each trial may have its own weights, line length, depth and effects' parameters.
    times : array, shape (k, n)
        Since the separation, by the log's clock; nan where a trial has fewer than k [s].
    effects : iterable of DescentEffect
    step : float
        Of the integration, and of the grid on which the sensor reads [s].

    Returns
    -------
    array, shape (k, n)
        [m]; 0 before the line is taut; nan where `times` is.
    """
    until = float(np.nanmax(times, initial=0.0))
    return sensor_history(dive, times.shape[1], until, effects=effects, step=step).at(times)


def true_depth(dive: Dive, hooks: DescentHooks, stages: Stages, since: Array, *, step: float = STEP) -> Array:
    """Depth of the vehicle's nose from the anchor's free fall to the mooring.

    Parameters
    ----------
    dive : Dive
    hooks : DescentHooks
    stages : Stages
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
    parts = _in_cache(since)
    return np.concatenate([np.clip(_depth(stages, rise, part), 0.0, dive.site_depth) for part in parts])


def _in_cache(times: Array) -> Iterator[Array]:
    """Rows of an array, some at a time."""
    rows = max(1, IN_CACHE // max(times.shape[1], 1))
    return (times[first : first + rows] for first in range(0, len(times), rows))


def _depth(stages: Stages, rise: Fall | None, since: Array) -> Array:
    """Depth of the nose by the stages, and by the rise after them if there is one [m]."""
    down = stages.lone.time + stages.pull_down.time
    depth = stages.pull_down.depth_at(since - stages.lone.time)
    if np.any(since[-1] > down):
        depth = np.where(since > down, stages.coast.depth_at(since - down), depth)
    if rise is not None:
        turned = down + stages.coast.time
        depth = np.where(since > turned, rise.depth_at(since - turned), depth)
    return depth


def _rise(dive: Dive, hooks: DescentHooks, stages: Stages, duration: float, step: float) -> Fall:
    """Carry the vehicle up from its lowest point until the line is taut again, for at most a duration [s]."""
    coast = stages.coast
    moored = np.maximum(over_trials(dive.site_depth, coast.depth.size) - dive.line_length, 0.0)
    limit = STAGE_TIME + float(np.max(dive.line_length)) / SLOWEST_DESCENT
    return fall(
        FreeVehicle(dive, hooks, stages.pull_down.time + coast.time),
        np.minimum(coast.depth, dive.site_depth),
        np.where(coast.ended, -over_trials(hooks.water_velocity, coast.depth.size), 0.0),
        Stop(shallowest=moored),
        time_limit=float(np.clip(duration + step, step, limit)),
        step=step,
        keep=True,
    )
