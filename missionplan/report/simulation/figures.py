"""Figures of a simulated mission as a whole: the waterfall of P(success) and the timeline."""

import math
import textwrap
from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.montecarlo.statistics import Probability
from missionplan.report.numbers import number, percent
from missionplan.report.page import BLUE, INK, ORANGE, PINK, SKY, YELLOW, Figure, to_figure
from missionplan.report.quantities import Unit, unit_for
from missionplan.results.simulation import Attrition, Outcome, PhaseOutcome

WIDTH = 5.0
"""Of a figure [in], so that its text can be read on a telephone."""
_KINDS = {"transit": SKY, "moor": PINK}


def waterfall(outcome: Outcome) -> Figure:
    """Draw P(success) after each thing that can go wrong."""
    steps = _losing(outcome)
    figure = MatplotlibFigure(figsize=(WIDTH, 0.55 + 0.42 * (len(steps) + 2)))
    draw_waterfall(figure.add_subplot(), outcome)
    losses = "; ".join(f"{step.step}, {100.0 * step.lost.value:.1f} %" for step in steps) or "nothing is lost"
    return to_figure(
        figure,
        "waterfall",
        f"Waterfall from all trials down to the {percent(outcome.total.events['success'])} in which the mission "
        f"succeeds: {losses}.",
        "Trials lost at each step, as shares of all trials; the last bar's whisker is the 95 % interval.",
    )


def _losing(outcome: Outcome) -> list[Attrition]:
    return [step for step in outcome.attrition if step.lost.value > 0.0]


def draw_waterfall(axes: Axes, outcome: Outcome) -> None:
    """Draw the trials that are left after each step at which some are lost."""
    steps = _losing(outcome)
    labels = ["all trials", *(step.step for step in steps), "mission succeeds"]
    axes.barh(0, 100.0, color=SKY, height=0.62)
    for row, step in enumerate(steps, start=1):
        _draw_loss(axes, row, step)
    _draw_success(axes, len(labels) - 1, outcome.total.events["success"])
    axes.set(yticks=range(len(labels)), xlim=(0.0, 100.0), xlabel="trials still good (%)")
    axes.set_yticklabels([textwrap.fill(label, 20) for label in labels])
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")


def _draw_loss(axes: Axes, row: int, step: Attrition) -> None:
    surviving, lost = 100.0 * step.surviving.value, 100.0 * step.lost.value
    axes.barh(row, lost, left=surviving, color=ORANGE, height=0.62)
    axes.plot([surviving, surviving], [row - 0.31, row + 1.31], color=INK, linewidth=0.7)
    half_interval = 50.0 * (step.lost.high - step.lost.low)
    place, shift, align = (surviving, -4, "right") if surviving > 25.0 else (surviving + lost, 4, "left")
    axes.annotate(
        f"−{number(lost, half_interval)} %",
        (place, row),
        (shift, 0),
        textcoords="offset points",
        va="center",
        fontsize=9,
        ha=align,
    )


def _draw_success(axes: Axes, row: int, success: Probability) -> None:
    axes.barh(row, 100.0 * success.value, color=BLUE, height=0.62)
    bounds = [[100.0 * (success.value - success.low)], [100.0 * (success.high - success.value)]]
    axes.errorbar(100.0 * success.value, row, xerr=bounds, color=INK, capsize=3, linewidth=1.2)
    inside = success.value > 0.5
    place, shift = (0.0, 4) if inside else (100.0 * success.high, 6)
    axes.annotate(
        percent(success),
        (place, row),
        (shift, 0),
        textcoords="offset points",
        va="center",
        fontsize=9,
        ha="left",
        color="white" if inside else INK,
        weight="bold",
    )


def timeline_figure(outcome: Outcome) -> Figure:
    """Draw when each phase begins and ends."""
    phases = _reached(outcome)
    unit = _timeline_unit(outcome)
    figure = MatplotlibFigure(figsize=(WIDTH, 0.75 + 0.52 * len(phases)))
    draw_timeline(figure.add_subplot(), outcome)
    words = ", ".join(
        f"{phase.label} from {number(unit(phase.start.p50))} to {number(unit(phase.end.p50))} {unit.name}"
        for phase in phases
    )
    return to_figure(
        figure,
        "timeline",
        f"Timeline: {words} (medians).",
        "Bars run from a phase's median start to its median end; lines show where 90 % of the starts and ends lie.",
    )


def _reached(outcome: Outcome) -> list[PhaseOutcome]:
    return [phase for phase in outcome.phases if math.isfinite(phase.start.p50)]


def _timeline_unit(outcome: Outcome) -> Unit:
    whole = max(phase.end.p95 for phase in _reached(outcome))
    return unit_for("total", "duration_s", outcome.provenance.data, typical=whole)


def draw_timeline(axes: Axes, outcome: Outcome) -> None:
    """Draw a bar from the median start to the median end of each phase that trials reach."""
    phases, unit = _reached(outcome), _timeline_unit(outcome)
    _draw_phases(axes, phases, unit)
    axes.set(yticks=range(len(phases)), xlabel=f"time since the start ({unit.name})", xlim=(0.0, None))
    axes.set_yticklabels([textwrap.fill(phase.label, 16) for phase in phases])
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")


def _draw_phases(axes: Axes, phases: Sequence[PhaseOutcome], unit: Unit) -> None:
    for row, phase in enumerate(phases):
        start, end = phase.start, phase.end
        colour = _KINDS.get(phase.kind, YELLOW)
        axes.barh(row, unit(end.p50 - start.p50), left=unit(start.p50), color=colour, height=0.5)
        for edge in (start, end):
            if edge.p95 > edge.p05:
                axes.plot([unit(edge.p05), unit(edge.p95)], [row, row], color=INK, linewidth=1.2, marker="|")
