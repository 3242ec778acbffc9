"""Report of `history`: each learned parameter from mission to mission, with its intervals, and where it changed."""

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.errors import InputError, Problem, did_you_mean, shown
from missionplan.report.diagnosis.findings import ageing_in_words
from missionplan.report.diagnosis.kind_report import part
from missionplan.report.page import BLUE, GREY, ORANGE, Cells, Figure, Page, PageSection, Table, to_figure, typed
from missionplan.report.quantities import Unit, reader_unit, with_error
from missionplan.report.wording import listed, number, parameter_in_words
from missionplan.studies.history.result import History, Learned

MOST_PANELS = 12
"""Parameters drawn, those with most values first."""
SURE = 0.995
"""Probability from which no doubt is told."""
MOVED = 3.0
"""Standard errors from the first value to the last from which a parameter did not hold still."""
UNLIKELY = 1e-6
"""Probability of measurements as far apart, of one mission, from which they are not of one vehicle."""
SURPRISING = 0.01
"""Probability of counts by the mission's rate below which they are called unlike it."""
RATES = ("per", "seen in the fleet", "the mission's", "rate", "as far out")
_OF_RATES = (
    "Gamma distributions, with Jeffreys' prior of half a failure; 90 % intervals. The last column is the probability "
    "of counts as far out by the mission's rate. A rate that the mission gives as a number, or a Weibull law, has no "
    "counts: those of the fleet stand in its place. reliability.yaml has all hazards: name it in the vehicle file."
)
COLUMNS = ("Parameter", "Report", "Value", "90 % interval", "State")


def page(history: History) -> Page:
    """Build the page of a history."""
    options = history.provenance.options
    rates = Table(RATES, _rate_rows(history), _OF_RATES, text_columns=3)
    order = {"data": "the data", "start": "the missions' starts"}.get(history.ordered_by, "the times of the reports")
    return Page(
        title="What was learned from mission to mission",
        answer=answer(history),
        draw=lambda: _figure(history),
        numbers=[
            ("Diagnoses", str(len(history.reports))),
            ("Parameters", str(len(history.parameters))),
            ("Changes", str(len(history.changes))),
        ],
        write=lambda: [
            *([PageSection("How often equipment fails", [rates])] if history.rates else []),
            PageSection("All values", [Table(COLUMNS, _rows(history), f"In the order of {order}.", 2)]),
        ],
        rerun=typed("history", options["folder"], mission=options.get("mission") or None),
        table=lambda: _cells(history),
        plots={"parameter": parameter},
    )


def _cells(history: History) -> Cells:
    """Tabulate for a terminal: the parameters, or the failure rates where no parameter was learned."""
    rows = _rows(history)
    return (COLUMNS, rows) if rows else (RATES, _rate_rows(history))


def answer(history: History) -> str:
    """Say how many diagnoses there are, what changed last, and what held still; and what fails how often."""
    sentences = [*ageing_in_words(history.levels, {})]
    for rate in history.rates:
        leaving = f" that leave it {rate.leaves}" if rate.leaves else ""
        seen = f"{leaving}: {rate.failures:g} in {rate.exposure:g} {rate.unit}"
        unlike = ", unlike the mission's rate" if rate.surprise < SURPRISING else ""
        sentences.append(f"Failures{seen}, {rate.rate:.2g} per {rate.per} ({rate.low:.2g} to {rate.high:.2g}){unlike}.")
    return (
        " ".join([*([_learned_in_words(history)] if history.reports else []), *sentences]) or "Nothing new was counted."
    )


def _rate_rows(history: History) -> list[list[str]]:
    return [
        [
            f"{rate.per}{f', {rate.leaves}' if rate.leaves else ''}",
            f"{rate.failures:g} in {rate.exposure:g} {rate.unit}",
            f"{rate.prior_failures:.3g} in {rate.prior_exposure:.4g} {rate.unit} ({rate.prior})",
            f"{rate.rate:.3g} ({rate.low:.2g} to {rate.high:.2g})",
            f"{rate.surprise:.2g}",
        ]
        for rate in history.rates
    ]


def _learned_in_words(history: History) -> str:
    count, many = len(history.reports), len(history.parameters)
    tells, learned = ("tells", "has") if count == 1 else ("tell", "have")
    who = f"{count} {'diagnosis' if count == 1 else 'diagnoses'}"
    if not many:
        return f"{who} {learned} learned no parameter."
    words = f"{who} {tells} of {many} parameter{'' if many == 1 else 's'}."
    unlike = [parameter_in_words(level.effect, level.name) for level in history.levels if level.agreement < UNLIKELY]
    if unlike:
        words += f" Those of one date do not agree on the {listed(unlike)}: are they of one vehicle?"
        return f"{words} Give each its own folder."
    return f"{words}{_followed_in_words(history)}"


