"""Will the mission work? What is checked and said before and after: what is missing, the current's record, notices.

Read then `simulate`, `trial_block` (one block), `block_statistics` (its statistics) and `outcome_builder`;
for a vehicle that does not come back `overdue` (times, and areas), `losses` (where trials end) and `drift`.
"""

from collections.abc import Iterator
from dataclasses import replace
from datetime import timedelta
from typing import TYPE_CHECKING

import numpy as np

from missionplan.arrays import Scalars
from missionplan.effects import CATALOGUE
from missionplan.errors import InputError, MissionplanError, Problem, counted
from missionplan.mission import Mission
from missionplan.mission.schema.phases import LegTableSection, TransitPhase
from missionplan.mission.views import missing_for_moorings, missing_for_transitions, missing_for_transits
from missionplan.phases.currents import Current
from missionplan.phases.ensemble import Ensemble
from missionplan.phases.gridded_current import GriddedCurrent
from missionplan.phases.recorded_currents import RecordedCurrent
from missionplan.physics.anchor import solve_anchor
from missionplan.physics.drag import range_notes
from missionplan.results.simulation import MooringAnchor
from missionplan.results.whereabouts import HeldVehicle
from missionplan.scenario.anchors import anchor_problem, wet_weight_of
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.site_current import recorded_current
from missionplan.studies.held_vehicle import check_dives, held_vehicle

if TYPE_CHECKING:
    from missionplan.montecarlo.statistics import Count
    from missionplan.studies.simulation.block_sequence import MergedBlocks, Precision


_TIMES_LOOKED_AT = 500
"""Of a record, for what its steps cost."""
TOLERATED = 0.01
"""Share of the trials that may leave the record."""
REMEDY = "take a longer or wider record, or say site.current.outside: hold (or zero)"


def check_cover(mission: Mission, means: Scenario) -> None:
    """Refuse a record of the current that does not cover the nominal mission in time, depth and place.

    `means` has the record. Raises InputError with the positions outside, and what the record lacks.
    """
    current = means.recorded
    if not isinstance(current, RecordedCurrent):
        return
    problems = list(_outside_in_place(mission, means, current))
    lasts = f"the record {_lasting(mission, current)}"
    if current.is_binding and (current.time[-1] < 0.0 or current.time[0] > 0.0):
        start = f", {_moment(mission, 0.0)}" if mission.start else ""
        problems.append(_problem(mission, f"{lasts}: it does not hold the mission's start{start}"))
    elif current.time[-1] < 0.0:  # nor may it be held: a mistaken start is likelier than a forecast that long ago
        message = f"{lasts}: it ends before the mission starts"
        problems.append(Problem(message, mission.file, key="site.current", hint="see start and site.current.start"))
    elif current.is_binding and not problems:
        problems += _nominal(mission, means, current, lasts)
    if problems:
        raise InputError(problems)


def check_trials(means: Scenario, left: "Count | None") -> None:
    """Refuse a run of which more than 1 % of the trials left the record of the current.

    Raises InputError with the remedy.
    """
    mission, current = means.mission, means.recorded
    share = left.probability().value if left is not None else 0.0
    if isinstance(current, RecordedCurrent) and current.is_binding and share > TOLERATED:
        words = f"{100.0 * share:.3g} % of the trials leave the record of the current"
        message = f"{words}, which {_extent(mission, current)}; at most {100.0 * TOLERATED:g} % may"
        raise InputError([_problem(mission, message)])


def interpolation_notices(means: Scenario) -> tuple[str, ...]:
    """Notice of what the straight lines between a record's times may cost a leg, where that is more than a metre.

    Between two times h apart a straight line is off by at most h²|u″|/8, of which second differences are the estimate.
    """
    current = means.recorded
    if not isinstance(current, RecordedCurrent) or isinstance(current, Ensemble) or current.time.size < 3:
        return ()
    times = current.time[current.time > -np.ptp(current.time[:2])][:_TIMES_LOOKED_AT]
    notices = []
    for phase in means.drawn.transits:
        place = means.position(phase.to)[:, None]
        values = np.stack([current.velocity(float(t), float(phase.depth), place)[:, 0] for t in times], axis=1)
        off = float(np.max(np.hypot(*np.diff(values, 2)), initial=0.0)) / 8.0
        longest = (
            float(np.max(phase.d_max.table, axis=0)[1]) if isinstance(phase.d_max, LegTableSection) else phase.d_max
        )
        metres = off * float(longest) / float(phase.speed)
        if metres > 1.0:
            step = float(np.median(np.diff(times))) / 60.0
            notices.append(
                f"{phase.name}: the current has a value every {step:.3g} min, and straight lines between them are off "
                f"by up to {off:.2g} m/s: up to {metres:.2g} m on a leg of {longest:.4g} m."
            )
    return tuple(notices)


