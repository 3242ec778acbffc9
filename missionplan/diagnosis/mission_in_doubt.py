"""One mission of several hypotheses: what they have in common as plain effects, the rest as explanations."""

import copy
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from missionplan.mission.schema.effect_list import ONE_OF
from missionplan.results.learned.evidence import Causes

DIGITS = 4
"""Of a probability in a mission file."""
ALIKE = 2e-3
"""Relative difference of numbers of one effect that fits from different starts leave."""
ROOT = "effects."


@dataclass(frozen=True)
class Hypothesis:
    """What may hold after a diagnosis.

    Attributes
    ----------
    causes : tuple of str
        Effects of the mission's explanation, and those found beyond it.
    probability : float
    extended : mapping
        Data of the mission under it.
    """

    causes: Causes
    probability: float
    extended: Mapping[str, object]


def mission_in_doubt(found: Sequence[Hypothesis]) -> dict[str, object]:
    """Write hypotheses into one mission: what they have in common as plain effects, the rest as explanations.

    Everything but the effects is that of the likeliest. A hypothesis without effects of its own is what the
    probabilities leave to 1. Hypotheses that differ in the vehicle's own keys, as tank data change them, cannot be
    written together: the likeliest is written alone.
    """
    mission = copy.deepcopy(dict(found[0].extended))
    lists = [items(each.extended, "effects") for each in found]
    common = [entry for entry in lists[0] if all(_is_in(entry, other) for other in lists[1:])]
    own = [[entry for entry in entries if not _is_in(entry, common)] for entries in lists]
    differ = any(each.extended.get("vehicle") != mission.get("vehicle") for each in found)
    if len(found) == 1 or differ or not any(own):
        return mission
    kept = _outside(items(mission, "correlations"), own)
    mission.pop("correlations", None)
    return (
        mission | {"effects": [*common, {ONE_OF: _explanations(found, own)}]} | ({"correlations": kept} if kept else {})
    )


def _is_in(entry: object, entries: Sequence[object]) -> bool:
    return any(_alike(entry, other) for other in entries)


def _alike(first: object, second: object) -> bool:
    """Whether effects are the same but for what fits from different starts leave."""
    if isinstance(first, Mapping) and isinstance(second, Mapping):
        return first.keys() == second.keys() and all(_alike(first[key], second[key]) for key in first)
    (number, *unit), (other, *other_unit) = str(first).split() or [""], str(second).split() or [""]
    try:
        return unit == other_unit and math.isclose(float(number), float(other), rel_tol=ALIKE)
    except ValueError:
        return first == second


def _explanations(found: Sequence[Hypothesis], own: Sequence[Sequence[Any]]) -> list[dict[str, object]]:
    """Explanations of the hypotheses that have effects of their own."""
    probabilities = _rounded([each.probability for each in found])
    return [
        _explanation(probability, entries, items(each.extended, "correlations"))
        for each, entries, probability in zip(found, own, probabilities, strict=True)
        if entries and probability > 0.0
    ]


def _outside(correlations: Sequence[Any], own: Sequence[Sequence[Any]]) -> list[Any]:
    """Correlations of no parameter of an explanation."""
    inside = tuple(f"{ROOT}{name}." for entries in own for entry in entries for name in entry)
    return [pair for pair in correlations if not any(name.startswith(inside) for name in pair["between"])]


def _rounded(probabilities: Sequence[float]) -> list[float]:
    """Probabilities to four digits, which still sum to 1: the likeliest takes what rounding leaves."""
    rounded = [round(probability, DIGITS) for probability in probabilities]
    return [round(1.0 - sum(rounded[1:]), DIGITS), *rounded[1:]]


def _explanation(probability: float, entries: Sequence[Any], correlations: Sequence[Any]) -> dict[str, object]:
    names = {f"{ROOT}{name}" for entry in entries for name in entry}
    inside = [
        renamed(pair, ROOT, "")
        for pair in correlations
        if all(name.rpartition(".")[0] in names for name in pair["between"])
    ]
    written: dict[str, object] = {"probability": probability, "effects": list(entries)}
    return written | ({"correlations": inside} if inside else {})


def items(data: Mapping[str, object], key: str) -> list[Any]:
    """Items of a list of a mission that has been read: mappings of known keys."""
    given = data.get(key)
    return list(given) if isinstance(given, list) else []


def renamed(pair: Mapping[str, Any], old: str, new: str) -> dict[str, object]:
    """A correlation with the beginning of its names changed."""
    return {"between": [f"{new}{name.removeprefix(old)}" for name in pair["between"]], "rho": pair["rho"]}
