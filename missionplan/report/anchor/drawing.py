"""To scale: an anchor in section, in millimetres from its tip, and a mooring's vehicle on its line."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure
from matplotlib.patches import Polygon, Rectangle, Wedge

from missionplan.arrays import Array
from missionplan.physics.anchor import AnchorDesign, cap_height
from missionplan.report.axes import column_of_panels, name_axis
from missionplan.report.page import BLUE, GREEN, GREY, INK, ORANGE, SKY, YELLOW, Figure, PageSection, Table, to_figure
from missionplan.report.quantities import quantity
from missionplan.report.wording import capitalised, phase_in_words
from missionplan.results.whereabouts import HeldState, HeldVehicle

_MM = 1e3
_RING_WIDTH = 0.012
"""Width [m] with which the trim ring is drawn; its thickness follows from its mass."""
_DARK_YELLOW = "#8a6100"


def drawing(design: AnchorDesign) -> Figure:
    """Draw an anchor in section."""
    figure = MatplotlibFigure(figsize=(6.0, 4.0))
    axes = figure.subplots()
    _draw_nose(axes, design)
    _draw_parts(axes, design)
    _mark_centre(axes, design, design.centre_of_buoyancy, "centre of buoyancy", "o", side=1.0)
    _mark_centre(axes, design, design.centre_of_gravity, "centre of gravity", "+", side=-1.0)
    r, end = design.problem.radius * _MM, design.length * _MM
    below = -r - 12.0  # lengths with arrows, and the limits about them
    _dimension(axes, 0.0, end, below - 16.0, f"{end:.0f} mm")
    _dimension(axes, r, end, below, f"C = {design.cylinder_length * _MM:.1f} mm")
    if _has_ring(design):
        place = design.trim_position * _MM
        _dimension(axes, 0.0, place, r + 24.0, f"ring at {place:.1f} mm")
    axes.set(xlim=(-14.0, end + 62.0), ylim=(below - 26.0, r + 36.0), xlabel="From the tip (mm)", aspect="equal")
    axes.grid(visible=False)
    axes.set_yticks([])
    axes.spines["left"].set_visible(False)
    built = "" if design.feasible else " It cannot be built; what would lie outside it is not drawn."
    ring = f", a trim ring at {design.trim_position * _MM:.0f} mm from the tip" if _has_ring(design) else ""
    return to_figure(
        figure,
        "anchor",
        alt=(
            f"Section of the anchor: a round front, a tube of {design.cylinder_length * _MM:.0f} mm{ring}, "
            "a back that takes in the vehicle's nose"
        ),
        caption=(
            "The anchor in section, to scale. Front, tube and back stand for their masses; their shapes inside are "
            f"drawn, not designed. Attached and dry, it neither sinks nor trims the vehicle.{built}"
        ),
    )


def _draw_nose(axes: Axes, design: AnchorDesign) -> None:
    """Draw the vehicle's nose, part of it inside the anchor."""
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


def _draw_parts(axes: Axes, design: AnchorDesign) -> None:
    """Draw front, tube, back and, where there is one, trim ring, as thick as their masses make them."""
    made, radius = design.problem.construction, design.problem.radius
    r, end = radius * _MM, design.length * _MM
    top = r + 6.0

    def band(start: float, length: float, below: float, thickness: float, colour: str) -> None:
        """Draw a hollow cylinder: start from the tip, length, depth below the anchor's surface and thickness [m]."""
        for sign in (1.0, -1.0):
            size = (length * _MM, -sign * thickness * _MM)
            edge = sign * (radius - below) * _MM
            axes.add_patch(Rectangle((start * _MM, edge), *size, facecolor=colour, zorder=4))

    shell = made.front.mass / made.front.density / (2.0 * math.pi * radius**2)  # a hemisphere
    axes.add_patch(Wedge((r, 0.0), r, 90.0, 270.0, width=min(shell * _MM, r), facecolor=BLUE, linewidth=0.0))
    axes.text(0.25 * r, top - 0.25 * r, "front", color=BLUE, ha="right", fontsize=8.5)
    wall = made.tube_mass_per_length / made.tube_density / (2.0 * math.pi * radius)
    band(radius, max(design.cylinder_length, 0.0), 0.0, wall, YELLOW)
    axes.text(r + 4.0, top, "tube", color=_DARK_YELLOW, ha="left", fontsize=8.5)
    depth = 2.0 * made.back.centre
    band(design.length - depth, depth, wall, made.back.mass / made.back.density / _around(radius, wall, depth), GREEN)
    axes.text(end, top, "back", color=GREEN, ha="right", fontsize=8.5)
    if _has_ring(design):
        thickness = design.trim_mass / made.trim_density / _around(radius, wall, _RING_WIDTH)
        band(design.trim_position - 0.5 * _RING_WIDTH, _RING_WIDTH, wall, thickness, ORANGE)
        label = f"ring {quantity(design.trim_mass, 'kg', '.2f')}"
        axes.text(design.trim_position * _MM, top, label, color=ORANGE, ha="center", fontsize=8.5)


