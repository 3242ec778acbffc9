"""Figures of `size-anchor`: the anchor in section, where the drag comes from, the dive in time and in space."""

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure
from matplotlib.patches import Circle, Polygon, Rectangle, Wedge

from missionplan.physics.anchor import AnchorDesign, cap_height
from missionplan.report.page import BLUE, GREEN, GREY, INK, ORANGE, PINK, SKY, YELLOW, Figure, to_figure
from missionplan.results.anchor import AnchorSizing, SizedAnchor

_MM = 1e3
_RING_WIDTH = 0.012
"""Width [m] with which the trim ring is drawn; its thickness follows from its mass."""


def drawing(design: AnchorDesign) -> Figure:
    """Draw the anchor in section, to scale, in millimetres from its tip."""
    figure = MatplotlibFigure(figsize=(6.0, 4.0))
    axes = figure.subplots()
    r, end = design.problem.radius * _MM, design.length * _MM
    _draw_nose(axes, design)
    _draw_solids(axes, design)
    for x, label, marker, above in (
        (design.centre_of_buoyancy, "centre of buoyancy", "o", True),
        (design.centre_of_gravity, "centre of gravity", "+", False),
    ):
        axes.plot(x * _MM, 0.0, marker, color=INK, markerfacecolor="none", markersize=10, markeredgewidth=1.3, zorder=6)
        axes.annotate(
            f"{label}\n{x * _MM:.1f} mm",
            (x * _MM, 2.5 if above else -2.5),
            (x * _MM - 4.0, 0.42 * r if above else -0.42 * r),
            ha="right",
            va="center",
            fontsize=8.5,
            arrowprops={"arrowstyle": "-", "color": INK, "linewidth": 0.7, "shrinkA": 1, "shrinkB": 3},
            zorder=6,
        )
    below = -r - 12.0
    _dimension(axes, 0.0, end, below - 16.0, f"{end:.0f} mm")
    _dimension(axes, r, end, below, f"C = {design.cylinder_length * _MM:.1f} mm")
    if math.isfinite(design.trim_position):
        _dimension(axes, 0.0, design.trim_position * _MM, r + 24.0, f"ring at {design.trim_position * _MM:.1f} mm")
    axes.set(xlim=(-14.0, end + 62.0), ylim=(below - 26.0, r + 36.0), xlabel="From the tip (mm)", aspect="equal")
    axes.grid(visible=False)
    axes.set_yticks([])
    axes.spines["left"].set_visible(False)
    built = "" if design.feasible else " It cannot be built: see the problems."
    return to_figure(
        figure,
        "anchor",
        alt=(
            f"Section of the anchor: a round front, a tube of {design.cylinder_length * _MM:.0f} mm, "
            f"a trim ring at {design.trim_position * _MM:.0f} mm from the tip, a back that takes in the vehicle's nose"
        ),
        caption=(
            "The anchor in section, to scale. Front, tube and back stand for their masses; their shapes inside are "
            f"drawn, not designed. Attached and dry, it neither sinks nor trims the vehicle.{built}"
        ),
    )


def _draw_nose(axes: Axes, design: AnchorDesign) -> None:
    """The vehicle's nose, part of it inside the anchor."""
    nose, end = design.problem.nose_radius * _MM, design.length * _MM
    height = cap_height(design.problem.overlap_volume, design.problem.nose_radius) * _MM
    tip = end - height
    angle = np.linspace(-math.pi / 2, math.pi / 2, 90)
    x, y = tip + nose * (1.0 - np.cos(angle)), nose * np.sin(angle)
    edge = end + 60.0
    outline = np.column_stack((np.append(x, [edge, edge]), np.append(y, [nose, -nose])))
    axes.add_patch(Polygon(outline, closed=True, facecolor=GREY, alpha=0.14, linewidth=0.0))
    axes.plot(x, y, color=GREY, linewidth=1.0)
    for side in (-nose, nose):
        axes.plot([tip + nose, edge], [side, side], color=GREY, linewidth=1.0)
    if height > 1.0:
        inside = x <= end
        cap = np.column_stack((np.append(x[inside], end), np.append(y[inside], y[inside][-1])))
        axes.add_patch(Polygon(cap, closed=True, facecolor=SKY, alpha=0.45, linewidth=0.0))
        axes.annotate(
            f"overlap\n{design.problem.overlap_volume * 1e3:.2f} L",
            (end - 0.5 * height, -0.35 * nose),
            (end + 8.0, -0.35 * nose),
            va="center",
            fontsize=8.5,
            arrowprops={"arrowstyle": "-", "color": INK, "linewidth": 0.7},
        )
    axes.text(end + 10.0, 0.3 * nose, "vehicle's nose", fontsize=8.5, va="center")


