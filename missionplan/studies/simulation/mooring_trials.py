"""A block of trials through a mooring, as `simulate` takes it.

A mooring on a grid of depths: the depth and slope where the anchor lands, and what the vehicle meets there.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
import scipy

from missionplan.arrays import Array, Scalars, over_trials
from missionplan.mission.schema.phases import MoorPhase
from missionplan.mission.schema.site import SlopeSection
from missionplan.montecarlo.reliability import Exposure
from missionplan.phases.currents import Current, Span
from missionplan.phases.hooks import TrialState
from missionplan.phases.mooring import MoorPlan, MoorRecord, moor
from missionplan.phases.place import Contact, Place, Way
from missionplan.physics.propulsion import JOULES_PER_WATT_HOUR
from missionplan.results.failures import Failure
from missionplan.scenario.phases import dive_of, fix_normals, line_strength, moor_plan, room_in_depth
from missionplan.scenario.scenario import STILL_WATER, Scenario
from missionplan.studies.held_vehicle import sinking_speed
from missionplan.studies.simulation.phase_trials import (
    Flags,
    PhaseTrials,
    TrialBlock,
    end_exhausted,
    failures_met,
    limit_events,
    margins_met,
    quantities_reached,
    where_reached,
)

TOLERANCE = 0.1
"""By which the depth that a trial went down to may differ from that where its anchor lies [m]: two fifths of what the
best survey of a harbour, of IHO S-44's Special Order, may be off."""
_MOST_PASSES = 8
_LEAST_DEPTH = 0.1
"""Of the water in which a mooring is computed that cannot be; such a trial has failed [m]."""


class Moored(NamedTuple):
    """A mooring of a block of trials, with what prevents it."""

    plan: MoorPlan
    prevented: dict[Failure, Flags]
    after: TrialState
    record: MoorRecord


def on_ground(
    scenario: Scenario, phase: MoorPhase[Scalars], state: TrialState, moored_in: Callable[[Scenario], Moored]
) -> Moored:
    """Moor where the water is as deep as where the anchor lands, which depends on how deep it is.

    The place is foreseen from the currents at the surface and half-way down, and again from each pass, until depths
    agree. An anchor drifts less far in a metre of descent than the ground rises, but for cliffs: there the last pass
    stands, and the depths differ by what the ground rises over the passes' last difference in place.
    """
    place = scenario.place
    if place is None or place.ground is None:
        return moored_in(scenario)
    landing, arrived = _foreseen(scenario, phase, state), state.clock
    done: Moored | None = None
    for _ in range(_MOST_PASSES):
        depth = _depth(place, landing, arrived)
        done = moored_in(_at(scenario, place, landing, depth))
        record = done.record
        down = state.alive & record.descent.touched_down
        lies = np.where(down, record.anchor, landing)
        arrived = np.where(down, state.clock + record.descent.release_time + record.descent.descent_time, state.clock)
        if not np.any(np.abs(_depth(place, lies, arrived) - depth) > TOLERANCE):
            break
        landing = lies
    if done is None:
        raise AssertionError("a mooring has one pass or more")
    return done


def _depth(place: Place, places: Array, t: Array) -> Array:
    """Depth of the water, where it is too little for any mooring a depth in which that shows [m]."""
    return np.fmax(place.water_at(places, t), _LEAST_DEPTH)


def _at(scenario: Scenario, place: Place, landing: Array, depth: Array) -> Scenario:
    """Return the mission in water of that depth, over that place's slope; one that the file gives stays."""
    site = scenario.drawn.site
    if place.ground is None or site is None or site.slope is not None:
        return scenario.at_depth(depth)
    angle, toward = place.ground.slope_at(landing)
    return scenario.at_depth(depth, SlopeSection.model_construct(angle=np.minimum(angle, 1.0), toward=toward))


