"""What alternatives are, reach and chose, side by side: tasks, requirements, values, windows, cells that all tried."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.mission.units import QuantityError, parse_number_with_unit
from missionplan.moments import moment_or_none
from missionplan.report.axes import mark_times
from missionplan.report.page import Figure, PageSection, Table, to_figure
from missionplan.report.planned import value_in_words
from missionplan.report.wording import (
    NARROW_SPACE,
    capitalised,
    in_words,
    keys_in_words,
    listed,
    number,
    percent,
    phase_in_words,
    share,
)
from missionplan.results.entries import mapping, mappings
from missionplan.results.simulation import RequirementOutcome
from missionplan.studies.comparison.differing_values import PartOfTask
from missionplan.studies.comparison.result import Alternative, Alternatives

_WORDS = {
    "phases": "their phases",
    "place": "the place",
    "depth": "the depth of the water",
    "requirements": "what is required",
    **{"from": "where {} begins", "to": "where {} leads", "hold": "how long {} holds"},
}
_OF_SEVERAL = {"from": "where {} begin", "to": "where {} lead", "hold": "how long {} hold"}


def task_in_words(differs: Mapping[PartOfTask, Sequence[str]]) -> str:
    """Write ``in where ingress leads, in the depth of the water and in what is required``."""
    parts = []
    for part, names in differs.items():
        several = len(names) > 1 and part in _OF_SEVERAL
        parts.append((_OF_SEVERAL if several else _WORDS)[part].format(" and ".join(map(phase_in_words, names))))
    return listed([f"in {words}" for words in parts])


def requirements_of(mission: Mapping[str, object]) -> list[Mapping[str, object]]:
    """Requirements of a mission's document."""
    return mappings(mission.get("requirements"))


def limit_in_words(requirement: Mapping[str, object]) -> str:
    """Write the limit of a mission's requirement as its file does: ``at most 75 ft``; empty for an event."""
    for bound in ("at_most", "at_least"):
        if bound in requirement:
            return f"{bound.replace('_', ' ')} {value_in_words(requirement[bound]).replace('*', NARROW_SPACE)}"
    return ""


_MOST_DIFFERING = 30
_OF_OTHER_COMMANDS = ("optimise.", "sweep.")
"""Sections of a mission on which a comparison does not depend."""


def requirements_section(found: Alternatives) -> Iterator[PageSection]:
    """Show what each alternative reaches of each requirement."""
    told = percent if len(found.alternatives) == 2 else share
    reached = [
        {_asked(item, found.provenance.data.get(each.name)): told(item.probability) for item in each.requirements}
        for each in found.alternatives
    ]
    asked = list(dict.fromkeys(key for each in reached for key in each))
    if asked:
        rows = [[*key, *(each.get(key, "–") for each in reached)] for key in asked]
        columns = ["requirement", "required", *(each.name for each in found.alternatives)]
        yield PageSection("What each reaches of what is required", [Table(columns, rows)])


def _asked(item: RequirementOutcome, mission: object) -> tuple[str, str]:
    """Write what is required and how surely; both may differ from mission to mission."""
    written = requirements_of(mapping(mission))
    alike = [each for each in written if each.get("quantity") == item.quantity and (item.bound or "quantity") in each]
    if len(alike) == 1:
        limit = limit_in_words(alike[0])
    else:
        limit = f"{item.bound.replace('_', ' ')} {number(item.limit or 0.0)}" if item.bound else ""
    return f"{in_words(item.quantity)} {limit}".strip(), f"{number(100.0 * item.required)}\u00a0%"


def differing_section(found: Alternatives) -> Iterator[PageSection]:
    """List the values in which the missions differ, but for what they let other commands try."""
    differing = [each for each in found.differing if not each.path.startswith(_OF_OTHER_COMMANDS)]
    if not differing:
        return
    rows = [  # of a file, its name
        [each.path, *(Path(value).name if Path(value).is_absolute() else value or "–" for value in each.values)]
        for each in differing[:_MOST_DIFFERING]
    ]
    count = len(differing)
    more = f"The first {_MOST_DIFFERING} of {count}." if count > _MOST_DIFFERING else ""
    heading = "1 value of the missions differs" if count == 1 else f"{count} values of the missions differ"
    names = [each.name for each in found.alternatives]
    yield PageSection(heading, [Table(["key", *names], rows, more, text_columns=len(names) + 1)])


_MOST_ROWS = 40
_MOST_WINDOWS = 4
_DAY = 86400.0


def choices_in_words(found: Alternatives) -> str:
    """Write the first sentence: ``The best start is 12:00 UTC in one and 06:00 UTC in two.``."""
    keys = _keys(found)
    what = f"The best {_name(keys[0])} is {{}} in {{}}" if len(keys) == 1 else "Best are {} in {}"
    by_words: dict[str, list[str]] = {}
    for each in found.alternatives:
        if np.isfinite(each.success.value):
            by_words.setdefault(chosen_in_words(found, each), []).append(each.name)
    return " ".join(f"{what.format(words, listed(names))}." for words, names in by_words.items())


