"""A body that hangs by its nose on a line, what lines are made of, and how one hangs between the body and its anchor.

The line is followed down from the body in pieces along each of which weight and drag per length are taken as constant,
so that a piece is an elastic catenary in closed form, whatever its slack (Irvine 1981, *Cable Structures*, sect. 1.4).
Drag is that of the current's components across and along it (Hoerner 1965, ch. III). What would hang deeper than its
lowest level place lies on the seafloor, straight, level and without friction; what floats lift of it rises from there
and comes down again. `docs/mooring.md` has the equations and their limits.

Densities of materials: *Synthetic fibre yarn properties*, Tension Technology International; of steel 7850 kg/m³.
Quasi-static stiffness and strength of ropes: the default coefficients of MoorPy (Hall et al., NREL,
doi:10.11578/dc.20210726.1), fitted to makers' catalogues of thicker ropes; aramid's from its yarn (49 and 2.0 N/tex),
of which a rope has half the stiffness and a third of the strength.

Vectors are east, north and up; trials are the last axis.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars
from missionplan.physics.drag import DragLaw
from missionplan.physics.seafloor import LayersAbove
from missionplan.physics.water import STANDARD_GRAVITY

LINE_COEFFICIENT = 1.2
"""C_d of a line across the flow, on its diameter: a smooth cylinder at Re 10³ to 10⁵ (Hoerner 1965, ch. III); one that
is set swinging by its wake has up to twice as much."""
_ALONG = 0.02 / LINE_COEFFICIENT
"""Drag along a line over that across it: friction of 0.02 on length × diameter (the same, on inclined cables)."""
_PIECES = 8
"""In which a line with drag is followed, between its ends and floats; without drag one is exact."""
_WEAKEST = 1e-12
"""Tension that keeps a slack line's direction finite [N]."""
_CURVED = 0.01
"""Square of the bend (see `_span`) below which five terms of the series are exact to 1e-11."""


@dataclass(frozen=True)
class Float:
    """Buoyancy on the line; each number is a float or an array over trials."""

    distance: Scalars
    """From the body along the line [m]."""
    buoyancy: Scalars
    """In water [N]."""


@dataclass(frozen=True)
class HeldLine:
    """The line; each number is a float or an array over trials, shape (n,)."""

    length: Scalars
    """Unstretched [m]."""
    drag_factor: Scalars = 0.0
    """½ ρ C_d d: drag per length across the flow over the speed squared; see `line_drag_factor` [kg/m²]."""
    wet_weight: Scalars = 0.0
    """Per length in water; negative where it floats [N/m]."""
    compliance: Scalars = 0.0
    """1/EA, stretch per length and tension [1/N]."""
    floats: tuple[Float, ...] = ()
    """From the body on."""


def line_drag_factor(diameter: Scalars, density: Scalars) -> Scalars:
    """Return ½ ρ C_d d [kg/m²] of a line from its diameter [m] and the water's density [kg/m³]."""
    return 0.5 * density * LINE_COEFFICIENT * diameter


@dataclass(frozen=True)
class LowPoint:
    """The deepest place before a float at which a line is level."""

    number: NDArray[np.intp]
    """Of the points of the line that come before it, shape (n,)."""
    distance: Array
    """From the body along the line, shape (n,) [m]."""
    fallen: Array
    tension: Array
    """Shape (3, n). From there to the body [m], and the tension there [N]. Without such a place it is infinitely high.
    """

    @classmethod
    def none(cls, trials: int) -> "LowPoint":
        """Return that of lines that are level nowhere."""
        high = np.zeros((3, trials))
        high[2] = -np.inf
        return cls(np.zeros(trials, dtype=np.intp), np.zeros(trials), high, np.zeros((3, trials)))

    def deeper(self, other: "LowPoint") -> "LowPoint":
        """Return the deeper of two, by trial."""
        is_deeper = other.fallen[2] > self.fallen[2]
        pairs = ((getattr(self, name), getattr(other, name)) for name in ("number", "distance", "fallen", "tension"))
        return LowPoint(*(np.where(is_deeper, new, old) for old, new in pairs))


@dataclass(frozen=True)
class HungLine:
    """A line that was followed from the body."""

    fallen: Array
    """From points of the line, the anchor last, to the body, shape (k, 3, n) [m]."""
    load: Array
    """With which it pulls the anchor, shape (3, n) [N]."""
    low: LowPoint

    @property
    def lowest(self) -> Array:
        """How far its lowest point but the first hangs below the body, shape (n,) [m]."""
        return np.asarray(np.maximum(self.fallen[-1, 2], self.low.fallen[2]))

    @property
    def deepest(self) -> Array:
        """The same with the first: the body's altitude where that point is on the seafloor, shape (n,) [m]."""
        return np.asarray(np.maximum(self.lowest, 0.0))


