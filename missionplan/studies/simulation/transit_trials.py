"""A block of trials through a transit, as `simulate` takes it."""

from dataclasses import replace

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.mission.schema.phases import TransitPhase
from missionplan.phases.state import TrialState
from missionplan.phases.transit.ground_velocity import random_part
from missionplan.phases.transit.plan import Environment, Normals, TransitNormals, TransitPlan, TransitRecord, column
from missionplan.phases.transit.transit import transit
from missionplan.physics.energy import JOULES_PER_WATT_HOUR
from missionplan.scenario.transit_streams import transit_normals
from missionplan.studies.simulation.phase_trials import (
    AGROUND,
    LEFT_RECORD,
    OUT_OF_ENERGY,
    OUTRUN,
    Flags,
    PhaseTrials,
    TrialBlock,
    end_exhausted,
    failures_met,
    limit_events,
    where_reached,
)


def transit_trials(
    block: TrialBlock, phase: TransitPhase[Scalars], state: TrialState
) -> tuple[TrialState, PhaseTrials]:
    """Run the trials of a block through a transit.

    Parameters
    ----------
    block : TrialBlock
    phase : TransitPhase
    state : TrialState
        Where the phase begins.
    """
    scenario = block.scenario
    plan, normals = scenario.transit_plan(phase), transit_normals(scenario, phase, block.source)
    environment = scenario.environment(phase)
    site = scenario.drawn.site
    is_flat = scenario.place is None or scenario.place.ground is None
    depth = np.inf if site is None or site.depth is None or not is_flat else site.depth
    aground = state.alive & np.atleast_1d(plan.depth >= depth)
    state = replace(state, alive=state.alive & ~aground)
    after, record = transit(
        plan,
        state,
        normals,
        environment,
        tracked=min(block.tracked, state.trials),
        execution=scenario.executions.get(phase.name),
    )
    continuing, exhausted = end_exhausted(after, scenario.capacity)
    goal, arrived = column(plan.goal), record.arrived & ~exhausted
    found = PhaseTrials(
        name=phase.name,
        kind=phase.kind,
        quantities=_quantities(record, arrived),
        events={"arrived": arrived},
        limits=_limits(state, record, environment),
        start=where_reached(state.alive, state.clock),
        end=where_reached(arrived, after.clock),
        failures=_failures(state, record, environment, aground) | {OUT_OF_ENERGY: exhausted},
        miss=where_reached(arrived, after.position - goal),
        track=np.empty((0, 2, 0)) if record.track is None else record.track.transpose(1, 0, 2),
        track_time=np.empty((0, 0)) if record.track_time is None else record.track_time,
        anchor=np.empty((2, 0)),
        goal=goal,
        radius=plan.arrival_radius,
        inputs=_leg_inputs(plan, normals, state, record, goal) if block.inputs and not plan.via else {},
        contact=record.contact if environment.place is not None else None,
    )
    return continuing, found


def _limits(state: TrialState, record: TransitRecord, environment: Environment) -> dict[str, Flags]:
    """Which trials meet the limits of the current, where there is one."""
    if environment.is_still:
        return {}
    left, outrun = state.alive & record.left_record, state.alive & record.outrun
    return limit_events(environment.current, current_faster=outrun, left_record=left)


def _failures(state: TrialState, record: TransitRecord, environment: Environment, aground: Flags) -> dict[str, Flags]:
    """Which trials fail, by the reason; the last holds all that did not arrive."""
    missed, current = state.alive & ~record.arrived, environment.current
    failures = {AGROUND: aground}
    if environment.place is not None:
        failures = failures_met(record.contact)
        failures[AGROUND] = failures[AGROUND] | aground
    if current is not None and current.is_binding:
        failures[LEFT_RECORD] = missed & record.left_record
    if not environment.is_still:
        failures[OUTRUN] = missed & record.outrun
    return failures | {"not arrived": missed}


def _quantities(record: TransitRecord, arrived: Flags) -> dict[str, Array]:
    quantities = {
        "duration_s": record.duration,
        "surfacings": record.surfacings,
        "distance_m": record.distance,
        "arrival_error_m": record.arrival_error,
        "energy_wh": record.energy / JOULES_PER_WATT_HOUR,
    }
    return {name: where_reached(arrived, values) for name, values in quantities.items()}


def _leg_inputs(
    plan: TransitPlan, normals: TransitNormals, state: TrialState, record: TransitRecord, goal: Array
) -> dict[str, Array]:
    """Sum up what was drawn each leg: the mean velocity error over the legs, and the error of the arrival fix.

    Along and across (to port) the straight course from where the transit began.
    """
    legs = record.surfacings
    # the error is linear in its normals
    found = {"velocity_error": random_part(plan.velocity_error, _mean_over_legs(normals.velocity, state, legs))}
    if normals.fix_on_diving is not None and np.any(plan.fix_error):
        found["fix_error"] = plan.fix_error * _of_last_leg(normals.fix_on_diving, state, legs)
    course = goal - state.position
    length = np.hypot(course[0], course[1])
    along = course / np.where(length > 0.0, length, 1.0)
    return {
        f"{name}.{side}": values
        for name, vector in found.items()
        for side, values in (
            ("along", vector[0] * along[0] + vector[1] * along[1]),
            ("across", vector[1] * along[0] - vector[0] * along[1]),
        )
    }


def _mean_over_legs(source: Normals, state: TrialState, legs: Array) -> Array:
    """Mean over each trial's legs of the normals, shape (2, n)."""
    fewest, most = int(legs.min()), int(legs.max())
    total = np.zeros((2, state.trials))
    for number in range(most):
        normal = source.leg(number)[:, : state.trials]
        total += normal if number < fewest else np.where(legs > number, normal, 0.0)
    return np.asarray(total / np.maximum(legs, 1.0))


def _of_last_leg(source: Normals, state: TrialState, legs: Array) -> Array:
    """Normals of each trial's last leg, shape (2, n)."""
    fewest, most = int(legs.min()), int(legs.max())
    last = np.zeros((2, state.trials))
    for number in range(max(fewest - 1, 0), most):
        last = np.where(legs == number + 1, source.leg(number)[:, : state.trials], last)
    return last