def chosen_in_words(found: Alternatives, each: Alternative) -> str:
    """Write what was chosen: ``12:00 UTC``; with the names of the keys where there are several."""
    values = each.chosen.values if each.chosen else {}
    alone = len(_keys(found)) == 1
    parts = [_shown(found, value) if alone else f"{_name(key)} {_shown(found, value)}" for key, value in values.items()]
    return listed(parts) or "–"


def windows_in_words(found: Alternatives, each: Alternative) -> str:
    """Write where all requirements are met: ``05:00 to 06:00 UTC, 12:00 UTC``, or in how many of the cells."""
    if each.chosen is None or not each.requirements:
        return "–"
    parts = [
        _shown(found, first)
        if first == last
        else f"{_shown(found, first).removesuffix(' UTC')} to {_shown(found, last)}"
        for first, last in each.chosen.windows
    ]
    if not parts:
        met = sum(cell.meets_all for cell in each.chosen.cells)
        return f"{met} of {each.chosen.count}" if met else "nowhere"
    more = [f"{len(parts) - _MOST_WINDOWS} more"] if len(parts) > _MOST_WINDOWS else []
    return ", ".join([*parts[:_MOST_WINDOWS], *more])


def curves_figure(found: Alternatives) -> Figure | None:
    """Draw P(success) against the only key, a line for each report; None where its values are no numbers."""
    keys = _keys(found)
    cells = [each.chosen.cells if each.chosen else () for each in found.alternatives]
    if len(keys) != 1 or not all(cells):
        return None
    scale = _scale([cell.values[0] for each in cells for cell in each])
    if scale is None:
        return None
    places, unit = scale
    figure = MatplotlibFigure(figsize=(6.0, 3.2))
    axes = figure.subplots()
    for row, (each, own) in enumerate(zip(found.alternatives, cells, strict=True)):
        x = np.array([places[cell.values[0]] for cell in own])
        low, middle, high = (
            100.0 * np.array([getattr(cell.success, part) for cell in own]) for part in ("low", "value", "high")
        )
        colour = f"C{row % 7}"
        axes.fill_between(x, low, high, color=colour, alpha=0.15, linewidth=0.0)
        axes.plot(x, middle, ".-", color=colour, markersize=4, linewidth=1.2, label=each.name)
    axes.set(
        ylabel="P(success) (%)", ylim=(-4.0, 104.0), xlabel=f"{capitalised(_name(keys[0]))}{unit and f' ({unit})'}"
    )
    if unit == "UTC":
        mark_times(axes.xaxis, one_day=_one_day(found))
    figure.legend(loc="outside upper center", ncols=3)
    return to_figure(
        figure,
        "cells",
        f"Probability of success against {_name(keys[0])} in {len(found.alternatives)} explorations",
        "Bands: 95 % intervals. Gaps: the mission cannot be run.",
    )


def cells_section(found: Alternatives) -> Iterator[PageSection]:
    """Show P(success) of the cells that all explorations have tried."""
    tried = [{cell.values: cell for cell in (each.chosen.cells if each.chosen else ())} for each in found.alternatives]
    common = [values for values in tried[0] if all(values in each for each in tried)]
    if not common:
        return
    rows = [
        [
            *(_shown(found, value) for value in values),
            *(f"{share(each[values].success)}{' ✓' if each[values].meets_all else ''}" for each in tried),
        ]
        for values in common[:_MOST_ROWS]
    ]
    columns = [*map(_name, _keys(found)), *(each.name for each in found.alternatives)]
    caption = "P(success); a tick where all requirements are met."
    if len(common) > _MOST_ROWS:
        caption += f" The first {_MOST_ROWS} of {len(common)}; each report has all of its own in explore.csv."
    heading = f"P(success) of the {len(common)} that {'both' if len(tried) == 2 else 'all'} have tried"
    yield PageSection(heading, [Table(columns, rows, caption, text_columns=len(_keys(found)))])


def _keys(found: Alternatives) -> list[str]:
    return list(dict.fromkeys(key for each in found.alternatives if each.chosen for key in each.chosen.values))


def _name(key: str) -> str:
    return keys_in_words(key.split("+"))


def _shown(found: Alternatives, value: str) -> str:
    """Write a value as people read it: a start by its time of day where all are on one."""
    moment = moment_or_none(value) if "T" in value else None
    if moment is None:
        return value
    return f"{moment:{'%H:%M' if _one_day(found) else '%d %b %H:%M'}} UTC"


def _one_day(found: Alternatives) -> bool:
    chosen = [each.chosen for each in found.alternatives if each.chosen]
    tried = {value for each in chosen for cell in each.cells for value in cell.values}
    tried.update(value for each in chosen for value in each.values.values())
    return len({moment.date() for value in tried if "T" in value and (moment := moment_or_none(value))}) == 1


def _scale(values: Sequence[str]) -> tuple[dict[str, float], str] | None:
    """Return the place of each value on an axis and its unit: moments in days, numbers in the first's unit."""
    moments = [moment_or_none(value) if "T" in value else None for value in values]
    if all(moments):
        days = (moment.timestamp() / _DAY for moment in moments if moment is not None)
        return dict(zip(values, days, strict=True)), "UTC"
    unit = values[0].partition(" ")[2]
    try:
        return {value: parse_number_with_unit(value if unit else float(value), unit) for value in values}, unit
    except (QuantityError, ValueError):
        return None
