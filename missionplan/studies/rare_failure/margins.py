"""How near each trial came to each way to fail, in the unit of its quantity: what leads to the failures."""

from collections.abc import Iterator

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.mission.schema.phases import MoorPhase, Phase, TransitPhase
from missionplan.physics.energy import JOULES_PER_WATT_HOUR
from missionplan.scenario.anchors import laden
from missionplan.scenario.held_vehicle import line_strength
from missionplan.scenario.scenario import Scenario
from missionplan.studies.rare_failure.event import RareEvent
from missionplan.studies.simulation.mission_trials import MissionTrials
from missionplan.studies.simulation.phase_trials import (
    AGROUND,
    LINE_PARTED,
    OUT_OF_ENERGY,
    TOO_LIGHT,
    TOO_SHALLOW,
    PhaseTrials,
)

_NOT_ARRIVED, _OUTSIDE, _STRUCK = "not arrived", "anchor outside the radius", "struck the seafloor"
_DRAGGED, _GROUNDED = "anchor dragged", "grounded in the hold"
_REASONS = {
    "arrived": (_NOT_ARRIVED, AGROUND, OUT_OF_ENERGY),
    "within_radius": (_OUTSIDE, TOO_SHALLOW, TOO_LIGHT, LINE_PARTED),
    "struck_seafloor": (_STRUCK,),
    "anchor_holds": (_DRAGGED, TOO_SHALLOW, TOO_LIGHT, LINE_PARTED),
    "grounded": (_GROUNDED,),
    "line_parts": (LINE_PARTED,),
    "hovering": (OUT_OF_ENERGY,),
}
"""Ways in which a phase's event fails, by the event."""


def margins(event: RareEvent, trials: MissionTrials, scenario: Scenario) -> dict[str, Array]:
    """Return the margins that matter for an event, by the way to fail; nan where a trial never came so far.

    Parameters
    ----------
    event : RareEvent
    trials : MissionTrials
    scenario : Scenario
        With the draws of these trials.
    """
    if event.is_quantity:
        values = np.asarray(trials.columns()[event.key], dtype=float)
        return {event.text: event.sign * (event.limit - values)}
    found: dict[str, Array] = {}
    spent: Scalars = 0.0
    for phase, done in zip(scenario.drawn.phases, trials.phases, strict=True):
        spent = spent + done.quantities["energy_wh"] if "energy_wh" in done.quantities else spent
        own = dict(_of_phase(phase, done, scenario, spent))
        ends_here = phase.name == event.phase
        chosen = _REASONS.get(event.name, ()) if ends_here else tuple(own) if event.negated else ()
        found |= {f"{phase.name}: {reason}": own[reason] for reason in chosen if reason in own}
        if ends_here:
            break
    return found


def _of_phase(
    phase: "Phase[Scalars]", done: PhaseTrials, scenario: Scenario, spent: Scalars
) -> Iterator[tuple[str, Array]]:
    """Margins of one phase; `spent` until its end [W h]."""
    if isinstance(phase, TransitPhase):
        yield from _of_transit(phase, done, scenario)
    elif isinstance(phase, MoorPhase):
        yield from _of_mooring(phase, done, scenario)
    left = scenario.capacity / JOULES_PER_WATT_HOUR - spent
    if np.all(np.isfinite(scenario.capacity)):
        yield OUT_OF_ENERGY, _each(left, done)


def _of_transit(phase: TransitPhase[Scalars], done: PhaseTrials, scenario: Scenario) -> Iterator[tuple[str, Array]]:
    """Legs left on arrival, less the share of the arrival radius used up: a trial just inside nearly needed another."""
    used = done.quantities["surfacings"] + np.minimum(done.quantities["arrival_error_m"] / done.radius, 1.0)
    yield _NOT_ARRIVED, scenario.navigation.max_legs + 1.0 - used
    site = scenario.drawn.site
    if site is not None and site.depth is not None:
        yield AGROUND, _each(site.depth - phase.depth, done)


def _of_mooring(phase: MoorPhase[Scalars], done: PhaseTrials, scenario: Scenario) -> Iterator[tuple[str, Array]]:
    found = done.quantities
    scenario = laden(scenario, phase)
    above_line = scenario.mooring.depth - phase.line_length
    yield TOO_SHALLOW, _each(above_line - scenario.mooring.vehicle.hull.length, done)
    yield TOO_LIGHT, found["terminal_velocity_m_s"]
    yield _OUTSIDE, done.radius - found["offset_m"]
    yield _STRUCK, found["lowest_altitude_m"]
    yield _DRAGGED, found["holding_margin"]
    yield _GROUNDED, found["nose_altitude_m"]
    strength = line_strength(phase)
    if strength is not None:
        tension = np.fmax(found["line_tension_n"], found.get("snatch_tension_n", found["line_tension_n"]))
        yield LINE_PARTED, strength - tension


def _each(values: Scalars, done: PhaseTrials) -> Array:
    """One value a trial that reached the phase; nan for the others."""
    return np.where(np.isnan(done.start), np.nan, values)