def _draw_solids(axes: Axes, design: AnchorDesign) -> None:
    """Front, tube, back and ring, mirrored about the axis."""
    made = design.problem.construction
    radius, end = design.problem.radius, design.length
    r = radius * _MM
    shell = made.front.mass / made.front.density / (2.0 * math.pi * radius**2)
    axes.add_patch(Wedge((r, 0.0), r, 90.0, 270.0, width=min(shell * _MM, r), facecolor=BLUE, linewidth=0.0))
    wall = made.tube_mass_per_length / made.tube_density / (2.0 * math.pi * radius)
    depth = 2.0 * made.back.centre
    back = made.back.mass / made.back.density / (2.0 * math.pi * (radius - wall) * depth)
    bands = [
        (radius, max(design.cylinder_length, 0.0), 0.0, wall, YELLOW),
        (end - depth, depth, wall, back, GREEN),
    ]
    if design.trim_mass > 0.0 and math.isfinite(design.trim_position):
        ring = design.trim_mass / made.trim_density / (2.0 * math.pi * (radius - wall) * _RING_WIDTH)
        bands.append((design.trim_position - 0.5 * _RING_WIDTH, _RING_WIDTH, wall, ring, ORANGE))
    for start, length, inward, thickness, colour in bands:
        for sign in (1.0, -1.0):
            low = sign * (radius - inward) * _MM
            patch = Rectangle((start * _MM, low), length * _MM, -sign * thickness * _MM, facecolor=colour, zorder=4)
            axes.add_patch(patch)
    top = r + 6.0
    axes.text(0.25 * r, top - 0.25 * r, "front", color=BLUE, ha="right", fontsize=8.5)
    axes.text(r + 4.0, top, "tube", color="#8a6100", ha="left", fontsize=8.5)
    axes.text(end * _MM, top, "back", color=GREEN, ha="right", fontsize=8.5)
    if len(bands) == 3:
        label = f"ring {design.trim_mass:.2f} kg"
        axes.text(design.trim_position * _MM, top, label, color=ORANGE, ha="center", fontsize=8.5)


def _dimension(axes: Axes, start: float, end: float, height: float, label: str) -> None:
    axes.annotate("", (start, height), (end, height), arrowprops={"arrowstyle": "<->", "color": INK, "linewidth": 0.8})
    axes.text(0.5 * (start + end), height + 1.5, label, ha="center", va="bottom", fontsize=8.5)


def drag_bars(anchor: SizedAnchor) -> Figure:
    """Draw where the drag comes from at terminal velocity."""
    drag = anchor.drag
    fins = float(drag.vehicle) - float(drag.body) - float(drag.sail)
    parts = [
        ("Hull", float(drag.body), BLUE),
        ("Sail", float(drag.sail), SKY),
        ("Fins, transducer", fins, GREEN),
        ("Anchor", float(drag.anchor), ORANGE),
    ]
    parts = [part for part in parts if part[1] > 0.0]
    figure = MatplotlibFigure(figsize=(6.0, 2.4))
    axes = figure.subplots()
    left = 0.0
    for row, (_, value, colour) in enumerate(parts):
        axes.barh(row, value, left=left, color=colour, height=0.62)
        axes.text(left + value + 0.01 * float(drag.total), row, f"{value:.2f} N", va="center", fontsize=9)
        left += value
    axes.axvline(left, color=INK, linewidth=1.0, linestyle=(0, (4, 3)))
    axes.text(0.99 * left, -0.75, f"wet weight that balances it: {left:.2f} N", ha="right", va="bottom", fontsize=9)
    axes.set_yticks(range(len(parts)), [name for name, _, _ in parts])
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    axes.set(
        xlabel=f"Drag at {anchor.terminal_velocity:.2f} m/s (N)", xlim=(0.0, 1.14 * left), ylim=(len(parts) - 0.5, -1.1)
    )
    listed = ", ".join(f"{name.lower()} {value:.2f} N" for name, value, _ in parts)
    return to_figure(figure, "drag", alt=f"Drag build-up: {listed}; together {left:.2f} N")


