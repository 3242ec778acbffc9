"""Figures of a simulated mission."""

import math
import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from missionplan.arrays import Array
from missionplan.montecarlo.statistics import Probability
from missionplan.report.numbers import Unit, number, percent, plain, si_per_unit, span, unit_for
from missionplan.report.page import BLUE, INK, ORANGE, PINK, SKY, YELLOW, Figure, to_figure
from missionplan.results.simulation import Histogram, Outcome, PhaseOutcome, RequirementOutcome, Sensitivity

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WIDTH = 5.0
"""Of a figure [in], so that its text can be read on a telephone."""


def waterfall(outcome: Outcome) -> Figure:
    """Show P(success) after each thing that can go wrong."""
    from matplotlib.figure import Figure as MatplotlibFigure

    steps = [step for step in outcome.attrition if step.lost.value > 0.0]
    success = outcome.total.events["success"]
    labels = ["all trials", *(step.step for step in steps), "mission succeeds"]
    figure = MatplotlibFigure(figsize=(WIDTH, 0.55 + 0.42 * len(labels)))
    axes = figure.add_subplot()
    axes.barh(0, 100.0, color=SKY, height=0.62)
    for row, step in enumerate(steps, start=1):
        surviving, lost = 100.0 * step.surviving.value, 100.0 * step.lost.value
        axes.barh(row, lost, left=surviving, color=ORANGE, height=0.62)
        axes.plot([surviving, surviving], [row - 0.31, row + 1.31], color=INK, linewidth=0.7)
        beside = ((surviving, row), (-4, 0), "right") if surviving > 25.0 else ((surviving + lost, row), (4, 0), "left")
        axes.annotate(f"−{number(lost, _half(step.lost))} %", *beside[:2], **_BESIDE, ha=beside[2])
    last = len(labels) - 1
    axes.barh(last, 100.0 * success.value, color=BLUE, height=0.62)
    bounds = [[100.0 * (success.value - success.low)], [100.0 * (success.high - success.value)]]
    axes.errorbar(100.0 * success.value, last, xerr=bounds, color=INK, capsize=3, linewidth=1.2)
    inside = success.value > 0.5
    place, offset = ((0.0, last), (4, 0)) if inside else ((100.0 * success.high, last), (6, 0))
    colour = "white" if inside else INK
    axes.annotate(percent(success), place, offset, **_BESIDE, ha="left", color=colour, weight="bold")
    axes.set(yticks=range(len(labels)), xlim=(0.0, 100.0), xlabel="trials still good (%)")
    axes.set_yticklabels([textwrap.fill(label, 20) for label in labels])
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    losses = "; ".join(f"{step.step}, {100.0 * step.lost.value:.1f} %" for step in steps) or "nothing is lost"
    return to_figure(
        figure,
        "waterfall",
        f"Waterfall from all trials down to the {percent(success)} in which the mission succeeds: {losses}.",
        "What is lost at each step, of all trials; the last bar's whisker is the 95 % interval.",
    )


_BESIDE: dict[str, Any] = {"textcoords": "offset points", "va": "center", "fontsize": 9}


def _half(probability: Probability) -> float:
    """Half of the interval [%]."""
    return 50.0 * (probability.high - probability.low)


def histogram_figure(
    phase: PhaseOutcome, key: str, outcome: Outcome, requirement: RequirementOutcome | None = None
) -> Figure:
    """Show the distribution of a quantity, with the requirement on it."""
    from matplotlib.figure import Figure as MatplotlibFigure

    statistic, title = phase.quantities[key], plain(f"{phase.name}.{key}")
    unit = unit_for(phase.name, key, outcome.provenance.data, typical=statistic.p50)
    edges, counts = _in_use(phase.histograms[key])
    figure = MatplotlibFigure(figsize=(WIDTH, 2.1))
    axes = figure.add_subplot()
    axes.stairs(100.0 * counts / max(counts.sum(), 1.0), edges / unit.size, fill=True, color=SKY)
    axes.axvspan(unit(statistic.p05), unit(statistic.p95), ymax=0.03, color=BLUE)
    axes.axvline(unit(statistic.p50), ymax=0.1, color=BLUE)
    axes.set(xlabel=f"{title}{unit.axis}", ylabel="trials (%)")
    axes.margins(x=0.02)
    axes.set_ylim(top=axes.get_ylim()[1] * 1.22)
    if requirement is not None and requirement.limit is not None:
        _mark_limit(axes, requirement, unit, key)
    low, middle, high = span(statistic, unit)
    return to_figure(
        figure,
        f"{phase.name}-{key}".replace("_", "-"),
        f"Histogram of {title}: median {middle}{unit.suffix}, 90 % of trials from {low} to {high}{unit.suffix}.",
        f"Median {middle}{unit.suffix}; 90 % of the trials that came so far lie between {low} and {high}{unit.suffix} "
        "(dark band). The outermost bars also hold what lies beyond them.",
    )


