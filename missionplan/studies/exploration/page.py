"""Page of an exploration: the answer, curves or maps, windows, the front, and what cannot be run."""

import shlex
from collections.abc import Iterator, Mapping, Sequence

from missionplan.report.explained import members_section
from missionplan.report.numbers import percent, share
from missionplan.report.page import Drawing, Figure, Page, PageSection, Table, Terminal
from missionplan.report.quantities import range_on, value_on
from missionplan.report.wording import capitalised, in_words
from missionplan.results.decision import Aim
from missionplan.studies.exploration.figures import (
    curves_figure,
    draw_exploration,
    front_figure,
    maps_figure,
    quantities_shown,
)
from missionplan.studies.exploration.result import Cell, Exploration, Status
from missionplan.studies.exploration.words import (
    answer,
    name_of,
    place_in_words,
    quantity_alone,
    quantity_with_error,
    ranges_in_words,
    tried,
)

_MOST_ROWS = 40
_MOST_REASONS = 12
_MOST_NARROW = 3
"""Quantities that fit on a terminal."""
_UNLESS: dict[Aim, str] = {
    "success": "unless the best succeeds more often",
    "energy": "unless the best takes less energy",
    "duration": "unless the best is faster",
}
_STATUS: dict[Status, str] = {
    "met": "met",
    "undecided": "undecided",
    "missed": "not met",
    "none": "–",
    "invalid": "cannot be run",
}


def page(found: Exploration) -> Page:
    """Build the page."""
    what = " and ".join(name_of(axis) for axis in found.axes)
    return Page(
        title=f"Which {what}? {found.provenance.mission}",
        answer=answer(found),
        draw=lambda: curves_figure(found) if len(found.axes) == 1 else maps_figure(found, "success"),
        numbers=_numbers(found),
        write=lambda: [section for part in (_maps, _good, _sailed, _front, _all, _invalid) for section in part(found)],
        verdict=_verdict(found),
        rerun=_rerun(found),
        glance=lambda: terminal(found),
        plots=PLOTS,
    )


def terminal(found: Exploration) -> Terminal:
    """Build the terminal's view: the best cells and those as good, or all of a few."""
    cells = [cell for cell in found.cells if cell.as_good] if len(found.cells) > _MOST_ROWS else list(found.cells)
    columns = ["", "requirements", "P(success)", *(in_words(key) for key in quantities_shown(found)[:_MOST_NARROW])]
    rows = [[place_in_words(found, cell), *_narrow(found, cell)] for cell in cells[:_MOST_ROWS]]
    return Terminal(answer(found), columns, rows, _verdict(found))


def _narrow(found: Exploration, cell: Cell) -> list[str]:
    """Numbers of a cell without their errors."""
    keys = quantities_shown(found)[:_MOST_NARROW]
    if cell.reason:
        return [_STATUS[cell.status], *["–"] * (len(keys) + 1)]
    marks = "best" if cell is found.best_cell else "as good" if cell.as_good else _STATUS[cell.status]
    return [marks, share(cell.success), *(_alone(found, cell, key) for key in keys)]


def _alone(found: Exploration, cell: Cell, key: str) -> str:
    return share(cell.events[key]) if key in cell.events else quantity_alone(found, cell, key)


def _verdict(found: Exploration) -> str:
    if not found.has_requirements:
        return ""
    if not found.any_meets_all:
        return "bad"
    return "good" if any(cell.status == "met" for cell in found.cells) else "undecided"


def _numbers(found: Exploration) -> list[tuple[str, str]]:
    numbers = [
        (f"{capitalised(tried(found))} tried", str(len(found.cells))),
        ("Trials of each", str(found.provenance.trials)),
    ]
    if found.best_cell is not None:
        numbers.insert(0, ("P(success) of the best", percent(found.best_cell.success)))
    return numbers


def _columns(found: Exploration) -> list[str]:
    keys = quantities_shown(found)
    return [*(name_of(axis) for axis in found.axes), "requirements", "P(success)", *map(in_words, keys), "as good"]


def _rows(found: Exploration, cells: Sequence[Cell]) -> list[list[str]]:
    keys = quantities_shown(found)
    rows = []
    for cell in cells:
        row = [value_on(axis, index) for axis, index in zip(found.axes, cell.place, strict=True)]
        row += [_STATUS[cell.status]]
        if cell.reason:
            row += ["–"] * (len(keys) + 2)
        else:
            row += [percent(cell.success), *(_shown(found, cell, key) for key in keys)]
            row += ["best" if cell is found.best_cell else "yes" if cell.as_good else ""]
        rows.append(row)
    return rows


