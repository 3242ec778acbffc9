"""Figures of an anchor: where the drag comes from, and its nominal dive against time and in space."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure
from matplotlib.patches import Circle

from missionplan.phases.mooring.profile import DescentProfile
from missionplan.report.axes import name_axis
from missionplan.report.page import BLUE, GREEN, GREY, INK, ORANGE, PINK, SKY, Figure, to_figure
from missionplan.report.quantities import quantity
from missionplan.results.anchor_sizing import AnchorSizing
from missionplan.results.sized_anchor import SizedAnchor

_DASHED = (0, (4, 3))


def drift_figure(sizing: AnchorSizing) -> Figure:
    """Draw the drift of anchor and vehicle from the last fix to touchdown."""
    anchor, radius = sizing.to_build, sizing.radius
    profile, offset = anchor.profile, anchor.nominal.offset
    until = int(np.count_nonzero(profile.time <= profile.stages["touchdown"]))
    figure = MatplotlibFigure(figsize=(6.0, 3.0))
    axes = figure.subplots()
    axes.add_patch(Circle((0.0, 0.0), radius, fill=False, color=PINK, linewidth=1.2, linestyle=_DASHED))
    axes.text(0.0, 1.04 * radius, f"radius {quantity(radius, 'm', '.1f')}", ha="center", va="bottom", fontsize=8.5)
    axes.plot(0.0, 0.0, "o", color=INK, markersize=4)
    axes.annotate("last fix", (0.0, 0.0), (-1.0, -1.5), ha="right", va="top", fontsize=8.5)
    axes.plot(*profile.anchor_track[:, :until], color=ORANGE, linewidth=2.6)
    axes.plot(*profile.vehicle_track[:, :until], color=BLUE, linewidth=1.3)
    east, north = (float(value) for value in profile.record.offset[:, 0])
    axes.plot(east, north, "x", color=ORANGE, markersize=7, markeredgewidth=2.0)
    label: dict[str, Any] = {"textcoords": "offset points", "ha": "right", "va": "top", "fontsize": 8.5}
    axes.annotate(quantity(offset, "m", ".1f"), (east, north), (0, -9), **label)
    limit = 1.28 * max(radius, offset)
    axes.set(xlim=(-limit, limit), ylim=(-limit, limit), aspect="equal")
    name_axis(axes.xaxis, "East", "m")
    name_axis(axes.yaxis, "North", "m")
    how = "each body drifts with its layer" if anchor.dive.tied is None else "the line ties the drift of both bodies"
    return to_figure(
        figure,
        "drift",
        alt=(
            "Drift of anchor and vehicle from the last fix to touchdown: "
            f"{quantity(offset, 'm', '.1f')}, with the allowed radius of {quantity(radius, 'm', '.1f')}"
        ),
        caption=(
            f"The nominal dive from above, with the mean currents: {how}. Orange: the anchor, which comes down at the "
            "cross; blue: the vehicle."
        ),
    )


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
        place = left + value + 0.01 * float(anchor.drag.total)
        axes.text(place, row, quantity(value, "N", ".2f"), va="center", fontsize=9)
        left += value
    axes.axvline(left, color=INK, linewidth=1.0, linestyle=_DASHED)
    words = f"wet weight that balances it: {quantity(left, 'N', '.2f')}"
    axes.text(0.99 * left, -0.75, words, ha="right", va="bottom", fontsize=9)
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
    end, terminal = profile.time[-1], anchor.nominal.terminal_velocity
    below.plot(profile.time, profile.vehicle_speed, color=BLUE)
    below.axhline(terminal, color=GREY, linewidth=1.0, linestyle=_DASHED)
    words = f"terminal velocity {quantity(terminal, 'm/s', '.2f')}"
    below.text(end, terminal, words, ha="right", va="bottom", fontsize=8.5)
    below.set(xlabel="Time since the last fix (s)", xlim=(0.0, end))
    name_axis(below.yaxis, "Vehicle's speed down", "m/s")
    below.set_ylim(top=1.22 * max(terminal, float(np.nanmax(profile.vehicle_speed))))
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
    anchor, nose = (float(np.interp(at, time, depth)) for depth in (profile.anchor_depth, profile.vehicle_depth))
    axes.annotate("anchor", (at - 0.5, anchor), color=ORANGE, ha="right", va="top", fontsize=9)
    axes.annotate("vehicle's nose", (at + 0.5, nose), color=BLUE, ha="left", va="bottom", fontsize=9)


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
