"""Trials of a phase: what every kind of phase tells of them, and transits and transitions."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars
from missionplan.mission.schema.manoeuvring import TransitionPhase
from missionplan.mission.schema.phases import TransitPhase
from missionplan.montecarlo.reliability import Exposure
from missionplan.montecarlo.streams import NormalSource
from missionplan.phases.currents import Current
from missionplan.phases.hooks import TrialState
from missionplan.phases.place import Contact
from missionplan.phases.transit import transit
from missionplan.phases.transit.ground_velocity import random_part
from missionplan.phases.transit.plan import Environment, TransitNormals, TransitPlan, TransitRecord, column
from missionplan.phases.transition_simulation import simulate_transition
from missionplan.physics.propulsion import JOULES_PER_WATT_HOUR
from missionplan.results.failures import MET, Failure
from missionplan.scenario.phases import manoeuvre, transit_normals, transition_vehicle
from missionplan.scenario.scenario import Scenario

Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class TrialBlock:
    """A block of trials to run."""

    scenario: Scenario
    """With the block's draws."""
    source: NormalSource
    """Of what is drawn each leg or fix."""
    tracked: int
    """Trials whose tracks are kept."""
    inputs: bool
    """Whether to sum up what was drawn each leg."""


@dataclass(frozen=True)
class PhaseTrials:
    """Trials of one phase. nan: the trial never reached it."""

    name: str
    kind: str
    quantities: Mapping[str, Array]
    """By the names of `summary.json`, shape (n,)."""
    events: Mapping[str, Flags]
    """Events, shape (n,)."""
    limits: Mapping[str, Flags]
    """Which trials met a current faster than the vehicle (``current_faster``), or left the record of it
    (``left_record``), whether or not they failed; empty where neither can be; shape (n,)."""
    start: Array
    end: Array
    """Since the mission's start, shape (n,) [s]."""
    failures: Mapping[Failure, Flags]
    """Trials of which the mission fails here, by the reason, in the order in which they happen, shape (n,)."""
    miss: Array
    """From the phase's goal to where it ended, of the vehicle or its anchor, shape (2, n) [m]."""
    track: Array
    """Of the first trials, nan after the phase has ended for them, shape (points, 2, k) [m]."""
    track_time: Array
    """Since the mission's start, at the points of the track, shape (points, k) [s]."""
    anchor: Array
    """On the seafloor; none in a transit; shape (2, n) or (2, 0) [m]."""
    goal: Array
    """Goal, shape (2, 1) or (2, n) [m]."""
    radius: Scalars
    """Of arrival or of the mooring, float or shape (n,) [m]."""
    inputs: Mapping[str, Array]
    """Draws of each leg or fix, summed up in one number a trial; empty where not requested; shape (n,)."""
    contact: Contact | None = None
    """What of ground, coast and zones each trial met here, on which leg and where; None where the phase meets none."""
    exposure: Exposure = field(default_factory=Exposure)
    """Of the equipment, in this phase."""
    left: Mapping[str, Flags] = field(default_factory=dict)
    """Trials whose equipment failed here, by what that leaves of the vehicle: ``adrift``, ``sunk``, …; shape (n,)."""
    profile: Array = field(default_factory=lambda: np.empty((2, 0, 0)))
    """When, since the mission's start, and how deep, of the same trials; straight between; shape (2, corners, k) [s,
    m]."""
    margins: Mapping[Failure, Array] = field(default_factory=dict)
    """By the reason, how near each trial came to failing here of what no quantity tells: 0 or less where it does; shape
    (n,)."""


def failures_met(contact: Contact) -> dict[Failure, Flags]:
    """Failures by what was met."""
    return {reason: contact.of(cause) for cause, reason in MET.items()}


def margins_met(contact: Contact | None) -> dict[Failure, Array]:
    """How near trials came to what was met or not; none where the place does not measure it."""
    if contact is None or not len(contact.nearest):
        return {}
    return {reason: contact.nearest[cause - 1] for cause, reason in MET.items()}


def limit_events(current: Current | None, **happened: Flags) -> dict[str, Flags]:
    """Events of the limits of the current; `left_record` only where the current is a record."""
    is_record = current is not None and current.is_record
    return {name: values for name, values in happened.items() if name != "left_record" or is_record}


def end_exhausted(state: TrialState, capacity: Scalars) -> tuple[TrialState, Flags]:
    """End the trials that have used more energy than the battery holds [J].

    Raises FloatingPointError when the position or the time of a trial under way is not finite.
    """
    for values in (state.position, state.fix, state.clock):
        if not np.isfinite(values).all() and not np.isfinite(values[..., state.alive]).all():
            raise FloatingPointError("the position or the time of a trial under way is not finite")
    exhausted = state.alive & (state.energy > capacity)
    return replace(state, alive=state.alive & ~exhausted), exhausted


