"""Time histories of one descent, for figures and tables: depths, speed and tracks of both bodies."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array
from missionplan.phases.currents import Current
from missionplan.phases.hooks import DescentEffect
from missionplan.phases.mooring.depth_sensor import true_depth
from missionplan.phases.mooring.descent import DescentRecord, DescentStages, descend, descent_stages
from missionplan.phases.mooring.forces import DescentHooks, Dive
from missionplan.phases.mooring.horizontal_drift import CrossFlowFall, HorizontalDrift
from missionplan.phases.mooring.tied_pull_down import TiedPullDown
from missionplan.phases.mooring.vertical_motion import STEP

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
    step: float = STEP,
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
    step : float
        [s].
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
        step=step,
    )
    drift = HorizontalDrift(current, place, np.array([t_start]))
    drift.wait(np.array([release_time]), np.zeros(1))
    stages = descent_stages(dive, hooks, 1, step=step, keep=True, drift=drift)
    events = _event_times(stages, release_time)
    since, vehicle = _vehicle_depth(dive, hooks, stages, step)
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
    waiting = np.arange(0.0, events["free fall"], step)
    time = np.concatenate((waiting, events["free fall"] + since[:, 0]))
    depths = [np.concatenate((np.zeros(waiting.size), depth[:, 0])) for depth in (vehicle, anchor)]
    tracks = [_track(current, place, t_start, time, depth, events["touchdown"]) for depth in depths]
    if stages.tied is not None and stages.fall is not None:
        tracks = _tied_tracks(stages.tied, stages.fall, tracks[0], time, events, place)
    return DescentProfile(record, time, depths[0], depths[1], tracks[0], tracks[1], events)


def _event_times(stages: DescentStages, release_time: float) -> dict[str, float]:
    lengths = {
        "free fall": stages.delay,
        "pull-down": stages.lone.time,
        "touchdown": stages.pull_down.time,
        "lowest point": stages.coast.time,
    }
    at = release_time + np.cumsum([float(length[0]) for length in lengths.values()])
    return {"separation": release_time, **{name: float(t) for name, t in zip(lengths, at, strict=True)}}


def _vehicle_depth(dive: Dive, hooks: DescentHooks, stages: DescentStages, step: float) -> tuple[Array, Array]:
    """Times since the start of the free fall [s] and the vehicle's depth [m], until its line is taut again."""
    turned = float(stages.lone.time[0] + stages.pull_down.time[0] + stages.coast.time[0])
    grid = np.arange(0.0, turned + MAX_RISE_TIME, step)[:, None]
    depth = true_depth(dive, hooks, stages, grid, step=step)
    moving = np.flatnonzero(np.abs(np.diff(depth[:, 0])) > 1e-9)
    end = min(int(moving[-1]) + 2 + round(2.0 / step), len(grid)) if moving.size else len(grid)
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
