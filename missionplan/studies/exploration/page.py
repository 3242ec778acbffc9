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


def answer(found: Exploration) -> str:
    """Write the best cell, what is as good, and where all requirements are met."""
    best = found.best_cell
    if best is None:
        return f"Nothing to choose: none of the {tried(found)} can be compared, as no trial does what is asked for."
    what = " and ".join(name_of(axis) for axis in found.axes)
    sentences = []
    if not found.constrained and found.has_requirements:
        missed = " and ".join(
            f"the {in_words(item.quantity)} ({percent(item.probability)}, {100.0 * item.required:g}\u00a0% required)"
            for item in best.requirements
            if not item.met
        )
        sentences.append(f"No {what} tried meets all requirements; even the best misses {missed}.")
    gives = [f"the mission succeeds in {percent(best.success)} of the trials"]
    for key, words in ((ENERGY, "takes"), (DURATION, "lasts")):
        if key in best.quantities and best.quantities[key].count:
            gives.append(f"{words} {quantity_in_words(found, best, key)}")
    plural = "are" if len(found.axes) > 1 else "is"
    sentences += [
        f"{_BEST[found.aim]} {what} {plural} {place_in_words(found, best)}: {listed(gives)}.",
        members_in_words(found.members, "succeeds"),
        _as_good(found),
        _windows(found),
    ]
    unrun, dropped = len(found.cells) - len(found.valid), sum(cell.dropped for cell in found.cells)
    if unrun:
        sentences.append(f"{unrun} of the {len(found.cells)} {tried(found)} cannot be run; the report says why.")
    if dropped:
        sentences.append(f"With fewer trials were run those that cannot be the best: {dropped} of the {tried(found)}.")
    return " ".join(filter(None, sentences))


def tried(found: Exploration) -> str:
    """Name what was tried: ``starts``; ``choices`` where two keys were varied, or one that has no plural."""
    if len(found.axes) == 1 and found.axes[0].keys in (("start",), ["start"]):
        return "starts"
    return "choices"


def place_in_words(found: Exploration, cell: Cell) -> str:
    """Write a cell's values: ``05:50 UTC and 1.4 m/s``."""
    return " and ".join(value_on(axis, index) for axis, index in zip(found.axes, cell.place, strict=True))


def quantity_in_words(found: Exploration, cell: Cell, key: str, *, alone: bool = False) -> str:
    """Write the mean of a cell's quantity with its error, or alone with the digits that this supports."""
    mean, error = cell.quantities[key].mean, cell.quantities[key].standard_error
    phase, _, name = key.rpartition(".")
    unit = unit_for(phase, name, found.provenance.data, typical=mean)
    if not alone:
        return with_error(mean, error, unit)
    return number(unit(mean), unit(error)) + unit.suffix if math.isfinite(mean) else "–"


def _as_good(found: Exploration) -> str:
    """Write which cells the trials cannot tell from the best."""
    count = sum(cell.as_good for cell in found.cells)
    trials = found.provenance.trials
    noise = f"as far as {'1 trial tells' if trials == 1 else f'{trials} trials tell'}"
    if len(found.valid) < 2:
        return ""
    if count < 2:
        is_short = found.constrained and not all(cell.meets_all for cell in found.valid)
        return f"Every other one tried {'misses a requirement or ' * is_short}{_WORSE[found.aim]}, {noise}."
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


def page(found: Exploration) -> Page:
    """Build the page."""
    what, is_line = " and ".join(name_of(axis) for axis in found.axes), len(found.axes) == 1
    mapped, made = [] if is_line else quantities_shown(found), found.provenance
    again = {"vary": made.options.get("vary"), "quantity": made.options.get("quantity"), "aim": found.aim}
    numbers = [(f"{capitalised(tried(found))} tried", str(len(found.cells)))]
    numbers.append(("Trials of each", str(found.provenance.trials)))
    if found.best_cell is not None:
        numbers.insert(0, ("P(success) of the best", percent(found.best_cell.success)))
    return Page(
        title=f"Which {what}? {found.provenance.mission}",
        answer=answer(found),
        draw=lambda: curves_figure(found) if is_line else maps_figure(found, "success"),
        numbers=numbers,
        write=lambda: [
            *([PageSection("What it costs", [maps_figure(found, key) for key in mapped])] if mapped else []),
            *_good(found),
            *members_section(found.members, "mission", "success (95 % interval)", _SAILED),
            *_others(found),
        ],
        verdict=_verdict(found),
        rerun=typed("explore", "mission.yaml", **again, trials=made.trials, seed=made.seed),
        table=lambda: _cells(found),
        plots={"cells": draw_exploration},
    )


