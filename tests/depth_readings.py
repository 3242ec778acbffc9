"""Readings of a depth sensor at the times of a log, for tests that compare them with the model."""

from collections.abc import Iterable

import numpy as np

from missionplan.arrays import Array
from missionplan.phases.hooks import DescentEffect
from missionplan.phases.mooring.forces import Dive
from missionplan.phases.mooring.motion import STEP
from missionplan.phases.mooring.profile import sensor_history


def simulate_readings(dive: Dive, times: Array, *, effects: Iterable[DescentEffect] = (), step: float = STEP) -> Array:
    """Readings of the vehicle's depth sensor at given times of its log, dive by dive.

    Parameters
    ----------
    dive : Dive
        Each trial may have its own weights, line length, depth and effects' parameters.
    times : array, shape (k, n)
        Since the separation, by the log's clock; nan where a trial has fewer than k [s].
    step : float
        Of the integration, and of the grid on which the sensor reads [s].

    Returns
    -------
    array, shape (k, n)
        [m]; 0 before the line is taut; nan where `times` is.
    """
    until = float(np.nanmax(times, initial=0.0))
    return sensor_history(dive, times.shape[1], until, effects=effects, step=step).at(times)