def _foreseen(scenario: Scenario, phase: MoorPhase[Scalars], state: TrialState) -> Array:
    """Where an anchor lands, roughly, shape (2, n): by the current at the surface, then by that half-way down."""
    current, place = scenario.current, scenario.place
    if current is None or place is None:
        return state.position
    depth = _depth(place, state.position, state.clock)
    release = np.zeros(state.trials) + phase.release_time
    waiting = current.mean_velocity(state.clock, release, 0.0, state.position, np.zeros((2, 1))) * release
    speed = sinking_speed(dive_of(scenario.means, phase))
    sinking = depth / speed if speed > 0.0 else 0.0 * depth
    half = current.velocity(state.clock + release, 0.5 * depth, state.position)
    return state.position + waiting + half * sinking


def met_at_mooring(place: Place, plan: MoorPlan, state: TrialState, after: TrialState, record: MoorRecord) -> Contact:
    """What trials meet of zones while they go down and hold, and of everything while they drift after the ascent."""
    contact, rows = Contact.none(state.trials, measured=place.is_measured), np.flatnonzero(state.alive)
    landed = np.where(record.descent.touched_down, record.anchor, state.position)
    end = np.where(after.alive, after.clock, state.clock + record.descent.release_time)
    columns = replace(place, ground=None)
    down = Way(state.position, landed, state.clock, end, 0.0, plan.dive.site_depth)
    contact.note(rows, columns.take(rows).meets(down.take(rows)), 0)
    rows = np.flatnonzero(state.alive & record.surfaced)
    up = Way(record.surfaced_at, after.position, after.clock - plan.surfacing_time, after.clock)
    contact.note(rows, place.take(rows).meets(up.take(rows)), 0)
    return contact


def mooring_trials(
    block: TrialBlock, phase: MoorPhase[Scalars], state: TrialState, goal: Array
) -> tuple[TrialState, PhaseTrials]:
    """Run the trials of a block through a mooring.

    `state`: where the phase begins. `goal`, shape (2, 1) or (2, n): of the transit before [m].
    """
    scenario, begun = block.scenario, state.alive
    current = scenario.current or STILL_WATER
    moored_in = partial(_moored_in, block, phase, state, fix_normals(f"{phase.name}.fix", block.source, state.trials))
    plan, prevented, after, record = on_ground(scenario, phase, state, moored_in)
    taut = begun & ~np.logical_or.reduce(list(prevented.values()))
    moored = taut & record.descent.touched_down
    contact = None
    if scenario.place is not None:
        contact = met_at_mooring(scenario.place, plan, state, after, record)
        after = replace(after, alive=after.alive & ~contact.met)
    left = moored & ~_is_covered(plan, current, state, after, record)
    lost = left & current.is_binding
    after = replace(after, alive=after.alive & ~lost)
    continuing, exhausted = end_exhausted(after, scenario.capacity)
    moored, ended = moored & ~lost, after.alive & ~exhausted
    failures = {
        **({} if contact is None else {name: begun & met for name, met in failures_met(contact).items()}),
        **prevented,
        Failure.LEFT_RECORD: lost,
        **_failures(block, record, begun, taut, moored),
        Failure.OUT_OF_ENERGY: exhausted,
    }
    room = room_in_depth(plan.dive, plan.held.body.length)
    track, track_time = _track(plan, state, after, record, block.tracked)
    return continuing, PhaseTrials(
        name=phase.name,
        kind=phase.kind,
        quantities=_quantities(record, goal, moored, after.alive, ended) | _snatch(plan, record, taut),
        events=_events(block, phase, record, taut, moored),
        limits=limit_events(current, left_record=left),
        start=where_reached(begun, state.clock),
        end=where_reached(ended, after.clock),
        failures=failures,
        miss=where_reached(moored, record.anchor - goal),
        track=track,
        track_time=track_time,
        anchor=where_reached(moored, record.anchor),
        goal=goal,
        radius=plan.radius,
        inputs={},
        contact=contact,
        exposure=_exposure(plan, begun, record),
        profile=_profile(plan, state, moored, after, record)[:, :, : block.tracked],
        margins={Failure.TOO_SHALLOW: over_trials(room, state.trials), **margins_met(contact)},
    )


