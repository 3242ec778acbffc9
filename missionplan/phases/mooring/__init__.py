"""Mooring: from the arrival fix down to the seafloor, the hold, the galvanic release, and up to the fix that follows.

Briggs et al., sections II–III. The anchor separates some time after the last fix and pulls the vehicle down, which
stands on its line as buoyancy and current allow until the galvanic link has corroded, then rises from there and
surfaces once for a fix. There is no other surfacing before the release.

Read next `descent`, `forces` and `motion`. `tied_pull_down` has the descent of two bodies whose drift the line ties,
`hold` the vehicle on its line. `profile` simulates the log of a descent, and follows one descent for figures.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars, over_trials
from missionplan.phases.currents import Current
from missionplan.phases.hooks import DescentEffect, TransitEffect, TrialState, surface_velocity
from missionplan.phases.mooring.descent import MIN_MEAN_SPEED, STAGE_TIME_MARGIN, DescentRecord, descend
from missionplan.phases.mooring.forces import DescentHooks, Dive, FreeVehicle
from missionplan.phases.mooring.hold import Hold, HoldRecord, hold_vehicle, lifted
from missionplan.phases.mooring.motion import HorizontalDrift, Integration, Stop, integrate_stage

STEP = 0.25
"""Step of the ascent [s], about a twentieth of the prototype's time constant of 6 s."""


@dataclass(frozen=True)
class AscentRecord:
    """Results of a block of ascents."""

    ascent_time: Array
    """Shape (n,). From the release to the surface; nan where the vehicle never surfaced [s]."""
    drift: Array
    """Displacement by the current meanwhile, east and north, shape (2, n) [m]."""
    surfaced: NDArray[np.bool_]
    """Shape (n,)."""


def ascend(
    dive: Dive,
    *,
    effects: Iterable[DescentEffect] = (),
    current: Current,
    position: Array,
    t_start: Array,
    since_taut: Array,
    start: Array,
    end: Scalars,
) -> AscentRecord:
    """Simulate the ascent of a block of moored vehicles to the surface.

    Parameters
    ----------
    dive : Dive
        Of the descent; the vehicle starts at rest.
    effects : iterable of DescentEffect
        Those of the descent: lifts, vertical water velocity and drag factors still act on the vehicle.
    position : array, shape (2, n)
        Of the vehicle, east and north of the coordinates' origin [m].
    t_start : array, shape (n,)
        Time of the release since the mission's start [s].
    since_taut : array, shape (n,)
        Time from the taut line of the descent to the release, for effects that decay [s].
    start : array, shape (n,)
        Depth of the nose when the line parts [m].
    end : float or array, shape (n,)
        Depth of the nose when the tail is at the surface [m].
    """
    hooks, trials = DescentHooks(effects), t_start.size
    start, end = np.maximum(start, 0.0), over_trials(end, trials)
    drift = HorizontalDrift(current, position, t_start)
    rise = integrate_stage(
        FreeVehicle(dive, hooks, since_taut),
        start,
        -over_trials(hooks.water_velocity, trials),
        Stop(shallowest=end),
        Integration(STAGE_TIME_MARGIN + float(np.max(start, initial=0.0)) / MIN_MEAN_SPEED, STEP),
        drift.stage(),
    )
    time = np.where(rise.ended, rise.time, np.nan)
    return AscentRecord(time, drift.position - position, rise.ended)


@dataclass(frozen=True)
class MoorPlan:
    """Parameters of one mooring. Each number may be an array over trials, shape (n,)."""

    dive: Dive
    """Bodies, line and depth."""
    held: Hold
    """The vehicle on its line."""
    radius: Scalars
    """R of Eq. 1: greatest distance of the anchor from the last fix [m]."""
    release_time: Scalars
    """From the last fix until the anchor separates [s]."""
    moored_time: Scalars = 0.0
    """From touchdown until the line parts [s]."""
    surfacing_time: Scalars = 0.0
    """At the surface after the ascent, up to the fix [s]."""
    fix_error: Scalars = 0.0
    """Standard deviation of that fix, each axis [m]."""
    hotel_power: Scalars = 0.0
    """Drawn throughout [W]."""
    surfacing_energy: Scalars = 0.0
    """For the one surfacing [J]."""


