"""Figures of an anchor: where the drag comes from, and its nominal dive against time and in space."""

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure
from matplotlib.patches import Circle

from missionplan.arrays import Array
from missionplan.phases.mooring.profile import DescentProfile
from missionplan.report.axes import name_axis
from missionplan.report.page import BLUE, GREEN, GREY, INK, ORANGE, PINK, SKY, Figure, to_figure
from missionplan.report.quantities import quantity
from missionplan.results.anchor_sizing import AnchorSizing
from missionplan.results.sized_anchor import SizedAnchor

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
            f"{quantity(sizing.to_build.nominal.offset, 'm', '.1f')}, "
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
    profile, until, offset = sizing.to_build.profile, _until_touchdown(sizing), sizing.to_build.nominal.offset
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
    axes.set_xlim(0.0, 1.1 * max(sizing.radius, sizing.to_build.nominal.offset))
    axes.set_title("Elevation")


def _label(
    axes: Axes, words: str, place: tuple[float, float], colour: str, *, shift: tuple[int, int], align: str
) -> None:
    axes.annotate(words, place, shift, textcoords="offset points", color=colour, ha=align, fontsize=9)


def drag_bars(anchor: SizedAnchor) -> Figure:
    """Draw where the drag comes from at terminal velocity."""
    parts = _drag_parts(anchor)
    figure = MatplotlibFigure(figsize=(6.0, 2.4))
    draw_drag(figure.subplots(), anchor)
    listed = ", ".join(f"{name.lower()} {quantity(value, 'N', '.2f')}" for name, value, _ in parts)
    whole = sum(value for _, value, _ in parts)
    return to_figure(figure, "drag", alt=f"Drag build-up: {listed}; together {quantity(whole, 'N', '.2f')}")


def draw_drag(axes: Axes, anchor: SizedAnchor) -> None:
    """Draw the drag of each part beside that of the parts before it."""
    parts, left = _drag_parts(anchor), 0.0
    for row, (_, value, colour) in enumerate(parts):
        axes.barh(row, value, left=left, color=colour, height=0.62)
        axes.text(
            left + value + 0.01 * float(anchor.drag.total),
            row,
            quantity(value, "N", ".2f"),
            va="center",
            fontsize=9,
        )
        left += value
    axes.axvline(left, color=INK, linewidth=1.0, linestyle=(0, (4, 3)))
    axes.text(
        0.99 * left,
        -0.75,
        f"wet weight that balances it: {quantity(left, 'N', '.2f')}",
        ha="right",
        va="bottom",
        fontsize=9,
    )
    axes.set_yticks(range(len(parts)), [name for name, _, _ in parts])
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    axes.set(xlim=(0.0, 1.14 * left), ylim=(len(parts) - 0.5, -1.1))
    name_axis(axes.xaxis, f"Drag at {quantity(anchor.terminal_velocity, 'm/s', '.2f')}", "N")


def _drag_parts(anchor: SizedAnchor) -> list[tuple[str, float, str]]:
    """Name, drag [N] and colour of each part that has drag."""
    drag = anchor.drag
    fins = float(drag.vehicle) - float(drag.body) - float(drag.sail)
    parts = [
        ("Hull", float(drag.body), BLUE),
        ("Sail", float(drag.sail), SKY),
        ("Fins, transducer", fins, GREEN),
        ("Anchor", float(drag.anchor), ORANGE),
    ]
    return [part for part in parts if part[1] > 0.0]


