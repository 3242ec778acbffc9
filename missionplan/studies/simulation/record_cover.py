"""Whether a record of the current covers the mission: the nominal one before a run, the trials after it."""

from collections.abc import Iterator
from dataclasses import replace
from datetime import timedelta
from typing import TYPE_CHECKING

import numpy as np

from missionplan.arrays import Array
from missionplan.errors import InputError, MissionplanError, Problem
from missionplan.mission import Mission
from missionplan.mission.schema.phases import LegTableSection
from missionplan.mission.views import missing_for_moorings, missing_for_transitions, missing_for_transits
from missionplan.phases.currents import Current
from missionplan.phases.fields.ensemble import Ensemble
from missionplan.phases.fields.gridded_current import GriddedCurrent
from missionplan.phases.recorded_currents import RecordedCurrent
from missionplan.scenario.scenario import Scenario

if TYPE_CHECKING:
    from missionplan.montecarlo.statistics import Probability
    from missionplan.studies.simulation.phase_trials import PhaseTrials

_TIMES_LOOKED_AT = 500
"""Of a record, for what its steps cost."""
TOLERATED = 0.01
"""Share of the trials that may leave the record."""
REMEDY = "take a longer or wider record, or say site.current.outside: hold (or zero)"


def check_cover(mission: Mission, means: Scenario) -> None:
    """Refuse a record of the current that does not cover the nominal mission in time, depth and place.

    Parameters
    ----------
    mission : Mission
    means : Scenario
        At the means, with the record.

    Raises
    ------
    InputError
        With the positions outside, and what the record lacks.
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


def check_trials(mission: Mission, current: object, left: "Probability | None") -> None:
    """Refuse a run of which more than 1 % of the trials left the record of the current.

    Raises
    ------
    InputError
        With the remedy.
    """
    if not isinstance(current, RecordedCurrent) or not current.is_binding or left is None:
        return
    if left.value > TOLERATED:
        share = f"{100.0 * left.value:.3g} % of the trials leave the record of the current"
        message = f"{share}, which {_extent(mission, current)}; at most {100.0 * TOLERATED:g} % may"
        raise InputError([_problem(mission, message)])


def interpolation_notices(means: Scenario) -> tuple[str, ...]:
    """Notice of what the straight lines between a record's times may cost a leg, where that is more than a metre.

    Between two times h apart a straight line is off by at most h²|u″|/8, of which second differences are the estimate.
    """
    current = means.recorded
    if not isinstance(current, RecordedCurrent) or isinstance(current, Ensemble) or current.time.size < 3:
        return ()
    times = current.time[current.time > -np.ptp(current.time[:2])][:_TIMES_LOOKED_AT]
    found = []
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
            found.append(
                f"{phase.name}: the current has a value every {step:.3g} min, and straight lines between them are off "
                f"by up to {off:.2g} m/s: up to {metres:.2g} m on a leg of {longest:.4g} m."
            )
    return tuple(found)


def cover_in_words(mission: Mission, current: Current | None) -> str:
    """Sentence on what a record of the current covers in time, place and depth; none where there is no record."""
    if not isinstance(current, RecordedCurrent) or not np.isfinite(current.time).all():
        return ""
    words = f" Current: {_lasting(mission, current)}"
    if isinstance(current, Ensemble):
        words += f", {len(current.members)} members"
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

    held = replace(means, recorded=replace(current, outside="hold"))
    try:
        phases = run_block(held, mission.monte_carlo.seed, 0, 1, inputs=False).phases if _is_complete(mission) else ()
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
        message = f"the nominal {_names(outside)} leaves the record, which {_extent(mission, current)}"
    return [_problem(mission, message)]


def _names(phases: "list[PhaseTrials]") -> str:
    return " and ".join(phase.name for phase in phases)


def _is_complete(mission: Mission) -> bool:
    missing = missing_for_transits(mission) if mission.transits else []
    missing += missing_for_moorings(mission) if mission.moors else []
    missing += missing_for_transitions(mission) if mission.transitions else []
    return bool(mission.phases) and not missing


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
    for name, place in _places(means):
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


def _places(means: Scenario) -> Iterator[tuple[str, Array]]:
    for phase in means.drawn.transits:
        for key, place in (("from", phase.start), ("to", phase.to)):
            if place is not None:
                yield f"{phase.name}.{key}", means.position(place)
