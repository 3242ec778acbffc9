"""Differences between two mission files, key by key."""

import math
import re
from collections.abc import Iterator, Mapping, Sequence

from missionplan.mission.quantity_paths import written_phases
from missionplan.mission.units import QuantityError, parse_number_with_unit
from missionplan.results.comparison import ChangedValue
from missionplan.results.task import DifferingValue

_TRAILING_UNIT = re.compile(r"\s*[+-]?[\d.]+(?:[eE][+-]?\d+)?\s*(\S.*?)\s*")


def changed_values(first: object, second: object) -> tuple[ChangedValue, ...]:
    """List the values that differ, by key path with phases by name; ``75 ft`` and ``22.86 m`` are the same."""
    one, two = dict(_leaves(first, "")), dict(_leaves(second, ""))
    return tuple(
        ChangedValue(path, _shown(one.get(path)), _shown(two.get(path)))
        for path in dict.fromkeys((*one, *two))
        if not _same(one.get(path), two.get(path))
    )


def differing_values(missions: Sequence[object]) -> tuple[DifferingValue, ...]:
    """List the values in which any of some missions differs from the first, by key path with phases by name."""
    leaves = [dict(_leaves(mission, "")) for mission in missions]
    return tuple(
        DifferingValue(path, tuple(_shown(each.get(path)) for each in leaves))
        for path in dict.fromkeys(path for each in leaves for path in each)
        if not all(_same(leaves[0].get(path), each.get(path)) for each in leaves[1:])
    )


def _leaves(value: object, path: str) -> Iterator[tuple[str, object]]:
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _leaves(inner, f"{path}.{key}" if path else str(key))
    elif isinstance(value, list) and path == "phases":
        for phase in written_phases({"phases": value}):
            yield from _leaves(phase.section, phase.key)
    elif isinstance(value, list) and path != "learned_from":
        for index, inner in enumerate(value):
            yield from _leaves(inner, f"{path}[{index}]")
    else:
        yield path, value


def _same(first: object, second: object) -> bool:
    if first == second:
        return True
    if not (isinstance(first, str) and isinstance(second, str)):
        return False
    match = _TRAILING_UNIT.fullmatch(second)
    if match is None:
        return False
    try:
        one, two = (parse_number_with_unit(text, match[1]) for text in (first, second))
    except QuantityError:
        return False
    return math.isclose(one, two, rel_tol=1e-12)


def _shown(value: object) -> str:
    if isinstance(value, list):
        return f"{len(value)} legs, dives or runs"
    return "" if value is None else str(value)