def _in_use(found: Histogram) -> tuple[Array, Array]:
    """Bins from the first to the last that holds a trial."""
    used = np.flatnonzero(found.counts)
    if not len(used):
        return found.edges, found.counts
    return found.edges[used[0] : used[-1] + 2], found.counts[used[0] : used[-1] + 1]


def _mark_limit(axes: "Axes", requirement: RequirementOutcome, unit: Unit, key: str) -> None:
    """Mark a requirement's limit; where it lies far off, an arrow at the edge points to it."""
    assert requirement.limit is not None
    limit = unit(requirement.limit / si_per_unit(key))
    low, high = axes.get_xlim()
    words = f"{'at most' if requirement.bound == 'at_most' else 'at least'} {number(limit)}{unit.suffix}"
    if low - (high - low) <= limit <= high + (high - low):
        axes.axvline(limit, color=ORANGE, linestyle=(0, (4, 2)))
        low, high = min(low, limit - 0.02 * (high - low)), max(high, limit + 0.02 * (high - low))
        left = limit > 0.5 * (low + high)
        place = ((-5, 0), "right") if left else ((5, 0), "left")
        axes.set_xlim(low, high)
        at = (limit, 0.97)
    else:
        beyond = limit > high
        words = f"{words} →" if beyond else f"← {words}"
        place, at = ((0, 0), "right" if beyond else "left"), (high if beyond else low, 0.97)
    axes.annotate(
        words, at, place[0], xycoords=("data", "axes fraction"), textcoords="offset points", ha=place[1], va="top"
    )


def timeline(outcome: Outcome) -> Figure:
    """Show when each phase begins and ends."""
    from matplotlib.figure import Figure as MatplotlibFigure

    phases = [phase for phase in outcome.phases if math.isfinite(phase.start.p50)]
    whole = max(phase.end.p95 for phase in phases)
    unit = unit_for("total", "duration_s", outcome.provenance.data, typical=whole)
    figure = MatplotlibFigure(figsize=(WIDTH, 0.75 + 0.52 * len(phases)))
    axes = figure.add_subplot()
    for row, phase in enumerate(phases):
        start, end = phase.start, phase.end
        axes.barh(
            row, unit(end.p50 - start.p50), left=unit(start.p50), color=_KINDS.get(phase.kind, YELLOW), height=0.5
        )
        for edge in (start, end):
            if edge.p95 > edge.p05:
                axes.plot([unit(edge.p05), unit(edge.p95)], [row, row], color=INK, linewidth=1.2, marker="|")
    axes.set(yticks=range(len(phases)), xlabel=f"time since the start ({unit.name})", xlim=(0.0, None))
    axes.set_yticklabels([textwrap.fill(phase.name, 16) for phase in phases])
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    words = ", ".join(
        f"{phase.name} from {number(unit(phase.start.p50))} to {number(unit(phase.end.p50))} {unit.name}"
        for phase in phases
    )
    return to_figure(
        figure,
        "timeline",
        f"Timeline: {words} (medians).",
        "Bars run from the median start to the median end of a phase; lines: where 90 % of the starts and ends lie.",
    )


_KINDS = {"transit": SKY, "moor": PINK}


def sensitivity_bars(groups: Sequence[tuple[str, Sequence[Sensitivity]]]) -> Figure:
    """Show what share of each key figure's variance each input explains."""
    from matplotlib.figure import Figure as MatplotlibFigure

    sizes = [len(found) + 0.9 for _, found in groups]
    figure = MatplotlibFigure(figsize=(WIDTH, 0.5 + 0.5 * sum(sizes)))
    panels = figure.subplots(len(groups), 1, sharex=True, squeeze=False, height_ratios=sizes).ravel()
    for axes, (output, found) in zip(panels, groups, strict=True):
        for row, influence in enumerate(found):
            share, error = 100.0 * max(influence.first_order, 0.0), 100.0 * influence.standard_error
            axes.barh(row, share, color=BLUE if influence.rank_correlation >= 0.0 else ORANGE, height=0.4)
            axes.errorbar(share, row, xerr=1.96 * error, color=INK, capsize=2.5, linewidth=1.0)
            axes.annotate(_influence(influence), (0.0, row - 0.24), (2, 1), **_ABOVE)
        axes.set(yticks=[], ylim=(len(found) - 0.6, -0.85), xlim=(0.0, 105.0), title=plain(output))
        axes.grid(visible=False, axis="y")
    panels[-1].set_xlabel("share of the variance explained alone (%)")
    words = "; ".join(f"{plain(output)}: mostly {plain(found[0].source)}" for output, found in groups)
    return to_figure(
        figure,
        "sensitivity",
        f"Bars of what each uncertain input explains of the key figures. {words}.",
        "First-order Sobol indices with 95 % intervals; blue: more of the input makes the figure larger, orange: "
        "smaller (sign of the rank correlation).",
    )


_ABOVE: dict[str, Any] = {"textcoords": "offset points", "va": "bottom", "ha": "left", "fontsize": 9}


def _influence(influence: Sensitivity) -> str:
    return f"{plain(influence.source)}  {number(100.0 * influence.first_order, 100.0 * influence.standard_error)} %"
