"""Simulation of one dive: pay-out, snatch, pull-down, touchdown, coasting and rising, by DOP853 with events."""

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
LINE_DAMPING = 0.06
"""Damping time of an elastic line [s]: rubber returns about two thirds of the energy."""


@dataclass(frozen=True)
class Dive:
    """Actual parameters of one run."""

    wet_weight: float
    line: float
    site_depth: float
    drag_factor: float = 1.0
    number: int = 0


@dataclass(frozen=True)
class DiveEffect:
    """Changes of a dive by an effect; every field is neutral by default.

    Times are relative to the anchor's separation (`weight`) or to the taut line (the others).
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
    """Delay on the log's clock [s] from the line's length and the dive's number."""
    hold: tuple[float, float] | None = None
    """Fraction of the depth to touchdown at which the vehicle is stopped, and for how long [s]."""
    line: Callable[[int], float] | None = None
    """Factor on the length of line paid out from the dive's number."""
    stretch: Callable[[float], float] | None = None
    """Compliance of the line [m/N] from its length."""
    reading: Callable[[Array, Array, int], Array] | None = None
    """Depth reading from time and true depth on the track's uniform grid and the dive's number."""
    pitch: Callable[[Array], Array] | None = None
    """Departure of the pitch from nose down [deg]."""


@dataclass(frozen=True)
class Track:
    """Depth of the vehicle's nose against time since separation, on a uniform grid from zero."""

    t: Array
    depth: Array
    t_taut: float
    t_touchdown: float


def _integrate(rate: Callable[[float, Array], list[float]], start: tuple[float, ...], end: float, event):
    """Integrate until the event or the end: solution, end time, end state, whether the event occurred."""
    event.terminal = True
    t0, *y0 = start
    run = solve_ivp(rate, (t0, end), y0, "DOP853", events=event, dense_output=True, rtol=1e-8, atol=1e-9, max_step=0.5)
    if not run.success:
        raise RuntimeError(f"integration failed: {run.message}")
    return run.sol, float(run.t[-1]), run.y[:, -1], run.status == 1


class _Motion:
    """Rates of depth and speed in each stage of a dive; times are relative to the separation."""

    def __init__(self, craft: Craft, dive: Dive, effects: Sequence[DiveEffect]) -> None:
        self.craft = craft
        self.dive = replace(dive, line=dive.line * prod(effect.line(dive.number) for effect in effects if effect.line))
        self.give = sum(effect.stretch(self.dive.line) for effect in effects if effect.stretch)
        self.alone_drag = dive.drag_factor * prod(effect.lone_drag for effect in effects)
        self.drags = [effect.drag for effect in effects if effect.drag]
        self.resists = [effect.resist for effect in effects if effect.resist]
        self.weights = [effect.weight for effect in effects if effect.weight]
        self.lifts = [effect.lift for effect in effects if effect.lift]
        self.waters = [effect.water for effect in effects if effect.water]
        self.joint = (craft.anchor_mass + craft.vehicle_mass) * prod(effect.mass for effect in effects)
        self.bottom = dive.site_depth - self.dive.line
        self.t_taut = 0.0

    def weight(self, t: float, z: float) -> float:
        """Wet weight of the anchor [N]."""
        return self.dive.wet_weight * prod(factor(t, z) for factor in self.weights)

    def buoyancy(self, z: float) -> float:
        """Net buoyancy of the vehicle [N]."""
        return self.craft.net_buoyancy + sum(lift(z) for lift in self.lifts)

    def tension(self, stretch: float, opening: float) -> float:
        """Tension of the line [N]."""
        return max(0.0, (stretch + LINE_DAMPING * opening) / self.give) if self.give and stretch > 0.0 else 0.0

    def through_water(self, since: float, y: Array) -> tuple[float, float]:
        """Speed through the water, and the factor on drag."""
        u = y[1] - sum(water(since, y[0]) for water in self.waters)
        return u, self.dive.drag_factor * prod(factor(since, u, y[0], self.dive.number) for factor in self.drags)

    def alone(self, t: float, y: Array) -> list[float]:
        """Rates of the anchor during pay-out."""
        return [y[1], (self.weight(t, 0.0) - self.alone_drag * self.craft.anchor_drag(y[1])) / self.craft.anchor_mass]

    def together(self, t: float, y: Array) -> list[float]:
        """Rates of both bodies joined by a taut line."""
        since, z = t - self.t_taut, y[0]
        u, factor = self.through_water(since, y)
        force = self.weight(t, z) - self.buoyancy(z)
        force -= factor * self.craft.drag(u) + sum(resist(since, u) for resist in self.resists)
        return [y[1], force / self.joint]

    def apart(self, t: float, y: Array) -> list[float]:
        """As ``together`` with an elastic line: stretch and its rate follow the vehicle's depth and speed."""
        since, z = t - self.t_taut, y[0]
        u, factor = self.through_water(since, y)
        pull = self.tension(y[2], y[3])
        ahead = (self.weight(t, z) - factor * self.craft.anchor_drag(u + y[3]) - pull) / self.craft.anchor_mass
        force = pull - self.buoyancy(z)
        force -= factor * self.craft.vehicle_drag(u) + sum(resist(since, u) for resist in self.resists)
        behind = force / (self.joint - self.craft.anchor_mass)
        return [y[1], behind, y[3], ahead - behind]

    def moored(self, t: float, y: Array) -> list[float]:
        """Rates of the vehicle above the anchor on the seafloor."""
        force = self.tension(self.bottom - y[0], -y[1]) - self.buoyancy(y[0])
        return [y[1], (force - self.dive.drag_factor * self.craft.vehicle_drag(y[1])) / self.craft.vehicle_mass]

    def after_snatch(self, speed: float) -> list[float]:
        """Initial state of ``together`` or ``apart`` when the line comes taut at an anchor speed."""
        return [0.0, 0.0, 0.0, speed] if self.give else [0.0, self.craft.anchor_mass * speed / self.joint]


