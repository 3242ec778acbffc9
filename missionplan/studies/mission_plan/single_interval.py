"""The one interval between surfacings that costs least where a vehicle cannot take a table of legs."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.mission.schema.phases import TransitPhase
from missionplan.phases.transit.plan import LegTable
from missionplan.scenario.scenario import Scenario
from missionplan.studies.leg_length.paired_trials import PILOT_BLOCK, LegsAtSpeed, arrival_shortfall, run_plans
from missionplan.studies.leg_length.sweep_scenario import SweepScenario

TRIALS = 1024
"""Common trials on which the table and the intervals are compared."""


@dataclass(frozen=True)
class SingleInterval:
    """An interval in place of a table.

    Attributes
    ----------
    length : float
        [m]
    extra_time, standard_error : float
        Mean time of a transit beyond that by the table, of the trials that arrive by both [s].
    """

    length: float
    extra_time: float
    standard_error: float


def single_interval(means: Scenario, phase: TransitPhase[Scalars], legs: LegTable, seed: int) -> SingleInterval:
    """Find the d_max of the mission's grid that costs least, and what it costs beyond the transit's table.

    It is chosen by the rule of `sweep-dmax`: of those that arrive as often as the mission requires the one of least
    time, and where none does, the likeliest to arrive.

    Raises
    ------
    InputError
        When the transit cannot be swept: the drift is as fast as the vehicle, or the energy does not suffice.
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