def cover_in_words(mission: Mission, current: Current | None) -> str:
    """Sentence on what a record of the current covers in time, place and depth; none where there is no record."""
    if not isinstance(current, RecordedCurrent) or not np.isfinite(current.time).all():
        return ""
    words = f" Current: {_lasting(mission, current)}"
    if isinstance(current, Ensemble):
        words += f", {counted(len(current.members), 'member')}"
    if isinstance(current, GriddedCurrent):
        low, high = current.grid.extent / 1000.0
        words += f", from {low[0]:.1f} to {high[0]:.1f} km east and from {low[1]:.1f} to {high[1]:.1f} km north"
        land = 1.0 - float(np.mean(np.any(current.wet, axis=0)))
        words += f" ({100.0 * land:.0f} % of it land)" if land else ""
    return f"{words}, down to {current.depths_covered[1]:.4g} m.".replace("Current: lasts ", "Current: ", 1)


def _lasting(mission: Mission, current: RecordedCurrent) -> str:
    """When a record begins and ends, as the predicate of a sentence."""
    if not np.isfinite(current.time).all():
        return "has no end"
    first, last = (_moment(mission, moment) for moment in current.time[[0, -1]])
    clock = "UTC" if mission.start else "after the mission's start"
    # of a field the times before the mission's are not read: where one is left, it is the last
    return f"lasts from {first} to {last} {clock}" if first != last else f"ends at {last} {clock}"


def _moment(mission: Mission, seconds: float) -> str:
    """Date and time of day, or the seconds since the start where the mission has none."""
    if mission.start is None:
        return f"{seconds:.0f} s"
    return (mission.start + timedelta(seconds=float(seconds))).strftime("%Y-%m-%d %H:%M")


def _nominal(mission: Mission, means: Scenario, current: RecordedCurrent, lasts: str) -> list[Problem]:
    """Run the mission once at its means, with the record's ends held, and see which phases leave it."""
    from missionplan.studies.simulation.trial_block import run_block  # most missions have no record to be run with

    scenario = replace(means, recorded=replace(current, outside="hold"))
    try:
        phases = () if _lacking(mission) else run_block(scenario, mission.monte_carlo.seed, 0, 1, inputs=False).phases
    except (MissionplanError, ArithmeticError):
        return []  # said by whoever runs the mission
    outside = [phase for phase in phases if np.any(phase.limits.get("left_record", False))]
    if not outside:
        return []
    ends = [float(phase.end[0]) for phase in phases if np.isfinite(phase.end[0])]
    if ends and ends[-1] > current.time[-1]:
        until = f"ends at {_moment(mission, ends[-1])}" if mission.start else f"takes {ends[-1]:.0f} s"
        message = f"{lasts}; the nominal mission {until}"
    else:
        names, verb = " and ".join(phase.name for phase in outside), "leaves" if len(outside) == 1 else "leave"
        message = f"the nominal {names} {verb} the record, which {_extent(mission, current)}"
    return [_problem(mission, message)]


def _extent(mission: Mission, current: RecordedCurrent) -> str:
    low, high = current.depths_covered
    lasts = "" if np.isinf(current.time[-1]) else f"{_lasting(mission, current)} and "
    words = f"{lasts}is good down to {high:.4g} m"
    return words if low <= 0.0 else f"{words}, from {low:.4g} m"


def _problem(mission: Mission, message: str) -> Problem:
    return Problem(message, mission.file, key="site.current", hint=REMEDY)


def _outside_in_place(mission: Mission, means: Scenario, current: RecordedCurrent) -> Iterator[Problem]:
    """Positions of the mission beyond a field that must hold them, or on its land."""
    if isinstance(current, Ensemble):
        for member in current.members:
            yield from _outside_in_place(mission, means, replace(member, outside=current.outside))
    if not isinstance(current, GriddedCurrent) or not current.is_binding:
        return
    low, high = current.grid.extent
    ends = [
        (phase.name, key, place)
        for phase in means.drawn.transits
        for key, place in (("from", phase.start), ("to", phase.to))
    ]
    for name, place in ((f"{name}.{key}", means.position(place)) for name, key, place in ends if place is not None):
        where = np.asarray(place, dtype=float)[:, None]
        beyond = False
        for value, first, last, way in zip(place, low, high, ("east", "north"), strict=True):
            if not first <= value <= last:
                beyond = True
                span = f"the field reaches from {first:.0f} m to {last:.0f} m {way} of the origin"
                yield Problem(f"lies at {value:.0f} m; {span}", mission.file, key=name, hint=REMEDY)
        if not beyond and not np.all(current.holds(where)):
            message = "lies on land, or in a gap of the grid, of this field of the current"
            yield Problem(message, mission.file, key=name, hint=REMEDY)


def _lacking(mission: Mission) -> list[Problem]:
    """Sections that the mission's phases need and that are missing."""
    problems = [] if mission.phases else [_missing(mission, "phases", "a mission to simulate has at least one phase")]
    problems += missing_for_transits(mission) if mission.transits else []
    problems += missing_for_moorings(mission) if mission.moors else []
    return problems + (missing_for_transitions(mission) if mission.transitions else [])


