"""What differs between missions; numbers of two summaries, and the chance that noise alone makes them differ."""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Literal, NamedTuple, TypeGuard

import numpy as np
from scipy.special import ndtr

from missionplan.mission.quantity_paths import written_phases
from missionplan.mission.units import QuantityError, parse_number_with_unit
from missionplan.results.entries import mapping, real
from missionplan.studies.comparison.result import ChangedValue, DifferingValue

_TRAILING_UNIT = re.compile(r"\s*[+-]?[\d.]+(?:[eE][+-]?\d+)?\s*(\S.*?)\s*")


def changed_values(first: object, second: object) -> tuple[ChangedValue, ...]:
    """List the values that differ, by key path with phases by name; ``75 ft`` and ``22.86 m`` are the same."""
    one, two = dict(_leaves(first, "")), dict(_leaves(second, ""))
    return tuple(
        ChangedValue(path, _value_shown(one.get(path)), _value_shown(two.get(path)))
        for path in dict.fromkeys((*one, *two))
        if not _same(one.get(path), two.get(path))
    )


def differing_values(missions: Sequence[object]) -> tuple[DifferingValue, ...]:
    """List the values in which any of some missions differs from the first, by key path with phases by name."""
    leaves = [dict(_leaves(mission, "")) for mission in missions]
    return tuple(
        DifferingValue(path, tuple(_value_shown(each.get(path)) for each in leaves))
        for path in dict.fromkeys(path for each in leaves for path in each)
        if not all(_same(leaves[0].get(path), each.get(path)) for each in leaves[1:])
    )


def _leaves(value: object, path: str) -> Iterator[tuple[str, object]]:
    if isinstance(value, Mapping) and path == "posterior":
        yield path, str(value.get("sha256", ""))[:12]
        for effect, known in mapping(value.get("summary")).items():
            yield f"{path}.{effect}", mapping(known).get("probability")
    elif isinstance(value, Mapping):
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


def _value_shown(value: object) -> str:
    if isinstance(value, list):
        return f"{len(value)} legs, dives or runs"
    return "" if value is None else str(value)


SECTIONS = {
    "simulate": ("phases", "total", "requirements"),
    "sweep-dmax": ("sweep",),
    "size-anchor": ("anchor", "descent", "odds", "probable"),
}
"""Sections that are compared, by the command that made the reports."""
_IDENTIFYING = ("name", "sigma_m_s", "d_max_m", "quantity")
"""Keys that identify the items of a list."""
_NOT_RESULTS = ("required", "at_most", "at_least", "met", "undecided", "trials_to_decide")
_NOISY = {"sweep-dmax": ("sweep",), "size-anchor": ("probable",)}
"""Sections whose plain numbers result from a search over noisy values."""
_MAX_DEPTH = 20


class SummaryNumber(NamedTuple):
    """A number of a summary."""

    kind: Literal["mean", "probability", "number"]
    value: float
    error: float
    """Standard error; nan where it is not known, or follows from the number of trials (a probability's)."""


KeyPath = tuple[str, ...]


def summary_numbers(summary: Mapping[str, object], command: str) -> dict[tuple[str, str], SummaryNumber]:
    """Numbers of a summary by group and key, such as ``moor`` and ``offset_m``."""
    found = {}
    for section in SECTIONS[command]:
        error = math.nan if section in _NOISY.get(command, ()) else 0.0
        value = summary.get(section)
        for path, number in _walk(value, (section,), error) if isinstance(value, Mapping | list) else ():
            found[_group_and_key(path)] = number
    return found


def _walk(value: object, path: KeyPath, error: float) -> Iterator[tuple[KeyPath, SummaryNumber]]:
    if len(path) > _MAX_DEPTH:
        return
    if isinstance(value, Mapping):
        yield from _walk_mapping(value, path, error)
    elif isinstance(value, list):
        for item in value:
            if isinstance(item, Mapping):
                name = ", ".join(_shown(item[key]) for key in (*_IDENTIFYING, "at_most", "at_least") if key in item)
                named = {key: inner for key, inner in item.items() if key not in _IDENTIFYING}
                yield from _walk(named, (*path, name), error)
    elif _is_number(value):
        yield path, SummaryNumber("number", float(value), error)


