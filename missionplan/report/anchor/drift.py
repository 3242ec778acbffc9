"""Figure of a dive in space: both bodies drift through the layers, in plan and in elevation."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure
from matplotlib.patches import Circle

from missionplan.report.axes import name_axis
from missionplan.report.page import BLUE, GREY, INK, ORANGE, PINK, SKY, Figure, to_figure
from missionplan.report.quantities import quantity
from missionplan.results.mooring.sizing import AnchorSizing

_DASHED = (0, (4, 3))


def drift_figure(sizing: AnchorSizing) -> Figure:
    """Draw the drift of anchor and vehicle from the last fix to touchdown."""
    figure = MatplotlibFigure(figsize=(6.0, 3.6))
    plan, elevation = figure.subplots(1, 2)
    _draw_radius(plan, sizing)
    _draw_plan(plan, sizing)
    _draw_elevation(elevation, sizing)
    return to_figure(
        figure,
        "drift",
        alt=(
            "Drift of anchor and vehicle from the last fix to touchdown: "
            f"{quantity(sizing.to_build.offset, 'm', '.1f')}, "
            f"with the allowed radius of {quantity(sizing.radius, 'm', '.1f')}"
        ),
        caption=f"The nominal dive with the mean currents: {_how(sizing)}. Cross: the anchor.",
    )


def _how(sizing: AnchorSizing) -> str:
    """Say how the bodies drift."""
    if sizing.to_build.dive.tied is None:
        return "each body drifts with its layer"
    return "the line ties the drift of both bodies"


def _until_touchdown(sizing: AnchorSizing) -> int:
    """Number of samples of the profile until touchdown."""
    profile = sizing.to_build.profile
    return int(np.count_nonzero(profile.time <= profile.stages["touchdown"]))


def _draw_radius(axes: Axes, sizing: AnchorSizing) -> None:
    """Draw the allowed radius about the last fix."""
    radius = sizing.radius
    axes.add_patch(Circle((0.0, 0.0), radius, fill=False, color=PINK, linewidth=1.2, linestyle=_DASHED))
    axes.text(0.0, 1.04 * radius, f"radius {quantity(radius, 'm', '.1f')}", ha="center", va="bottom", fontsize=8.5)
    axes.plot(0.0, 0.0, "o", color=INK, markersize=4)
    axes.annotate("last fix", (0.0, 0.0), (-1.0, -1.5), ha="right", va="top", fontsize=8.5)


def _draw_plan(axes: Axes, sizing: AnchorSizing) -> None:
    profile, until, offset = sizing.to_build.profile, _until_touchdown(sizing), sizing.to_build.offset
    axes.plot(*profile.anchor_track[:, :until], color=ORANGE, linewidth=2.6)
    axes.plot(*profile.vehicle_track[:, :until], color=BLUE, linewidth=1.3)
    east, north = (float(value) for value in profile.record.offset[:, 0])
    axes.plot(east, north, "x", color=ORANGE, markersize=7, markeredgewidth=2.0)
    axes.annotate(
        quantity(offset, "m", ".1f"),
        (east, north),
        (0, -9),
        textcoords="offset points",
        ha="right",
        va="top",
        fontsize=8.5,
    )
    limit = 1.28 * max(sizing.radius, offset)
    axes.set(xlim=(-limit, limit), ylim=(-limit, limit), aspect="equal")
    name_axis(axes.xaxis, "East", "m")
    name_axis(axes.yaxis, "North", "m")
    axes.set_title("Plan")


def _draw_elevation(axes: Axes, sizing: AnchorSizing) -> None:
    profile, until = sizing.to_build.profile, _until_touchdown(sizing)
    anchor, vehicle = np.hypot(*profile.anchor_track), np.hypot(*profile.vehicle_track)
    axes.plot(anchor[:until], profile.anchor_depth[:until], color=ORANGE)
    axes.plot(vehicle[:until], profile.vehicle_depth[:until], color=BLUE)
    edge = 0.0
    for layer in sizing.layers[:-1]:
        edge += layer.thickness
        axes.axhline(edge, color=SKY, linewidth=1.0)
        axes.text(0.0, edge, "edge of a layer", va="bottom", fontsize=8.5)
    axes.axhline(sizing.depth, color=GREY, linewidth=2.0)
    axes.axvline(sizing.radius, color=PINK, linewidth=1.2, linestyle=_DASHED)
    middle = int((until - 1) * 0.62)
    _label(axes, "anchor", (anchor[middle], profile.anchor_depth[middle]), ORANGE, shift=(-7, -3), align="right")
    _label(axes, "vehicle", (vehicle[middle], profile.vehicle_depth[middle]), BLUE, shift=(7, 3), align="left")
    axes.set(ylim=(1.06 * sizing.depth, -0.04 * sizing.depth))
    name_axis(axes.xaxis, "Distance from the last fix", "m")
    name_axis(axes.yaxis, "Depth", "m")
    axes.set_xlim(0.0, 1.1 * max(sizing.radius, sizing.to_build.offset))
    axes.set_title("Elevation")


def _label(
    axes: Axes, words: str, place: tuple[float, float], colour: str, *, shift: tuple[int, int], align: str
) -> None:
    axes.annotate(words, place, shift, textcoords="offset points", color=colour, ha=align, fontsize=9)
