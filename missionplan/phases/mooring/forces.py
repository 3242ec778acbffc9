"""Forces of each stage of a descent (Briggs et al., section III, made dynamic), with the effects' hooks combined."""

from collections.abc import Callable, Iterable
from copy import copy
from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.phases.hooks import DescentEffect
from missionplan.phases.mooring.motion import TiedBodies
from missionplan.physics.drag import DragLaw
from missionplan.physics.vehicle_dynamics import LineSpring, PitchingBody


@dataclass(frozen=True)
class Dive:
    """Bodies, line and depth of a descent; each number is a float or an array over trials, shape (n,)."""

    wet_weight: Scalars
    """Of the flooded anchor [N]."""
    anchor_mass: Scalars
    anchor_added_mass: Scalars
    """Of the anchor with the water inside, and its axial added mass [kg]."""
    anchor_drag: DragLaw
    vehicle_mass: Scalars
    vehicle_added_mass: Scalars
    """Of the egress vehicle, and its axial added mass [kg]."""
    net_buoyancy: Scalars
    """Buoyancy minus weight of the egress vehicle [N]."""
    vehicle_drag: DragLaw
    line_length: Scalars
    """From the anchor to the vehicle's nose [m]."""
    site_depth: Scalars
    """[m]."""
    tied: TiedBodies | None = None
    """What ties the horizontal drift of the two bodies together; None: each goes with its layer of the current."""
    spring: LineSpring | None = None
    """For the peak tension of the snatch; None: it is not computed."""
    pitching: PitchingBody | None = None
    """For the pitch-over after the snatch; None: the vehicle is nose down at once."""
    flooding_time: Scalars = 0.0
    """From the separation until the anchor is full of water [s]."""

    def weight_at(self, since_separation: Scalars) -> Scalars:
        """Wet weight of the anchor at a time since its separation [s] [N].

        It separates neutral (Eq. 17) and floods through openings under a head that falls as it fills (Torricelli), to
        the wet weight of Eq. 15. Its mass is taken as that of the full anchor throughout.
        """
        if isinstance(self.flooding_time, float) and self.flooding_time == 0.0:
            return self.wet_weight
        time = np.asarray(self.flooding_time)
        empty = np.where(time > 0.0, np.maximum(1.0 - since_separation / np.maximum(time, 1e-9), 0.0), 0.0)
        return self.wet_weight * (1.0 - empty * empty)

    @property
    def lone_mass(self) -> Scalars:
        """Mass that moves while the anchor falls alone [kg]."""
        return self.anchor_mass + self.anchor_added_mass

    @property
    def free_mass(self) -> Scalars:
        """Mass that moves with the vehicle alone [kg]."""
        return self.vehicle_mass + self.vehicle_added_mass

    @property
    def joint_mass(self) -> Scalars:
        """Mass that moves once the line is taut [kg]."""
        return self.lone_mass + self.free_mass


class DescentHooks:
    """The combined hooks of several effects: factors multiply, lifts, velocities and delays add.

    Hooks that no effect refines are skipped, so that they cost nothing at each step.
    """

    def __init__(self, effects: Iterable[DescentEffect] = ()) -> None:
        effects = tuple(effects)
        self._later: Scalars = 0.0

        def refined(name: str) -> list[Callable[..., Scalars]]:
            return [getattr(effect, name) for effect in effects if effect.refines(name)]

        self._lone_drag, self._drag = refined("lone_drag_factor"), refined("drag_factor")
        self._local_drag = refined("local_drag_factor")
        self._weight, self._lift, self._mass = refined("wet_weight_factor"), refined("lift"), refined("mass_factor")
        self._water, self._delay = refined("water_velocity"), refined("delay")
        self._reading = [effect.reading for effect in effects if effect.refines("reading")]

    def later(self, elapsed: Array) -> "DescentHooks":
        """Return the hooks for a clock that starts some time after the line went taut, shape (n,) [s]."""
        hooks = copy(self)
        hooks._later = elapsed
        return hooks

    @property
    def lone_drag_factor(self) -> Scalars:
        """Factor on the anchor's drag while it falls alone."""
        return _product(hook() for hook in self._lone_drag)

    @property
    def changes_drag(self) -> bool:
        """Whether an effect changes both bodies' drag."""
        return bool(self._drag or self._local_drag)

    @property
    def mass_factor(self) -> Scalars:
        """Factor on the joint mass."""
        return _product(hook() for hook in self._mass)

    @property
    def water_velocity(self) -> Scalars:
        """Downward velocity of the water once the line is taut [m/s]."""
        return _total(hook() for hook in self._water)

    def drag_factor(self, since_taut: Scalars, speed: Scalars) -> Scalars:
        """Factor on both bodies' drag, at a time since the line went taut [s] and a speed [m/s]."""
        return _product(hook(since_taut + self._later, speed) for hook in self._drag)

    def local_drag_factor(self, depth: Scalars, line_length: Scalars) -> Scalars:
        """Factor on both bodies' drag, at the vehicle's depth and on a line of a length [m]."""
        return _product(hook(depth, line_length) for hook in self._local_drag)

    def wet_weight_factor(self, since_separation: Scalars) -> Scalars:
        """Factor on the anchor's wet weight, at a time since its separation [s]."""
        return _product(hook(since_separation) for hook in self._weight)

    def lift(self, depth: Scalars) -> Scalars:
        """Upward force on the vehicle at its depth [m] once the line is taut [N]."""
        return _total(hook(depth) for hook in self._lift)

    def delay(self, line_length: Scalars) -> Scalars:
        """Delay of everything after the separation [s]."""
        return _total(hook(line_length) for hook in self._delay)

    def reading(self, t: Array, depth: Array) -> Array:
        """Depth that the sensor reads, from the true depth on a uniform grid; effects apply in their order [m]."""
        for hook in self._reading:
            depth = hook(t, depth)
        return depth


