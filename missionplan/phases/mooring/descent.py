"""Descent from the last fix to the moored vehicle: release, pay-out, snatch, pull-down, touchdown, coasting.

The paper (section III) assumes terminal velocity from the start; here both bodies have mass. Depths are those of the
vehicle's nose, where the line is attached; the anchor is a line's length below it once the line is taut.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, over_trials
from missionplan.phases.currents import Current
from missionplan.phases.hooks import DescentEffect
from missionplan.phases.mooring.forces import DescentHooks, Dive, FreeVehicle, LoneFall, PullDown
from missionplan.phases.mooring.motion import (
    STEP,
    CrossFlowFall,
    Followed,
    HorizontalDrift,
    Integration,
    Stage,
    Stop,
    integrate_stage,
)
from missionplan.phases.mooring.pitch_over import PitchOver, depth_lost, pitch_over, snatch_tension
from missionplan.phases.mooring.tied_pull_down import TiedPullDown, pull_down_tied
from missionplan.physics.drag import terminal_velocity

MIN_MEAN_SPEED = 0.1
"""Mean speed below which a stage is cut off as never ending [m/s]."""
STAGE_TIME_MARGIN = 60.0
"""Time allowed for a stage beyond that [s]."""


@dataclass(frozen=True)
class DescentStages:
    """The stages of a descent."""

    lone: Stage
    pull_down: Stage
    coast: Stage
    """The anchor alone (its depth), both bodies, and the vehicle after touchdown (the vehicle's depth)."""
    delay: Array
    """From the separation to the start of the anchor's free fall, shape (n,) [s]."""
    fall: CrossFlowFall | None = None
    """Horizontal motion of the lone anchor where the bodies' drift is tied."""
    tied: TiedPullDown | None = None
    """The pull-down in three dimensions, as above."""
    pitched: PitchOver | None = None
    """How the vehicle came nose down, which `pull_down` holds, where that is simulated."""

    @property
    def taut_at(self) -> Array:
        """Time from the separation to the taut line, shape (n,) [s]."""
        return self.delay + self.lone.time

    @property
    def touchdown_at(self) -> Array:
        """Time from the separation to the anchor's touchdown, shape (n,) [s]."""
        return self.taut_at + self.pull_down.time


@dataclass(frozen=True)
class DescentRecord:
    """Results of a block of descents; arrays of shape (n,) unless stated otherwise."""

    release_time: Array
    """From the last fix to the anchor's separation [s]."""
    payout_time: Array
    """From the separation to the taut line [s]."""
    descent_time: Array
    """From the separation to the anchor's touchdown; nan where it never touched down [s]."""
    terminal_velocity: Array
    """Speed through the water at which the forces at touchdown balance [m/s]."""
    touchdown_speed: Array
    """Speed over the ground with which the anchor touches down; nan where it never did [m/s]."""
    offset: Array
    """Of the anchor on the seafloor from where the vehicle was at the last fix, east and north, shape (2, n) [m]."""
    lowest_altitude: Array
    """Least height of the vehicle's nose above the seafloor; where negative, how deep it would have gone into it [m].
    """
    touched_down: NDArray[np.bool_]
    struck: NDArray[np.bool_]
    """Whether the anchor reached the seafloor with the vehicle on its line, and whether the vehicle did."""
    snatch_tension: Array
    """Peak tension of the line as it goes taut; nan where its stiffness is not known [N]."""
    parted: NDArray[np.bool_]
    """Whether it parted then."""
    nose_down_time: Array
    depth_lost: Array
    """From the taut line to nose down [s], and the depth that the vehicle would have gained by being so at once [m];
    nan where the pitch-over is not simulated, or the vehicle does not turn over."""

    @property
    def offset_distance(self) -> Array:
        """Distance of the anchor from the last fix, shape (n,) [m]."""
        return np.asarray(np.hypot(self.offset[0], self.offset[1]))


def descent_stages(
    dive: Dive,
    hooks: DescentHooks,
    trials: int,
    *,
    step: float = STEP,
    keep: bool = False,
    drift: HorizontalDrift | None = None,
    until: float = np.inf,
) -> DescentStages:
    """Simulate anchor and vehicle from the separation to the vehicle's lowest point.

    Parameters
    ----------
    trials : int
        n.
    step : float
        [s].
    keep : bool
        Whether to keep the stages' histories.
    drift : HorizontalDrift, optional
        Of the anchor.
    until : float
        Time since the start of the free fall at which stages are cut [s].
    """
    rest = np.zeros(trials)
    line, bottom = (over_trials(value, trials) for value in (dive.line_length, dive.site_depth))
    limit = STAGE_TIME_MARGIN + float(np.max(bottom, initial=0.0)) / MIN_MEAN_SPEED
    delay = np.maximum(over_trials(hooks.delay(line), trials), 0.0)
    if drift is not None:
        drift.wait(delay, rest)
    falling = _lone_drift(dive, drift, keep)
    stop = Stop(deepest=np.minimum(line, bottom))
    how = Integration(limit, step, keep)
    lone = integrate_stage(LoneFall(dive, hooks), rest, rest, stop, how, falling.stage() if falling else None)
    taut = lone.ended & (line < bottom)  # a longer line never pulls the vehicle down
    until -= float(np.min(lone.time))
    tied = None
    how = replace(how, time_limit=min(limit, until))
    deepest = np.where(taut, bottom - line, 0.0)
    pitched = pitch_over(dive, dive.pitching, hooks, lone, deepest, how) if dive.pitching is not None else None
    begun = pitched.stage if pitched is not None else None
    if drift is not None and dive.tied is not None and isinstance(falling, CrossFlowFall):
        drift.wait(lone.time, rest)  # the vehicle's, afloat
        if begun is not None:
            falling.stage()(lone.time, begun.time, line + 0.5 * begun.depth)
            drift.wait(begun.time, rest)
        tied = pull_down_tied(dive, dive.tied, hooks, (lone, begun), falling, drift, taut, how)
        pull_down = tied.stage
        drift.position = tied.end.anchor[:2]
    else:
        pull_down = _pull_down(dive, hooks, (lone, begun), drift, deepest, how)
    if begun is not None:
        pull_down = Followed.by(begun, pull_down)
    until -= float(np.min(pull_down.time))
    coast = integrate_stage(
        FreeVehicle(dive, hooks, pull_down.time),
        pull_down.depth,
        pull_down.speed,
        Stop(deepest=2.0 * bottom, at_rest=True),  # a vehicle without buoyancy would sink without end
        replace(how, time_limit=min(limit, until)),
    )
    return DescentStages(
        lone, pull_down, coast, delay, falling if isinstance(falling, CrossFlowFall) else None, tied, pitched
    )


def _lone_drift(dive: Dive, drift: HorizontalDrift | None, keep: bool) -> HorizontalDrift | CrossFlowFall | None:
    """Horizontal drift of the anchor while it falls alone."""
    if drift is None or dive.tied is None:
        return drift
    rest = np.zeros(drift.position.shape[1])
    return CrossFlowFall(dive.tied.anchor, drift, drift.water(rest), keep=keep)


def _pull_down(
    dive: Dive,
    hooks: DescentHooks,
    before: tuple[Stage, Stage | None],
    drift: HorizontalDrift | None,
    deepest: Array,
    how: Integration,
) -> Stage:
    """Pull the vehicle down by a vertical line, the anchor carried by its layer."""
    lone, begun = before
    line, depth = over_trials(dive.line_length, lone.time.size), np.zeros(lone.time.size)
    if drift is not None:
        drift.advance(lone.time)
    if begun is None:
        # the snatch conserves momentum over the ground: moving water needs the bodies' time constant to act on them
        snatched = dive.lone_mass * lone.speed / (dive.joint_mass * hooks.mass_factor)
        speed = np.where(deepest > 0.0, snatched - hooks.water_velocity, 0.0)
        forces = PullDown(dive, hooks, lone.time)
    else:
        depth, speed = begun.depth, begun.speed
        if drift is not None:
            drift.wait(begun.time, line + 0.5 * depth)
        forces = PullDown(dive, hooks.later(begun.time), lone.time + begun.time)
    on_step = drift.stage(below=line) if drift else None
    return integrate_stage(forces, depth, speed, Stop(deepest=deepest), how, on_step)


def descend(
    dive: Dive,
    *,
    effects: Iterable[DescentEffect] = (),
    release_time: Array,
    current: Current,
    position: Array,
    t_start: Array,
    surface_velocity: Array | float = 0.0,
    step: float = STEP,
) -> DescentRecord:
    """Simulate a block of descents from the last fix to the vehicle's lowest point.

    Parameters
    ----------
    release_time : array, shape (n,)
        From the last fix to the anchor's separation [s].
    current : Current
        Each body drifts with the layer that it is in.
    position : array, shape (2, n)
        At the last fix, east and north of the coordinates' origin [m].
    t_start : array, shape (n,)
        Time of the last fix since the mission's start [s].
    surface_velocity : array, shape (2, n), optional
        Drift at the surface beyond the current, until the anchor separates [m/s].
    step : float
        Of the integration [s].
    """
    hooks = DescentHooks(effects)
    trials = release_time.size
    drift = HorizontalDrift(current, position, t_start)
    drift.wait(release_time, np.zeros(trials), extra=surface_velocity)
    stages = descent_stages(dive, hooks, trials, step=step, drift=drift)
    reaches_seafloor = over_trials(dive.line_length, trials) >= over_trials(dive.site_depth, trials)
    tension = snatch_tension(dive, hooks, stages.lone)
    turning = np.full((2, trials), np.nan)
    if (pitched := stages.pitched) is not None:
        lost = depth_lost(dive, hooks, stages.lone, pitched)
        turning = np.where(pitched.turned, np.stack((pitched.stage.time, lost)), np.nan)
    parted = tension > dive.spring.strength if dive.spring is not None else np.zeros(trials, dtype=bool)
    # a longer line leaves the vehicle afloat
    down = stages.lone.ended & stages.pull_down.ended & ~reaches_seafloor & ~parted
    deepest = np.where(down, stages.coast.depth, stages.pull_down.depth)
    lowest = over_trials(dive.site_depth, trials) - deepest
    # speed through the water at which the forces at touchdown balance, shape (n,) [m/s]
    ended = stages.pull_down
    forces = PullDown(dive, hooks, stages.lone.time)
    pull = forces.pull(ended.time, ended.depth)
    speed = terminal_velocity(lambda v: forces.drag(ended.time, ended.depth, np.asarray(v)), pull)
    return DescentRecord(
        release_time=release_time,
        payout_time=stages.taut_at,
        descent_time=np.where(down, stages.touchdown_at, np.nan),
        terminal_velocity=np.broadcast_to(speed, ended.time.shape),
        touchdown_speed=np.where(down, stages.pull_down.speed + hooks.water_velocity, np.nan),
        offset=drift.position - position,
        lowest_altitude=lowest,
        touched_down=down,
        struck=lowest <= 0.0,
        snatch_tension=tension,
        parted=parted,
        nose_down_time=turning[0],
        depth_lost=turning[1],
    )
