"""The `effects:` section: effects of the catalogue with their parameters in SI, and explanations of which one holds."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TypeVar

from missionplan.effects import CATALOGUE
from missionplan.errors import KeyPath, LocalProblem, did_you_mean, key_path, shown
from missionplan.mission.schema.effect_list import ONE_OF, EffectEntry, EffectList, Explanation, OneOf
from missionplan.mission.schema.quantity_parser import QuantityParser
from missionplan.mission.schema.section import all_invalid, invalid
from missionplan.mission.units import QuantityError
from missionplan.moments import moment_of
from missionplan.montecarlo.distributions import ROUNDING, Quantity, mean_of
from missionplan.montecarlo.draws import Correlation, correlation_problems

_T = TypeVar("_T")

EPOCH = "epoch"
"""Key of the date from which the phases of an effect count."""
_EXPLANATION = ("probability", "effects", "correlations")
_EACH = "each as `effect-id: {parameter: quantity}`"
_PROBABILITY = QuantityParser("", low=0.0, high=1.0, open_low=True, fixed=True)
_PAIR = "{between: [effect.parameter, effect.parameter], rho}"
_RHO = QuantityParser("", low=-1.0, high=1.0, fixed=True)


def read_effects(value: object) -> EffectList:
    """Read the list as a pydantic validator does.

    Raises
    ------
    PydanticCustomError
        With one `LocalProblem` in ``ctx['problems']`` for each key that is wrong.
    """
    if isinstance(value, EffectList):
        return value
    if not isinstance(value, list | tuple):
        raise invalid(f"expected a list of effects, {_EACH}")
    items: list[EffectEntry | OneOf] = []
    problems: list[LocalProblem] = []
    for index, item in enumerate(value):
        try:
            items.append(_item(item, ("effects", index)))
        except QuantityError as error:
            problems += [problem.within((index,)) for problem in error.problems]
    if problems:
        raise all_invalid(problems)
    return EffectList(tuple(items))


def _item(item: object, path: KeyPath) -> EffectEntry | OneOf:
    if isinstance(item, Mapping) and ONE_OF in item:
        if len(item) > 1:
            others = ", ".join(str(key) for key in item if key != ONE_OF)
            raise QuantityError(f"given {others} beside it, expected an item of its own", (ONE_OF,))
        return _one_of(item[ONE_OF], path)
    return replace(_entry(item), path=path)


def _one_of(value: object, path: KeyPath) -> OneOf:
    """Read explanations.

    Raises QuantityError with every key that is wrong.
    """
    if not isinstance(value, list) or not value:
        raise QuantityError("expected a list of explanations, each {probability, effects}", (ONE_OF,))
    place = f"{key_path(path)}.{ONE_OF}"
    found: list[Explanation] = []
    problems: list[LocalProblem] = []
    for number, item in enumerate(value):
        try:
            found.append(_explanation(item, (*path, ONE_OF, number), (place, (number,))))
        except QuantityError as error:
            problems += [problem.within((ONE_OF, number)) for problem in error.problems]
    total = sum(each.probability for each in found)
    if not problems and total > 1.0 + ROUNDING:
        problems.append(LocalProblem((ONE_OF,), f"the probabilities sum to {total:.6g}, expected at most 1"))
    if problems:
        raise QuantityError(problems)
    return OneOf(place, tuple(found))


def _explanation(item: object, path: KeyPath, explanation: tuple[str, tuple[int, ...]]) -> Explanation:
    if not isinstance(item, Mapping):
        raise QuantityError(f"given {shown(item)}, expected an explanation: {{probability, effects}}")
    problems = [
        LocalProblem((str(key),), "unknown key", did_you_mean(str(key), _EXPLANATION))
        for key in item
        if key not in _EXPLANATION
    ]
    problems += [LocalProblem((key,), "missing") for key in _EXPLANATION[:2] if key not in item]
    probability = _read(problems, item, "probability", lambda given: _fixed(_PROBABILITY, given)) or 0.0
    entries = _read(problems, item, "effects", lambda given: _held(given, (*path, "effects"), explanation)) or ()
    names = {f"{entry.effect}.{name}": value for entry in entries for name, value in entry.parameters.items()}
    correlations: tuple[Correlation, ...] = ()
    if entries:
        correlations = _read(problems, item, "correlations", lambda given: _correlations(given, names)) or ()
    if problems:
        raise QuantityError(problems)
    return Explanation(probability, entries, correlations)


def _read(
    problems: list[LocalProblem], item: Mapping[object, object], key: str, read: Callable[[object], _T]
) -> _T | None:
    """Read a key of a mapping; None where it has none, or a wrong one, whose problems are added."""
    if key not in item:
        return None
    try:
        return read(item[key])
    except QuantityError as error:
        problems += [problem.within((key,)) for problem in error.problems]
        return None


def _fixed(parser: QuantityParser, given: object) -> float:
    return mean_of(parser.parse(given))


def _held(value: object, path: KeyPath, explanation: tuple[str, tuple[int, ...]]) -> tuple[EffectEntry, ...]:
    """Read the effects of an explanation."""
    if not isinstance(value, list) or not value:
        raise QuantityError(f"expected a list of effects, {_EACH}")
    found: list[EffectEntry] = []
    problems: list[LocalProblem] = []
    for index, item in enumerate(value):
        try:
            if isinstance(item, Mapping) and ONE_OF in item:
                raise QuantityError("an explanation cannot hold explanations; write each combination", (ONE_OF,))
            entry = _entry(item)
            if entry.effect in [other.effect for other in found]:
                raise QuantityError("this explanation has the effect already", (entry.effect,))
            found.append(replace(entry, path=(*path, index), explanation=explanation))
        except QuantityError as error:
            problems += [problem.within((index,)) for problem in error.problems]
    if problems:
        raise QuantityError(problems)
    return tuple(found)


def _correlations(value: object, parameters: Mapping[str, Quantity]) -> tuple[Correlation, ...]:
    """Read the correlations of an explanation's parameters."""
    if not isinstance(value, list):
        raise QuantityError(f"given {shown(value)}, expected a list of {_PAIR}")
    found: list[Correlation] = []
    problems: list[LocalProblem] = []
    for index, item in enumerate(value):
        try:
            found.append(_correlation(item))
        except QuantityError as error:
            problems += [problem.within((index,)) for problem in error.problems]
    problems = problems or correlation_problems(parameters, found)
    if problems:
        raise QuantityError(problems)
    return tuple(found)


