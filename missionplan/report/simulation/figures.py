"""Figures of a simulated mission: from above and against time, the waterfall of P(success), and histograms."""

import math
import textwrap
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure as MatplotlibFigure
from matplotlib.ticker import MaxNLocator

from missionplan.arrays import Array
from missionplan.errors import counted
from missionplan.exporters.geojson import COLOURS
from missionplan.montecarlo.statistics import Probability
from missionplan.report.axes import column_of_panels, name_axis
from missionplan.report.page import BLUE, GREY, INK, ORANGE, SKY, Figure, to_figure
from missionplan.report.plan_view import (
    WIDTH,
    Frame,
    draw_region,
    draw_ring,
    emptiest_corner,
    frame,
    median_trial,
    north_and_scale,
    rings,
    track,
)
from missionplan.report.quantities import quantity, si_per_unit, span, unit_for
from missionplan.report.simulation.quantities import failure_in_words, requirement_on, unit_of
from missionplan.report.site_map import name_goals, room_for_names
from missionplan.report.wording import in_words, number, percent, share
from missionplan.results.decision import SeaChart
from missionplan.results.simulation import Attrition, Outcome, PhaseOutcome


def waterfall(outcome: Outcome) -> Figure:
    """Draw P(success) after each thing that can go wrong."""
    steps = _losing(outcome)
    figure = MatplotlibFigure(figsize=(WIDTH, 0.55 + 0.42 * (len(steps) + 1)))
    draw_waterfall(figure.add_subplot(), outcome)
    losses = "; ".join(f"{failure_in_words(step.step)}, {share(step.lost)}" for step in steps) or "nothing is lost"
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
    labels = [*(failure_in_words(step.step) for step in steps), "mission succeeds"]
    for row, step in enumerate(steps):
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
    _draw_success(axes, len(labels) - 1, outcome.total.events["success"])
    axes.set(yticks=range(len(labels)), xlim=(0.0, 100.0), xlabel="trials still good (%)")
    axes.set_yticklabels([textwrap.fill(label, 20) for label in labels])
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")


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


_PROFILED = 60
"""Trials whose depth is drawn."""


def draw_profile(axes: Axes, outcome: Outcome) -> None:
    """Draw the depth of some trials against time, those that fail in another colour, and that of the median trial."""
    tracks, phases = outcome.tracks, outcome.phases
    ends = [time for phase in phases for time in (phase.end.p95, phase.start.p95) if math.isfinite(time)]
    unit = unit_for("total", "duration_s", outcome.provenance.data, typical=max([*ends, 1.0]))
    when, depth = tracks.profile
    shown = slice(min(_PROFILED, when.shape[1]))
    for success, colour in ((True, SKY), (False, ORANGE)):
        of = np.flatnonzero(tracks.success[shown] == success)
        lines = [np.column_stack([when[:, trial] / unit.size, depth[:, trial]]) for trial in of]
        axes.add_collection(LineCollection(lines, colors=colour, linewidths=0.5, alpha=0.5, zorder=2 + (not success)))
    middle = median_trial(tracks)
    axes.plot(when[:, middle] / unit.size, depth[:, middle], color=INK, linewidth=1.2)
    for trial in np.flatnonzero(~tracks.success[shown]):  # cross where it fails: the last corner that it has
        had = np.flatnonzero(np.isfinite(when[:, trial]))
        if len(had):
            axes.plot(when[had[-1], trial] / unit.size, depth[had[-1], trial], "x", color=ORANGE, markersize=4)
    axes.margins(x=0.01)
    axes.set(
        xlabel=f"time since the start{unit.axis}",
        xlim=(0.0, None),
        ylim=(1.08 * float(np.nanmax(depth, initial=1.0)), 0.0),
    )
    name_axis(axes.yaxis, "depth", "m")


