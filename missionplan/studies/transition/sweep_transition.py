"""Slowing down to hover over the grid of Palmer, Hearn & Stevenson, Table 2: depth, pitch and energy."""

from dataclasses import replace

import numpy as np
import pandas as pd
from scipy.optimize import brentq

from missionplan.errors import InputError, Problem
from missionplan.mission import MissionOrPath
from missionplan.mission.schema.transition import TransitionGrid
from missionplan.mission.views import TransitionMission
from missionplan.montecarlo.parallel.blocks import Progress
from missionplan.phases.transition.plan import Manoeuvre, TransitionVehicle
from missionplan.phases.transition.simulation import simulate_transition
from missionplan.physics.tunnel_thruster import hover_power, revolutions_for
from missionplan.physics.vehicle_dynamics import level_trim
from missionplan.results.transition import FORCE, PAIR, SUCTION, TimeHistory, TransitionSweep
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.transition import manoeuvre, transition_vehicle
from missionplan.studies.run import Run
from missionplan.studies.transition.grid_runs import SAMPLE, GridRuns, time_history

LOWEST_SPEED = 0.3
"""Speed down to which point A is sought [m/s]."""


def sweep_transition(
    mission: MissionOrPath, *, phase: str | None = None, time_step: float = 0.5, progress: Progress | None = None
) -> TransitionSweep:
    """Run the grid of a mission's transition phase, at the means of everything uncertain.

    Parameters
    ----------
    mission : Mission, str or Path
        With a transition phase and a vehicle with `manoeuvring` and at least one tunnel thruster.
    phase : str, optional
        The transition's name; default the first.
    time_step : float
        Of the runs and their controllers [s].
    progress : callable, optional
        Called with the variants of the vehicle done and their total.

    Raises
    ------
    InputError
        When the mission lacks what a transition needs.
    """
    run = Run.begun("sweep-transition", mission, progress=progress)
    mission = run.mission
    scenario = Scenario.at_means(mission)
    transition = TransitionMission.of(scenario.drawn).transition(phase)
    vehicle = replace(transition_vehicle(scenario, transition), suction_moment=False)
    if not vehicle.thrusters:
        raise InputError([Problem("missing; the sweep needs a tunnel thruster", mission.file, key="vehicle.thrusters")])
    grid, planned = transition.sweep, manoeuvre(transition)
    variants = _variants(vehicle, grid.pair_spacing)

    def run_variant(name: str) -> GridRuns:
        return GridRuns(grid if name == FORCE else _at_shown(grid), variants[name], planned, time_step)

    runs = dict(zip(variants, run.workers.run(run_variant, list(variants)), strict=True))
    unassisted = _unassisted(vehicle, planned, grid, time_step)
    options = {"phase": transition.name, "time_step": time_step}
    provenance = run.provenance(options, mission.notices(), trials=0)
    deceleration, steepness, mid_speed = shown = (grid.shown_deceleration, grid.shown_steepness, grid.shown_mid_speed)
    return TransitionSweep(
        provenance=provenance,
        cells=pd.concat([run.table(name) for name, run in runs.items()], ignore_index=True),
        shown_deceleration=deceleration,
        unassisted=unassisted,
        saturation_speed=saturation_speed(vehicle, planned.start_speed),
        by_mid_speed=tuple(runs[FORCE].history((deceleration, steepness, u), f"{u:g}") for u in grid.mid_speed),
        by_steepness=tuple(runs[FORCE].history((deceleration, s, mid_speed), f"{s:g}") for s in grid.steepness),
        by_variant=tuple(run.history(shown, name) for name, run in runs.items()),
        hover=_hover(vehicle),
    )


def _unassisted(vehicle: TransitionVehicle, planned: Manoeuvre, grid: TransitionGrid, time_step: float) -> TimeHistory:
    """The shown deceleration without thrusters."""
    record = simulate_transition(
        replace(vehicle, thrusters=()),
        replace(planned, deceleration=grid.shown_deceleration, after=20.0),
        time_step=time_step,
        sample=SAMPLE,
    )
    return time_history(record, 0, "no thrusters")


def _at_shown(grid: TransitionGrid) -> TransitionGrid:
    """The grid with the shown deceleration alone."""
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
    """Speed at which level flight needs the sternplanes' limit, point A of Fig. 3 [m/s]; nan if it never does.

    Bracketed from the survey speed down, then found by Brent's method (Brent 1973, ch. 4).
    """

    def beyond(speed: float) -> float:
        return float(level_trim(vehicle.body, speed).sternplane) - vehicle.sternplanes.limit

    speeds = np.arange(start_speed, LOWEST_SPEED, -0.02)
    for slower, faster in zip(speeds[1:], speeds[:-1], strict=True):
        if beyond(slower) >= 0.0:
            return float(brentq(beyond, slower, faster))
    return float("nan")


def _hover(vehicle: TransitionVehicle) -> dict[str, float]:
    """Thrust, shaft rate and power at hover, of one thruster and of a pair."""
    thruster, force = vehicle.thrusters[0], float(vehicle.body.excess_buoyancy)
    density = vehicle.body.density
    return {
        "thrust_n": force,
        "revolutions_per_s": float(revolutions_for(thruster.thrust_constant, force)),
        "power_w": hover_power(force, thruster.area, density),
        "pair_power_w": hover_power(force, thruster.area, density, thrusters=2),
    }