def _correlation(item: object) -> Correlation:
    if not isinstance(item, Mapping) or set(item) != {"between", "rho"}:
        raise QuantityError(f"given {shown(item)}, expected {_PAIR}")
    between = item["between"]
    if not isinstance(between, list) or len(between) != 2 or not all(isinstance(name, str) for name in between):
        raise QuantityError(f"given {shown(between)}, expected two of the explanation's parameters", ("between",))
    try:
        return Correlation((between[0], between[1]), _fixed(_RHO, item["rho"]))
    except QuantityError as error:
        raise QuantityError([problem.within(("rho",)) for problem in error.problems]) from None


def _entry(item: object) -> EffectEntry:
    """Read one effect.

    Raises QuantityError with every key that is wrong.
    """
    if not isinstance(item, Mapping) or len(item) != 1 or not isinstance(next(iter(item.values())), Mapping):
        raise QuantityError("expected one effect in each item, as `effect-id: {parameter: quantity}`")
    ((effect, given),) = item.items()
    if effect not in CATALOGUE:
        hint = did_you_mean(str(effect), [*CATALOGUE, ONE_OF], before="; ")
        raise QuantityError(f"no effect of that name{hint}", (effect,))
    parameters: dict[str, Quantity] = {}
    problems: list[LocalProblem] = []
    epoch = None
    for name, text in given.items():
        if name == EPOCH and CATALOGUE[effect].frequency_of is not None:
            try:
                epoch = moment_of(text).timestamp()
            except (ValueError, OverflowError, TypeError):
                words = f"given {shown(text)}, expected a date such as 2026-06-01T04:00Z"
                problems.append(LocalProblem((effect, name), words))
            continue
        try:
            parameters[name] = _parameter(effect, name, text)
        except QuantityError as error:
            problems += [problem.within((effect, name)) for problem in error.problems]
    if problems:
        raise QuantityError(problems)
    return EffectEntry(effect, parameters, epoch=epoch)


def _parameter(effect: str, name: str, text: object) -> Quantity:
    known = CATALOGUE[effect].parameters
    if name not in known:
        hint = did_you_mean(str(name), known, before="; ")
        raise QuantityError(f"{effect} has no such parameter; it has {', '.join(known)}{hint}")
    return QuantityParser(known[name].unit, low=known[name].low, high=known[name].high).parse(text)
