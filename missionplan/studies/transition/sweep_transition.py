"""Slowing down to hover over the grid of Palmer, Hearn & Stevenson, Table 2: depth, pitch and energy."""

import time
from dataclasses import replace

import numpy as np
import pandas as pd
from scipy.optimize import brentq

from missionplan.arrays import Array
from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.mission.schema.transition import TransitionGrid
from missionplan.mission.views import TransitionMission
from missionplan.phases.transition.plan import History, Manoeuvre, TransitionRecord, TransitionVehicle, energy_until
from missionplan.phases.transition.simulation import simulate_transition
from missionplan.physics.energy import JOULES_PER_WATT_HOUR
from missionplan.physics.tunnel_thruster import hover_power, revolutions_for
from missionplan.physics.vehicle_dynamics import level_trim
from missionplan.results.base import Provenance
from missionplan.results.transition import FORCE, PAIR, SUCTION, TimeHistory, TransitionSweep
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.transition import manoeuvre, transition_vehicle

SAMPLE = 1.0
"""Interval of the histories [s]."""
LOWEST_SPEED = 0.3
"""Speed down to which point A is sought [m/s]."""


def sweep_transition(mission: Mission, *, phase: str | None = None, time_step: float = 0.5) -> TransitionSweep:
    """Run the grid of a mission's transition phase, at the means of everything uncertain.

    Parameters
    ----------
    mission : Mission
        With a transition phase and a vehicle with `manoeuvring` and at least one tunnel thruster.
    phase : str, optional
        The transition's name; default the first.
    time_step : float
        Of the runs and their controllers [s].

    Raises
    ------
    InputError
        When the mission lacks what a transition needs.
    """
    started = time.perf_counter()
    written = TransitionMission.of(mission).transition(phase)
    scenario = Scenario.at_means(mission)
    vehicle = replace(transition_vehicle(scenario, written), suction_moment=False)
    if not vehicle.thrusters:
        raise InputError([Problem("missing; the sweep needs a tunnel thruster", mission.file, key="vehicle.thrusters")])
    grid, asked = written.sweep, manoeuvre(scenario, written)
    variants = _variants(vehicle, grid.pair_spacing)
    records = {
        name: _Runs(grid if name == FORCE else _at_shown(grid), varied, asked, time_step)
        for name, varied in variants.items()
    }
    pick = (grid.shown_deceleration, grid.shown_steepness, grid.shown_mid_speed)
    force = records[FORCE]
    alone = simulate_transition(
        replace(vehicle, thrusters=()),
        replace(asked, deceleration=pick[0], after=20.0),
        time_step=time_step,
        sample=SAMPLE,
    )
    provenance = Provenance(
        command="sweep-transition",
        mission=mission.name,
        file=mission.file,
        seed=mission.monte_carlo.seed,
        trials=0,
        options={"phase": written.name, "time_step": time_step},
        elapsed_s=time.perf_counter() - started,
        data=mission.raw,
        notices=mission.notices(),
    )
    return TransitionSweep(
        provenance=provenance,
        cells=pd.concat([runs.table(name) for name, runs in records.items()], ignore_index=True),
        shown_deceleration=pick[0],
        unassisted=_track(alone, 0, "no thrusters"),
        saturation_speed=saturation_speed(vehicle, asked.start_speed),
        by_mid_speed=tuple(force.track((pick[0], pick[1], u), f"{u:g}") for u in grid.mid_speed),
        by_steepness=tuple(force.track((pick[0], s, pick[2]), f"{s:g}") for s in grid.steepness),
        by_variant=tuple(runs.track(pick, name) for name, runs in records.items()),
        hover=_hover(vehicle),
    )


def _at_shown(grid: TransitionGrid) -> TransitionGrid:
    return grid.model_copy(update={"deceleration": (grid.shown_deceleration,)})


