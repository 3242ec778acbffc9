"""Small transits for the tests: a goal 1 km east, one parameter changed at a time."""

import numpy as np

from missionplan.montecarlo.streams import LegNormals
from missionplan.phases.hooks import TrialState
from missionplan.phases.transit import transit
from missionplan.phases.transit.plan import Environment, TransitNormals, TransitPlan, VelocityError

GOAL = np.array([1000.0, 0.0])


class FixedNormals:
    """Given normals, the same for every leg or one array per leg."""

    def __init__(self, *legs):
        self.legs = [np.array(leg, dtype=float) for leg in legs]

    def leg(self, number):
        return self.legs[min(number, len(self.legs) - 1)]


def plan(**changes):
    given = {
        "goal": GOAL,
        "speed": 1.0,
        "arrival_radius": 10.0,
        "d_max": 1000.0,
        "surfacing_time": 60.0,
        "velocity_error": VelocityError.isotropic(0.0),
    }
    return TransitPlan(**{**given, **changes})


def start(trials=3, at=(0.0, 0.0)):
    return TrialState.at(np.array(at, dtype=float), trials)


def normals(block=0, seed=1, effects=()):
    names = ("velocity", "fix_on_surfacing", "fix_on_diving")
    return TransitNormals(*(LegNormals(seed, f"test.{name}", block) for name in names), effects)


def run(changes=None, state=None, draws=None, tracked=0, **around):
    return transit(
        plan(**(changes or {})),
        state if state is not None else start(),
        draws or normals(),
        Environment(**around),
        tracked=tracked,
    )