def where_reached(reached: Flags, values: Array) -> Array:
    """Values of the trials that reached something, nan for the others."""
    return values if reached.all() else np.where(reached, values, np.nan)


def quantities_reached(reached: Mapping[str, tuple[Flags, Array]]) -> dict[str, Array]:
    """Quantities by name, nan for the trials that did not reach them."""
    return {name: where_reached(mask, values) for name, (mask, values) in reached.items()}


def transit_trials(
    block: TrialBlock, phase: TransitPhase[Scalars], state: TrialState
) -> tuple[TrialState, PhaseTrials]:
    """Run the trials of a block through a transit."""
    scenario = block.scenario
    plan, normals = scenario.transit_plan(phase), transit_normals(scenario, phase, block.source)
    environment = scenario.environment(phase)
    site = scenario.drawn.site
    is_flat = scenario.place is None or scenario.place.ground is None
    depth = np.inf if site is None or site.depth is None or not is_flat else site.depth
    aground = state.alive & np.atleast_1d(plan.depth >= depth)
    state = replace(state, alive=state.alive & ~aground)
    execution = scenario.executions.get(phase.name)
    tracked = min(block.tracked, state.trials)
    after, record = transit(plan, state, normals, environment, tracked=tracked, execution=execution)
    reserve = 0.0 if execution is None else execution.reserve
    continuing, exhausted = end_exhausted(after, scenario.capacity * (1.0 - reserve))
    goal, arrived = column(plan.goal), record.arrived & ~exhausted
    contact = record.contact if environment.place is not None else None
    below = {Failure.AGROUND: _each(depth - plan.depth, state)} if np.all(np.isfinite(depth)) else {}
    trials = PhaseTrials(
        name=phase.name,
        kind=phase.kind,
        quantities=_quantities(record, arrived),
        events={"arrived": arrived},
        limits=_limits(state, record, environment),
        start=where_reached(state.alive, state.clock),
        end=where_reached(arrived, after.clock),
        failures=_failures(state, record, environment, aground) | {Failure.OUT_OF_ENERGY: exhausted},
        miss=where_reached(arrived, after.position - goal),
        track=np.empty((0, 2, 0)) if record.track is None else record.track.transpose(1, 0, 2),
        track_time=np.empty((0, 0)) if record.track_time is None else record.track_time,
        anchor=np.empty((2, 0)),
        goal=goal,
        radius=plan.arrival_radius,
        inputs=_leg_inputs(plan, normals, state, record, goal) if block.inputs and not plan.via else {},
        contact=contact,
        exposure=Exposure(record.duration, record.distance, record.surfacings, record.surfacings),
        profile=_profile(plan, record.track_time),
        margins=below | margins_met(contact),
    )
    return continuing, trials


def _profile(plan: TransitPlan, time: Array | None) -> Array:
    """Depth against time of the tracked trials: down after each fix, up where each leg ends [s, m]."""
    if time is None or len(time) < 2:
        return np.empty((2, 0, 0 if time is None else time.shape[1]))
    trials = time.shape[1]
    depth = np.zeros((len(time), 2, trials))  # the rows are by turns on diving and on surfacing
    depth[1::2, 0] = np.atleast_1d(plan.depth)[:trials]
    depth[:-1:2, 1] = np.where(np.isfinite(time[1::2]), depth[1::2, 0], 0.0)
    when = np.repeat(time, 2, axis=0)
    return np.stack([when, np.where(np.isfinite(when), depth.reshape(-1, trials), np.nan)])


def _limits(state: TrialState, record: TransitRecord, environment: Environment) -> dict[str, Flags]:
    """Which trials meet the limits of the current, where there is one."""
    if environment.is_still:
        return {}
    left, outrun = state.alive & record.left_record, state.alive & record.outrun
    return limit_events(environment.current, current_faster=outrun, left_record=left)


def _failures(
    state: TrialState, record: TransitRecord, environment: Environment, aground: Flags
) -> dict[Failure, Flags]:
    """Which trials fail, by the reason; the last holds all that did not arrive."""
    missed, current = state.alive & ~record.arrived, environment.current
    failures = {Failure.AGROUND: aground}
    if environment.place is not None:
        failures = failures_met(record.contact)
        failures[Failure.AGROUND] = failures[Failure.AGROUND] | aground
    if current is not None and current.is_binding:
        failures[Failure.LEFT_RECORD] = missed & record.left_record
    if not environment.is_still:
        failures[Failure.OUTRUN] = missed & record.outrun
    return failures | {Failure.NOT_ARRIVED: missed}