def _product(factors: Iterable[Scalars]) -> Scalars:
    result: Scalars = 1.0
    for factor in factors:
        result = result * factor
    return result


def _total(terms: Iterable[Scalars]) -> Scalars:
    result: Scalars = 0.0
    for term in terms:
        result = result + term
    return result


class LoneFall:
    """The anchor alone, from its separation until the line is taut: (m_a + added) a = W - F_anchor."""

    water_velocity: Scalars = 0.0

    def __init__(self, dive: Dive, hooks: DescentHooks) -> None:
        self._dive, self._hooks = dive, hooks
        self._drag_factor = hooks.lone_drag_factor

    def acceleration(self, t: Scalars, depth: Array, speed: Array) -> Array:
        """Of the anchor [m/s²]."""
        dive = self._dive
        weight = dive.weight_at(t) * self._hooks.wet_weight_factor(t)
        return np.asarray((weight - self._drag_factor * dive.anchor_drag(speed)) / dive.lone_mass)


class PullDown:
    """Both bodies on a taut line: M a = W - B_net - lift - F_vehicle - F_anchor (Eq. 14)."""

    def __init__(self, dive: Dive, hooks: DescentHooks, taut_at: Array) -> None:
        self._dive, self._hooks, self._taut_at = dive, hooks, taut_at
        self._mass = dive.joint_mass * hooks.mass_factor
        self.water_velocity = hooks.water_velocity

    def drag(self, t: Scalars, depth: Array, speed: Array) -> Array:
        """Of both bodies [N], at a time since the line went taut [s], a depth [m] and a speed in the water [m/s]."""
        dive, hooks = self._dive, self._hooks
        force = np.asarray(dive.vehicle_drag(speed) + dive.anchor_drag(speed))
        if not hooks.changes_drag:
            return force
        return force * (hooks.drag_factor(t, np.abs(speed)) * hooks.local_drag_factor(depth, dive.line_length))

    def pull(self, t: Scalars, depth: Array) -> Array:
        """Net downward force without drag [N], at a time since the line went taut [s] and the vehicle's depth [m]."""
        dive, hooks = self._dive, self._hooks
        since = self._taut_at + t
        weight = dive.weight_at(since) * hooks.wet_weight_factor(since)
        return np.asarray(weight - dive.net_buoyancy - hooks.lift(depth))

    def acceleration(self, t: float, depth: Array, speed: Array) -> Array:
        """Of both bodies [m/s²]."""
        return np.asarray((self.pull(t, depth) - self.drag(t, depth, speed)) / self._mass)


class FreeVehicle:
    """The vehicle on a slack line after touchdown, sinking on or rising: M_v a = -B_net - lift - F_vehicle."""

    def __init__(self, dive: Dive, hooks: DescentHooks, since_taut: Array) -> None:
        self._dive, self._hooks, self._since_taut = dive, hooks, since_taut
        self._negative_mass = -dive.free_mass
        self.water_velocity = hooks.water_velocity

    def acceleration(self, t: float, depth: Array, speed: Array) -> Array:
        """Of the vehicle [m/s²]."""
        dive, hooks = self._dive, self._hooks
        drag = dive.vehicle_drag(speed)
        if hooks.changes_drag:
            drag = drag * hooks.drag_factor(self._since_taut + t, np.abs(speed))
            drag = drag * hooks.local_drag_factor(depth, dive.line_length)
        return np.asarray((dive.net_buoyancy + hooks.lift(depth) + drag) / self._negative_mass)


_STEADY_TIME = 1e6
"""Time by which every transient effect has decayed [s]."""


@dataclass(frozen=True)
class SteadyDescent:
    """Both bodies at a steady speed: the balance of Eqs. 14–15, with the effects that do not decay."""

    through_water: Scalars
    """Speed through the water, shape (n,) [m/s]."""
    drag_factor: Scalars
    """Of the effects, on both bodies' drag, mean over the depth, shape (n,)."""
    lift: Scalars
    """Of the effects, on the vehicle, mean over the depth, shape (n,) [N]."""
    weight_factor: Scalars
    """Of the effects, on the anchor's wet weight, shape (n,)."""

    @classmethod
    def at(cls, speed: float, hooks: DescentHooks, site_depth: float, line_length: float) -> "SteadyDescent":
        """Descent at a speed over the ground [m/s] to a depth on a line of a length [m]."""
        through_water = speed - hooks.water_velocity
        depths = np.linspace(0.01, 0.99, 50, dtype=np.float64) * site_depth
        lift = float(np.mean(np.broadcast_to(hooks.lift(depths), depths.shape)))
        local = float(np.mean(np.broadcast_to(hooks.local_drag_factor(depths, line_length), depths.shape)))
        drag_factor = local * hooks.drag_factor(_STEADY_TIME, through_water)
        return cls(through_water, drag_factor, lift, hooks.wet_weight_factor(_STEADY_TIME))

    def wet_weight(self, drag: Scalars) -> Scalars:
        """Wet weight of the anchor that balances the drag of both bodies without effects [N] (Eq. 15) [N]."""
        return (drag * self.drag_factor + self.lift) / self.weight_factor
