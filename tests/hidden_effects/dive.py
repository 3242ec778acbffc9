"""One dive: pay-out, snatch, pull-down, touchdown, coasting and rising, by DOP853 with events."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import prod

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from .drag import Craft

Array = NDArray[np.float64]
STEP = 0.02
"""Spacing of the returned track [s]."""
LINE_LOSS = 0.06
"""Time over which an elastic line damps its stretching [s]: rubber gives back some two thirds of the energy."""


@dataclass(frozen=True)
class Dive:
    """One run as it really was."""

    wet_weight: float
    line: float
    site_depth: float
    drag_factor: float = 1.0
    number: int = 0


@dataclass(frozen=True)
class Twist:
    """What an effect changes in a dive; every field is neutral by default.

    Times count from the anchor's separation (`weight`) or from the taut line (the others).
    """

    lone_drag: float = 1.0
    drag: Callable[[float, float, float, int], float] | None = None
    """Factor on both bodies' drag from time, speed through the water, depth and the dive's number."""
    resist: Callable[[float, float], float] | None = None
    """Extra force against the motion [N] from time and speed through the water."""
    weight: Callable[[float, float], float] | None = None
    """Factor on the wet weight from time and depth."""
    lift: Callable[[float], float] | None = None
    """Upward force [N] from depth."""
    mass: float = 1.0
    water: Callable[[float, float], float] | None = None
    """Downward velocity of the water [m/s] from time and depth."""
    delay: Callable[[float, int], float] | None = None
    """Lateness on the log's clock [s] from the line's length and the dive's number."""
    hold: tuple[float, float] | None = None
    """Share of the way to touchdown at which the vehicle is stopped, and for how long [s]."""
    line: Callable[[int], float] | None = None
    """Factor on the length of line that runs out from the dive's number."""
    stretch: Callable[[float], float] | None = None
    """How far the line gives under load [m/N] from its length."""
    reading: Callable[[Array, Array, int], Array] | None = None
    """Depth read, from time and true depth on the track's uniform grid and the dive's number."""
    pitch: Callable[[Array], Array] | None = None
    """Departure of the pitch from nose down [deg]."""


@dataclass(frozen=True)
class Track:
    """Depth of the vehicle's nose against time since separation, on a uniform grid from zero."""

    t: Array
    depth: Array
    t_taut: float
    t_touchdown: float


def _fall(rate: Callable[[float, Array], list[float]], start: tuple[float, ...], end: float, event):
    """Integrate until the event or the end: solution, end time, end state, whether the event came."""
    event.terminal = True
    t0, *y0 = start
    run = solve_ivp(rate, (t0, end), y0, "DOP853", events=event, dense_output=True, rtol=1e-8, atol=1e-9, max_step=0.5)
    if not run.success:
        raise RuntimeError(f"integration failed: {run.message}")
    return run.sol, float(run.t[-1]), run.y[:, -1], run.status == 1


class _Motion:
    """Rates of depth and speed in each stage of a dive; times count from the separation."""

    def __init__(self, craft: Craft, dive: Dive, twists: Sequence[Twist]) -> None:
        self.craft = craft
        self.dive = replace(dive, line=dive.line * prod(twist.line(dive.number) for twist in twists if twist.line))
        self.give = sum(twist.stretch(self.dive.line) for twist in twists if twist.stretch)
        self.lone = dive.drag_factor * prod(twist.lone_drag for twist in twists)
        self.drags = [twist.drag for twist in twists if twist.drag]
        self.resists = [twist.resist for twist in twists if twist.resist]
        self.weights = [twist.weight for twist in twists if twist.weight]
        self.lifts = [twist.lift for twist in twists if twist.lift]
        self.waters = [twist.water for twist in twists if twist.water]
        self.joint = (craft.anchor_mass + craft.vehicle_mass) * prod(twist.mass for twist in twists)
        self.bottom = dive.site_depth - self.dive.line
        self.t_taut = 0.0

    def weight(self, t: float, z: float) -> float:
        """The anchor's."""
        return self.dive.wet_weight * prod(factor(t, z) for factor in self.weights)

    def buoyancy(self, z: float) -> float:
        """The vehicle's."""
        return self.craft.net_buoyancy + sum(lift(z) for lift in self.lifts)

    def tension(self, stretch: float, opening: float) -> float:
        """The line's."""
        return max(0.0, (stretch + LINE_LOSS * opening) / self.give) if self.give and stretch > 0.0 else 0.0

    def through_water(self, since: float, y: Array) -> tuple[float, float]:
        """Speed, and the factor on drag there."""
        u = y[1] - sum(water(since, y[0]) for water in self.waters)
        return u, self.dive.drag_factor * prod(factor(since, u, y[0], self.dive.number) for factor in self.drags)

    def alone(self, t: float, y: Array) -> list[float]:
        """The anchor, while the line runs out."""
        return [y[1], (self.weight(t, 0.0) - self.lone * self.craft.anchor_drag(y[1])) / self.craft.anchor_mass]

    def together(self, t: float, y: Array) -> list[float]:
        """Both bodies as one."""
        since, z = t - self.t_taut, y[0]
        u, factor = self.through_water(since, y)
        force = self.weight(t, z) - self.buoyancy(z)
        force -= factor * self.craft.drag(u) + sum(resist(since, u) for resist in self.resists)
        return [y[1], force / self.joint]

    def apart(self, t: float, y: Array) -> list[float]:
        """As ``together``, with the stretch and its rate after the vehicle's depth and speed."""
        since, z = t - self.t_taut, y[0]
        u, factor = self.through_water(since, y)
        pull = self.tension(y[2], y[3])
        ahead = (self.weight(t, z) - factor * self.craft.anchor_drag(u + y[3]) - pull) / self.craft.anchor_mass
        force = pull - self.buoyancy(z)
        force -= factor * self.craft.vehicle_drag(u) + sum(resist(since, u) for resist in self.resists)
        behind = force / (self.joint - self.craft.anchor_mass)
        return [y[1], behind, y[3], ahead - behind]

    def moored(self, t: float, y: Array) -> list[float]:
        """The vehicle above the anchor on the seafloor."""
        force = self.tension(self.bottom - y[0], -y[1]) - self.buoyancy(y[0])
        return [y[1], (force - self.dive.drag_factor * self.craft.vehicle_drag(y[1])) / self.craft.vehicle_mass]

    def after_snatch(self, speed: float) -> list[float]:
        """State of ``together`` or ``apart`` when the line is taut and the anchor has a speed."""
        return [0.0, 0.0, 0.0, speed] if self.give else [0.0, self.craft.anchor_mass * speed / self.joint]


