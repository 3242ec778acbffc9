"""Readings of a depth sensor during descents, which are fitted to measured dives, and time histories of one descent."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, over_trials, row_and_next
from missionplan.phases.currents import Current
from missionplan.phases.hooks import DescentEffect
from missionplan.phases.mooring.descent import (
    MIN_MEAN_SPEED,
    STAGE_TIME_MARGIN,
    DescentRecord,
    DescentStages,
    descend,
    descent_stages,
)
from missionplan.phases.mooring.forces import DescentHooks, Dive, FreeVehicle
from missionplan.phases.mooring.motion import (
    STEP,
    CrossFlowFall,
    HorizontalDrift,
    Integration,
    Stage,
    Stop,
    integrate_stage,
)
from missionplan.phases.mooring.tied_pull_down import TiedPullDown

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
        Integration(float(np.clip(duration + step, step, limit)), step, keep=True),
    )


MAX_RISE_TIME = 120.0
"""Longest time of the rise to the line's length that is simulated [s]."""


@dataclass(frozen=True)
class DescentProfile:
    """A single descent against time."""

    record: DescentRecord
    """Of the one trial."""
    time: Array
    """Since the last fix, shape (k,) [s]."""
    vehicle_depth: Array
    anchor_depth: Array
    """Shape (k,). Of the vehicle's nose and of the anchor [m]."""
    vehicle_track: Array
    anchor_track: Array
    """Shape (2, k). East and north of the last fix, until touchdown, nan after it [m]."""
    stages: dict[str, float]
    """Separation, free fall, pull-down, touchdown and lowest point, each since the last fix [s]."""

    @property
    def vehicle_speed(self) -> Array:
        """Downward velocity of the vehicle, shape (k,) [m/s]."""
        return np.gradient(self.vehicle_depth, self.time)


def simulate_profile(
    dive: Dive,
    *,
    effects: Iterable[DescentEffect] = (),
    release_time: float,
    current: Current,
    position: Array,
    t_start: float = 0.0,
) -> DescentProfile:
    """Simulate one descent until the vehicle floats at the line's length above the anchor.

    Parameters
    ----------
    dive : Dive
        With floats for parameters.
    release_time : float
        From the last fix to the separation [s].
    position : array, shape (2,)
        At the last fix, east and north of the coordinates' origin [m].
    t_start : float
        Of the last fix since the mission's start [s].
    """
    effects = tuple(effects)
    hooks = DescentHooks(effects)
    place = np.asarray(position, dtype=float).reshape(2, 1)
    record = descend(
        dive,
        effects=effects,
        release_time=np.array([release_time]),
        current=current,
        position=place,
        t_start=np.array([t_start]),
    )
    drift = HorizontalDrift(current, place, np.array([t_start]))
    drift.wait(np.array([release_time]), np.zeros(1))
    stages = descent_stages(dive, hooks, 1, keep=True, drift=drift)
    lengths = {
        "free fall": stages.delay,
        "pull-down": stages.lone.time,
        "touchdown": stages.pull_down.time,
        "lowest point": stages.coast.time,
    }
    at = release_time + np.cumsum([float(length[0]) for length in lengths.values()])
    events = {"separation": release_time, **{name: float(t) for name, t in zip(lengths, at, strict=True)}}
    since, vehicle = _vehicle_depth(dive, hooks, stages)
    line = float(np.asarray(dive.line_length))
    falling = stages.lone.depth_at(since)
    anchor = np.where(since < stages.lone.time, falling, np.minimum(vehicle + line, stages.pull_down.depth + line))
    down = float(stages.lone.time[0] + stages.pull_down.time[0])
    if stages.tied is not None:
        line = stages.tied.end.place[5]
        hanging = stages.tied.anchor_depth_at(since[:, 0] - stages.lone.time)[:, None]
        hanging = np.where(since < stages.lone.time + stages.tied.after, vehicle + line, hanging)
        anchor = np.where(since < stages.lone.time, np.minimum(falling, hanging), hanging)
    anchor = np.where(since > down, stages.pull_down.depth + line, anchor)
    waiting = np.arange(0.0, events["free fall"], STEP)
    time = np.concatenate((waiting, events["free fall"] + since[:, 0]))
    depths = [np.concatenate((np.zeros(waiting.size), depth[:, 0])) for depth in (vehicle, anchor)]
    tracks = [_track(current, place, t_start, time, depth, events["touchdown"]) for depth in depths]
    if stages.tied is not None and stages.fall is not None:
        tracks = _tied_tracks(stages.tied, stages.fall, tracks[0], time, events, place)
    return DescentProfile(record, time, depths[0], depths[1], tracks[0], tracks[1], events)


def _vehicle_depth(dive: Dive, hooks: DescentHooks, stages: DescentStages) -> tuple[Array, Array]:
    """Times since the start of the free fall [s] and the vehicle's depth [m], until its line is taut again."""
    turned = float(stages.lone.time[0] + stages.pull_down.time[0] + stages.coast.time[0])
    grid = np.arange(0.0, turned + MAX_RISE_TIME, STEP)[:, None]
    depth = true_depth(dive, hooks, stages, grid)
    moving = np.flatnonzero(np.abs(np.diff(depth[:, 0])) > 1e-9)
    end = min(int(moving[-1]) + 2 + round(2.0 / STEP), len(grid)) if moving.size else len(grid)
    return grid[:end], depth[:end]


def _track(current: Current, place: Array, t_start: float, time: Array, depth: Array, until: float) -> Array:
    """Displacement with the layers along a depth history, shape (2, k) [m]; nan after a time [s]."""
    middle = 0.5 * (time[1:] + time[:-1])
    positions = np.broadcast_to(place, (2, middle.size))
    velocity = np.broadcast_to(
        current.velocity(t_start + middle, 0.5 * (depth[1:] + depth[:-1]), positions), positions.shape
    )
    track = np.concatenate((np.zeros((2, 1)), np.cumsum(velocity * np.diff(time), axis=1)), axis=1)
    return np.where(time <= until + np.diff(time).max(), track, np.nan)


def _tied_tracks(
    tied: TiedPullDown, fall: CrossFlowFall, afloat: Array, time: Array, events: dict[str, float], place: Array
) -> list[Array]:
    """Tracks of the vehicle, afloat until the line is taut, and of the anchor, shape (2, k) each [m]."""
    falling, pulled = time >= events["free fall"], time >= events["pull-down"]
    fallen = np.array([t[0] for t, _ in fall.track])
    anchor = afloat.copy()
    for axis in range(2):
        reached = np.array([position[axis, 0] for _, position in fall.track]) - place[axis]
        anchor[axis, falling] = np.interp(time[falling] - events["free fall"], fallen, reached)
    tracks = afloat.copy(), anchor
    hanging = tied.places[:, :2, 0] + tied.places[:, 3:5, 0]
    for track, reached in zip(tracks, (tied.places[:, :2, 0], hanging), strict=True):
        for axis in range(2):
            since = time[pulled] - events["pull-down"]
            track[axis, pulled] = np.interp(since, tied.times, reached[:, axis] - place[axis])
    return [np.where(np.isnan(afloat), np.nan, track) for track in tracks]
