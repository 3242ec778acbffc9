"""What an exploration found, in sentences, and its page: curves or maps, windows, the front, and what cannot be run."""

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from operator import attrgetter

from missionplan.report.explained import hangs_on_doubt, members_in_words, members_section
from missionplan.report.page import Cells, Page, PageSection, Table, typed
from missionplan.report.quantities import range_on, unit_for, value_on, with_error
from missionplan.report.wording import capitalised, in_words, listed, number, percent, share
from missionplan.results.decision import Aim, Axis
from missionplan.studies.exploration.figures import (
    curves_figure,
    draw_exploration,
    front_figure,
    maps_figure,
    name_of,
    quantities_shown,
)
from missionplan.studies.exploration.result import DURATION, ENERGY, Cell, Exploration, Status, Window

_AS_GOOD: dict[Aim, tuple[str, str, str]] = {
    "success": ("succeeds as often", "succeed as often", "Succeeding as often"),
    "energy": ("takes as little energy", "take as little energy", "Taking as little energy"),
    "duration": ("is as fast", "are as fast", "As fast"),
}
"""In what one or several are as good as the best: they may be worse in all else."""
_BEST = {"success": "The best", "energy": "For the least energy the best", "duration": "For the least time the best"}
_WORSE: dict[Aim, str] = {"success": "succeeds less often", "energy": "takes more energy", "duration": "takes longer"}
_MOST_RANGES = 4
"""Ranges that a sentence lists."""


def answer(result: Exploration) -> str:
    """Write the best cell, what is as good, and where all requirements are met."""
    best = result.best_cell
    if best is None:
        return f"Nothing to choose: none of the {tried(result)} can be compared, as no trial does what is asked for."
    what = " and ".join(name_of(axis) for axis in result.axes)
    sentences = []
    if not result.constrained and result.has_requirements:
        missed = " and ".join(
            f"the {in_words(item.quantity)} ({percent(item.probability)}, {100.0 * item.required:g}\u00a0% required)"
            for item in best.requirements
            if not item.met
        )
        sentences.append(f"No {what} tried meets all requirements; even the best misses {missed}.")
    gives = [f"the mission succeeds in {percent(best.success)} of the trials"]
    for key, words in ((ENERGY, "takes"), (DURATION, "lasts")):
        if key in best.quantities and best.quantities[key].count:
            gives.append(f"{words} {quantity_in_words(result, best, key)}")
    plural = "are" if len(result.axes) > 1 else "is"
    sentences += [
        f"{_BEST[result.aim]} {what} {plural} {place_in_words(result, best)}: {listed(gives)}.",
        members_in_words(result.members, "succeeds"),
        _as_good(result),
        _windows(result),
    ]
    unrun, dropped = len(result.cells) - len(result.valid), sum(cell.dropped for cell in result.cells)
    if unrun:
        sentences.append(f"{unrun} of the {len(result.cells)} {tried(result)} cannot be run; the report says why.")
    if dropped:
        sentences.append(f"With fewer trials were run those that cannot be the best: {dropped} of the {tried(result)}.")
    return " ".join(filter(None, sentences))


def tried(result: Exploration) -> str:
    """Name what was tried: ``starts``; ``choices`` where two keys were varied, or one that has no plural."""
    if len(result.axes) == 1 and result.axes[0].keys in (("start",), ["start"]):
        return "starts"
    return "choices"


def place_in_words(result: Exploration, cell: Cell) -> str:
    """Write a cell's values: ``05:50 UTC and 1.4 m/s``."""
    return " and ".join(value_on(axis, index) for axis, index in zip(result.axes, cell.place, strict=True))


def quantity_in_words(result: Exploration, cell: Cell, key: str, *, alone: bool = False) -> str:
    """Write the mean of a cell's quantity with its error, or alone with the digits that this supports."""
    mean, error = cell.quantities[key].mean, cell.quantities[key].standard_error
    phase, _, name = key.rpartition(".")
    unit = unit_for(phase, name, result.provenance.data, typical=mean)
    if not alone:
        return with_error(mean, error, unit)
    return number(unit(mean), unit(error)) + unit.suffix if math.isfinite(mean) else "–"