def _cells(found: Exploration) -> Cells:
    """Tabulate for a terminal: the best cells and those as good, or all of a few; numbers without their errors."""
    cells = [cell for cell in found.cells if cell.as_good] if len(found.cells) > _MOST_ROWS else list(found.cells)
    keys, rows = quantities_shown(found)[:_MOST_NARROW], []
    for cell in cells[:_MOST_ROWS]:
        mark = "best" if cell is found.best_cell else "as good" if cell.as_good else _STATUS[cell.status]
        numbers = ["–"] * (len(keys) + 1)
        if not cell.reason:
            numbers = [share(cell.success), *(_shown(found, cell, key, alone=True) for key in keys)]
        rows.append([place_in_words(found, cell), mark, *numbers])
    return ["", "requirements", "P(success)", *map(in_words, keys)], rows


def _verdict(found: Exploration) -> str:
    if not found.has_requirements:
        return ""
    if not found.any_meets_all:
        return "bad"
    best = found.best_cell
    doubts = [(each.probability, each.good) for each in found.members]
    if best and best.success.high < 0.5:
        return "bad"
    if not best or best.status != "met" or hangs_on_doubt(best.success, doubts):
        return "undecided"
    return "good"


def _shown(found: Exploration, cell: Cell, key: str, *, alone: bool = False) -> str:
    """Write how often an event came about, or the mean of a quantity, with its error or alone."""
    return share(cell.events[key]) if key in cell.events else quantity_in_words(found, cell, key, alone=alone)


def _table(found: Exploration, cells: Sequence[Cell]) -> Table:
    keys, rows = quantities_shown(found), []
    for cell in cells[:_MOST_ROWS]:
        told = ["–"] * (len(keys) + 2)
        if not cell.reason:
            mark = "best" if cell is found.best_cell else "yes" if cell.as_good else ""
            told = [percent(cell.success), *(_shown(found, cell, key) for key in keys), mark]
        values = [value_on(axis, index) for axis, index in zip(found.axes, cell.place, strict=True)]
        rows.append([*values, _STATUS[cell.status], *told])
    many = f"The first {_MOST_ROWS} of {len(cells)}; all are in explore.csv." if len(cells) > _MOST_ROWS else ""
    columns = [*map(name_of, found.axes), "requirements", "P(success)", *map(in_words, keys), "as good"]
    return Table(columns, rows, many, text_columns=len(found.axes) + 1)


def _good(found: Exploration) -> Iterator[PageSection]:
    good = [cell for cell in found.cells if cell.as_good]
    if len(found.axes) == 1 and found.windows:
        axis, rows = found.axes[0], []
        for each in found.windows:
            where = value_on(axis, each.first) if each.first == each.last else range_on(axis, each.first, each.last)
            least = min((cell.success for cell in found.cells[each.first : each.last + 1]), key=attrgetter("value"))
            rows.append((where, str(each.last - each.first + 1), percent(least)))
        heading = f"All requirements are met {ranges_in_words(axis, found.windows)}"
        caption = "Between the values that were tried nothing is known: a finer step shows where a window ends."
        yield PageSection(heading, [Table(("window", "tried", "least P(success)"), rows, caption)])
    if good:
        text = (
            f"{capitalised(tried(found))} are compared trial by trial on the same random numbers. One counts as good "
            f"unless it {_WORSE[found.aim]} by more than chance, at 5 % for all together (Bonferroni)."
        )
        more = "" if len(good) == 1 else f"; {len(good) - 1} more {'is' if len(good) == 2 else 'are'} as good"
        best = place_in_words(found, found.best_cell or good[0])
        yield PageSection(capitalised(f"{best} is the best{more}"), [text, _table(found, good)])


def _others(found: Exploration) -> Iterator[PageSection]:
    """Yield the front of what can be had, all cells of a few along one key, and what cannot be run."""
    front = [cell for cell in found.cells if cell.on_front]
    figure = front_figure(found)
    if figure is not None and len(front) > 1:
        heading = f"{len(front)} {tried(found)} trade success, energy and duration against each other"
        shown_above = all(cell.as_good for cell in front)
        table = [] if shown_above else [_table(found, sorted(front, key=lambda cell: -cell.success.value))]
        yield PageSection(heading, [figure, *table])
    few = len(found.axes) == 1 and len(found.cells) <= 5 * _MOST_ROWS
    if few and not all(cell.as_good for cell in found.cells):
        yield PageSection("All that was tried", [_table(found, found.cells)])
    unrun = [cell for cell in found.cells if cell.reason]
    if unrun:
        first = {cell.reason: cell for cell in reversed(unrun)}
        count = Counter(cell.reason for cell in unrun)
        rows = [(place_in_words(found, first[each]), str(count[each]), each) for each in list(count)[:_MOST_REASONS]]
        yield PageSection(
            f"{len(unrun)} of {len(found.cells)} {tried(found)} cannot be run",
            [Table(("for instance", tried(found), "reason"), rows, "All reasons are in explore.csv.", text_columns=3)],
        )
