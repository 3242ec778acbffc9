"""Figures of `tide`: the ellipses, and the record beside the tide that was found in it."""

import math
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.dates import AutoDateLocator, ConciseDateFormatter
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.arrays import Array
from missionplan.report.axes import name_axis
from missionplan.report.page import BLUE, GREEN, GREY, ORANGE, PINK, SKY, YELLOW, Figure, to_figure
from missionplan.report.quantities import quantity
from missionplan.results.tide import Constituent, TideResult

_COLOURS = (BLUE, ORANGE, GREEN, PINK, YELLOW, SKY)
_DRAWN = len(_COLOURS)


def draw_ellipses(axes: Axes, result: TideResult) -> None:
    """Draw the largest ellipses, each with a spoke to where the current is when the equilibrium tide is highest."""
    tide = result.shown
    angle = np.linspace(0.0, 2.0 * np.pi, 121)
    for wave, colour in zip(tide.constituents[:_DRAWN], _COLOURS, strict=False):
        east, north = _ellipse(wave, angle)
        axes.plot(east, north, color=colour, label=f"{wave.name}{' (inferred)' if wave.inferred_from else ''}")
        axes.plot([0.0, east[0]], [0.0, north[0]], color=colour, linewidth=0.8)
    axes.plot([0.0, tide.east], [0.0, tide.north], color=GREY, linewidth=2.0, label="mean")
    axes.set(aspect="equal")
    name_axis(axes.xaxis, "east", "m/s")
    name_axis(axes.yaxis, "north", "m/s")
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=4)


def ellipses_figure(result: TideResult) -> Figure:
    """Draw the ellipses at the depth that is shown."""
    figure = MatplotlibFigure(figsize=(5.4, 4.2))
    axes = figure.add_subplot()
    draw_ellipses(axes, result)
    axes.set_aspect("equal", adjustable="datalim")
    names = ", ".join(wave.name for wave in result.shown.constituents[:_DRAWN])
    depth = quantity(result.shown_depth, "m", "g")
    return to_figure(
        figure,
        "ellipses",
        f"Tidal ellipses of {names or 'no constituent'} at {depth}, and the mean current.",
        f"The current at {depth} goes round each ellipse once a period; the spoke ends where it is when the "
        "equilibrium tide is highest at Greenwich.",
    )


def draw_record(axes: Axes, result: TideResult, component: Literal["east", "north"] = "east") -> None:
    """Draw one component of the record, and of the tide with the mean."""
    row = ("east", "north").index(component)
    axes.plot(_moments(result), result.measured[row], color=GREY, linewidth=0.7, label="measured")
    axes.plot(_moments(result), result.fitted[row], color=BLUE, linewidth=0.9, label="tide and mean")
    name_axis(axes.yaxis, component, "m/s")
    _date(axes)


def record_figure(result: TideResult) -> Figure:
    """Draw the record and the tide with the mean, east above north, and what is left."""
    figure = MatplotlibFigure(figsize=(6.4, 5.4))
    upper, middle, lower = figure.subplots(3, 1, sharex=True)
    draw_record(upper, result, "east")
    draw_record(middle, result, "north")
    moments = _moments(result)
    left = result.measured - result.fitted
    lower.plot(moments, left[0], color=ORANGE, linewidth=0.7, label="east")
    lower.plot(moments, left[1], color=GREEN, linewidth=0.7, label="north")
    name_axis(lower.yaxis, "left", "m/s")
    lower.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2)
    lower.set(xlabel="UTC")
    upper.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2)
    return to_figure(
        figure,
        "record",
        f"The current at {quantity(result.shown_depth, 'm', 'g')} as measured, and the tide with the mean, "
        "against time.",
        f"The current at {quantity(result.shown_depth, 'm', 'g')}; at the bottom what is left when tide and "
        "mean are taken out.",
    )


def _moments(result: TideResult) -> Array:
    """Matplotlib's days: since the start of 1970."""
    return np.asarray(result.time / 86400.0)


def _date(axes: Axes) -> None:
    locator = AutoDateLocator(minticks=3, maxticks=7)  # type: ignore[no-untyped-call]
    axes.xaxis.set_major_locator(locator)
    axes.xaxis.set_major_formatter(ConciseDateFormatter(locator))  # type: ignore[no-untyped-call]


def _ellipse(wave: Constituent, angle: Array) -> tuple[Array, Array]:
    along, across = wave.major * np.cos(angle - wave.phase), wave.minor * np.sin(angle - wave.phase)
    sine, cosine = math.sin(wave.toward), math.cos(wave.toward)
    return along * sine - across * cosine, along * cosine + across * sine