def sink(craft: Craft, dive: Dive, twists: Sequence[Twist] = (), end: float = 120.0, followed: bool = True) -> Track:
    """Follow one dive until ``end`` seconds after the separation.

    ``dive.drag_factor`` multiplies the drag of both bodies throughout. The depth of the nose is zero until the line
    is taut; the anchor touches down when the nose is one line's length above the seafloor. A dive that is not
    ``followed`` stays where it is at touchdown. With a line that stretches the two bodies are followed apart, joined
    by its tension; there is no snatch then.
    """
    motion = _Motion(craft, dive, twists)
    line, bottom = motion.dive.line, motion.bottom
    _, t_taut, state, _ = _fall(motion.alone, (0.0, 0.0, 0.0), 600.0, lambda t, y: y[0] - line)
    motion.t_taut = t_taut
    descend = motion.apart if motion.give else motion.together
    start = motion.after_snatch(state[1])
    pieces: list[tuple[float, Callable[[Array], Array]]] = []
    stop = next((twist.hold for twist in twists if twist.hold), None)
    t_now = t_taut
    if stop is not None:
        ledge = stop[0] * bottom
        solution, t_now, state, _ = _fall(descend, (t_now, *start), end, lambda t, y: y[0] - ledge)
        pieces.append((t_now, solution))
        start = [float(state[0])] + [0.0] * (len(start) - 1)
        t_now += stop[1]
        pieces.append((t_now, lambda t, z=start[0]: np.array([np.full_like(t, z)])))
    t_touchdown = float("inf")
    if t_now < end:
        # depth of the vehicle, and the stretch if there is one, are the even entries
        solution, t_now, state, down = _fall(descend, (t_now, *start), end, lambda t, y: sum(y[::2]) - bottom)
        pieces.append((t_now, solution))
        if down:
            t_touchdown = t_now
            rest = [(end, lambda t: np.array([np.full_like(t, state[0])]))]
            pieces += _after_touchdown(motion.moored, motion.dive, t_now, state, end) if followed else rest
    return _assemble(pieces, t_taut, t_touchdown, end)


def _after_touchdown(coast: Callable[[float, Array], list[float]], dive: Dive, t: float, state: Array, end: float):
    """Coast to rest (or to the seafloor), rise under net buoyancy, and hang at the line's length.

    A vehicle that has become heavier than water stays on the seafloor.
    """

    def halt(t: float, y: Array) -> float:
        return min(y[1], dive.site_depth - y[0])

    bottom = dive.site_depth - dive.line
    solution, t_low, state, _ = _fall(coast, (t, state[0], state[1]), end, halt)
    pieces = [(t_low, solution)]
    t_up = t_low
    if coast(t_low, np.array([state[0], 0.0]))[1] >= 0.0:
        return [*pieces, (end, lambda t: np.array([np.full_like(t, state[0])]))]
    if t_low < end:
        solution, t_up, state, _ = _fall(coast, (t_low, state[0], 0.0), end, lambda t, y: y[0] - bottom)
        pieces.append((t_up, solution))
    if t_up < end:
        pieces.append((end, lambda t: np.array([np.full_like(t, bottom)])))
    return pieces


def _assemble(pieces, t_taut: float, t_touchdown: float, end: float) -> Track:
    t = np.arange(0.0, end, STEP)
    depth = np.zeros_like(t)
    begin = t_taut
    for until, solution in pieces:
        inside = (t >= begin) & (t < until)
        if inside.any():
            depth[inside] = solution(t[inside])[0]
        begin = until
    return Track(t, depth, t_taut, t_touchdown)