def histograms(outcome: Outcome, shown: Sequence[tuple[PhaseOutcome, str]]) -> Figure:
    """Draw the distributions of quantities, one under the other, with the requirements on them."""
    figure, panels = column_of_panels(WIDTH, [0.95] * len(shown), (0.6, 0.2, 0.5, 0.1), 0.55)
    words = []
    for axes, (phase, key) in zip(panels, shown, strict=True):
        draw_histogram(axes, outcome, phase, key)
        unit = unit_of(outcome, phase, key)
        low, middle, high = span(phase.quantities[key], unit)
        words.append(f"{in_words(f'{phase.name}.{key}')}: median {middle}{unit.suffix}, 90 % from {low} to {high}")
    return to_figure(
        figure,
        "histograms",
        f"Histograms: {'; '.join(words)}.",
        "Dark: the median, and the band that holds 90 % of the trials that reached it. The outermost bars also hold "
        "what lies beyond them.",
    )


def draw_histogram(axes: Axes, outcome: Outcome, phase: PhaseOutcome, key: str) -> None:
    """Draw bars, the median, the band that holds 90 %, and the limit of a requirement."""
    statistic, title, unit = phase.quantities[key], in_words(f"{phase.name}.{key}"), unit_of(outcome, phase, key)
    edges, counts = phase.histograms[key].edges, phase.histograms[key].counts
    if (used := np.flatnonzero(counts)).size:  # bins from the first to the last that holds a trial
        edges, counts = edges[used[0] : used[-1] + 2], counts[used[0] : used[-1] + 1]
    axes.stairs(100.0 * counts / max(counts.sum(), 1.0), edges / unit.size, fill=True, color=SKY)
    axes.axvspan(unit(statistic.p05), unit(statistic.p95), ymax=0.03, color=BLUE)
    axes.axvline(unit(statistic.p50), ymax=0.1, color=BLUE)
    axes.set(xlabel=f"{title}{unit.axis}", ylabel="trials (%)")
    axes.margins(x=0.02)
    axes.set_ylim(top=axes.get_ylim()[1] * 1.22)
    requirement = requirement_on(outcome, phase, key)
    if requirement is not None and requirement.limit is not None:
        bound = "at most" if requirement.bound == "at_most" else "at least"
        limit = unit(requirement.limit / si_per_unit(key))
        low, high = axes.get_xlim()
        words = f"{bound} {number(limit)}{unit.suffix}"
        if low - (high - low) <= limit <= high + (high - low):
            axes.axvline(limit, color=ORANGE, linestyle=(0, (4, 2)))
            low, high = min(low, limit - 0.02 * (high - low)), max(high, limit + 0.02 * (high - low))
            axes.set_xlim(low, high)
            left = limit > 0.5 * (low + high)
            _at_top(axes, words, limit, shift=-5 if left else 5, align="right" if left else "left")
        elif limit > high:
            _at_top(axes, f"{words} →", high, shift=0, align="right")
        else:
            _at_top(axes, f"← {words}", low, shift=0, align="left")


def _at_top(axes: Axes, words: str, place: float, *, shift: int, align: str) -> None:
    axes.annotate(
        words,
        (place, 0.97),
        (shift, 0),
        xycoords=("data", "axes fraction"),
        textcoords="offset points",
        ha=align,
        va="top",
    )


_MAPPED = 200
"""Trials drawn."""


def mission_figure(outcome: Outcome) -> Figure:
    """Draw the mission as simulated: from above where it moves over ground, and its depth against time."""
    moves = moves_over_ground(outcome)
    heights = [(WIDTH - 0.95) * _frame(outcome).shape, 1.3] if moves else [1.3]
    figure, panels = column_of_panels(WIDTH, heights, (0.8, 0.15, 0.5, 0.1), 0.6)
    if moves:
        draw_tracks(panels[0], outcome)
    draw_profile(panels[-1], outcome)
    seen = "from above, north up, and their depth against time" if moves else "as depth against time"
    failed = int(np.count_nonzero(~outcome.tracks.success[:_MAPPED]))
    count = min(outcome.tracks.success.size, _MAPPED)
    crosses = f" {failed} of them fail (orange, a cross where they end)." if failed else " None of them fails."
    lines = " Circles, ellipses: as required, and of 50 and 95 % of the trials." if moves else ""
    if moves and outcome.chart is not None:
        kinds = {kind for kind, _ in outcome.chart.shapes}
        lines += " Grey lines: depth of the water at the start." if outcome.chart.depth is not None else ""
        lines += f"{' Brown: land.' if 'land' in kinds else ''}{' Hatched: keep out.' if 'keep-out' in kinds else ''}"
    astray = _frame(outcome).outliers_in_words() if moves else ""
    return to_figure(
        figure,
        "mission",
        f"{counted(count, 'trial')} of the mission {seen}.{crosses}",
        f"{counted(count, 'trial')} (light) {seen}; dark: the median trial.{crosses}{lines}{astray}",
        origin=outcome.tracks.origin,
    )