def _variants(vehicle: TransitionVehicle, spacing: float | None) -> dict[str, TransitionVehicle]:
    """The paper's three: force alone at the centre, with the jet's suction, and a pair of the same thruster."""
    one = replace(vehicle.thrusters[0], position=0.0)
    half = (vehicle.body.length / 2.0 if spacing is None else spacing) / 2.0
    pair = (replace(one, position=half), replace(one, position=-half))
    return {
        FORCE: replace(vehicle, thrusters=(one,)),
        SUCTION: replace(vehicle, thrusters=(one,), suction_moment=True),
        PAIR: replace(vehicle, thrusters=pair, suction_moment=True),
    }


def saturation_speed(vehicle: TransitionVehicle, start_speed: float) -> float:
    """Speed at which level flight asks for the sternplanes' limit, point A of Fig. 3 [m/s]; nan if it never does."""

    def beyond(speed: float) -> float:
        return float(level_trim(vehicle.body, speed).sternplane) - vehicle.sternplanes.limit

    speeds = np.arange(start_speed, LOWEST_SPEED, -0.02)
    for slower, faster in zip(speeds[1:], speeds[:-1], strict=True):
        if beyond(slower) >= 0.0:
            return float(brentq(beyond, slower, faster))
    return float("nan")


def _hover(vehicle: TransitionVehicle) -> dict[str, float]:
    thruster, force = vehicle.thrusters[0], float(vehicle.body.excess_buoyancy)
    density = vehicle.body.density
    return {
        "thrust_n": force,
        "revolutions_per_s": float(revolutions_for(thruster.thrust_constant, force)),
        "power_w": hover_power(force, thruster.area, density),
        "pair_power_w": hover_power(force, thruster.area, density, thrusters=2),
    }


class _Runs:
    """Every combination of a grid, run side by side."""

    def __init__(self, grid: TransitionGrid, vehicle: TransitionVehicle, asked: Manoeuvre, time_step: float) -> None:
        axes = (grid.deceleration, grid.steepness, grid.mid_speed)
        self.shape = tuple(len(axis) for axis in axes)
        self.points: Array = np.array([grid_axis.ravel() for grid_axis in np.meshgrid(*axes, indexing="ij")])
        deceleration, steepness, mid_speed = self.points
        varied = replace(asked, deceleration=deceleration, steepness=steepness, mid_speed=mid_speed)
        self.record = simulate_transition(vehicle, varied, time_step=time_step, sample=SAMPLE)

    @property
    def history(self) -> History:
        assert self.record.history is not None
        return self.record.history

    def common_energy(self) -> Array:
        """Energy until the slowest of each set of mid-transition speeds hovers, option (a) [J]."""
        hover = np.where(np.isnan(self.record.hover_time), self.record.end_time, self.record.hover_time)
        latest = hover.reshape(self.shape).max(axis=2, keepdims=True)
        return energy_until(self.history, np.broadcast_to(latest, self.shape).ravel())

    def table(self, variant: str) -> pd.DataFrame:
        """One run a row."""
        record = self.record
        return pd.DataFrame(
            {
                "variant": variant,
                "deceleration_m_s2": self.points[0],
                "steepness_m_s": self.points[1],
                "mid_speed_m_s": self.points[2],
                "depth_excursion_m": record.depth_excursion,
                "pitch_excursion_rad": record.pitch_excursion,
                "hover_time_s": record.hover_time,
                "hover_pitch_rad": record.hover_pitch,
                "energy_common_wh": self.common_energy() / JOULES_PER_WATT_HOUR,
                "energy_to_hover_wh": record.energy_to_hover / JOULES_PER_WATT_HOUR,
                "energy_out_of_range": record.out_of_range,
            }
        )

    def track(self, point: tuple[float, float, float], label: str) -> TimeHistory:
        """History of one combination."""
        index = int(np.flatnonzero(np.all(self.points == np.array(point)[:, None], axis=0))[0])
        return _track(self.record, index, label)


def _track(record: TransitionRecord, index: int, label: str) -> TimeHistory:
    history = record.history
    assert history is not None
    columns = (history.speed, history.pitch, history.depth, history.sternplane)
    speed, pitch, depth, sternplane = (column[:, index] for column in columns)
    return TimeHistory(label, history.time, speed, pitch, depth, sternplane)
