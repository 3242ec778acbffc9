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


def requirements_section(result: Alternatives) -> Iterator[PageSection]:
    """Show what each alternative reaches of each requirement."""
    writer = percent if len(result.alternatives) == 2 else share
    reached = [
        {_asked(item, result.provenance.data.get(case.name)): writer(item.probability) for item in case.requirements}
        for case in result.alternatives
    ]
    asked = list(dict.fromkeys(key for shares in reached for key in shares))
    if asked:
        rows = [[*key, *(shares.get(key, "–") for shares in reached)] for key in asked]
        columns = ["requirement", "required", *(case.name for case in result.alternatives)]
        yield PageSection("What each reaches of what is required", [Table(columns, rows)])


def _asked(item: RequirementOutcome, mission: object) -> tuple[str, str]:
    """Write what is required and how surely; both may differ from mission to mission."""
    written = requirements_of(mapping(mission))
    alike = [
        entry for entry in written if entry.get("quantity") == item.quantity and (item.bound or "quantity") in entry
    ]
    if len(alike) == 1:
        limit = limit_in_words(alike[0])
    else:
        limit = f"{item.bound.replace('_', ' ')} {number(item.limit or 0.0)}" if item.bound else ""
    return f"{in_words(item.quantity)} {limit}".strip(), f"{number(100.0 * item.required)}\u00a0%"


def differing_section(result: Alternatives) -> Iterator[PageSection]:
    """List the values in which the missions differ, but for what they let other commands try."""
    differing = [key for key in result.differing if not key.path.startswith(_OF_OTHER_COMMANDS)]
    if not differing:
        return
    rows = [  # of a file, its name
        [key.path, *(Path(value).name if Path(value).is_absolute() else value or "–" for value in key.values)]
        for key in differing[:_MOST_DIFFERING]
    ]
    count = len(differing)
    more = f"The first {_MOST_DIFFERING} of {count}." if count > _MOST_DIFFERING else ""
    heading = "1 value of the missions differs" if count == 1 else f"{count} values of the missions differ"
    names = [case.name for case in result.alternatives]
    yield PageSection(heading, [Table(["key", *names], rows, more, text_columns=len(names) + 1)])


_MOST_ROWS = 40
_MOST_WINDOWS = 4
_DAY = 86400.0


def choices_in_words(result: Alternatives) -> str:
    """Write the first sentence: ``The best start is 12:00 UTC in one and 06:00 UTC in two.``."""
    keys = _keys(result)
    what = f"The best {_name(keys[0])} is {{}} in {{}}" if len(keys) == 1 else "Best are {} in {}"
    by_words: dict[str, list[str]] = {}
    for case in result.alternatives:
        if np.isfinite(case.success.value):
            by_words.setdefault(chosen_in_words(result, case), []).append(case.name)
    return " ".join(f"{what.format(words, listed(names))}." for words, names in by_words.items())


def chosen_in_words(result: Alternatives, case: Alternative) -> str:
    """Write what was chosen: ``12:00 UTC``; with the names of the keys where there are several."""
    values = case.chosen.values if case.chosen else {}
    alone = len(_keys(result)) == 1
    parts = [
        _shown(result, value) if alone else f"{_name(key)} {_shown(result, value)}" for key, value in values.items()
    ]
    return listed(parts) or "–"


def windows_in_words(result: Alternatives, case: Alternative) -> str:
    """Write where all requirements are met: ``05:00 to 06:00 UTC, 12:00 UTC``, or in how many of the cells."""
    if case.chosen is None or not case.requirements:
        return "–"
    parts = [
        _shown(result, first)
        if first == last
        else f"{_shown(result, first).removesuffix(' UTC')} to {_shown(result, last)}"
        for first, last in case.chosen.windows
    ]
    if not parts:
        met = sum(cell.meets_all for cell in case.chosen.cells)
        return f"{met} of {case.chosen.count}" if met else "nowhere"
    more = [f"{len(parts) - _MOST_WINDOWS} more"] if len(parts) > _MOST_WINDOWS else []
    return ", ".join([*parts[:_MOST_WINDOWS], *more])


def curves_figure(result: Alternatives) -> Figure | None:
    """Draw P(success) against the only key, a line for each report; None where its values are no numbers."""
    keys = _keys(result)
    cells = [case.chosen.cells if case.chosen else () for case in result.alternatives]
    if len(keys) != 1 or not all(cells):
        return None
    scale = _scale([cell.values[0] for curve in cells for cell in curve])
    if scale is None:
        return None
    places, unit = scale
    figure = MatplotlibFigure(figsize=(6.0, 3.2))
    axes = figure.subplots()
    for row, (case, curve) in enumerate(zip(result.alternatives, cells, strict=True)):
        x = np.array([places[cell.values[0]] for cell in curve])
        low, middle, high = (
            100.0 * np.array([getattr(cell.success, part) for cell in curve]) for part in ("low", "value", "high")
        )
        colour = f"C{row % 7}"
        axes.fill_between(x, low, high, color=colour, alpha=0.15, linewidth=0.0)
        axes.plot(x, middle, ".-", color=colour, markersize=4, linewidth=1.2, label=case.name)
    axes.set(
        ylabel="P(success) (%)", ylim=(-4.0, 104.0), xlabel=f"{capitalised(_name(keys[0]))}{unit and f' ({unit})'}"
    )
    if unit == "UTC":
        mark_times(axes.xaxis, one_day=_one_day(result))
    figure.legend(loc="outside upper center", ncols=3)
    return to_figure(
        figure,
        "cells",
        f"Probability of success against {_name(keys[0])} in {len(result.alternatives)} explorations",
        "Bands: 95 % intervals. Gaps: the mission cannot be run.",
    )


def cells_section(result: Alternatives) -> Iterator[PageSection]:
    """Show P(success) of the cells that all explorations have tried."""
    tried = [{cell.values: cell for cell in (case.chosen.cells if case.chosen else ())} for case in result.alternatives]
    common = [values for values in tried[0] if all(values in cells for cells in tried)]
    if not common:
        return
    rows = [
        [
            *(_shown(result, value) for value in values),
            *(f"{share(cells[values].success)}{' ✓' if cells[values].meets_all else ''}" for cells in tried),
        ]
        for values in common[:_MOST_ROWS]
    ]
    columns = [*map(_name, _keys(result)), *(case.name for case in result.alternatives)]
    caption = "P(success); a tick where all requirements are met."
    if len(common) > _MOST_ROWS:
        caption += f" The first {_MOST_ROWS} of {len(common)}; each report has all of its own in explore.csv."
    heading = f"P(success) of the {len(common)} that {'both' if len(tried) == 2 else 'all'} have tried"
    yield PageSection(heading, [Table(columns, rows, caption, text_columns=len(_keys(result)))])


def _keys(result: Alternatives) -> list[str]:
    return list(dict.fromkeys(key for case in result.alternatives if case.chosen for key in case.chosen.values))


def _name(key: str) -> str:
    return keys_in_words(key.split("+"))


def _shown(result: Alternatives, value: str) -> str:
    """Write a value as people read it: a start by its time of day where all are on one."""
    moment = moment_or_none(value) if "T" in value else None
    if moment is None:
        return value
    return f"{moment:{'%H:%M' if _one_day(result) else '%d %b %H:%M'}} UTC"


def _one_day(result: Alternatives) -> bool:
    chosen = [case.chosen for case in result.alternatives if case.chosen]
    tried = {value for choice in chosen for cell in choice.cells for value in cell.values}
    tried.update(value for choice in chosen for value in choice.values.values())
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
