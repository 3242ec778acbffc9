"""Values of a mission file in words: quantities with their units, distributions as ± and ranges."""

import re
from collections.abc import Mapping

from missionplan.report.quantities import DIMENSIONS, as_written, reader_system
from missionplan.report.wording import in_words

_QUANTITY = re.compile(r"\s*([+-]?[\d.]+(?:[eE][+-]?\d+)?)\s*(\D.*?)?\s*")
_MOST_CHOICES = 6


def value_in_words(value: object) -> str:
    """Write a value of a mission file: ``10 ± 3 s, at least 0 s``."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, Mapping):
        return _distribution(value) or "; ".join(
            f"{in_words(str(key))} {value_in_words(inner)}" for key, inner in value.items()
        )
    if isinstance(value, list | tuple):
        return f"({', '.join(map(value_in_words, value))})"
    return _degrees(str(value))


def _degrees(text: str) -> str:
    text = re.sub(r"(?<=\d)\.0+(?= |$)", "", text)
    found = _QUANTITY.fullmatch(text)
    if found and found[2] in DIMENSIONS and reader_system():
        return as_written(found[1], found[2])
    return re.sub(r"(?<=\d)\s*deg\b", "°", text)


def _distribution(value: Mapping[str, object]) -> str:
    """Write a distribution; empty for any other mapping."""
    keys = set(value)
    words = {str(key): value_in_words(inner) for key, inner in value.items()}
    if {"mean", "sd"} <= keys <= {"mean", "sd", "low", "high"}:
        bounds = [f", at least {words['low']}"] if "low" in keys else []
        bounds += [f", at most {words['high']}"] if "high" in keys else []
        return _joined(words["mean"], "±", words["sd"]) + "".join(bounds)
    if keys == {"low", "high"}:
        return _joined(words["low"], "to", words["high"])
    if keys == {"median", "factor"}:
        return f"{words['median']}, × or ÷ {words['factor']}"
    choices = value.get("choices")
    if keys == {"choices"} and isinstance(choices, list | tuple):
        listed = [value_in_words(choice) for choice in choices]
        if len(listed) > _MOST_CHOICES:
            return f"one of {len(listed)} values, from {listed[0]} to {listed[-1]}"
        return " or ".join(listed)
    return ""


def _joined(first: str, sign: str, second: str) -> str:
    """Join two quantities; a unit that both have is written once."""
    one, two = _QUANTITY.fullmatch(first), _QUANTITY.fullmatch(second)
    if one is None or two is None or one[2] != two[2]:
        return f"{first} {sign} {second}"
    number, other, unit = one[1], two[1], one[2] or ""
    decimals, wanted = (len(each.partition(".")[2]) for each in (number, other))
    if sign == "±" and decimals > wanted:  # no error bears more digits than it has itself
        return f"{first}, sd {second}"
    if sign == "±" and decimals < wanted and "e" not in number.lower():
        number = f"{float(number):.{wanted}f}"
    return f"{number} {sign} {other}{'' if unit in ('°', '') else ' '}{unit}"
