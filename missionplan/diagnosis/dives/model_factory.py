"""From a mission and dive logs to a model: the mission's first mooring at its means, bound to the dives."""

from collections.abc import Callable

from missionplan.arrays import Array
from missionplan.diagnosis.dives.forward import DescentForward
from missionplan.diagnosis.dives.model import DescentModel
from missionplan.diagnosis.dives.preparation import PreparedDives
from missionplan.diagnosis.given_effects import GivenEffect, check_together, given_priors
from missionplan.effects import effects_of
from missionplan.mission import Mission
from missionplan.mission.views import MooringMission
from missionplan.phases.mooring.forces import Dive
from missionplan.scenario.mooring import dive_of
from missionplan.scenario.scenario import Scenario


def descent_model(data: PreparedDives, mission: Mission) -> DescentModel:
    """Bind a mission's first mooring to dive logs.

    Raises
    ------
    InputError
        When the mission lacks what a descent needs.
    """
    return DescentModel(DescentForward(descent_builder(mission), data.dives), given_on_descent(mission))


def given_on_descent(mission: Mission) -> tuple[GivenEffect, ...]:
    """Return a mission's own effects on a descent, as its dives are diagnosed.

    Raises
    ------
    InputError
        When a diagnosis cannot hold them together.
    """
    given = given_priors(mission, effects_of("descent"))
    check_together(given, mission, "descent")
    return given


def descent_builder(mission: Mission) -> Callable[[Array, Array], Dive]:
    """Return the mission's descent, without effects, as a function of wet weights [N] and line lengths [m].

    Raises
    ------
    InputError
        When the mission lacks what a descent needs.
    """
    moor = MooringMission.of(mission, depth=False).mooring()
    scenario = Scenario.at_means(mission)

    def build(weights: Array, lines: Array) -> Dive:
        own = {f"{moor.name}.anchor_wet_weight": weights, f"{moor.name}.line_length": lines}
        here = Scenario(mission, {**scenario.draws, "site.depth": 0.0, **own})
        return dive_of(here, moor.model_copy(update={"anchor_wet_weight": float(weights[0])}))

    return build
