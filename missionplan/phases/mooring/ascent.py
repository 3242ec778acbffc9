"""From the galvanic release to the surface: the vehicle rises on its net buoyancy, tail first along its axis.

Depths are those of its nose, which is a vehicle's length below the surface when the tail is at it.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars, over_trials
from missionplan.phases.currents import Current
from missionplan.phases.hooks import DescentEffect
from missionplan.phases.mooring.descent import MIN_MEAN_SPEED, STAGE_TIME_MARGIN
from missionplan.phases.mooring.forces import DescentHooks, Dive, FreeVehicle
from missionplan.phases.mooring.horizontal_drift import HorizontalDrift
from missionplan.phases.mooring.vertical_motion import Stop, integrate_stage

STEP = 0.25
"""Default step [s], about a twentieth of the prototype's time constant of 6 s."""


@dataclass(frozen=True)
class AscentRecord:
    """Results of a block of ascents.

    Attributes
    ----------
    surfaced : array of bool, shape (n,)
    """

    ascent_time: Array
    """Shape (n,). From the release to the surface; nan where the vehicle never surfaced [s]."""
    drift: Array
    """Displacement by the current meanwhile, east and north, shape (2, n) [m]."""
    surfaced: NDArray[np.bool_]


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
    step: float = STEP,
) -> AscentRecord:
    """Simulate the ascent of a block of moored vehicles to the surface.

    Parameters
    ----------
    dive : Dive
        Of the descent; the vehicle starts at rest.
    effects : iterable of DescentEffect
        Those of the descent: lifts, vertical water velocity and drag factors still act on the vehicle.
    current : Current
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
    step : float
        Of the integration [s].

    Returns
    -------
    AscentRecord
    """
    hooks, trials = DescentHooks(effects), t_start.size
    start, end = np.maximum(start, 0.0), over_trials(end, trials)
    drift = HorizontalDrift(current, position, t_start)
    rise = integrate_stage(
        FreeVehicle(dive, hooks, since_taut),
        start,
        -over_trials(hooks.water_velocity, trials),
        Stop(shallowest=end),
        time_limit=STAGE_TIME_MARGIN + float(np.max(start, initial=0.0)) / MIN_MEAN_SPEED,
        step=step,
        on_step=drift.stage(),
    )
    time = np.where(rise.ended, rise.time, np.nan)
    return AscentRecord(time, drift.position - position, rise.ended)