def _around(radius: float, wall: float, width: float) -> float:
    """Area inside the tube over a width of it [m²]."""
    return 2.0 * math.pi * (radius - wall) * width


def _has_ring(design: AnchorDesign) -> bool:
    return design.trim_mass > 0.0 and _is_inside(design, design.trim_position)


def _is_inside(design: AnchorDesign, place: float) -> bool:
    """Whether a place [m from the tip] lies in the anchor: of one that cannot be built it need not."""
    return 0.0 <= place <= design.length


def _mark_centre(axes: Axes, design: AnchorDesign, place: float, label: str, marker: str, *, side: float) -> None:
    """Mark a point on the axis [m], its label above (side 1) or below (-1)."""
    if not _is_inside(design, place):
        return
    x, r = place * _MM, design.problem.radius * _MM
    axes.plot(x, 0.0, marker, color=INK, markerfacecolor="none", markersize=10, markeredgewidth=1.3, zorder=6)
    axes.annotate(
        f"{label}\n{x:.1f} mm",
        (x, side * 2.5),
        (x - 4.0, side * 0.42 * r),
        ha="right",
        va="center",
        fontsize=8.5,
        arrowprops={"arrowstyle": "-", "color": INK, "linewidth": 0.7, "shrinkA": 1, "shrinkB": 3},
        zorder=6,
    )


def _dimension(axes: Axes, start: float, end: float, height: float, label: str) -> None:
    axes.annotate("", (start, height), (end, height), arrowprops={"arrowstyle": "<->", "color": INK, "linewidth": 0.8})
    axes.text(0.5 * (start + end), height + 1.5, label, ha="center", va="bottom", fontsize=8.5)


_CAP = np.linspace(-0.5 * math.pi, 0.5 * math.pi, 24)


def hold_section(hold: HeldVehicle, *, alone: bool = True) -> PageSection:
    """Present how the vehicle stands on its line; the heading names the mooring where it is not the only one."""
    worst = hold.states[-1]
    where = "In" if alone else f"{capitalised(phase_in_words(hold.phase))}: in"
    heading = (
        f"{where} the {worst.current} ({quantity(worst.speed, 'm/s', '.2f')}) the nose stands "
        f"{quantity(worst.nose_altitude, 'm', '.1f')} above "
        f"the bottom, {quantity(worst.excursion, 'm', '.1f')} from the anchor, which "
        f"{'holds' if worst.holding_margin >= 0.0 else 'drags'}"
    )
    states = _apart(hold)
    table = Table(
        ("", *(state.current for state in states)),
        [(label, *map(cell, states)) for label, cell in _ROWS],
        _held_by(hold),
    )
    return PageSection(heading, [hold_figure(hold), table, *hold.remedies])


def _held_by(hold: HeldVehicle) -> str:
    """Write what holds the vehicle where it is, and what of it the mission does not say."""
    words = f"{quantity(hold.anchor_weight, 'N', '.3g')} wet and a holding factor of {hold.friction:g}"
    if hold.friction_assumed:
        words += " (assumed: 0.2 on clay to 0.6 on sand)"
    if hold.centres_assumed:
        words += ", the net buoyancy at mid-length (assumed: centre_of_gravity, centre_of_buoyancy)"
    if hold.if_polyester is None:
        return f"With an anchor of {words}."
    nose = quantity(hold.if_polyester, "m", ".2f")
    return (
        f"With an anchor of {words}. The line is taken as weightless (line_material): of polyester, the nose would "
        f"stand {nose} above the bottom in the {hold.states[-1].current}."
    )


_ROWS: tuple[tuple[str, Callable[[HeldState], str]], ...] = (
    ("Current at the anchor", lambda state: quantity(state.speed, "m/s", ".3f")),
    ("Nose above the seafloor", lambda state: quantity(state.nose_altitude, "m", ".2f")),
    ("Tail above the seafloor", lambda state: quantity(state.tail_altitude, "m", ".2f")),
    ("Nose from the anchor", lambda state: quantity(state.excursion, "m", ".2f")),
    ("Pitch, nose down", lambda state: f"{math.degrees(state.pitch):.0f} °"),
    ("Line from the vertical, at the anchor", lambda state: f"{math.degrees(state.line_angle):.0f} °"),
    ("Line tension at the nose", lambda state: quantity(state.tension_at_nose, "N", ".2f")),
    ("Line tension at the anchor", lambda state: quantity(state.tension_at_anchor, "N", ".2f")),
    ("Anchor's own drag", lambda state: quantity(state.anchor_drag, "N", ".2f")),
    ("Holding factor that it needs", lambda state: _or_none(state.friction_needed, f"{state.friction_needed:.2f}")),
    ("Holding margin", lambda state: f"{state.holding_margin:.2f}"),
    (
        "Wet weight of this size that just holds",
        lambda state: _or_none(state.least_weight, quantity(state.least_weight, "N", ".1f")),
    ),
)


