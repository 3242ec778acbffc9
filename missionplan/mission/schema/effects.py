"""The `effects:` section: effects of the catalogue with their parameters in SI."""

from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

from pydantic_core import PydanticCustomError

from missionplan.effects import CATALOGUE
from missionplan.mission.schema.section import complain
from missionplan.mission.units import QuantityParser
from missionplan.montecarlo.distributions import Quantity


@dataclass(frozen=True)
class EffectEntry:
    """One effect of the mission: its id in the catalogue and its parameters, floats or distributions [SI]."""

    effect: str
    parameters: dict[str, Quantity]


def read_effects(value: Any) -> tuple[EffectEntry, ...]:
    """Read the list; for pydantic.

    Raises
    ------
    PydanticCustomError
        With one entry of ``ctx['problems']`` for each key that is wrong.
    """
    if not isinstance(value, list | tuple):
        raise complain("expected a list of effects, each as `effect-id: {parameter: quantity}`")
    problems: list[tuple[tuple[str | int, ...], str]] = []
    entries = [_read_entry(item, index, problems) for index, item in enumerate(value)]
    if problems:
        raise PydanticCustomError("effects", "{words}", {"words": problems[0][1], "problems": problems})
    return tuple(entry for entry in entries if entry is not None)


def _read_entry(item: Any, index: int, problems: list[tuple[tuple[str | int, ...], str]]) -> EffectEntry | None:
    if isinstance(item, EffectEntry):
        return item
    if not isinstance(item, dict) or len(item) != 1 or not isinstance(next(iter(item.values())), dict):
        problems.append(((index,), "expected one effect in each item, as `effect-id: {parameter: quantity}`"))
        return None
    effect, given = next(iter(item.items()))
    if effect not in CATALOGUE:
        problems.append(((index, effect), f"no effect of that name{_did_you_mean(effect, list(CATALOGUE))}"))
        return None
    known = CATALOGUE[effect].parameters
    parameters: dict[str, Quantity] = {}
    for name, text in given.items():
        if name not in known:
            words = f"{effect} has no such parameter; it has {', '.join(known)}{_did_you_mean(name, list(known))}"
            problems.append(((index, effect, name), words))
            continue
        try:
            parameters[name] = QuantityParser(known[name].unit, low=known[name].low, high=known[name].high)(text)
        except PydanticCustomError as error:
            for below, words in (error.context or {})["problems"]:
                problems.append(((index, effect, name, *below), words))
    return EffectEntry(effect, parameters)


def _did_you_mean(name: str, known: list[str]) -> str:
    close = get_close_matches(name, known, n=1)
    return f"; did you mean {close[0]}?" if close else ""