def _moored_in(
    block: TrialBlock, phase: MoorPhase[Scalars], state: TrialState, normals: Array, scenario: Scenario
) -> Moored:
    """Moor in a scenario: the block's, or that with the depths of the trials' own places."""
    plan = moor_plan(scenario, phase)
    prevented = {Failure.TOO_SHALLOW: state.alive & (room_in_depth(plan.dive, plan.held.body.length) <= 0.0)}
    anchor = block.scenario.mooring.anchor
    if anchor.premature_flooding > 0.0:
        flooding = block.source.once(f"{phase.name}.premature_flooding")[: state.alive.size]
        prevented[Failure.FLOODED_EARLY] = state.alive & (scipy.special.ndtr(flooding) < anchor.premature_flooding)
    taut = state.alive & ~np.logical_or.reduce(list(prevented.values()))
    current = block.scenario.current or STILL_WATER
    effects, surface = scenario.descent_effects, scenario.effects_afloat
    alive = replace(state, alive=taut)
    return Moored(plan, prevented, *moor(plan, alive, normals, current, effects=effects, surface_effects=surface))


def _failures(block: TrialBlock, record: MoorRecord, begun: Flags, taut: Flags, moored: Flags) -> dict[Failure, Flags]:
    """Return the trials that fail by each way of the dive and the hold, in the order in which they come about."""
    # of the hold those alone of which the vehicle file gives what they depend on
    mooring, hold, hold_failures = block.scenario.mooring, record.hold, {}
    if mooring.anchor.holding_factor is not None:
        hold_failures[Failure.DRAGGED] = moored & ~hold.anchor_holds
    if mooring.vehicle.centres is not None:
        hold_failures[Failure.GROUNDED] = moored & hold.grounded
    return {
        Failure.LINE_PARTED: taut & record.line_parted,
        Failure.TOO_LIGHT: begun & ~moored & (record.descent.terminal_velocity <= 0.0),
        Failure.NOT_DOWN: begun & ~moored,
        Failure.OUTSIDE: moored & ~record.within_radius,
        Failure.STRUCK: moored & record.struck,
        **hold_failures,
        Failure.NOT_SURFACED: moored & ~record.surfaced,
    }


def _exposure(plan: MoorPlan, begun: Flags, record: MoorRecord) -> Exposure:
    """What the equipment of the trials that began the mooring goes through, to the end of the hold where they stay."""
    descent, one = record.descent, begun.astype(float)
    stay = descent.release_time + np.nan_to_num(descent.descent_time) + plan.moored_time
    time = np.where(record.surfaced, np.nan_to_num(record.duration), stay)
    down = begun & descent.touched_down
    up = (down & record.surfaced).astype(float)
    return Exposure(one * time, 0.0, up, one, one, down.astype(float))


def _snatch(plan: MoorPlan, record: MoorRecord, taut: Flags) -> dict[str, Array]:
    """What the mission and vehicle files let be known of the snatch, also of lines that part then."""
    descent, quantities = record.descent, {}
    if plan.dive.spring is not None:
        quantities["snatch_tension_n"] = (taut, descent.snatch_tension)
    if plan.dive.pitching is not None:
        down = taut & descent.touched_down
        quantities |= {"nose_down_time_s": (down, descent.nose_down_time), "depth_lost_m": (down, descent.depth_lost)}
    return quantities_reached(quantities)


def _events(
    block: TrialBlock, phase: MoorPhase[Scalars], record: MoorRecord, taut: Flags, moored: Flags
) -> dict[str, Flags]:
    """Events of the dive and the hold; that the line parts where its strength is known."""
    dive = {"within_radius": moored & record.within_radius, "struck_seafloor": moored & record.struck}
    events = {**dive, "anchor_holds": moored & record.hold.anchor_holds, "grounded": moored & record.hold.grounded}
    if line_strength(phase) is not None:
        events["line_parts"] = taut & record.line_parted
    return events