def _apart(hold: HeldVehicle) -> tuple[HeldState, ...]:
    """States in different currents: where the current stays as it is, the last says it all."""
    *others, worst = hold.states
    return (*(state for state in others if f"{state.speed:.3f}" != f"{worst.speed:.3f}"), worst)


def _or_none(value: float, words: str) -> str:
    return words if math.isfinite(value) else "none holds"


def hold_figure(hold: HeldVehicle) -> Figure:
    """Draw body, line and anchor to scale in each current, seen across it."""
    reach = max(max(state.tail[0], state.excursion) for state in hold.states)
    top = max(0.3 * reach, *(max(state.tail[1], state.line[-1, 1]) for state in hold.states))
    left, right = -0.12 * max(reach, top) - 0.3, 1.08 * reach + 0.5
    low = min(-0.06 * top - 0.1, *(state.uphill * side for state in hold.states for side in (left, right)))
    height = min(4.0, 5.25 * (1.25 * top - low) / (right - left))
    figure, (axes,) = column_of_panels(6.0, [height], (0.6, 0.15, 0.8, 0.1))
    rise = hold.states[-1].uphill
    axes.fill_between([left, right], [rise * left, rise * right], -1e3, color=GREY, alpha=0.25, linewidth=0.0)
    axes.plot([left, right], [rise * left, rise * right], color=GREY, linewidth=1.5)
    length, radius = hold.anchor_length, 0.5 * hold.anchor_diameter  # it lies with its back towards the line
    outline = np.array([0.0, radius]) - _capsule(length, radius, blunt=True)
    axes.add_patch(Polygon(outline, closed=True, facecolor=ORANGE, linewidth=0.0, zorder=5))
    label: dict[str, Any] = {"textcoords": "offset points", "color": ORANGE, "ha": "right", "fontsize": 9}
    axes.annotate("anchor", (-0.5 * length, 2.0 * radius), (-4, 8), **label)
    for state, colour in reversed(list(zip(reversed(_apart(hold)), (BLUE, SKY), strict=False))):
        nose = np.array([float(state.line[-1, 0]), float(state.line[-1, 1])])
        axes.plot(state.line[:, 0], state.line[:, 1], color=INK, linewidth=0.9)
        axis = (np.array(state.tail) - nose) / hold.length
        turn = np.array([axis, [-axis[1], axis[0]]])
        outline = nose + _capsule(hold.length, 0.5 * hold.diameter) @ turn
        named = f"{state.current}, {quantity(state.speed, 'm/s', '.2f')}"
        axes.add_patch(Polygon(outline, closed=True, facecolor=colour, linewidth=0.0, zorder=4, label=named))
    tail, tip, words = (left + part * (right - left) for part in (0.02, 0.25, 0.27))
    arrow = {"arrowstyle": "->", "color": INK, "linewidth": 1.2}
    axes.annotate("", (tip, 1.16 * top), (tail, 1.16 * top), arrowprops=arrow)
    axes.text(words, 1.16 * top, "current", va="center", fontsize=9)
    axes.set(xlim=(left, right), ylim=(low, 1.25 * top), aspect="equal")
    name_axis(axes.xaxis, "Downstream of the anchor", "m")
    name_axis(axes.yaxis, "Above the anchor", "m")
    figure.legend(loc="lower center", ncols=2)
    listed = "; ".join(
        f"{state.current} of {quantity(state.speed, 'm/s', '.2f')}: nose "
        f"{quantity(state.nose_altitude, 'm', '.1f')} above the bottom and "
        f"{quantity(state.excursion, 'm', '.1f')} downstream, tail {quantity(state.tail_altitude, 'm', '.1f')} above it"
        for state in hold.states
    )
    return to_figure(
        figure,
        f"hold-{hold.phase}" if hold.phase != "moor" else "hold",
        alt=f"Vehicle, line and anchor to scale. {capitalised(listed)}",
        caption="Vehicle, line and anchor to scale, every distribution at its mean, each current in its own direction.",
    )


def _capsule(length: float, radius: float, *, blunt: bool = False) -> Array:
    """Outline of a round-ended body from its tip at the origin along the first axis, shape (k, 2) [m]."""
    front = np.column_stack((radius - radius * np.cos(_CAP), radius * np.sin(_CAP)))
    if blunt:
        return np.concatenate((front, [[length, radius], [length, -radius]]))
    back = np.column_stack((length - radius + radius * np.cos(_CAP), -radius * np.sin(_CAP)))
    return np.concatenate((front, back))
