"""Whether the nominal dives of a mission are possible at all."""

import numpy as np

from missionplan.arrays import Scalars
from missionplan.errors import InputError, Problem
from missionplan.mission.views import missing_for_moorings
from missionplan.phases.mooring.forces import Dive
from missionplan.physics.vehicle_drag import terminal_velocity
from missionplan.scenario.mooring import dive_of
from missionplan.scenario.scenario import Scenario

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
