"""What an exploration found, in sentences."""

import math
from collections.abc import Sequence

from missionplan.report.explained import members_in_words
from missionplan.report.numbers import number, percent
from missionplan.report.quantities import range_on, unit_for, value_on, with_error
from missionplan.report.wording import in_words, keys_in_words
from missionplan.results.decision import Aim, Axis
from missionplan.results.simulation import RequirementOutcome
from missionplan.studies.exploration.result import Cell, Exploration, Window

ENERGY, DURATION = "total.energy_wh", "total.duration_s"
_AS_GOOD: dict[Aim, tuple[str, str, str]] = {
    "success": ("succeeds as often", "succeed as often", "Succeeding as often"),
    "energy": ("takes as little energy", "take as little energy", "Taking as little energy"),
    "duration": ("is as fast", "are as fast", "As fast"),
}
"""In what one or several are as good as the best: they may be worse in all else."""
_WORSE: dict[Aim, str] = {"success": "succeeds less often", "energy": "takes more energy", "duration": "takes longer"}
_MOST_RANGES = 4
"""Ranges that a sentence lists."""


def answer(found: Exploration) -> str:
    """Write the best cell, what is as good, and where all requirements are met."""
    best = found.best_cell
    if best is None:
        return f"None of the {tried(found)} can be compared: no trial reaches what is asked for."
    sentences = [
        *_unmet(found, best),
        f"{_best_in_words(found, best)}: {_what_it_gives(found, best)}.",
        members_in_words(found.members, "succeeds"),
        _as_good(found),
        _windows(found),
        _invalid(found),
        _dropped(found),
    ]
    return " ".join(filter(None, sentences))


def name_of(axis: Axis) -> str:
    """Write what is varied: ``speed (ingress, egress)``."""
    return keys_in_words(axis.keys)


def tried(found: Exploration) -> str:
    """Name what was tried: ``starts``; ``choices`` where two keys were varied, or one that has no plural."""
    if len(found.axes) == 1 and found.axes[0].keys in (("start",), ["start"]):
        return "starts"
    return "choices"


def place_in_words(found: Exploration, cell: Cell) -> str:
    """Write a cell's values: ``05:50 UTC and 1.4 m/s``."""
    return " and ".join(value_on(axis, index) for axis, index in zip(found.axes, cell.place, strict=True))


def quantity_with_error(found: Exploration, cell: Cell, key: str) -> str:
    """Write the mean of a cell's quantity with its error."""
    statistic = cell.quantities[key]
    phase, _, name = key.rpartition(".")
    unit = unit_for(phase, name, found.provenance.data, typical=statistic.mean)
    return with_error(statistic.mean, statistic.standard_error, unit)


def quantity_alone(found: Exploration, cell: Cell, key: str) -> str:
    """Write the mean of a cell's quantity with the digits that its error supports."""
    statistic = cell.quantities[key]
    if not math.isfinite(statistic.mean):
        return "–"
    phase, _, name = key.rpartition(".")
    unit = unit_for(phase, name, found.provenance.data, typical=statistic.mean)
    return number(unit(statistic.mean), unit(statistic.standard_error)) + unit.suffix


def _unmet(found: Exploration, best: Cell) -> list[str]:
    if found.constrained or not found.has_requirements:
        return []
    what = " and ".join(name_of(axis) for axis in found.axes)
    missed = [item for item in best.requirements if not item.met]
    return [f"No {what} tried meets all requirements; even the best misses {_requirements(missed)}."]


def _requirements(items: Sequence[RequirementOutcome]) -> str:
    parts = [
        f"the {in_words(item.quantity)} ({percent(item.probability)}, {100.0 * item.required:g}\u00a0% required)"
        for item in items
    ]
    return " and ".join(parts)


def _best_in_words(found: Exploration, best: Cell) -> str:
    what = " and ".join(name_of(axis) for axis in found.axes)
    plural = "are" if len(found.axes) > 1 else "is"
    aim = {"success": "The best", "energy": "For the least energy the best", "duration": "For the least time the best"}
    return f"{aim[found.aim]} {what} {plural} {place_in_words(found, best)}"


def _what_it_gives(found: Exploration, best: Cell) -> str:
    parts = [f"the mission succeeds in {percent(best.success)} of the trials"]
    for key, words in ((ENERGY, "takes"), (DURATION, "lasts")):
        if key in best.quantities and best.quantities[key].count:
            parts.append(f"{words} {quantity_with_error(found, best, key)}")
    return ", ".join(parts[:-1]) + f" and {parts[-1]}" if len(parts) > 1 else parts[0]


def _as_good(found: Exploration) -> str:
    """Write which cells the trials cannot tell from the best."""
    count = sum(cell.as_good for cell in found.cells)
    noise = f"as far as {found.provenance.trials} trials tell"
    if count < 2:
        return f"Every other one tried {_WORSE[found.aim]}, {noise}."
    if len(found.axes) == 1:
        axis = found.axes[0]
        if axis.numbers is None:
            others = [
                axis.labels[cell.place[0]] for cell in found.cells if cell.as_good and cell is not found.best_cell
            ]
            return f"{_AS_GOOD[found.aim][2]}, {noise}: {', '.join(others)}."
        where = ranges_in_words(axis, found.ranges_as_good)
        return f"Any {name_of(axis)} {where} {_AS_GOOD[found.aim][0]}, {noise}."
    return f"{count} of the {len(found.cells)} {tried(found)} {_AS_GOOD[found.aim][1]}, {noise}."


def _windows(found: Exploration) -> str:
    if not found.has_requirements or not found.constrained or any(cell.dropped for cell in found.cells):
        return ""
    met = sum(cell.meets_all for cell in found.cells)
    if len(found.axes) == 1 and found.axes[0].numbers is not None:
        where = ranges_in_words(found.axes[0], found.windows)
    else:
        where = f"with {met} of the {len(found.cells)} {tried(found)}"
    doubt = "" if any(cell.status == "met" for cell in found.cells) else "; it takes more trials to be sure of it"
    return f"All requirements are met {where}{doubt}."


def ranges_in_words(axis: Axis, windows: Sequence[Window]) -> str:
    """Write ``from 05:10 to 06:40 UTC and at 11:00 UTC``."""
    parts = [
        f"at {value_on(axis, window.first)}"
        if window.first == window.last
        else f"from {range_on(axis, window.first, window.last)}"
        for window in windows[:_MOST_RANGES]
    ]
    if len(windows) > _MOST_RANGES:
        parts.append(f"in {len(windows) - _MOST_RANGES} more ranges")
    return ", ".join(parts[:-1]) + f" and {parts[-1]}" if len(parts) > 1 else parts[0]


def _dropped(found: Exploration) -> str:
    count = sum(cell.dropped for cell in found.cells)
    return f"{count} {tried(found)} that cannot be the best were run with fewer trials." if count else ""


def _invalid(found: Exploration) -> str:
    count = len(found.cells) - len(found.valid)
    if not count:
        return ""
    return f"{count} of the {len(found.cells)} {tried(found)} cannot be run; the report says why."