def hang(line: HeldLine, current: LayersAbove, altitude: Array, pull: Array) -> HungLine:
    """Follow a line down from a body.

    Parameters
    ----------
    altitude : array, shape (n,)
        Of the body, for the current along the line [m].
    pull : array, shape (3, n)
        With which the body pulls [N].

    Returns
    -------
    HungLine
        Where the line comes to lie level and no float is beyond, its rest lies on the seafloor.
    """
    loads = _Loads(line, current, altitude)
    tension, fallen, low = pull, np.zeros_like(pull), LowPoint.none(altitude.size)
    lies, distance = np.zeros(altitude.size, dtype=bool), np.zeros(altitude.size)
    places: list[Array] = []
    for length, lift, is_last in _segments(line):
        count = _PIECES if loads.has_drag else 1
        step = length / count
        for _ in range(count):
            piece = _piece(loads, tension, fallen, lies, step, is_last=is_last)
            lies |= piece.levels & is_last
            if not is_last and piece.levels.any():
                here = fallen + np.where(piece.levels, piece.to_level, -np.inf)
                number = np.full(altitude.size, len(places))
                low = low.deeper(LowPoint(number, distance + piece.share * step, here, piece.level))
            fallen, tension, distance = fallen + piece.moved, piece.end, distance + step
            places.append(fallen)
        tension = tension + np.array([[0.0], [0.0], [1.0]]) * lift
    return HungLine(np.stack(places), tension, low)


def _segments(line: HeldLine) -> Iterator[tuple[Scalars, Scalars, bool]]:
    """Yield the lengths between body, floats and anchor, the lift at the end of each [m, N], and whether it is last."""
    before: Scalars = 0.0
    for item in line.floats:
        after = np.clip(item.distance, before, line.length)
        yield after - before, item.buoyancy, False
        before = after
    yield line.length - before, 0.0, True


@dataclass(frozen=True)
class _Piece:
    """A piece of the line."""

    moved: Array
    end: Array
    """Shape (3, n). From its end to its beginning [m], and the tension there [N]."""
    levels: NDArray[np.bool_]
    """Whether it becomes level, shape (n,)."""
    to_level: Array
    level: Array
    """Shape (3, n). The same of the place where it does, else of its end."""
    share: Scalars
    """Of the piece, until there, float or shape (n,)."""


def _piece(
    loads: "_Loads", tension: Array, fallen: Array, lies: NDArray[np.bool_], step: Scalars, *, is_last: bool
) -> _Piece:
    """Follow one piece of the line; what `lies` bears no load. In the last segment it lies from where it is level."""
    load = np.where(lies, 0.0, loads.per_length(tension, fallen, step))
    end = tension + load * step
    levels = (end[2] <= 0.0) & (load[2] <= 0.0) & (tension[2] >= end[2])
    if not is_last:
        levels &= tension[2] > 0.0
    if not levels.any():
        moved = _span(tension, end, step, loads.line.compliance)
        return _Piece(moved, end, levels, moved, end, 1.0)
    until = np.where(levels, np.maximum(tension[2], 0.0) / np.maximum(tension[2] - end[2], _WEAKEST), 1.0)
    level = tension + load * (until * step)
    level[2] = np.where(levels, 0.0, level[2])
    onward = np.where(levels, level, end) if is_last else end
    moved = _span(tension, level, until * step, loads.line.compliance)
    rest = _span(level, onward, (1.0 - until) * step, loads.line.compliance)
    return _Piece(moved + rest, onward, levels, moved, level, until)


@dataclass(frozen=True)
class _Loads:
    """Weight and drag along a line below a body at an altitude [m]."""

    line: HeldLine
    current: LayersAbove
    altitude: Array

    @property
    def has_drag(self) -> bool:
        return bool(np.any(self.line.drag_factor))

    def per_length(self, tension: Array, fallen: Array, step: Scalars) -> Array:
        """Load along a piece as it is at its middle, shape (3, n) [N/m]."""
        weight = np.zeros_like(tension)
        weight[2] = -self.line.wet_weight
        if not self.has_drag:
            return weight
        along = direction(tension)
        velocity = self.current.at((self.altitude - fallen[2] - 0.5 * step * along[2])[None])[:, 0]
        middle = tension + 0.5 * step * (weight + self._drag(velocity, along))
        return np.asarray(weight + self._drag(velocity, direction(middle)))

    def _drag(self, velocity: Array, along: Array) -> Array:
        speed = (velocity * along[:2]).sum(axis=0)
        across = -along * speed
        across[:2] += velocity
        friction = _ALONG * np.abs(speed) * speed * along
        return np.asarray(self.line.drag_factor * (np.sqrt((across**2).sum(axis=0)) * across + friction))


