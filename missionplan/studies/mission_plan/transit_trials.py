"""What trials of a transit tell its plan: how long legs take, and which one interval stands for a table of legs."""

from dataclasses import dataclass, replace

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.mission.schema.phases import TransitPhase
from missionplan.montecarlo.streams import BlockStreams
from missionplan.phases.transit.execution import Execution
from missionplan.phases.transit.plan import LegTable
from missionplan.phases.transit.transit import transit
from missionplan.scenario.phases import deployed, transit_normals
from missionplan.scenario.scenario import Scenario
from missionplan.studies.leg_length.paired_trials import PILOT_BLOCK, LegsAtSpeed, arrival_shortfall, run_plans
from missionplan.studies.leg_length.sweep_scenario import SweepScenario

TRIALS = 1024
"""Trials from which the 99 % durations are taken, and on which a table and intervals are compared."""
SHARE = 0.99
_MOST_POINTS = 2_000_000
"""Points of tracks that are kept at once, which bounds the memory."""


@dataclass(frozen=True)
class TransitDurations:
    """Durations that 99 % of the trials keep."""

    legs: Array
    """Under way, by the number of the leg, of the trials that sail it, shape (m,) [s]."""
    whole: float
    """Of the trials that arrive, from the first dive to the fix on arrival; nan where none does [s]."""
    arrived: float
    """Share of the trials that arrive."""
    surface_drift: Array
    """Mean drift at the surface after the last leg, shape (2,) [m]."""

    def leg(self, number: int) -> float:
        """Duration of a leg, from 0; that of the longest leg where no trial needed so many [s]."""
        if number < len(self.legs):
            return float(self.legs[number])
        return float(self.legs.max()) if len(self.legs) else float("nan")


def transit_durations(
    means: Scenario,
    phase: TransitPhase[Scalars],
    start: Array,
    begins: float,
    seed: int,
    execution: Execution | None = None,
) -> TransitDurations:
    """Sail a transit alone, from its nominal start.

    `means`: the mission at its means. `start`, shape (2,): [m]. `begins`: mission time of the first dive [s].
    `execution`: of the vehicle, by other rules than the plan's; its time-out is left out.
    """
    trials = min(TRIALS, max(_MOST_POINTS // means.navigation.max_legs, 1))
    drawn = means.sampled(seed=seed, block=0, size=trials)
    if execution is not None:
        execution = replace(execution, time_out=float("inf"))
        drawn = replace(drawn, executions={phase.name: execution})
    source = BlockStreams(seed, 0)
    state = replace(deployed(drawn, phase, start, source, trials), clock=np.full(trials, begins))
    normals = transit_normals(drawn, phase, source)
    with np.errstate(all="ignore"):  # a trial that cannot be computed has no duration
        plan, environment = drawn.transit_plan(phase), drawn.environment(phase)
        _, record = transit(plan, state, normals, environment, tracked=trials, execution=execution)
    time = record.track_time if record.track_time is not None else np.empty((1, trials))
    legs = time[1::2] - time[:-1:2]
    arrived = record.duration[record.arrived & np.isfinite(record.duration)]
    return TransitDurations(
        legs=np.array([_quantile(leg[np.isfinite(leg)]) for leg in legs if np.isfinite(leg).any()]),
        whole=_quantile(arrived) if arrived.size else float("nan"),
        arrived=arrived.size / trials,
        surface_drift=_last_drift(record.track),
    )


def _last_drift(track: Array | None) -> Array:
    """Mean over the trials of the drift at the surface after each one's last leg, shape (2,) [m]."""
    if track is None or track.shape[1] < 3:
        return np.zeros(2)
    drift = track[:, 2::2] - track[:, 1:-1:2]
    legs = np.isfinite(drift[0]).sum(axis=0)
    last = drift[:, np.maximum(legs - 1, 0), np.arange(drift.shape[2])]
    return np.asarray(last[:, legs > 0].mean(axis=1) if np.any(legs) else np.zeros(2))


def _quantile(durations: Array) -> float:
    return float(np.quantile(durations, SHARE))


@dataclass(frozen=True)
class SingleInterval:
    """An interval in place of a table."""

    length: float
    """[m]"""
    extra_time: float
    standard_error: float
    """Mean time of a transit beyond that by the table, of the trials that arrive by both [s]."""


def single_interval(means: Scenario, phase: TransitPhase[Scalars], legs: LegTable, seed: int) -> SingleInterval:
    """Find the d_max of the mission's grid that costs least, and what it costs beyond the transit's table.

    It is chosen by the rule of `sweep-dmax`: of those that arrive as often as the mission requires the one of least
    time, and where none does, the likeliest to arrive.

    Raises InputError when the transit cannot be swept: the drift is as fast as the vehicle, or the energy does not
    suffice.
    """
    mission = means.mission
    swept = mission.model_copy(update={"sweep": mission.sweep.model_copy(update={"phase": phase.name})})
    scenario = SweepScenario.of(swept, means)
    candidates = [float(length) for length in scenario.d_max]
    plans = [LegsAtSpeed(legs), *(LegsAtSpeed(length) for length in candidates)]
    table, *single = run_plans(scenario, plans, seed, PILOT_BLOCK, TRIALS)
    scores = [
        (arrival_shortfall(found, scenario.required_arrival), _mean(found.duration[found.arrived])) for found in single
    ]
    best = min(range(len(single)), key=scores.__getitem__)
    both = single[best].arrived & table.arrived
    extra = single[best].duration[both] - table.duration[both]
    error = float(extra.std() / np.sqrt(max(extra.size, 1))) if extra.size else float("nan")
    return SingleInterval(candidates[best], _mean(extra), error)


def _mean(values: Array) -> float:
    """Mean; infinite where no trial arrives, so that no such interval is chosen."""
    return float(values.mean()) if values.size else float("inf")