@dataclass(frozen=True)
class MoorRecord:
    """Results of a mooring; arrays of shape (n,) unless stated otherwise."""

    descent: DescentRecord
    hold: HoldRecord
    """Without meaning where the anchor never touched down."""
    anchor: Array
    """Shape (2, n). Position on the seafloor, east and north of the coordinates' origin; nan where it never touched
    down [m]."""
    offset: Array
    """Of the anchor from the last fix, which holds its drift and the error of that fix, shape (2, n) [m]."""
    surfaced_at: Array
    """Shape (2, n). Where the vehicle surfaced; nan where it did not [m]."""
    ascent_time: Array
    """From the parting of the line to the surface; nan where the vehicle did not surface [s]."""
    duration: Array
    """From the arrival fix to the fix after the ascent; nan as above [s]."""
    energy: Array
    """nan as above [J]."""
    within_radius: NDArray[np.bool_]
    struck: NDArray[np.bool_]
    surfaced: NDArray[np.bool_]
    line_parted: NDArray[np.bool_]
    """Whether the anchor came down within the radius about the last fix, the vehicle struck the seafloor on the way
    down, the vehicle surfaced again, and the line was overloaded by the snatch or in the hold."""

    @property
    def offset_distance(self) -> Array:
        """Distance of the anchor from the last fix, shape (n,) [m]."""
        return np.asarray(np.hypot(self.offset[0], self.offset[1]))


def moor(
    plan: MoorPlan,
    state: TrialState,
    fix_normals: Array,
    current: Current,
    *,
    effects: Iterable[DescentEffect] = (),
    surface_effects: Iterable[TransitEffect] = (),
) -> tuple[TrialState, MoorRecord]:
    """Take a block of trials through a mooring.

    A vehicle whose anchor came down outside the radius, or that struck the seafloor, is simulated further: it is
    buoyant, and its line parts in any case. A trial that never touched down, or never surfaced, ends here.

    Parameters
    ----------
    state : TrialState
        At the arrival fix.
    fix_normals : array, shape (2, n)
        Standard normals of the fix after the ascent.
    current : Current
        Anchor and vehicle drift with the layers that they are in.
    surface_effects : iterable of TransitEffect
        Only their drift at the surface acts here.

    Returns
    -------
    state, record : TrialState, MoorRecord
        A trial that was not alive before keeps its state, and its record has no meaning.
    """
    effects, surface_effects = tuple(effects), tuple(surface_effects)
    release = over_trials(plan.release_time, state.trials)
    descent = descend(
        plan.dive,
        effects=effects,
        release_time=release,
        current=current,
        position=state.position,
        t_start=state.clock,
        surface_velocity=surface_velocity(surface_effects, state.clock, release, state.position),
    )
    down, landed = descent.touched_down, state.position + descent.offset
    sinking, moored = np.where(down, descent.descent_time, 0.0), plan.moored_time
    parted_at = state.clock + release + sinking + moored
    hold = hold_vehicle(lifted(plan.held, effects), current, landed, state.clock + release + sinking, moored)
    ascent = ascend(
        plan.dive,
        effects=effects,
        current=current,
        position=landed + hold.parted_from[:2],
        t_start=parted_at,
        since_taut=sinking + moored - np.where(down, descent.payout_time, 0.0),
        start=over_trials(plan.dive.site_depth, state.trials) - hold.parted_from[2],
        end=plan.held.body.length,
    )
    came_up = landed + hold.parted_from[:2] + ascent.drift
    up_at = parted_at + np.where(down & ascent.surfaced, ascent.ascent_time, 0.0)
    time = over_trials(plan.surfacing_time, state.trials)
    carried = current.mean_velocity(up_at, time, 0.0, came_up, np.zeros((2, 1)))
    end = came_up + (carried + surface_velocity(surface_effects, up_at, time, came_up)) * time
    record = _record(plan, state, (descent, hold, ascent), came_up, up_at + time - state.clock)
    # state after the mooring; a trial that ends here, or has ended before, stays where it was
    goes_on = state.alive & record.surfaced
    return TrialState(
        position=np.where(goes_on, end, state.position),
        fix=np.where(goes_on, (end + plan.fix_error * fix_normals), state.fix),
        clock=np.where(goes_on, state.clock + record.duration, state.clock),
        energy=np.where(goes_on, state.energy + record.energy, state.energy),
        alive=goes_on,
    ), record


def _record(
    plan: MoorPlan,
    state: TrialState,
    stages: tuple[DescentRecord, HoldRecord, AscentRecord],
    came_up: Array,
    duration: Array,
) -> MoorRecord:
    """Record of a mooring, nan where a trial did not get so far; `duration` up to the fix after the ascent [s]."""
    descent, hold, ascent = stages
    down, landed = descent.touched_down, state.position + descent.offset
    surfaced = down & ascent.surfaced
    offset = np.where(down, landed - state.fix, np.nan)
    time = np.where(surfaced, duration, np.nan)
    strength = plan.dive.spring.strength if plan.dive.spring is not None else np.inf
    return MoorRecord(
        descent=descent,
        hold=hold,
        anchor=np.where(down, landed, np.nan),
        offset=offset,
        surfaced_at=np.where(surfaced, came_up, np.nan),
        ascent_time=np.where(down, ascent.ascent_time, np.nan),
        duration=time,
        energy=time * plan.hotel_power + plan.surfacing_energy,
        within_radius=np.hypot(offset[0], offset[1]) <= plan.radius,
        struck=descent.struck & down,
        surfaced=surfaced,
        line_parted=descent.parted | (down & (hold.line_tension > strength)),
    )