def descent_profile(anchor: SizedAnchor) -> Figure:
    """Draw depth and speed against time, with the stages marked."""
    profile, seafloor = anchor.profile, float(np.asarray(anchor.dive.site_depth))
    figure = MatplotlibFigure(figsize=(6.0, 5.4))
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(1.6, 1.0))
    draw_depths(above, profile, seafloor)
    mark_lowest_point(above, profile, seafloor, anchor.nominal.lowest_altitude)
    above.set(ylim=(1.06 * seafloor, -0.26 * seafloor))
    name_axis(above.yaxis, "Depth", "m")
    above.set_yticks([tick for tick in above.get_yticks() if 0.0 <= tick <= seafloor])
    _draw_speed(below, profile, anchor.nominal.terminal_velocity)
    _mark_stages(above, below, profile.stages, float(profile.time[-1]), -0.25 * seafloor)
    return to_figure(
        figure,
        "descent",
        alt=(
            f"Depth and speed against time: taut line after {profile.stages['pull-down']:.1f} s, touchdown after "
            f"{profile.stages['touchdown']:.1f} s, the vehicle's lowest point "
            f"{quantity(anchor.nominal.lowest_altitude, 'm', '.1f')} above the "
            "seafloor"
        ),
        caption="The nominal dive, every distribution at its mean. Dotted: the stages' ends.",
    )


def draw_depths(axes: Axes, profile: DescentProfile, seafloor: float) -> None:
    """Draw the depths of anchor and vehicle, and the seafloor."""
    time = profile.time
    axes.plot(time, profile.anchor_depth, color=ORANGE)
    axes.plot(time, profile.vehicle_depth, color=BLUE)
    axes.axhline(seafloor, color=GREY, linewidth=2.0)
    axes.text(time[-1], seafloor, "seafloor", ha="right", va="bottom", fontsize=8.5)
    at = 0.45 * (profile.stages["touchdown"] + profile.stages["pull-down"])
    anchor, nose = (
        (at - 0.5, _at(profile, profile.anchor_depth, at)),
        (at + 0.5, _at(profile, profile.vehicle_depth, at)),
    )
    axes.annotate("anchor", anchor, color=ORANGE, ha="right", va="top", fontsize=9)
    axes.annotate("vehicle's nose", nose, color=BLUE, ha="left", va="bottom", fontsize=9)


def _at(profile: DescentProfile, values: Array, time: float) -> float:
    return float(np.interp(time, profile.time, values))


def mark_lowest_point(axes: Axes, profile: DescentProfile, seafloor: float, altitude: float) -> None:
    """Say at the vehicle's lowest point how far above the seafloor it stops."""
    lowest = profile.stages["lowest point"]
    axes.annotate(
        f"stops {quantity(altitude, 'm', '.1f')} above" if altitude > 0.0 else "strikes the seafloor",
        (lowest, min(seafloor - altitude, seafloor)),
        (lowest, seafloor - max(altitude, 0.0) - 0.16 * seafloor),
        ha="center",
        fontsize=8.5,
        arrowprops={"arrowstyle": "-", "color": INK, "linewidth": 0.7},
    )


def _draw_speed(axes: Axes, profile: DescentProfile, terminal: float) -> None:
    end = profile.time[-1]
    axes.plot(profile.time, profile.vehicle_speed, color=BLUE)
    axes.axhline(terminal, color=GREY, linewidth=1.0, linestyle=(0, (4, 3)))
    axes.text(
        end, terminal, f"terminal velocity {quantity(terminal, 'm/s', '.2f')}", ha="right", va="bottom", fontsize=8.5
    )
    axes.set(xlabel="Time since the last fix (s)", xlim=(0.0, end))
    name_axis(axes.yaxis, "Vehicle's speed down", "m/s")
    axes.set_ylim(top=1.22 * max(terminal, float(np.nanmax(profile.vehicle_speed))))


def _mark_stages(above: Axes, below: Axes, stages: Mapping[str, float], end: float, height: float) -> None:
    edges = [0.0, stages["free fall"], stages["pull-down"], stages["touchdown"], stages["lowest point"], end]
    names = ["release", "pay-out", "pull-down", "coasting", "rise"]
    for start, stop, name in zip(edges, edges[1:], names, strict=False):
        if start > 0.0:
            for axes in (above, below):
                axes.axvline(start, color=GREY, linewidth=0.8, linestyle=":")
        if stop - start > 0.02 * end:
            turned = 90 if stop - start < 0.11 * end else 0
            above.text(0.5 * (start + stop), height, name, ha="center", va="top", fontsize=8.5, rotation=turned)