def _followed_in_words(history: History) -> str:
    """Say what changed, went elsewhere or held still, but for what is told of levels that jumped or drift."""
    levels = {(level.effect, level.name) for level in history.levels if level.jumps or level.has_trend}
    changes = [entry for entry in history.changes if entry.key not in levels]
    if changes:
        words = "; ".join(f"{_named(entry)} in {entry.report}, to {_valued(entry)}" for entry in changes[-3:])
        return f" Not as before: {words}."
    if history.changes:
        return ""
    followed = [entries for entries in history.parameters.values() if len(entries) > 1]
    sure = [past for past in followed if past[-1].key not in levels and past[-1].probability >= SURE]
    if not sure:
        return "" if followed else " None was seen twice yet."
    if moved := [f"{_named(past[0])} from {_valued(past[0])} to {_valued(past[-1])}" for past in sure if _moved(past)]:
        return f" With time went {'; '.join(moved)}."
    last = max(sure, key=len)
    none = "No other" if levels else "None"
    return f" {none} changed: {_named(last[-1])} is {_valued(last[-1])} after {len(last)} diagnoses."


def _moved(entries: Sequence[Learned]) -> bool:
    """Whether the last value of a parameter lies outside what the first and its own error leave to chance."""
    first, last = entries[0], entries[-1]
    return abs(last.value - first.value) > MOVED * math.hypot(first.sd, last.sd)


def _named(entry: Learned) -> str:
    return parameter_in_words(entry.effect, entry.name)


def _valued(entry: Learned) -> str:
    return with_error(entry.value, entry.sd, _unit(entry))


def _unit(entry: Learned) -> Unit:
    """Unit in which a value is shown: angles in degrees."""
    return Unit("°", float(np.radians(1.0))) if entry.unit == "rad" else reader_unit(entry.unit, entry.value)


def _rows(history: History) -> list[list[str]]:
    rows = []
    for entries in history.parameters.values():
        for entry in entries:
            unit = _unit(entry)
            low, high = (number(unit(end), unit(entry.sd)) for end in (entry.low, entry.high))
            interval = f"{low} to {high}{unit.suffix}"
            doubt = f", if it is that ({part(entry.probability)})" if entry.probability < SURE else ""
            state = f"{'changed' if entry.is_change else entry.state}{doubt}"
            rows.append([_named(entry), entry.report, _valued(entry), interval, state])
    return rows


def _figure(history: History) -> Figure | None:
    """Draw each parameter over the diagnoses; vertical lines where it was no longer as before."""
    drawn = sorted(history.parameters.values(), key=lambda entries: -len(entries))[:MOST_PANELS]
    if not drawn:
        return None
    columns = 1 if len(drawn) == 1 else 2
    rows = -(-len(drawn) // columns)
    figure = MatplotlibFigure(figsize=(6.4, 0.7 + 1.7 * rows))
    panels = figure.subplots(rows, columns, sharex=True, squeeze=False).ravel()
    for axes, entries in zip(panels, drawn, strict=False):
        draw_parameter(axes, history, entries)
    for axes in panels[len(drawn) :]:
        axes.set_axis_off()
    for place, axes in enumerate(panels[: len(drawn)]):
        is_lowest = place >= max(len(drawn) - columns, 0)
        axes.xaxis.set_tick_params(labelbottom=is_lowest)
        axes.set_xlabel("Diagnosis" if is_lowest else "")
    return to_figure(
        figure,
        "history",
        alt="Learned parameters from mission to mission with their 90 % intervals",
        caption=(
            "What each diagnosis left of each parameter, with its 90 % interval; a dashed line stands where it was no "
            "longer as before. Numbers are those of the reports in the table, in the order of time."
        ),
    )


def draw_parameter(axes: Axes, history: History, entries: Sequence[Learned]) -> None:
    """Draw a parameter over the diagnoses, with its intervals; a dashed line where it was no longer as before."""
    place = {report: index + 1 for index, report in enumerate(history.reports)}
    axes.set(xlabel="Diagnosis", xlim=(0.5, len(place) + 0.5))
    axes.set_xticks(list(place.values()))
    unit = _unit(entries[-1])
    for entry in entries:
        at, colour = place[entry.report], ORANGE if entry.is_change else BLUE
        if entry.is_change:
            axes.axvline(at - 0.5, color=GREY, linestyle="--", linewidth=1.0)
        axes.vlines(at, unit(entry.low), unit(entry.high), color=colour, linewidth=1.6)
        axes.plot(at, unit(entry.value), "o", color=colour, markersize=4.0)
    axes.set_title(f"{_named(entries[-1])}{unit.axis}", fontsize=9)


def parameter(axes: Axes, history: History, effect: str = "") -> None:
    """Draw a parameter, by its effect and name as in ``compass-bias.angle``; by default that with most diagnoses."""
    parameters = {f"{entries[0].effect}.{entries[0].name}": entries for entries in history.parameters.values()}
    if not parameters:
        raise InputError([Problem("the diagnoses tell of no parameter", key="plot")])
    chosen = effect or max(parameters, key=lambda name: len(parameters[name]))
    if chosen not in parameters:
        problem = f"given {shown(effect)}, expected one of {', '.join(parameters)}"
        raise InputError([Problem(problem, key="effect", hint=did_you_mean(str(effect), parameters))])
    draw_parameter(axes, history, parameters[chosen])
