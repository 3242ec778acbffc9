"""Drawing of an anchor in section, to scale, in millimetres from its tip."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure
from matplotlib.patches import Polygon, Rectangle, Wedge

from missionplan.physics.anchor import AnchorDesign, cap_height
from missionplan.report.page import BLUE, GREEN, GREY, INK, ORANGE, SKY, YELLOW, Figure, to_figure
from missionplan.report.quantities import quantity

_MM = 1e3
_RING_WIDTH = 0.012
"""Width [m] with which the trim ring is drawn; its thickness follows from its mass."""
_DARK_YELLOW = "#8a6100"


def drawing(design: AnchorDesign) -> Figure:
    """Draw an anchor in section."""
    figure = MatplotlibFigure(figsize=(6.0, 4.0))
    axes = figure.subplots()
    _draw_nose(axes, design)
    _draw_front(axes, design)
    _draw_bands(axes, design)
    _label_parts(axes, design)
    _mark_centre(axes, design, design.centre_of_buoyancy, "centre of buoyancy", "o", side=1.0)
    _mark_centre(axes, design, design.centre_of_gravity, "centre of gravity", "+", side=-1.0)
    _draw_dimensions(axes, design)
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


def _draw_front(axes: Axes, design: AnchorDesign) -> None:
    """Draw the front as a hemispherical shell of its mass."""
    front, radius = design.problem.construction.front, design.problem.radius
    shell = front.mass / front.density / (2.0 * math.pi * radius**2)
    r = radius * _MM
    axes.add_patch(Wedge((r, 0.0), r, 90.0, 270.0, width=min(shell * _MM, r), facecolor=BLUE, linewidth=0.0))


@dataclass(frozen=True)
class _Band:
    """A hollow cylinder: start from the tip, length, depth below the anchor's surface and thickness [m]."""

    start: float
    length: float
    below: float
    thickness: float
    colour: str


def _bands(design: AnchorDesign) -> Iterator[_Band]:
    """Yield tube, back and, where there is one, trim ring, as thick as their masses make them."""
    made, radius = design.problem.construction, design.problem.radius
    wall = made.tube_mass_per_length / made.tube_density / (2.0 * math.pi * radius)
    yield _Band(radius, max(design.cylinder_length, 0.0), 0.0, wall, YELLOW)
    depth = 2.0 * made.back.centre
    back = made.back.mass / made.back.density / (2.0 * math.pi * (radius - wall) * depth)
    yield _Band(design.length - depth, depth, wall, back, GREEN)
    if _has_ring(design):
        ring = design.trim_mass / made.trim_density / (2.0 * math.pi * (radius - wall) * _RING_WIDTH)
        yield _Band(design.trim_position - 0.5 * _RING_WIDTH, _RING_WIDTH, wall, ring, ORANGE)


def _has_ring(design: AnchorDesign) -> bool:
    return design.trim_mass > 0.0 and _is_inside(design, design.trim_position)


def _is_inside(design: AnchorDesign, place: float) -> bool:
    """Whether a place [m from the tip] lies in the anchor: of one that cannot be built it need not."""
    return 0.0 <= place <= design.length


def _draw_bands(axes: Axes, design: AnchorDesign) -> None:
    """Draw tube, back and ring, mirrored about the axis."""
    for band in _bands(design):
        for sign in (1.0, -1.0):
            edge = sign * (design.problem.radius - band.below) * _MM
            size = (band.length * _MM, -sign * band.thickness * _MM)
            axes.add_patch(Rectangle((band.start * _MM, edge), *size, facecolor=band.colour, zorder=4))


def _label_parts(axes: Axes, design: AnchorDesign) -> None:
    r, end = design.problem.radius * _MM, design.length * _MM
    top = r + 6.0
    axes.text(0.25 * r, top - 0.25 * r, "front", color=BLUE, ha="right", fontsize=8.5)
    axes.text(r + 4.0, top, "tube", color=_DARK_YELLOW, ha="left", fontsize=8.5)
    axes.text(end, top, "back", color=GREEN, ha="right", fontsize=8.5)
    if _has_ring(design):
        label = f"ring {quantity(design.trim_mass, 'kg', '.2f')}"
        axes.text(design.trim_position * _MM, top, label, color=ORANGE, ha="center", fontsize=8.5)


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


def _draw_dimensions(axes: Axes, design: AnchorDesign) -> None:
    """Draw lengths with arrows, and set the limits about them."""
    r, end = design.problem.radius * _MM, design.length * _MM
    below = -r - 12.0
    _dimension(axes, 0.0, end, below - 16.0, f"{end:.0f} mm")
    _dimension(axes, r, end, below, f"C = {design.cylinder_length * _MM:.1f} mm")
    if _has_ring(design):
        ring = design.trim_position * _MM
        _dimension(axes, 0.0, ring, r + 24.0, f"ring at {ring:.1f} mm")
    axes.set(xlim=(-14.0, end + 62.0), ylim=(below - 26.0, r + 36.0), xlabel="From the tip (mm)", aspect="equal")


def _dimension(axes: Axes, start: float, end: float, height: float, label: str) -> None:
    axes.annotate("", (start, height), (end, height), arrowprops={"arrowstyle": "<->", "color": INK, "linewidth": 0.8})
    axes.text(0.5 * (start + end), height + 1.5, label, ha="center", va="bottom", fontsize=8.5)
