"""A mooring on a grid of depths: the depth and slope where the anchor lands, and what the vehicle meets there."""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.mission.schema.phases import MoorPhase
from missionplan.mission.schema.site import SlopeSection
from missionplan.phases.mooring.mooring import MoorPlan, MoorRecord
from missionplan.phases.place.place import Contact, Place, Way
from missionplan.phases.state import TrialState
from missionplan.scenario.mooring import dive_of
from missionplan.scenario.scenario import Scenario
from missionplan.studies.nominal_dive import sinking_speed
from missionplan.studies.simulation.phase_trials import Flags

TOLERANCE = 0.1
"""By which the depth that a trial went down to may differ from that where its anchor lies [m]: two fifths of what the
best survey of a harbour, of IHO S-44's Special Order, may be off."""
_MOST_PASSES = 8
_LEAST_DEPTH = 0.1
"""Of the water in which a mooring is computed that cannot be; such a trial has failed [m]."""


class Moored(NamedTuple):
    """A mooring of a block of trials, with what prevents it."""

    plan: MoorPlan
    prevented: dict[str, Flags]
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
    deep = scenario.at_depth(depth)
    site = deep.drawn.site
    if place.ground is None or site is None or site.slope is not None:
        return deep
    angle, toward = place.ground.slope_at(landing)
    section: SlopeSection[Scalars] = SlopeSection.model_construct(angle=np.minimum(angle, 1.0), toward=toward)
    return deep.on_slope(section)


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