def _span(start: Array, end: Array, length: Scalars, compliance: Scalars) -> Array:
    """Vector along a piece whose tension changes evenly between its ends, shape (3, n) [m].

    The integral of the tension's direction, and of the stretch: an elastic catenary. With the tensions' sum s, their
    difference as a share x of it, and g = artanh(x)/x, the direction's mean is 2/s (g T − (g − 1)/x² T·Δ Δ/s²), where T
    is the mean tension and Δ the change.
    """
    first, last = size(start), size(end)
    total = np.maximum(first + last, _WEAKEST)
    change, mean = end - start, 0.5 * (start + end)
    bend = np.minimum((change * change).sum(axis=0) / total**2, 1.0 - 1e-14)
    g = 1.0 + bend * (1 / 3 + bend * (1 / 5 + bend * (1 / 7 + bend / 9)))
    h = 1 / 3 + bend * (1 / 5 + bend * (1 / 7 + bend * (1 / 9 + bend / 11)))
    if np.max(bend) > _CURVED:
        x = np.sqrt(np.maximum(bend, _CURVED))
        g = np.where(bend > _CURVED, np.arctanh(x) / x, g)
        h = np.where(bend > _CURVED, (g - 1.0) / np.maximum(bend, _CURVED), h)
    direction = 2.0 / total * (g * mean - h * (last - first) / (2.0 * total) * change)
    return np.asarray(length * (direction + compliance * mean))


def size(vector: Array) -> Array:
    """Length of vectors, shape (n,)."""
    return np.asarray(np.sqrt((vector * vector).sum(axis=0)))


def direction(vector: Array) -> Array:
    """Unit vector, shape (3, n)."""
    return np.asarray(vector / np.maximum(size(vector), _WEAKEST))


CROSSFLOW_COEFFICIENT = 1.1
"""C_d of a long round body across the flow, on length × diameter, below the drag crisis (Hoerner 1965, ch. III)."""
_SECTIONS = 10
"""Of the body, each with the current at its middle."""


@dataclass(frozen=True)
class HeldBody:
    """A slender body held by its nose; each number is a float or an array over trials, shape (n,)."""

    length: Scalars
    diameter: Scalars
    """[m]."""
    net_buoyancy: Scalars
    """Buoyancy minus weight [N]."""
    raising_moment: Scalars
    """About the nose with the body level, buoyancy's minus weight's; positive raises the tail [N m]."""
    righting_moment: Scalars
    """About the nose with the body upright, of centres off the axis; its size counts, as the body rolls freely [N m].
    """
    crossflow_coefficient: Scalars
    """C_d on length × diameter."""
    axial_drag: DragLaw
    """Drag along the axis."""
    density: Scalars
    """Of the water [kg/m³]."""

    @property
    def section_drag(self) -> Scalars:
        """Drag of a section of the body across the flow over the speed squared [kg/m]."""
        return 0.5 * self.density * self.crossflow_coefficient * self.diameter * self.length / _SECTIONS

    @property
    def sections(self) -> Array:
        """Middles of the body's sections from its nose, shape (m, 1) or (m, n) [m]."""
        middles = (np.arange(_SECTIONS) + 0.5) / _SECTIONS
        return np.asarray(middles[:, None] * self.length)


@dataclass(frozen=True)
class LineMaterial:
    """A material of lines."""

    density: float
    """Of the material [kg/m³]."""
    filling: float
    """Share of the line's circle that it fills. Of a fibre line all of it, the most that a tight cord of this diameter
    weighs; laid and plaited ropes fill 0.63 to 0.75, and `line_wet_weight` states what was weighed."""
    stiffness: float
    """EA over the diameter squared [Pa]."""
    strength: float
    """Breaking load over the diameter squared [Pa]."""

    def wet_weight(self, diameter: Scalars, water_density: Scalars) -> Scalars:
        """Weight in water of a metre, negative where it floats [N/m]."""
        area = 0.25 * math.pi * self.filling * diameter * diameter
        return (self.density - water_density) * area * STANDARD_GRAVITY


LINE_MATERIALS: Mapping[str, LineMaterial] = {
    "polyester": LineMaterial(1380.0, 1.0, 4.31e9, 3.08e8),
    "nylon": LineMaterial(1140.0, 1.0, 1.04e9, 2.07e8),
    "aramid": LineMaterial(1440.0, 1.0, 2.0e10, 5.5e8),
    "polyethylene": LineMaterial(970.0, 1.0, 3.25e10, 5.8e8),
    "steel-wire": LineMaterial(7850.0, 0.65, 9.71e10, 1.02e9),
}
"""By the word of `line_material`. Polyethylene is that of high modulus (Dyneema, Spectra); a wire rope with a wire core
fills 0.65 of its circle."""
