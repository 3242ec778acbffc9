"""What a mission must hold to be simulated, said before any work is done, and what its reader should know."""

from collections.abc import Sequence

import numpy as np

from missionplan.arrays import Array
from missionplan.effects import CATALOGUE
from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.mission.schema.phases import TransitPhase
from missionplan.mission.schema.transition import TransitionPhase
from missionplan.phases.currents import FieldCurrent, SeriesCurrent
from missionplan.physics.anchor import solve_anchor
from missionplan.physics.vehicle_drag import range_notes
from missionplan.scenario.anchor_weight import anchor_problem
from missionplan.scenario.mooring import wet_weight_of
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.transition import check_transition
from missionplan.studies.simulation.block_statistics import BlockStatistics


def check_complete(mission: Mission) -> None:
    """Refuse a mission that lacks a section which its phases need.

    Raises
    ------
    InputError
        With everything that is missing.
    """
    missing = [] if mission.phases else [("phases", "a mission to simulate has at least one phase")]
    vehicle, site = mission.vehicle, mission.site
    if mission.moors:
        missing += [] if site and site.depth is not None else [("site.depth", "a mooring needs it")]
        missing += [] if site and site.water is not None else [("site.water", "a mooring needs it")]
        missing += [] if vehicle else [("vehicle", "a mooring needs it")]
        missing += [] if not vehicle or vehicle.mass is not None else [("vehicle.mass", "a mooring needs it")]
        missing += [] if not vehicle or vehicle.anchor else [("vehicle.anchor", "a mooring needs it")]
        anchor = vehicle.anchor if vehicle else None
        if anchor and anchor.flooded_mass is None and anchor.construction is None:
            missing.append(("vehicle.anchor.flooded_mass", "a descent needs it where no construction is given"))
    if any(isinstance(phase, TransitionPhase) for phase in mission.phases):
        missing += check_transition(mission)
    turning = any(entry.effect == "inertial-current" for entry in mission.effects)
    if turning and mission.transits and (site is None or site.origin is None):
        missing.append(("site.origin", "inertial-current needs its latitude"))
    if missing:
        raise InputError([Problem(f"missing; {words}", mission.file, key=key) for key, words in missing])


def check_current(mission: Mission, means: Scenario) -> None:
    """Refuse a field of currents that does not reach the mission, in place or in time.

    Raises
    ------
    InputError
        With the positions outside, or the record's time.
    """
    current = means.recorded
    if not isinstance(current, FieldCurrent | SeriesCurrent):
        return
    problems = []
    if current.time[-1] < 0.0 or current.time[0] > 0.0:
        given = f"from {current.time[0]:.0f} s to {current.time[-1]:.0f} s of the mission's start"
        problems.append(
            Problem(f"the record lasts {given}: it does not hold the start", mission.file, key="site.current")
        )
    if isinstance(current, FieldCurrent):
        problems += _places_outside(mission, means, current)
    if problems:
        raise InputError(problems)


def _places_outside(mission: Mission, means: Scenario, field: FieldCurrent) -> list[Problem]:
    problems = []
    for name, place in _places(mission, means):
        for value, axis, way in zip(place, (field.east_axis, field.north_axis), ("east", "north"), strict=True):
            if not axis[0] <= value <= axis[-1]:
                span = f"the field reaches from {axis[0]:.0f} m to {axis[-1]:.0f} m {way} of the origin"
                problems.append(Problem(f"lies at {value:.0f} m; {span}", mission.file, key=name))
    return problems


def _places(mission: Mission, means: Scenario) -> list[tuple[str, Array]]:
    found = []
    for phase in mission.transits:
        ends = {"from": phase.start, "to": phase.to}
        found += [
            (f"{phase.name}.{key}", means.position(place, f"{phase.name}.{key}"))
            for key, place in ends.items()
            if place is not None
        ]
    return found


def notices(mission: Mission, means: Scenario) -> tuple[str, ...]:
    """What the reader should know of the input: cut distributions, models out of their range, what is left out."""
    found = list(mission.notices())
    if mission.vehicle is None:
        found.append("The mission has no vehicle: energy is not reckoned.")
    elif mission.budget is None:
        found.append("The mission has no energy budget: energy is not reckoned.")
    elif mission.transits and (mission.site is None or mission.site.water is None):
        found.append("The mission has no site.water: the energy of propulsion is not reckoned.")
    if mission.vehicle is not None and mission.site is not None and mission.site.water is not None:
        speeds = [float(means[f"{phase.name}.speed"]) for phase in mission.transits]
        found += range_notes(means.vehicle_drag, min(speeds)) if speeds else ()
    found += [words for phase in mission.transits if (words := _drift_notice(means, phase))]
    for entry in mission.effects:
        if not CATALOGUE[entry.effect].changes_plan:
            where = "shows in the tank alone" if CATALOGUE[entry.effect].phase == "tank" else "acts on a reading alone"
            found.append(f"{entry.effect} {where}: it is carried and does not change the plan.")
    return (*found, *_anchor_notices(mission, means))


def _drift_notice(means: Scenario, phase: TransitPhase) -> str:
    """Say where the mean drift at the start is as fast as the vehicle, so that few trials can arrive."""
    drift = np.array([float(means[f"navigation.velocity_error.mean[{axis}]"]) for axis in (0, 1)])
    if means.current is not None:
        depth, place = means[f"{phase.name}.depth"], np.zeros((2, 1))
        drift = drift + means.current.velocity(0.0, depth, place)[:, 0]
    speed, carried = float(means[f"{phase.name}.speed"]), float(np.hypot(*drift))
    if carried < speed:
        return ""
    return f"{phase.name}: the mean drift, {carried:.3g} m/s, is as fast as the vehicle, {speed:.3g} m/s."


def _anchor_notices(mission: Mission, means: Scenario) -> list[str]:
    anchor = mission.vehicle.anchor if mission.vehicle else None
    if not mission.moors or anchor is None or anchor.construction is None or anchor.flooded_mass is not None:
        return []
    found = []
    uncertain = [path for path in mission.uncertain() if path.startswith("vehicle.anchor.construction")]
    if uncertain:
        found.append(f"The anchor is built once, from the means of its parts: {', '.join(uncertain)} not drawn.")
    for phase in mission.moors:
        weight = float(wet_weight_of(means, phase))
        for failure in solve_anchor(anchor_problem(means), weight).failures:
            found.append(
                f"{phase.name}: an anchor of {weight:.3g} N wet cannot be built as described: {failure.words}."
            )
    return found


def failure_notices(failed: Sequence[str]) -> tuple[str, ...]:
    """Say how to run a failed block alone."""
    if not failed:
        return ()
    how = "missionplan.studies.simulation.simulate.simulate_block(mission, seed=…, block=…) runs one alone"
    return (f"{len(failed)} blocks of trials failed and are left out, see failed_blocks; {how}.",)


def late_notices(means: Scenario, totals: BlockStatistics) -> tuple[str, ...]:
    """What the reader should know of the run: missions that outlast the record of the current."""
    current = means.recorded
    if not isinstance(current, FieldCurrent | SeriesCurrent) or len(current.time) < 2:
        return ()
    latest = float(totals.statistics["total.duration_s"].moments.high)
    if latest <= current.time[-1]:
        return ()
    return (
        f"The record of the current ends after {current.time[-1]:.0f} s; the longest mission takes {latest:.0f} s.",
    )