def _track(
    plan: MoorPlan, before: TrialState, after: TrialState, record: MoorRecord, tracked: int
) -> tuple[Array, Array]:
    """Anchor on the seafloor, vehicle surfacing, last fix: where, shape (3, 2, k) [m], and when, shape (3, k) [s]."""
    descent, end = record.descent, before.clock + record.duration
    points = (record.anchor, record.surfaced_at, after.position)
    times = (before.clock + descent.release_time + descent.descent_time, end - plan.surfacing_time, end)
    track = np.stack([np.where(after.alive, point, np.nan)[:, :tracked] for point in points])
    return track, np.stack([np.where(after.alive, time, np.nan)[:tracked] for time in times])


def _profile(plan: MoorPlan, before: TrialState, moored: Flags, after: TrialState, record: MoorRecord) -> Array:
    """Depth of the nose against time: sinking, held on the line, rising, afloat, shape (2, 6, n) [s, m]."""
    descent, end = record.descent, before.clock + record.duration
    surfaced = end - plan.surfacing_time
    hold_depth = plan.dive.site_depth - record.hold.nose_altitude
    afloat = np.zeros(before.trials)
    times = (before.clock, before.clock + descent.release_time, surfaced - record.ascent_time, surfaced, end)
    begun, released, rising, surfacing, ended = (np.broadcast_to(time, afloat.shape) for time in times)
    when = [begun, released, released + descent.descent_time, rising, surfacing, ended]
    lasts = [before.alive, before.alive, moored, moored & after.alive, after.alive, after.alive]
    depth = [afloat, afloat, afloat + hold_depth, afloat + hold_depth, afloat, afloat]
    return np.array([np.where(lasts, when, np.nan), np.where(lasts, depth, np.nan)])


def _is_covered(plan: MoorPlan, current: Current, before: TrialState, after: TrialState, record: MoorRecord) -> Flags:
    """Whether the current was known on the way down and on the way up, and so in the hold between them.

    Shape broadcasting to (n,).
    """
    depth, descent = plan.dive.site_depth, record.descent
    down = before.clock + descent.release_time + descent.descent_time
    up = before.clock + record.duration
    rising = up - plan.surfacing_time - record.ascent_time
    covered = current.covers(Span(before.clock, down, depth, (before.position, record.anchor)))
    surfaced = (record.anchor, record.surfaced_at, after.position)
    return covered & (current.covers(Span(rising, up, depth, surfaced)) | ~record.surfaced)


def _quantities(record: MoorRecord, goal: Array, moored: Flags, surfaced: Flags, ended: Flags) -> dict[str, Array]:
    descent, miss = record.descent, record.anchor - goal
    return quantities_reached(
        {
            "release_time_s": (moored, descent.release_time),
            "payout_time_s": (moored, descent.payout_time),
            "descent_time_s": (moored, descent.descent_time),
            "terminal_velocity_m_s": (moored, descent.terminal_velocity),
            "touchdown_speed_m_s": (moored, descent.touchdown_speed),
            "offset_m": (moored, record.offset_distance),
            "target_offset_m": (moored, np.hypot(miss[0], miss[1])),
            "lowest_altitude_m": (moored, descent.lowest_altitude),
            "nose_altitude_m": (moored, record.hold.nose_altitude),
            "excursion_m": (moored, record.hold.excursion),
            "line_tension_n": (moored, record.hold.line_tension),
            "holding_margin": (moored, record.hold.holding_margin),
            "ascent_time_s": (surfaced, record.ascent_time),
            "duration_s": (ended, record.duration),
            "energy_wh": (ended, record.energy / JOULES_PER_WATT_HOUR),
        }
    )