def simulate_dive(
    craft: Craft, dive: Dive, effects: Sequence[DiveEffect] = (), end: float = 120.0, followed: bool = True
) -> Track:
    """Simulate one dive until ``end`` seconds after the separation.

    ``dive.drag_factor`` multiplies the drag of both bodies throughout. The depth of the nose is zero until the line
    is taut; the anchor touches down when the nose is one line length above the seafloor. Unless ``followed``, the
    depth stays constant from touchdown. With an elastic line the two bodies move separately, joined by its tension,
    and there is no snatch.
    """
    motion = _Motion(craft, dive, effects)
    line, bottom = motion.dive.line, motion.bottom
    _, t_taut, state, _ = _integrate(motion.alone, (0.0, 0.0, 0.0), 600.0, lambda t, y: y[0] - line)
    motion.t_taut = t_taut
    descend = motion.apart if motion.give else motion.together
    start = motion.after_snatch(state[1])
    pieces: list[tuple[float, Callable[[Array], Array]]] = []
    stop = next((effect.hold for effect in effects if effect.hold), None)
    t_now = t_taut
    if stop is not None:
        ledge = stop[0] * bottom
        solution, t_now, state, _ = _integrate(descend, (t_now, *start), end, lambda t, y: y[0] - ledge)
        pieces.append((t_now, solution))
        start = [float(state[0])] + [0.0] * (len(start) - 1)
        t_now += stop[1]
        pieces.append((t_now, lambda t, z=start[0]: np.array([np.full_like(t, z)])))
    t_touchdown = float("inf")
    if t_now < end:
        # the even entries are the vehicle's depth and, with an elastic line, the stretch
        solution, t_now, state, down = _integrate(descend, (t_now, *start), end, lambda t, y: sum(y[::2]) - bottom)
        pieces.append((t_now, solution))
        if down:
            t_touchdown = t_now
            rest = [(end, lambda t: np.array([np.full_like(t, state[0])]))]
            pieces += _after_touchdown(motion.moored, motion.dive, t_now, state, end) if followed else rest
    return _assemble(pieces, t_taut, t_touchdown, end)


def _after_touchdown(coast: Callable[[float, Array], list[float]], dive: Dive, t: float, state: Array, end: float):
    """Coast to rest (or to the seafloor), rise under net buoyancy, and stop at the line's length.

    A vehicle that has become heavier than water stays on the seafloor.
    """

    def halt(t: float, y: Array) -> float:
        return min(y[1], dive.site_depth - y[0])

    bottom = dive.site_depth - dive.line
    solution, t_low, state, _ = _integrate(coast, (t, state[0], state[1]), end, halt)
    pieces = [(t_low, solution)]
    t_up = t_low
    if coast(t_low, np.array([state[0], 0.0]))[1] >= 0.0:
        return [*pieces, (end, lambda t: np.array([np.full_like(t, state[0])]))]
    if t_low < end:
        solution, t_up, state, _ = _integrate(coast, (t_low, state[0], 0.0), end, lambda t, y: y[0] - bottom)
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
