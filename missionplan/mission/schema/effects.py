"""The `effects:` section: effects of the catalogue with their parameters in SI."""

from collections.abc import Mapping
from dataclasses import dataclass

from missionplan.effects import CATALOGUE
from missionplan.errors import LocalProblem, did_you_mean
from missionplan.mission.schema.quantity_parser import QuantityParser
from missionplan.mission.schema.section import all_invalid, invalid
from missionplan.mission.units import QuantityError
from missionplan.montecarlo.distributions import Quantity


@dataclass(frozen=True)
class EffectEntry:
    """One effect of the mission: its id in the catalogue and its parameters, floats or distributions [SI]."""

    effect: str
    parameters: dict[str, Quantity]


def read_effects(value: object) -> tuple[EffectEntry, ...]:
    """Read the list as a pydantic validator does.

    Raises
    ------
    PydanticCustomError
        With one `LocalProblem` in ``ctx['problems']`` for each key that is wrong.
    """
    if not isinstance(value, list | tuple):
        raise invalid("expected a list of effects, each as `effect-id: {parameter: quantity}`")
    entries: list[EffectEntry] = []
    problems: list[LocalProblem] = []
    for index, item in enumerate(value):
        try:
            entries.append(item if isinstance(item, EffectEntry) else _entry(item))
        except QuantityError as error:
            problems += [problem.within((index,)) for problem in error.problems]
    if problems:
        raise all_invalid(problems)
    return tuple(entries)


def _entry(item: object) -> EffectEntry:
    """Read one item of the list.

    Raises
    ------
    QuantityError
        With every key that is wrong.
    """
    if not isinstance(item, Mapping) or len(item) != 1 or not isinstance(next(iter(item.values())), Mapping):
        raise QuantityError("expected one effect in each item, as `effect-id: {parameter: quantity}`")
    ((effect, given),) = item.items()
    if effect not in CATALOGUE:
        hint = did_you_mean(str(effect), CATALOGUE, before="; ")
        raise QuantityError(f"no effect of that name{hint}", (effect,))
    parameters: dict[str, Quantity] = {}
    problems: list[LocalProblem] = []
    for name, text in given.items():
        try:
            parameters[name] = _parameter(effect, name, text)
        except QuantityError as error:
            problems += [problem.within((effect, name)) for problem in error.problems]
    if problems:
        raise QuantityError(problems)
    return EffectEntry(effect, parameters)


def _parameter(effect: str, name: str, text: object) -> Quantity:
    known = CATALOGUE[effect].parameters
    if name not in known:
        hint = did_you_mean(str(name), known, before="; ")
        raise QuantityError(f"{effect} has no such parameter; it has {', '.join(known)}{hint}")
    return QuantityParser(known[name].unit, low=known[name].low, high=known[name].high).parse(text)
