"""Forces on two bodies tied by a taut line in a current: each in three dimensions, the line as a constraint.

Coordinates are the place of the vehicle's nose and the line's vector d from it to the anchor: east, north, down. With
the forces F of water and weight and the diagonal mass matrices M (axial down, lateral across),

    M_v a_v = F_v + λ d,    M_a a_a = F_a - λ d,    d·(a_a - a_v) + |ḋ|² = 0,

where λ L is the tension. Both bodies stay upright: drag acts along and across them separately (cross-flow principle).
"""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array, Scalars, over_trials
from missionplan.phases.mooring.forces import DescentHooks, Dive
from missionplan.phases.mooring.horizontal_drift import TiedBodies
from missionplan.physics.drag import DragLaw


@dataclass(frozen=True)
class TiedState:
    """Vehicle and anchor on a taut line; rows are the vehicle's and the line's vector, each east, north, down."""

    place: Array
    """Of the vehicle's nose, and from it to the anchor, shape (6, n) [m]."""
    rate: Array
    """Their derivatives, shape (6, n) [m/s]."""

    @property
    def anchor(self) -> Array:
        """Place of the anchor, shape (3, n) [m]."""
        return self.place[:3] + self.place[3:]


class TiedForces:
    """Motion of both bodies on the taut line under each of their forces."""

    def __init__(self, dive: Dive, bodies: TiedBodies, hooks: DescentHooks, taut_at: Array) -> None:
        trials = taut_at.size
        self._dive, self._hooks, self._taut_at = dive, hooks, taut_at
        self.water_velocity = hooks.water_velocity
        self._factor = factor = hooks.mass_factor

        def per_mass(across: Scalars, along: Scalars) -> Array:
            return np.stack([over_trials(1.0 / (factor * mass), trials) for mass in (across, across, along)])

        self._per_vehicle = per_mass(bodies.vehicle.mass, dive.free_mass)
        self._per_anchor = per_mass(bodies.anchor.mass, dive.lone_mass)
        self._per_pair = self._per_vehicle + self._per_anchor
        self._decay = [bodies.vehicle.drag * self._per_vehicle[0], bodies.anchor.drag * self._per_anchor[0]]
        self._length_squared = over_trials(dive.line_length, trials) ** 2
        self._across = self._length_squared * self._per_pair[0]
        self._along = self._per_pair[2] - self._per_pair[0]

    def snatched(self, state: TiedState) -> TiedState:
        """State after the line has gone taut: an impulse along it ends the motion apart."""
        rate = state.rate.copy()
        rate[3:] = (rate[:3] + rate[3:]) / self._factor - rate[:3]  # an effect's mass takes part from now on
        self.tighten(state.place, rate)
        return TiedState(state.place, rate)

    def tighten(self, place: Array, rate: Array) -> None:
        """End the motion apart by an impulse along the line, in place."""
        line = place[3:]
        impulse = line * (_dot(line, rate[3:]) / self._mobility(line))
        rate[:3] += impulse * self._per_vehicle
        rate[3:] -= impulse * self._per_pair

    def hold(self, place: Array, rate: Array) -> None:
        """Hold the line at its length, and the vehicle in the water, in place."""
        line = place[3:]
        line *= np.sqrt(self._length_squared / _dot(line, line))
        self.tighten(place, rate)
        above = place[2] < 0.0
        if above.any():
            rate[2] = np.where(above, np.maximum(rate[2], 0.0), rate[2])
            place[2] = np.maximum(place[2], 0.0)

    def drag_across(self, place: Array, rate: Array, water: Array, duration: float) -> None:
        """Let the drag across both bodies act for a duration [s], in place; without other forces it is exact.

        The velocity w through the water falls off as w/(1 + c w t), c = k/m, which no step makes unstable.
        """
        vehicle = rate[:2] - water[0]
        anchor = rate[:2] + rate[3:5] - water[1]
        for through, decay in zip((vehicle, anchor), self._decay, strict=True):
            speed = np.sqrt(through[0] * through[0] + through[1] * through[1])
            through /= 1.0 + (duration * decay) * speed
        rate[3:5] = anchor - vehicle + (water[1] - water[0])
        rate[:2] = vehicle + water[0]
        self.tighten(place, rate)

    def acceleration(self, t: float, place: Array, rate: Array) -> Array:
        """Second derivative of a place under the vertical forces and the line, shape (6, n) [m/s²].

        Parameters
        ----------
        t : float
            Since the line went taut [s].
        place, rate : array, shape (6, n)
            As in `TiedState`.
        """
        dive, hooks = self._dive, self._hooks
        line, turning = place[3:], rate[3:]
        vehicle = rate[2] - self.water_velocity
        anchor = vehicle + turning[2]
        lifted = dive.net_buoyancy + hooks.lift(place[2]) + self._drag(t, place[2], dive.vehicle_drag, vehicle)
        since = self._taut_at + t
        weight = dive.weight_at(since) * hooks.wet_weight_factor(since)
        sinking = -lifted * self._per_vehicle[2]
        apart = (weight - self._drag(t, place[2], dive.anchor_drag, anchor)) * self._per_anchor[2] - sinking
        tension = (line[2] * apart + _dot(turning, turning)) / self._mobility(line)
        pull = line * tension
        result = np.empty_like(place)
        np.multiply(pull, self._per_vehicle, out=result[:3])
        np.multiply(pull, -self._per_pair, out=result[3:])
        result[2] += sinking
        result[5] += apart
        return result

    def _drag(self, t: float, depth: Array, law: DragLaw, speed: Array) -> Scalars:
        """Drag of a body along its axis, with the effects' factor at the vehicle's depth [N]."""
        drag, hooks = law(speed), self._hooks
        if not hooks.changes_drag:
            return drag
        return drag * hooks.drag_factor(t, np.abs(speed)) * hooks.local_drag_factor(depth, self._dive.line_length)

    def _mobility(self, line: Array) -> Array:
        """Motion apart that an impulse d along the line ends: Σ d² (1/M_a + 1/M_v) [m²/kg]."""
        return np.asarray(self._across + line[2] * line[2] * self._along)


def _dot(a: Array, b: Array) -> Array:
    """Inner products of vectors, shape (3, n) each."""
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])