def _as_good(result: Exploration) -> str:
    """Write which cells the trials cannot tell from the best."""
    count = sum(cell.as_good for cell in result.cells)
    trials = result.provenance.trials
    noise = f"as far as {'1 trial tells' if trials == 1 else f'{trials} trials tell'}"
    if len(result.valid) < 2:
        return ""
    if count < 2:
        is_short = result.constrained and not all(cell.meets_all for cell in result.valid)
        return f"Every other one tried {'misses a requirement or ' * is_short}{_WORSE[result.aim]}, {noise}."
    if len(result.axes) == 1:
        axis = result.axes[0]
        if axis.numbers is None:
            others = [
                axis.labels[cell.place[0]] for cell in result.cells if cell.as_good and cell is not result.best_cell
            ]
            return f"{_AS_GOOD[result.aim][2]}, {noise}: {', '.join(others)}."
        where = ranges_in_words(axis, result.ranges_as_good)
        return f"Any {name_of(axis)} tried {where} {_AS_GOOD[result.aim][0]}, {noise}."
    return f"{count} of the {len(result.cells)} {tried(result)} {_AS_GOOD[result.aim][1]}, {noise}."


def _windows(result: Exploration) -> str:
    if not result.has_requirements or not result.constrained or any(cell.dropped for cell in result.cells):
        return ""
    sure = [cell.status == "met" for cell in result.cells]
    unsure = [cell.meets_all and not is_sure for cell, is_sure in zip(result.cells, sure, strict=True)]
    first, *others = [_where_in_words(result, has) for has in (sure, unsure) if any(has)]
    if not any(sure):
        return f"All requirements are met {first}; it takes more trials to be sure of it."
    return f"All requirements are met {first}{''.join(f'; {more} it takes more trials to be sure' for more in others)}."


def _where_in_words(result: Exploration, has: Sequence[bool]) -> str:
    if len(result.axes) == 1 and result.axes[0].numbers is not None:
        return ranges_in_words(result.axes[0], result.ranges(has))
    return f"with {sum(has)} of the {len(result.cells)} {tried(result)}"


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
    return listed(parts)


_SAILED = "The best, in the trials that sail in each member."
_MOST_ROWS = 40
_MOST_REASONS = 12
_MOST_NARROW = 3
"""Quantities that fit on a terminal."""
_STATUS: dict[Status, str] = {
    "met": "met",
    "undecided": "undecided",
    "missed": "not met",
    "none": "–",
    "invalid": "cannot be run",
}


def page(result: Exploration) -> Page:
    """Build the page."""
    what, is_line = " and ".join(name_of(axis) for axis in result.axes), len(result.axes) == 1
    mapped, made = [] if is_line else quantities_shown(result), result.provenance
    again = {"vary": made.options.get("vary"), "quantity": made.options.get("quantity"), "aim": result.aim}
    numbers = [(f"{capitalised(tried(result))} tried", str(len(result.cells)))]
    numbers.append(("Trials of each", str(result.provenance.trials)))
    if result.best_cell is not None:
        numbers.insert(0, ("P(success) of the best", percent(result.best_cell.success)))
    return Page(
        title=f"Which {what}? {result.provenance.mission}",
        answer=answer(result),
        draw=lambda: curves_figure(result) if is_line else maps_figure(result, "success"),
        numbers=numbers,
        write=lambda: [
            *([PageSection("What it costs", [maps_figure(result, key) for key in mapped])] if mapped else []),
            *_good(result),
            *members_section(result.members, "mission", "success (95 % interval)", _SAILED),
            *_others(result),
        ],
        verdict=_verdict(result),
        rerun=typed("explore", "mission.yaml", **again, trials=made.trials, seed=made.seed),
        table=lambda: _cells(result),
        plots={"cells": draw_exploration},
    )


def _cells(result: Exploration) -> Cells:
    """Tabulate for a terminal: the best cells and those as good, or all of a few; numbers without their errors."""
    cells = [cell for cell in result.cells if cell.as_good] if len(result.cells) > _MOST_ROWS else list(result.cells)
    keys, rows = quantities_shown(result)[:_MOST_NARROW], []
    for cell in cells[:_MOST_ROWS]:
        mark = "best" if cell is result.best_cell else "as good" if cell.as_good else _STATUS[cell.status]
        numbers = ["–"] * (len(keys) + 1)
        if not cell.reason:
            numbers = [share(cell.success), *(_shown(result, cell, key, alone=True) for key in keys)]
        rows.append([place_in_words(result, cell), mark, *numbers])
    return ["", "requirements", "P(success)", *map(in_words, keys)], rows