def check_complete(mission: Mission) -> None:
    """Refuse a mission that lacks a section which its phases need.

    Raises InputError with everything that is missing.
    """
    problems = _lacking(mission)
    if mission.transits and (mission.site is None or mission.site.origin is None):
        turning = [entry.effect for entry in mission.effects if CATALOGUE[entry.effect].needs_latitude]
        problems += [_missing(mission, "site.origin", f"{effect} needs its latitude") for effect in turning[:1]]
    if problems:
        raise InputError(problems)


def _missing(mission: Mission, key: str, reason: str) -> Problem:
    return Problem(f"missing; {reason}", mission.file, key=key)


def covered_means(mission: Mission) -> Scenario:
    """Return a mission at its means; raises InputError where its current does not cover it, or a dive is impossible."""
    means = Scenario.at_means(mission, recorded_current(mission))
    check_cover(mission, means)
    check_dives(means)
    return means


def input_notices(mission: Mission, means: Scenario) -> tuple[str, ...]:
    """Notices of the input: truncated distributions, models out of their range, what is left out."""
    notices: list[str] = []
    for entry in mission.effects:
        if not CATALOGUE[entry.effect].changes_plan:
            where = "shows in the tank alone" if CATALOGUE[entry.effect].phase == "tank" else "acts on a reading alone"
            notices.append(f"{entry.effect} {where}: it is carried and does not change the plan.")
    uncertain = [path for path in mission.uncertain() if path.startswith("vehicle.anchor.construction")]
    if uncertain and _makes_anchors(mission):
        notices.append(f"The anchor is built once, from the means of its parts: {', '.join(uncertain)} not drawn.")
    site = mission.site
    if site is not None and site.bathymetry is not None and site.depth_datum is None:
        notices.append(
            "site.depth_datum is not given: depths are taken as below the level that site.tide_height counts from."
        )
    return (
        *mission.notices(),
        *_energy_notices(mission),
        *interpolation_notices(means),
        *(means.place.notices if means.place is not None else ()),
        *(words for phase in means.drawn.transits if (words := _drift_notice(means, phase))),
        *notices,
    )


def _energy_notices(mission: Mission) -> tuple[str, ...]:
    if mission.vehicle is None:
        return ("The mission has no vehicle: energy is not computed.",)
    if mission.budget is None:
        return ("The mission has no energy budget: energy is not computed.",)
    if mission.transits and (mission.site is None or mission.site.water is None):
        return ("The mission has no site.water: the energy of propulsion is not computed.",)
    return ()


def vehicle_notices(mission: Mission, means: Scenario) -> tuple[str, ...]:
    """Notices that hold for every mission with this vehicle at this speed: where the model of its drag ends."""
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
    return f"{phase.name}: the mean drift, {drift_speed:.3g} m/s, reaches the vehicle's speed, {vehicle_speed:.3g} m/s."


def _makes_anchors(mission: Mission) -> bool:
    """Whether the mission's anchors are made of the parts that it gives."""
    anchor = mission.vehicle.anchor if mission.vehicle else None
    return bool(mission.moors and anchor and anchor.construction is not None and anchor.flooded_mass is None)


def mooring_anchors(mission: Mission, means: Scenario) -> tuple[MooringAnchor, ...]:
    """Return the anchors that are sized by the mission's worst case, and those that their parts cannot make."""
    anchors = []
    for phase in means.drawn.moors:
        weight, is_sized = float(wet_weight_of(means, phase)), phase.anchor_wet_weight == "sized"
        failures = solve_anchor(anchor_problem(means), weight).failures if _makes_anchors(mission) else ()
        if is_sized or failures:
            words = tuple(failure.words for failure in failures)
            anchors.append(MooringAnchor(phase.name, weight, is_sized, words))
    return tuple(anchors)


def held_vehicles(means: Scenario) -> tuple[HeldVehicle, ...]:
    """How the vehicle of each mooring stands on its line."""
    return tuple(held_vehicle(means, phase, float(wet_weight_of(means, phase))) for phase in means.drawn.moors)


def run_notices(merged: "MergedBlocks", goal: "Precision | None") -> tuple[str, ...]:
    """Notices of the run: precision not reached, failed blocks."""
    trials, failures = merged.totals.trials, len(merged.failures)
    notices = []
    if goal is not None and not goal.is_reached(merged.totals):
        notices.append(f"The precision asked for, {goal.text}, was not reached in {counted(trials, 'trial')}.")
    if failures:
        how = "missionplan.studies.simulation.simulate.simulate_block(mission, seed=…, block=…) runs one alone"
        notices.append(f"Blocks of trials that failed and are left out: {failures}; see failed_blocks; {how}.")
    return tuple(notices)