def _quantities(record: TransitRecord, arrived: Flags) -> dict[str, Array]:
    quantities = {
        "duration_s": record.duration,
        "surfacings": record.surfacings,
        "distance_m": record.distance,
        "arrival_error_m": record.arrival_error,
        "energy_wh": record.energy / JOULES_PER_WATT_HOUR,
    }
    return {name: where_reached(arrived, values) for name, values in quantities.items()}


UNITS_OF_LEGS = {"velocity_error": "m/s", "fix_error": "m"}
SIDES = ("along", "across")
"""What is summed up of the draws of each leg, with its SI unit, along and across the course."""


def _leg_inputs(
    plan: TransitPlan, normals: TransitNormals, state: TrialState, record: TransitRecord, goal: Array
) -> dict[str, Array]:
    """Sum up what was drawn each leg: the mean velocity error over the legs, and the error of the arrival fix.

    Along and across (to port) the straight course from where the transit began.
    """
    legs = record.surfacings
    # the error is linear in its normals
    # mean over each trial's legs of the normals, shape (2, n)
    fewest, most = int(legs.min()), int(legs.max())
    total = np.zeros((2, state.trials))
    for number in range(most):
        normal = normals.velocity.leg(number)[:, : state.trials]
        total += normal if number < fewest else np.where(legs > number, normal, 0.0)
    errors = {"velocity_error": random_part(plan.velocity_error, np.asarray(total / np.maximum(legs, 1.0)))}
    if normals.fix_on_diving is not None and np.any(plan.fix_error):
        last = np.zeros((2, state.trials))  # normals of each trial's last leg
        for number in range(max(fewest - 1, 0), most):
            last = np.where(legs == number + 1, normals.fix_on_diving.leg(number)[:, : state.trials], last)
        errors["fix_error"] = plan.fix_error * last
    course = goal - state.position
    length = np.hypot(course[0], course[1])
    along = course / np.where(length > 0.0, length, 1.0)
    return {
        f"{name}.{side}": values
        for name, vector in errors.items()
        for side, values in zip(
            SIDES,
            (vector[0] * along[0] + vector[1] * along[1], vector[1] * along[0] - vector[0] * along[1]),
            strict=True,
        )
    }


def transition_trials(
    block: TrialBlock, phase: TransitionPhase[Scalars], state: TrialState
) -> tuple[TrialState, PhaseTrials]:
    """Slow every trial of a block down to hover, where it is.

    Energy is that of the tunnel thrusters until the vehicle hovers, and of the hotel load where the mission has one;
    the propeller's own is left out, as in the paper. A vehicle that does not reach hover fails.

    `state`: where the phase begins.
    """
    scenario = block.scenario
    record = simulate_transition(transition_vehicle(scenario, phase), manoeuvre(phase))
    hotel = scenario.budget.hotel
    duration = _each(record.hover_time, state)
    spent = _each(record.energy_to_hover, state) + duration * (hotel if np.all(np.isfinite(hotel)) else 0.0)
    hovering = state.alive & np.isfinite(duration)
    after = replace(
        state,
        clock=state.clock + np.where(hovering, duration, 0.0),
        energy=state.energy + np.where(hovering, spent, 0.0),
        alive=hovering,
    )
    continuing, exhausted = end_exhausted(after, scenario.capacity)
    quantities = {
        "depth_excursion_m": (state.alive, _each(record.depth_excursion, state)),
        "pitch_excursion_rad": (state.alive, _each(record.pitch_excursion, state)),
        "hover_time_s": (hovering, duration),
        "duration_s": (hovering, duration),
        "energy_wh": (hovering, spent / JOULES_PER_WATT_HOUR),
    }
    trials = PhaseTrials(
        name=phase.name,
        kind=phase.kind,
        quantities=quantities_reached(quantities),
        limits={},
        events={"hovering": hovering},
        start=where_reached(state.alive, state.clock),
        end=where_reached(hovering, after.clock),
        failures={Failure.NOT_HOVERING: state.alive & ~hovering, Failure.OUT_OF_ENERGY: exhausted},
        miss=np.full((2, state.trials), np.nan),
        track=where_reached(hovering, state.position)[None, :, : block.tracked],
        track_time=where_reached(hovering, after.clock)[None, : block.tracked],
        anchor=np.empty((2, 0)),
        goal=state.position,
        radius=0.0,
        inputs={},
        profile=np.empty((2, 0, min(block.tracked, state.trials))),
    )
    return continuing, trials


def _each(values: Scalars, state: TrialState) -> Array:
    """One value a trial, also where no draw made them differ."""
    return np.array(np.broadcast_to(values, (state.trials,)), dtype=float)