def descent_profile(anchor: SizedAnchor) -> Figure:
    """Draw depth and speed against time, with the stages marked."""
    profile, depth = anchor.profile, float(np.asarray(anchor.dive.site_depth))
    figure = MatplotlibFigure(figsize=(6.0, 5.4))
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(1.6, 1.0))
    above.plot(profile.time, profile.anchor_depth, color=ORANGE)
    above.plot(profile.time, profile.vehicle_depth, color=BLUE)
    above.axhline(depth, color=GREY, linewidth=2.0)
    above.text(profile.time[-1], depth, "seafloor", ha="right", va="bottom", fontsize=8.5)
    at = 0.45 * (profile.stages["touchdown"] + profile.stages["pull-down"])
    for line, label, colour, side in (
        (profile.anchor_depth, "anchor", ORANGE, "right"),
        (profile.vehicle_depth, "vehicle's nose", BLUE, "left"),
    ):
        shift = -0.5 if side == "right" else 0.5
        va = "top" if side == "right" else "bottom"
        place = (at + shift, float(np.interp(at, profile.time, line)))
        above.annotate(label, place, color=colour, ha=side, va=va, fontsize=9)
    lowest = profile.stages["lowest point"]
    gap = anchor.lowest_altitude
    above.annotate(
        f"stops {gap:.1f} m above" if gap > 0.0 else "strikes the seafloor",
        (lowest, min(depth - gap, depth)),
        (lowest, depth - max(gap, 0.0) - 0.16 * depth),
        ha="center",
        fontsize=8.5,
        arrowprops={"arrowstyle": "-", "color": INK, "linewidth": 0.7},
    )
    above.set(ylabel="Depth (m)", ylim=(1.06 * depth, -0.26 * depth))
    above.set_yticks([tick for tick in above.get_yticks() if 0.0 <= tick <= depth])
    below.plot(profile.time, profile.vehicle_speed, color=BLUE)
    terminal = float(profile.record.terminal_velocity[0])
    below.axhline(terminal, color=GREY, linewidth=1.0, linestyle=(0, (4, 3)))
    below.text(
        profile.time[-1], terminal, f"terminal velocity {terminal:.2f} m/s", ha="right", va="bottom", fontsize=8.5
    )
    below.set(xlabel="Time since the last fix (s)", ylabel="Vehicle's speed down (m/s)", xlim=(0.0, profile.time[-1]))
    below.set_ylim(top=1.22 * max(terminal, float(np.nanmax(profile.vehicle_speed))))
    _mark_stages(above, below, profile.stages, float(profile.time[-1]), -0.25 * depth)
    return to_figure(
        figure,
        "descent",
        alt=(
            f"Depth and speed against time: taut line after {profile.stages['pull-down']:.1f} s, touchdown after "
            f"{profile.stages['touchdown']:.1f} s, the vehicle's lowest point {gap:.1f} m above the seafloor"
        ),
        caption="The nominal dive, every distribution at its mean. Dotted: the stages' ends.",
    )