def _verdict(result: Exploration) -> str:
    if not result.has_requirements:
        return ""
    if not result.any_meets_all:
        return "bad"
    best = result.best_cell
    doubts = [(member.probability, member.good) for member in result.members]
    if best and best.success.high < 0.5:
        return "bad"
    if not best or best.status != "met" or hangs_on_doubt(best.success, doubts):
        return "undecided"
    return "good"


def _shown(result: Exploration, cell: Cell, key: str, *, alone: bool = False) -> str:
    """Write how often an event came about, or the mean of a quantity, with its error or alone."""
    return share(cell.events[key]) if key in cell.events else quantity_in_words(result, cell, key, alone=alone)


def _table(result: Exploration, cells: Sequence[Cell]) -> Table:
    keys, rows = quantities_shown(result), []
    for cell in cells[:_MOST_ROWS]:
        numbers = ["–"] * (len(keys) + 2)
        if not cell.reason:
            mark = "best" if cell is result.best_cell else "yes" if cell.as_good else ""
            numbers = [percent(cell.success), *(_shown(result, cell, key) for key in keys), mark]
        values = [value_on(axis, index) for axis, index in zip(result.axes, cell.place, strict=True)]
        rows.append([*values, _STATUS[cell.status], *numbers])
    many = f"The first {_MOST_ROWS} of {len(cells)}; all are in explore.csv." if len(cells) > _MOST_ROWS else ""
    columns = [*map(name_of, result.axes), "requirements", "P(success)", *map(in_words, keys), "as good"]
    return Table(columns, rows, many, text_columns=len(result.axes) + 1)


def _good(result: Exploration) -> Iterator[PageSection]:
    good = [cell for cell in result.cells if cell.as_good]
    if len(result.axes) == 1 and result.windows:
        axis, rows = result.axes[0], []
        for span in result.windows:
            where = value_on(axis, span.first) if span.first == span.last else range_on(axis, span.first, span.last)
            least = min((cell.success for cell in result.cells[span.first : span.last + 1]), key=attrgetter("value"))
            rows.append((where, str(span.last - span.first + 1), percent(least)))
        heading = _windows(result).removesuffix(".")
        caption = "Between the values that were tried nothing is known: a finer step shows where a window ends."
        yield PageSection(heading, [Table(("window", "tried", "least P(success)"), rows, caption)])
    if good:
        text = (
            f"{capitalised(tried(result))} are compared trial by trial on the same random numbers. One counts as good "
            f"unless it {_WORSE[result.aim]} by more than chance, at 5 % for all together (Bonferroni)."
        )
        more = "" if len(good) == 1 else f"; {len(good) - 1} more {'is' if len(good) == 2 else 'are'} as good"
        best = place_in_words(result, result.best_cell or good[0])
        yield PageSection(capitalised(f"{best} is the best{more}"), [text, _table(result, good)])


def _others(result: Exploration) -> Iterator[PageSection]:
    """Yield the front of what can be had, all cells of a few along one key, and what cannot be run."""
    front = [cell for cell in result.cells if cell.on_front]
    figure = front_figure(result)
    if figure is not None and len(front) > 1:
        heading = f"{len(front)} {tried(result)} trade success, energy and duration against each other"
        shown_above = all(cell.as_good for cell in front)
        table = [] if shown_above else [_table(result, sorted(front, key=lambda cell: -cell.success.value))]
        yield PageSection(heading, [figure, *table])
    few = len(result.axes) == 1 and len(result.cells) <= 5 * _MOST_ROWS
    if few and not all(cell.as_good for cell in result.cells):
        yield PageSection("All that was tried", [_table(result, result.cells)])
    unrun = [cell for cell in result.cells if cell.reason]
    if unrun:
        first = {cell.reason: cell for cell in reversed(unrun)}
        count = Counter(cell.reason for cell in unrun)
        rows = [
            (place_in_words(result, first[reason]), str(count[reason]), reason)
            for reason in list(count)[:_MOST_REASONS]
        ]
        yield PageSection(
            f"{len(unrun)} of {len(result.cells)} {tried(result)} cannot be run",
            [Table(("for instance", tried(result), "reason"), rows, "All reasons are in explore.csv.", text_columns=3)],
        )
