"""From the galvanic release to the surface: the vehicle rises on its net buoyancy, tail first along its axis."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, over_trials
from missionplan.phases.currents import Current
from missionplan.phases.hooks import DescentEffect
from missionplan.phases.mooring.descent import MIN_MEAN_SPEED, STAGE_TIME_MARGIN, HorizontalDrift
from missionplan.phases.mooring.forces import DescentHooks, Dive, FreeVehicle
from missionplan.phases.mooring.vertical_motion import Stop, integrate_stage

STEP = 0.25
"""Default step [s], about a twentieth of the prototype's time constant of 6 s."""


@dataclass(frozen=True)
class AscentRecord:
    """Results of a block of ascents.

    Attributes
    ----------
    ascent_time : array, shape (n,)
        From the release to the surface; nan where the vehicle never surfaced [s].
    drift : array, shape (2, n)
        Displacement by the current meanwhile, east and north [m].
    surfaced : array of bool, shape (n,)
    """

    ascent_time: Array
    drift: Array
    surfaced: NDArray[np.bool_]


def ascend(
    dive: Dive,
    *,
    effects: Iterable[DescentEffect] = (),
    current: Current,
    position: Array,
    t_start: Array,
    since_taut: Array,
    step: float = STEP,
) -> AscentRecord:
    """Simulate the ascent of a block of moored vehicles to the surface.

    Parameters
    ----------
    dive : Dive
        Of the descent; the vehicle starts at rest, a line's length above the seafloor.
    effects : iterable of DescentEffect
        Those of the descent: lifts, vertical water velocity and drag factors still act on the vehicle.
    current : Current
    position : array, shape (2, n)
        Of the mooring, east and north of the coordinates' origin [m].
    t_start : array, shape (n,)
        Time of the release since the mission's start [s].
    since_taut : array, shape (n,)
        Time from the taut line of the descent to the release, for effects that decay [s].
    step : float
        Of the integration [s].

    Returns
    -------
    AscentRecord
    """
    hooks, trials = DescentHooks(effects), t_start.size
    bottom, line = over_trials(dive.site_depth, trials), over_trials(dive.line_length, trials)
    start = np.maximum(bottom - line, 0.0)
    drift = HorizontalDrift(current, position, t_start)
    rise = integrate_stage(
        FreeVehicle(dive, hooks, since_taut),
        start,
        -over_trials(hooks.water_velocity, trials),
        Stop(shallowest=0.0),
        time_limit=STAGE_TIME_MARGIN + float(np.max(start, initial=0.0)) / MIN_MEAN_SPEED,
        step=step,
        on_step=drift.stage(),
    )
    time = np.where(rise.ended, rise.time, np.nan)
    return AscentRecord(time, drift.position - position, rise.ended)