def moves_over_ground(outcome: Outcome) -> bool:
    """Whether any phase has somewhere to go."""
    return any(radius > 0.0 for _, radius in outcome.tracks.targets.values())


def _draw_place(axes: Axes, chart: SeaChart, shown: Frame) -> None:
    """Draw depths, land and zones kept out of behind the tracks; of depths what is shown, so that labels are in it."""
    if chart.depth is not None:
        columns, rows = (
            slice(max(int(np.searchsorted(axis, low)) - 1, 0), int(np.searchsorted(axis, high)) + 1)
            for axis, (low, high) in ((chart.east, shown.west_east), (chart.north, shown.south_north))
        )
        east, north, water = chart.east[columns], chart.north[rows], np.ma.masked_invalid(chart.depth[rows, columns])
        if min(water.shape) > 1 and water.count():
            levels = MaxNLocator(6).tick_values(float(water.min()), float(water.max()))
            axes.contourf(east, north, -water, [0.0, 1e5], colors=[COLOURS["land"]], alpha=0.35, zorder=0.1)
            drawn = axes.contour(east, north, water, levels, colors=GREY, linewidths=0.5, zorder=0.2)
            axes.clabel(drawn, fontsize=7, fmt=lambda depth: quantity(depth, "m", "g"))
    for kind, outlines in chart.shapes:
        draw_region(axes, outlines, kind, zorder=0.3)


def _lines(outcome: Outcome) -> list[Array]:
    """Tracks that are drawn."""
    tracks = outcome.tracks
    return [track(tracks, trial) for trial in range(min(tracks.position.shape[2], _MAPPED))]


def _circles(outcome: Outcome) -> list[Array]:
    return [ring.line for ring in rings(outcome)]


def _frame(outcome: Outcome) -> Frame:
    return frame(_lines(outcome), [*_circles(outcome), *room_for_names(outcome.provenance.data)])


def draw_tracks(axes: Axes, outcome: Outcome) -> None:
    """Draw tracks, the median trial, circles and ellipses, the north arrow and a scale."""
    tracks, lines, shown = outcome.tracks, _lines(outcome), _frame(outcome)
    if outcome.chart is not None:
        _draw_place(axes, outcome.chart, shown)
    fails = ~tracks.success[: len(lines)]
    for failing, colour in ((False, SKY), (True, ORANGE)):
        drawn = [line.T for line, fail in zip(lines, fails, strict=True) if fail == failing]
        axes.add_collection(LineCollection(drawn, colors=colour, linewidths=0.5, alpha=0.45))
    for line in (line for line, fail in zip(lines, fails, strict=True) if fail and line.size):
        axes.plot(*line[:, -1], "x", color=ORANGE, markersize=4)
    middle = track(tracks, median_trial(tracks))
    axes.plot(*middle, color=INK, linewidth=1.2, marker="o", markersize=2.5, label="median trial")
    for ring in rings(outcome):
        draw_ring(axes, ring, ring.line, linewidth=1.0)
    name_goals(axes, outcome.provenance.data)
    axes.set(xlim=shown.west_east, ylim=shown.south_north, aspect="equal")
    name_axis(axes.xaxis, "east", "m")
    name_axis(axes.yaxis, "north", "m")
    north_and_scale(axes, shown.width, emptiest_corner([*lines, *_circles(outcome)], shown.limits))