def _walk_mapping(value: Mapping[str, object], path: KeyPath, error: float) -> Iterator[tuple[KeyPath, SummaryNumber]]:
    """Read a mapping that may be a statistic, a probability or a point of a sweep."""
    is_cost = "mean" not in value
    estimate, standard_error = value.get("cost" if is_cost else "mean"), value.get("standard_error")
    if _is_number(estimate) and _is_number(standard_error):
        yield (*path, "cost") if is_cost else path, SummaryNumber("mean", float(estimate), float(standard_error))
        if is_cost and _is_number(d_max := value.get("d_max_m")):
            yield (*path, "d_max_m"), SummaryNumber("number", float(d_max), error)
    elif set(value) == {"value", "low", "high"}:
        if _is_number(probability := value["value"]):
            yield path, SummaryNumber("probability", float(probability), math.nan)
    else:
        for key, inner in value.items():
            if key not in _NOT_RESULTS:
                yield from _walk(inner, (*path, str(key)), error)


def _is_number(value: object) -> TypeGuard[float]:
    return not isinstance(value, bool) and math.isfinite(real(value))


def _shown(value: object) -> str:
    return f"{value:.6g}" if _is_number(value) else str(value)


def _group_and_key(path: KeyPath) -> tuple[str, str]:
    """The parts of the path that a reader needs."""
    if path[0] == "requirements":
        return "requirement", path[1]
    kept = [part for part in path if part not in ("phases", "quantities", "events")] or list(path)
    return ", ".join(kept[:-1]) or kept[-1], kept[-1]


def standard_error_and_p_value(
    first: SummaryNumber, second: SummaryNumber, trials: tuple[int, int]
) -> tuple[float | None, float | None]:
    """Standard error of the difference of two independent estimates, and its two-sided p-value from a z test.

    None where the standard errors are not known. Without noise, the p-value is 1 where the numbers are equal, else 0.
    """
    change = second.value - first.value
    if first.kind == "probability":
        error, pooled = _two_proportions(first.value, second.value, *trials)
    else:
        error = pooled = math.hypot(first.error, second.error)
    if not math.isfinite(error):
        return None, None
    if pooled == 0.0:
        return 0.0, 1.0 if math.isclose(first.value, second.value, rel_tol=1e-9, abs_tol=1e-12) else 0.0
    return error, float(2.0 * ndtr(-abs(change) / pooled))


def _two_proportions(first: float, second: float, n: int, m: int) -> tuple[float, float]:
    """Standard error of the difference of two proportions, and the pooled one of the test that they are equal.

    Fleiss, Levin & Paik 2003, Statistical Methods for Rates and Proportions, ch. 3.
    """
    if n < 1 or m < 1:
        return math.nan, math.nan
    share = (n * first + m * second) / (n + m)
    own = math.sqrt(first * (1.0 - first) / n + second * (1.0 - second) / m)
    return own, math.sqrt(max(share * (1.0 - share), 0.0) * (1.0 / n + 1.0 / m))


def holm(p_values: Sequence[float]) -> list[float]:
    """Adjust p-values so that the chance of any false finding stays at the level.

    Step-down procedure of Holm 1979, A simple sequentially rejective multiple test procedure, Scand. J. Statist. 6,
    65–70.
    """
    order = np.argsort(p_values)
    factors = np.arange(len(p_values), 0, -1)
    adjusted = np.empty(len(p_values))
    adjusted[order] = np.minimum(np.maximum.accumulate(factors * np.asarray(p_values, dtype=float)[order]), 1.0)
    return [float(value) for value in adjusted]