def _mark_stages(above: Axes, below: Axes, stages: dict[str, float], end: float, height: float) -> None:
    edges = [0.0, stages["free fall"], stages["pull-down"], stages["touchdown"], stages["lowest point"], end]
    names = ["release", "pay-out", "pull-down", "coasting", "rise"]
    for start, stop, name in zip(edges, edges[1:], names, strict=False):
        if start > 0.0:
            for axes in (above, below):
                axes.axvline(start, color=GREY, linewidth=0.8, linestyle=":")
        if stop - start > 0.02 * end:
            narrow = stop - start < 0.11 * end
            above.text(
                0.5 * (start + stop),
                height,
                name,
                ha="center",
                va="top",
                fontsize=8.5,
                rotation=90 if narrow else 0,
            )


def drift(sizing: AnchorSizing) -> Figure:
    """Draw the drift of both bodies through the layers, in plan and in elevation."""
    profile = sizing.anchor.profile
    figure = MatplotlibFigure(figsize=(6.0, 3.6))
    plan, side = figure.subplots(1, 2)
    until = profile.time <= profile.stages["touchdown"]
    tracks = {"anchor": (profile.anchor_track, profile.anchor_depth, ORANGE)}
    tracks["vehicle"] = (profile.vehicle_track, profile.vehicle_depth, BLUE)
    plan.add_patch(Circle((0.0, 0.0), sizing.radius, fill=False, color=PINK, linewidth=1.2, linestyle=(0, (4, 3))))
    plan.text(0.0, 1.04 * sizing.radius, f"radius {sizing.radius:.1f} m", ha="center", va="bottom", fontsize=8.5)
    plan.plot(0.0, 0.0, "o", color=INK, markersize=4)
    plan.annotate("last fix", (0.0, 0.0), (-1.0, -1.5), ha="right", va="top", fontsize=8.5)
    for name, (track, depth, colour) in tracks.items():
        away = np.hypot(track[0], track[1])
        plan.plot(track[0, until], track[1, until], color=colour, linewidth=2.6 if name == "anchor" else 1.3)
        side.plot(away[until], depth[until], color=colour)
    end = profile.record.offset[:, 0]
    plan.plot(*end, "x", color=ORANGE, markersize=7, markeredgewidth=2.0)
    plan.annotate(
        f"{sizing.anchor.offset:.1f} m", end, (0, -9), textcoords="offset points", ha="right", va="top", fontsize=8.5
    )
    limit = 1.28 * max(sizing.radius, sizing.anchor.offset)
    plan.set(xlim=(-limit, limit), ylim=(-limit, limit), aspect="equal", xlabel="East (m)", ylabel="North (m)")
    plan.set_title("Plan")
    edge = 0.0
    for layer in sizing.layers[:-1]:
        edge += layer.thickness
        side.axhline(edge, color=SKY, linewidth=1.0)
        side.text(0.0, edge, "edge of a layer", va="bottom", fontsize=8.5)
    side.axhline(sizing.depth, color=GREY, linewidth=2.0)
    side.axvline(sizing.radius, color=PINK, linewidth=1.2, linestyle=(0, (4, 3)))
    middle = int(np.flatnonzero(until)[-1] * 0.62)
    for name, (track, depth, colour) in tracks.items():
        at = (float(np.hypot(track[0, middle], track[1, middle])), float(depth[middle]))
        left = name == "anchor"
        offset = (-7, -3) if left else (7, 3)
        side.annotate(
            name, at, offset, textcoords="offset points", color=colour, ha="right" if left else "left", fontsize=9
        )
    side.set(
        xlabel="Distance from the last fix (m)", ylabel="Depth (m)", ylim=(1.06 * sizing.depth, -0.04 * sizing.depth)
    )
    side.set_xlim(0.0, 1.1 * max(sizing.radius, sizing.anchor.offset))
    side.set_title("Elevation")
    return to_figure(
        figure,
        "drift",
        alt=(
            f"Drift of anchor and vehicle from the last fix to touchdown: {sizing.anchor.offset:.1f} m, "
            f"with the allowed radius of {sizing.radius:.1f} m"
        ),
        caption="The nominal dive with the mean currents: each body goes with its layer. Cross: the anchor.",
    )
