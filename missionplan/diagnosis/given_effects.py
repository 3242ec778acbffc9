"""Effects that a mission carries already: part of the base model."""

from missionplan.effects import CATALOGUE, Effect
from missionplan.mission import Mission
from missionplan.montecarlo.distributions import mean_of


def given_effects(mission: Mission) -> list[Effect]:
    """Return a mission's effects at their means, those on readings included."""
    return [
        CATALOGUE[entry.effect].make({name: mean_of(value) for name, value in entry.parameters.items()})
        for entry in mission.effects
    ]
