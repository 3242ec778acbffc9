"""Figures of an anchor: where the drag comes from, and its nominal dive against time."""

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.arrays import Array
from missionplan.phases.mooring.profile import DescentProfile
from missionplan.report.axes import name_axis
from missionplan.report.page import BLUE, GREEN, GREY, INK, ORANGE, SKY, Figure, to_figure
from missionplan.report.quantities import quantity
from missionplan.results.mooring.sized_anchor import SizedAnchor


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
    mark_lowest_point(above, profile, seafloor, anchor.lowest_altitude)
    above.set(ylim=(1.06 * seafloor, -0.26 * seafloor))
    name_axis(above.yaxis, "Depth", "m")
    above.set_yticks([tick for tick in above.get_yticks() if 0.0 <= tick <= seafloor])
    _draw_speed(below, profile, anchor.dive_terminal_velocity)
    _mark_stages(above, below, profile.stages, float(profile.time[-1]), -0.25 * seafloor)
    return to_figure(
        figure,
        "descent",
        alt=(
            f"Depth and speed against time: taut line after {profile.stages['pull-down']:.1f} s, touchdown after "
            f"{profile.stages['touchdown']:.1f} s, the vehicle's lowest point "
            f"{quantity(anchor.lowest_altitude, 'm', '.1f')} above the "
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
