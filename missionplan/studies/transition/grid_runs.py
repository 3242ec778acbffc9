"""Every combination of a grid of manoeuvres, run side by side: table and time histories."""

from dataclasses import replace

import numpy as np
import pandas as pd

from missionplan.arrays import Array
from missionplan.mission.schema.transition import TransitionGrid
from missionplan.phases.transition.plan import Manoeuvre, TransitionRecord, TransitionVehicle, energy_until
from missionplan.phases.transition.simulation import simulate_transition
from missionplan.physics.energy import JOULES_PER_WATT_HOUR
from missionplan.results.transition import TimeHistory

SAMPLE = 1.0
"""Interval of the histories [s]."""


class GridRuns:
    """Every combination of a grid, run side by side.

    Parameters
    ----------
    grid : TransitionGrid
    vehicle : TransitionVehicle
    manoeuvre : Manoeuvre
        Its deceleration, steepness and mid-transition speed are replaced by the grid's.
    time_step : float
        [s]
    """

    def __init__(
        self, grid: TransitionGrid, vehicle: TransitionVehicle, manoeuvre: Manoeuvre, time_step: float
    ) -> None:
        axes = (grid.deceleration, grid.steepness, grid.mid_speed)
        self._shape = tuple(len(axis) for axis in axes)
        self._points: Array = np.array([grid_axis.ravel() for grid_axis in np.meshgrid(*axes, indexing="ij")])
        deceleration, steepness, mid_speed = self._points
        varied = replace(manoeuvre, deceleration=deceleration, steepness=steepness, mid_speed=mid_speed)
        self._record = simulate_transition(vehicle, varied, time_step=time_step, sample=SAMPLE)

    def table(self, variant: str) -> pd.DataFrame:
        """One run a row."""
        record = self._record
        return pd.DataFrame(
            {
                "variant": variant,
                "deceleration_m_s2": self._points[0],
                "steepness_m_s": self._points[1],
                "mid_speed_m_s": self._points[2],
                "depth_excursion_m": record.depth_excursion,
                "pitch_excursion_rad": record.pitch_excursion,
                "hover_time_s": record.hover_time,
                "hover_pitch_rad": record.hover_pitch,
                "energy_common_wh": self._common_energy() / JOULES_PER_WATT_HOUR,
                "energy_to_hover_wh": record.energy_to_hover / JOULES_PER_WATT_HOUR,
                "energy_out_of_range": record.out_of_range,
            }
        )

    def history(self, point: tuple[float, float, float], label: str) -> TimeHistory:
        """Time history of one combination: deceleration, steepness and mid-transition speed."""
        index = int(np.flatnonzero(np.all(self._points == np.array(point)[:, None], axis=0))[0])
        return time_history(self._record, index, label)

    def _common_energy(self) -> Array:
        """Energy until the slowest of each set of mid-transition speeds hovers, option (a) [J]."""
        record = self._record
        hover = np.where(np.isnan(record.hover_time), record.end_time, record.hover_time)
        latest = hover.reshape(self._shape).max(axis=2, keepdims=True)
        return energy_until(record.history, np.broadcast_to(latest, self._shape).ravel())


def time_history(record: TransitionRecord, index: int, label: str) -> TimeHistory:
    """Time history of one trial of a record."""
    history = record.history
    columns = (history.speed, history.pitch, history.depth, history.sternplane)
    speed, pitch, depth, sternplane = (column[:, index] for column in columns)
    return TimeHistory(label, history.time, speed, pitch, depth, sternplane)
