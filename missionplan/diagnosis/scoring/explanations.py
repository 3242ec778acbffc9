"""A mission under each of its explanations, and without its effects."""

from itertools import product

from missionplan.mission import Mission
from missionplan.mission.schema.effect_list import EffectList


def explained(mission: Mission) -> list[tuple[float, Mission]]:
    """Return the mission under each combination of its explanations, with the probability that it holds."""
    doubts = [doubt for doubt in mission.doubts if doubt.known is None]
    found = []
    for numbers in product(*(range(len(doubt.probabilities)) for doubt in doubts)):
        share, known = 1.0, mission
        for doubt, number in zip(doubts, numbers, strict=True):
            share, known = share * doubt.probabilities[number], known.knowing(doubt.place, number)
        if share > 0.0:
            found.append((share, known))
    return found


def bare_mission(mission: Mission) -> Mission:
    """Return the mission without its effects."""
    kept = tuple(each for each in mission.correlations if not any(path.startswith("effects") for path in each.between))
    return mission.model_copy(update={"effect_list": EffectList(), "correlations": kept})
