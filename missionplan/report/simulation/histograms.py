"""Histograms of a simulated mission's quantities, with the requirements on them."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.arrays import Array
from missionplan.report.numbers import number
from missionplan.report.page import BLUE, ORANGE, SKY, Figure, to_figure
from missionplan.report.quantities import Unit, si_per_unit, span
from missionplan.report.simulation.figures import WIDTH
from missionplan.report.simulation.quantities import requirement_on, unit_of
from missionplan.report.wording import in_words
from missionplan.results.simulation import Histogram, Outcome, PhaseOutcome


def histogram_figure(outcome: Outcome, phase: PhaseOutcome, key: str) -> Figure:
    """Draw the distribution of a quantity, with the requirement on it where there is one."""
    statistic, title, unit = phase.quantities[key], in_words(f"{phase.name}.{key}"), unit_of(outcome, phase, key)
    figure = MatplotlibFigure(figsize=(WIDTH, 2.1))
    draw_histogram(figure.add_subplot(), outcome, phase, key)
    low, middle, high = span(statistic, unit)
    return to_figure(
        figure,
        f"{phase.name}-{key}".replace("_", "-"),
        f"Histogram of {title}: median {middle}{unit.suffix}, 90 % of trials from {low} to {high}{unit.suffix}.",
        f"Median {middle}{unit.suffix}; 90 % of the trials that reached it lie between {low} and {high}{unit.suffix} "
        "(dark band). The outermost bars also hold what lies beyond them.",
    )


def draw_histogram(axes: Axes, outcome: Outcome, phase: PhaseOutcome, key: str) -> None:
    """Draw bars, the median, the band that holds 90 %, and the limit of a requirement."""
    statistic, title, unit = phase.quantities[key], in_words(f"{phase.name}.{key}"), unit_of(outcome, phase, key)
    edges, counts = _in_use(phase.histograms[key])
    axes.stairs(100.0 * counts / max(counts.sum(), 1.0), edges / unit.size, fill=True, color=SKY)
    axes.axvspan(unit(statistic.p05), unit(statistic.p95), ymax=0.03, color=BLUE)
    axes.axvline(unit(statistic.p50), ymax=0.1, color=BLUE)
    axes.set(xlabel=f"{title}{unit.axis}", ylabel="trials (%)")
    axes.margins(x=0.02)
    axes.set_ylim(top=axes.get_ylim()[1] * 1.22)
    requirement = requirement_on(outcome, phase, key)
    if requirement is not None and requirement.limit is not None:
        bound = "at most" if requirement.bound == "at_most" else "at least"
        _mark_limit(axes, unit(requirement.limit / si_per_unit(key)), bound, unit)


def _in_use(found: Histogram) -> tuple[Array, Array]:
    """Bins from the first to the last that holds a trial."""
    used = np.flatnonzero(found.counts)
    if not len(used):
        return found.edges, found.counts
    return found.edges[used[0] : used[-1] + 2], found.counts[used[0] : used[-1] + 1]


def _mark_limit(axes: Axes, limit: float, bound: str, unit: Unit) -> None:
    """Draw a line at a limit; where it lies far outside the axes, an arrow at the edge that points to it."""
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
