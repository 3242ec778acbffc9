"""What a mission needs to be simulated, checked before any trial is run, and notices for the reader."""

from typing import TYPE_CHECKING

import numpy as np

from missionplan.arrays import Scalars
from missionplan.effects import CATALOGUE
from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.mission.schema.phases import TransitPhase
from missionplan.mission.views import missing_for_moorings, missing_for_transitions, missing_for_transits
from missionplan.physics.anchor import solve_anchor
from missionplan.physics.vehicle_drag import range_notes
from missionplan.results.mooring.held_vehicle import HeldVehicle
from missionplan.results.mooring.sized_anchor import MooringAnchor
from missionplan.scenario.anchors import anchor_problem, wet_weight_of
from missionplan.scenario.scenario import Scenario
from missionplan.studies.flooding import flooding_notice
from missionplan.studies.held_vehicle import held_vehicle
from missionplan.studies.simulation.record_cover import interpolation_notices

if TYPE_CHECKING:
    from missionplan.studies.simulation.block_sequence import MergedBlocks
    from missionplan.studies.simulation.precision import Precision


def check_complete(mission: Mission) -> None:
    """Refuse a mission that lacks a section which its phases need.

    Raises
    ------
    InputError
        With everything that is missing.
    """
    problems = [] if mission.phases else [_missing(mission, "phases", "a mission to simulate has at least one phase")]
    problems += missing_for_transits(mission) if mission.transits else []
    problems += missing_for_moorings(mission) if mission.moors else []
    problems += missing_for_transitions(mission) if mission.transitions else []
    if mission.transits and (mission.site is None or mission.site.origin is None):
        turning = [entry.effect for entry in mission.effects if CATALOGUE[entry.effect].needs_latitude]
        problems += [_missing(mission, "site.origin", f"{effect} needs its latitude") for effect in turning[:1]]
    if problems:
        raise InputError(problems)


def _missing(mission: Mission, key: str, reason: str) -> Problem:
    return Problem(f"missing; {reason}", mission.file, key=key)


def input_notices(mission: Mission, means: Scenario) -> tuple[str, ...]:
    """Notices of the input: truncated distributions, models out of their range, what is left out."""
    return (
        *mission.notices(),
        *_energy_notices(mission),
        *_drag_notices(mission, means),
        *interpolation_notices(means),
        *(words for phase in means.drawn.transits if (words := _drift_notice(means, phase))),
        *_effect_notices(mission),
        *_anchor_notices(mission),
        *_datum_notice(mission),
        *(words for phase in means.drawn.moors if (words := flooding_notice(means, phase))),
    )


def _energy_notices(mission: Mission) -> tuple[str, ...]:
    """Notice where energy is not computed, or not all of it."""
    if mission.vehicle is None:
        return ("The mission has no vehicle: energy is not computed.",)
    if mission.budget is None:
        return ("The mission has no energy budget: energy is not computed.",)
    if mission.transits and (mission.site is None or mission.site.water is None):
        return ("The mission has no site.water: the energy of propulsion is not computed.",)
    return ()


def _drag_notices(mission: Mission, means: Scenario) -> tuple[str, ...]:
    """Notices where the model of the drag leaves its range."""
    if mission.vehicle is None or mission.site is None or mission.site.water is None or not mission.transits:
        return ()
    return range_notes(means.vehicle_drag, min(float(phase.speed) for phase in means.drawn.transits))


def _drift_notice(means: Scenario, phase: TransitPhase[Scalars]) -> str:
    """Notice of a mean drift at the start as fast as the vehicle, so that few trials can arrive; else empty."""
    drift = means.velocity_error.mean[:, 0]
    if means.current is not None:
        drift = drift + means.current.velocity(0.0, phase.depth, np.zeros((2, 1)))[:, 0]
    vehicle_speed, drift_speed = float(phase.speed), float(np.hypot(*drift))
    if drift_speed < vehicle_speed:
        return ""
    return f"{phase.name}: the mean drift, {drift_speed:.3g} m/s, is as fast as the vehicle, {vehicle_speed:.3g} m/s."


def _effect_notices(mission: Mission) -> list[str]:
    """Notices of effects that do not change the plan."""
    found = []
    for entry in mission.effects:
        if not CATALOGUE[entry.effect].changes_plan:
            where = "shows in the tank alone" if CATALOGUE[entry.effect].phase == "tank" else "acts on a reading alone"
            found.append(f"{entry.effect} {where}: it is carried and does not change the plan.")
    return found


def _anchor_notices(mission: Mission) -> list[str]:
    """Notice of parts of an anchor that are not drawn."""
    uncertain = [path for path in mission.uncertain() if path.startswith("vehicle.anchor.construction")]
    if not uncertain or not _makes_anchors(mission):
        return []
    return [f"The anchor is built once, from the means of its parts: {', '.join(uncertain)} not drawn."]


def _datum_notice(mission: Mission) -> list[str]:
    """Notice of a grid of depths whose datum nobody states."""
    site = mission.site
    if site is None or site.bathymetry is None or site.depth_datum is not None:
        return []
    return ["site.depth_datum is not given: depths are taken as below the level that site.tide_height counts from."]


def _makes_anchors(mission: Mission) -> bool:
    """Whether the mission's anchors are made of the parts that it gives."""
    anchor = mission.vehicle.anchor if mission.vehicle else None
    return bool(mission.moors and anchor and anchor.construction is not None and anchor.flooded_mass is None)


def mooring_anchors(mission: Mission, means: Scenario) -> tuple[MooringAnchor, ...]:
    """Return the anchors that are sized by the mission's worst case, and those that their parts cannot make."""
    found = []
    for phase in means.drawn.moors:
        weight, is_sized = float(wet_weight_of(means, phase)), phase.anchor_wet_weight == "sized"
        failures = solve_anchor(anchor_problem(means), weight).failures if _makes_anchors(mission) else ()
        if is_sized or failures:
            words = tuple(failure.words for failure in failures)
            found.append(MooringAnchor(phase.name, weight, is_sized, words))
    return tuple(found)


def held_vehicles(means: Scenario) -> tuple[HeldVehicle, ...]:
    """How the vehicle of each mooring stands on its line."""
    return tuple(held_vehicle(means, phase, float(wet_weight_of(means, phase))) for phase in means.drawn.moors)


def run_notices(merged: "MergedBlocks", goal: "Precision | None") -> tuple[str, ...]:
    """Notices of the run: precision not reached, failed blocks."""
    trials, failures = merged.totals.trials, len(merged.failures)
    found = []
    if goal is not None and not goal.is_reached(merged.totals):
        found.append(f"The precision asked for, {goal.text}, was not reached in {trials} trials.")
    if failures:
        how = "missionplan.studies.simulation.simulate.simulate_block(mission, seed=…, block=…) runs one alone"
        found.append(f"{failures} blocks of trials failed and are left out, see failed_blocks; {how}.")
    return tuple(found)