def _shown(found: Exploration, cell: Cell, key: str) -> str:
    return share(cell.events[key]) if key in cell.events else quantity_with_error(found, cell, key)


def _table(found: Exploration, cells: Sequence[Cell]) -> Table:
    many = f"The first {_MOST_ROWS} of {len(cells)}; all are in explore.csv." if len(cells) > _MOST_ROWS else ""
    return Table(_columns(found), _rows(found, cells[:_MOST_ROWS]), many, text_columns=len(found.axes) + 1)


def _maps(found: Exploration) -> Iterator[PageSection]:
    if len(found.axes) == 2:
        figures: list[Figure] = [maps_figure(found, key) for key in quantities_shown(found)]
        if figures:
            yield PageSection("What it costs", figures)


def _good(found: Exploration) -> Iterator[PageSection]:
    good = [cell for cell in found.cells if cell.as_good]
    if len(found.axes) == 1 and found.windows:
        axis = found.axes[0]
        rows = [
            (
                value_on(axis, window.first)
                if window.first == window.last
                else range_on(axis, window.first, window.last),
                str(window.last - window.first + 1),
                percent(min((found.cells[i].success for i in range(window.first, window.last + 1)), key=_value)),
            )
            for window in found.windows
        ]
        heading = f"All requirements are met {ranges_in_words(axis, found.windows)}"
        caption = "Between the values that were tried nothing is known: a finer step shows where a window ends."
        yield PageSection(heading, [Table(("window", "tried", "least P(success)"), rows, caption)])
    if good:
        text = (
            f"{capitalised(tried(found))} are compared trial by trial on the same random numbers. One counts as good "
            f"{_UNLESS[found.aim]} by more than chance, at 5 % for all together (Bonferroni)."
        )
        yield PageSection(f"{capitalised(_good_in_words(found, good))}", [text, _table(found, good)])


def _value(probability: object) -> float:
    return float(getattr(probability, "value", 0.0))


def _good_in_words(found: Exploration, good: Sequence[Cell]) -> str:
    best = place_in_words(found, good[0]) if found.best_cell is None else place_in_words(found, found.best_cell)
    return f"{best} is the best" if len(good) == 1 else f"{best} is the best; {len(good) - 1} more are as good"


def _sailed(found: Exploration) -> Iterator[PageSection]:
    note = "The best, in the trials that sail in each member."
    yield from members_section(found.members, "mission", "success (95 % interval)", note)


def _front(found: Exploration) -> Iterator[PageSection]:
    front = [cell for cell in found.cells if cell.on_front]
    figure = front_figure(found)
    if figure is not None and len(front) > 1:
        heading = f"{len(front)} {tried(found)} trade success, energy and duration against each other"
        shown_above = all(cell.as_good for cell in front)
        table = [] if shown_above else [_table(found, sorted(front, key=lambda cell: -cell.success.value))]
        yield PageSection(heading, [figure, *table])


def _all(found: Exploration) -> Iterator[PageSection]:
    shown_above = all(cell.as_good for cell in found.cells)
    if len(found.axes) == 1 and len(found.cells) <= 5 * _MOST_ROWS and not shown_above:
        yield PageSection("All that was tried", [_table(found, found.cells)], is_reference=True)


def _invalid(found: Exploration) -> Iterator[PageSection]:
    by_reason: dict[str, list[Cell]] = {}
    for cell in found.cells:
        if cell.reason:
            by_reason.setdefault(cell.reason, []).append(cell)
    if by_reason:
        count = sum(map(len, by_reason.values()))
        rows = [
            (place_in_words(found, cells[0]), str(len(cells)), reason)
            for reason, cells in list(by_reason.items())[:_MOST_REASONS]
        ]
        yield PageSection(
            f"{count} of {len(found.cells)} {tried(found)} cannot be run",
            [Table(("for instance", tried(found), "reason"), rows, "All reasons are in explore.csv.", text_columns=3)],
        )


def _rerun(found: Exploration) -> str:
    options = found.provenance.options
    vary, quantities = options.get("vary"), options.get("quantity")
    words = ["missionplan explore mission.yaml"]
    words += [f"--vary {shlex.quote(str(each))}" for each in (vary if isinstance(vary, list) else [])]
    words += [f"--quantity {shlex.quote(str(each))}" for each in (quantities if isinstance(quantities, list) else [])]
    words += [f"--aim {found.aim} --trials {found.provenance.trials} --seed {found.provenance.seed}"]
    return " ".join(words)


PLOTS: Mapping[str, Drawing] = {"cells": draw_exploration}
"""Plots on given axes by name, the main one first."""
