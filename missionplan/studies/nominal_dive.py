"""What a descent needs before it is asked for: a dive at the means that succeeds; flooding in time."""

from dataclasses import replace

import numpy as np

from missionplan.arrays import Scalars
from missionplan.errors import InputError, Problem
from missionplan.mission.schema.phases import MoorPhase
from missionplan.mission.views import missing_for_moorings
from missionplan.phases.mooring.descent import descend
from missionplan.phases.mooring.forces import Dive
from missionplan.physics.vehicle_drag import terminal_velocity
from missionplan.scenario.mooring import dive_of
from missionplan.scenario.scenario import STILL_WATER, Scenario

FASTEST = 10.0
"""Terminal velocity [m/s] that no streamlined body on a line reaches: torpedo anchors, of tonnes, fall at 15 to 25."""


def check_dives(means: Scenario) -> None:
    """Refuse a mission whose nominal dives are faster than any; one that lacks what a mooring needs is left alone.

    So is an anchor that is `sized`: its weight follows from the radius and the current, and is no slip of a unit.

    Parameters
    ----------
    means : Scenario
        At the means.

    Raises
    ------
    InputError
        With each mooring and its terminal velocity.
    """
    mission = means.mission
    if not mission.moors or missing_for_moorings(mission):
        return
    problems = []
    for phase in means.drawn.moors:
        if isinstance(phase.anchor_wet_weight, str):
            continue
        fastest = sinking_speed(dive_of(means, phase))
        if fastest > FASTEST:
            message = f"{phase.name} goes down at {fastest:.3g} m/s; expected at most {FASTEST:g} m/s"
            key = f"{phase.name}.anchor_wet_weight"
            problems.append(Problem(message, mission.file, key=key, hint="are the units of weight and hull right?"))
    if problems:
        raise InputError(problems)


def sinking_speed(dive: Dive) -> float:
    """Speed at which anchor and vehicle sink together [m/s]; 0 where they do not."""

    def drag(speed: Scalars) -> Scalars:
        return dive.vehicle_drag(speed) + dive.anchor_drag(speed)

    return float(np.max(terminal_velocity(drag, dive.wet_weight - dive.net_buoyancy)))


STATED = 5.0
"""Flooding time of the notice [s]."""


def flooding_notice(means: Scenario, phase: MoorPhase[Scalars], weight: float | None = None) -> str:
    """Notice that the anchor is taken as flooded when it separates; empty where the vehicle file gives a time.

    Parameters
    ----------
    means : Scenario
        At the means.
    phase : MoorPhase
    weight : float, optional
        Wet weight of the anchor, by default the mission's [N].
    """
    if means.mooring.anchor.flooding_time is not None:
        return ""
    dive = dive_of(means, phase, weight)
    at_once, flooding = (_nominal(means, phase, replace(dive, flooding_time=time)) for time in (0.0, STATED))
    if not np.isfinite([*at_once, *flooding]).all():
        return ""
    longer, further = (later - now for later, now in zip(flooding, at_once, strict=True))
    return (
        f"{phase.name}: the anchor is taken as flooded when it separates. {STATED:g} s of flooding "
        f"(anchor.flooding_time) would make the nominal descent {longer:.1f} s longer and change its offset by "
        f"{further:+.1f} m."
    )


def _nominal(means: Scenario, phase: MoorPhase[Scalars], dive: Dive) -> tuple[float, float]:
    """Time [s] and offset [m] of the dive at the means, from the origin at the mission's start; nan where it fails."""
    record = descend(
        dive,
        effects=means.descent_effects,
        release_time=np.full(1, float(phase.release_time)),
        current=means.current or STILL_WATER,
        position=np.zeros((2, 1)),
        t_start=np.zeros(1),
    )
    return float(record.descent_time[0]), float(record.offset_distance[0])
