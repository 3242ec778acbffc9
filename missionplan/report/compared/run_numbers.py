"""Numbers of two runs in words: their names, units and changes."""

from collections.abc import Mapping

from missionplan.mission.checks.requirements import QUANTITIES
from missionplan.report.numbers import NARROW_SPACE, has_spread, number
from missionplan.report.planned.values import value_in_words
from missionplan.report.quantities import Unit, as_written, reader_unit, unit_for, with_error
from missionplan.report.wording import in_words
from missionplan.results.comparison import ComparedNumber, Comparison
from missionplan.results.plain_data import mapping, mappings

_PERCENT = Unit("%", 0.01)
_GROUPS = {"sweep": "", "anchor": "", "odds": "dives"}
"""How sections of `summary.json` are named, where not by their keys."""

_OF_SWEEP = {
    ("curve", "cost"): "mean cost",
    ("best", "cost"): "least mean cost",
    ("best", "d_max_m"): "d_max of least cost",
    ("recommended", "cost"): "mean cost at the recommended d_max",
    ("recommended", "d_max_m"): "recommended d_max",
    ("recommended", "saving_s"): "time saved against one leg at the recommended d_max",
    ("recommended", "required_arrival"): "required probability of arrival",
    ("one_leg", "cost"): "mean cost in one leg",
    ("one_leg", "d_max_m"): "length of one leg",
    ("", "saving_s"): "time saved against one leg",
}
"""Numbers of a sweep, by where they are in `summary.json`."""


def importance(difference: ComparedNumber) -> float:
    """Size of the change against its noise, or, without noise, against the number."""
    change = abs(difference.change or 0.0)
    noise = noise_of(difference)
    if noise:
        return change / noise
    return change / max(abs(difference.first or 0.0), abs(difference.second or 0.0), 1e-300)


def noise_of(difference: ComparedNumber) -> float:
    """Standard error of the change; zero where it is only rounding."""
    error = difference.standard_error or 0.0
    size = max(abs(difference.first or 0.0), abs(difference.second or 0.0))
    return error if has_spread(size, error) else 0.0


def name_of(comparison: Comparison, difference: ComparedNumber) -> str:
    """Name a number."""
    if difference.group == "requirement":
        return f"{_requirement(comparison, difference)} (requirement)"
    if difference.group.startswith("sweep, "):
        return _of_sweep(comparison, difference)
    group = _GROUPS.get(difference.group, difference.group)
    return in_words(f"{group}.{difference.key}".lstrip(".")) if group != difference.key else in_words(difference.key)


def _of_sweep(comparison: Comparison, difference: ComparedNumber) -> str:
    """Name a number of a sweep over maximum leg lengths, whose group is ``sweep, 0.035, curve, 48``."""
    _, sigma, *rest = difference.group.split(", ")
    which, d_max = (*rest, "", "")[:2]
    words = _OF_SWEEP.get((which, difference.key), "") or in_words(difference.key)
    if which == "curve":
        words += f" at d_max = {with_error(float(d_max), 0.0, reader_unit('m', float(d_max)))}"
    spreads = {each.group.split(", ")[1] for each in comparison.differences if each.group.startswith("sweep, ")}
    return f"{words} (σ_v = {as_written(sigma, 'm/s')})" if len(spreads) > 1 else words


def _requirement(comparison: Comparison, difference: ComparedNumber) -> str:
    """Write a requirement with its limit as the mission does, or in SI where that is not certain."""
    quantity, _, limit = difference.key.partition(", ")
    alike = [item for item in requirements_of(_mission(comparison, difference)) if item.get("quantity") == quantity]
    if limit:
        limit = (limit_in_words(alike[0]) if len(alike) == 1 else "") or _in_si(quantity, limit)
    return f"{in_words(quantity)} {limit}".strip()


def _in_si(quantity: str, limit: str) -> str:
    """Write the limit of a requirement, as the comparison's keys have it, with its SI unit."""
    units = {name: unit for kind in QUANTITIES.values() for name, unit in kind.items()}
    unit = units.get(quantity.partition(".")[2], "")
    if not unit:
        return limit
    words, _, value = limit.rpartition(" ")
    return f"{words} {with_error(float(value), 0.0, reader_unit(unit, float(value)))}".strip()


def requirements_of(mission: Mapping[str, object]) -> list[Mapping[str, object]]:
    """Requirements of a mission's document."""
    return mappings(mission.get("requirements"))


def _mission(comparison: Comparison, difference: ComparedNumber) -> Mapping[str, object]:
    """Data of the second run's mission; of the first's where only that has the number."""
    return mapping(comparison.provenance.data["second" if difference.second is not None else "first"])


def limit_in_words(requirement: Mapping[str, object]) -> str:
    """Write the limit of a mission's requirement as its file does: ``at most 75 ft``; empty for an event."""
    for bound in ("at_most", "at_least"):
        if bound in requirement:
            return f"{bound.replace('_', ' ')} {value_in_words(requirement[bound]).replace('*', NARROW_SPACE)}"
    return ""


def _unit(comparison: Comparison, difference: ComparedNumber) -> Unit:
    if difference.kind == "probability" or difference.key == "cost":
        return _PERCENT
    typical = difference.first if difference.first is not None else difference.second
    return unit_for(difference.group, difference.key, _mission(comparison, difference), typical=abs(typical or 0.0))


def shown_change(comparison: Comparison, difference: ComparedNumber) -> str:
    """Write second minus first, with its standard error."""
    change = difference.change
    if change is None:
        return "–"
    words = with_error(change, noise_of(difference), _unit(comparison, difference))
    return words if words.startswith("−") or change == 0.0 else f"+{words}"


def row_of(comparison: Comparison, difference: ComparedNumber) -> tuple[str, str, str, str, str]:
    """Write a number's name, verdict, both values and change."""
    unit, error = _unit(comparison, difference), noise_of(difference)
    first, second = (
        "–" if value is None else number(unit(value), unit(error)) + unit.suffix
        for value in (difference.first, difference.second)
    )
    return name_of(comparison, difference), difference.verdict, first, second, shown_change(comparison, difference)
