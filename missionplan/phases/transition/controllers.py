"""Depth controllers of a transition: sternplanes at speed, tunnel thrusters at low speed, and the interchange between.

Palmer, Hearn & Stevenson, sections 2, 5.1 and 7.2. Controls are held over each step. The gains are not in the paper:
they come from outside.
"""

import numpy as np

from missionplan.arrays import Array
from missionplan.phases.transition.plan import Manoeuvre, TransitionVehicle, allocation, interchange

ZONE = 2.0
"""Half width of the transition zone in steepnesses: the interchange is at 1.8 and 98.2 % there. Assumed."""


class Controllers:
    """The two depth controllers with their integrators, arrays over trials of shape (n,).

    Parameters
    ----------
    vehicle : TransitionVehicle
    manoeuvre : Manoeuvre
    time_step : float
        [s].
    speed, pitch, sternplane : array, shape (n,)
        Trim at the start, which the controllers hold [m/s, rad, rad].

    Attributes
    ----------
    saturation_speed : array
        Highest speed so far at which the sternplanes were at their limit [m/s]; nan if they never were.
    """

    def __init__(
        self,
        vehicle: TransitionVehicle,
        manoeuvre: Manoeuvre,
        time_step: float,
        speed: Array,
        pitch: Array,
        sternplane: Array,
    ) -> None:
        self._vehicle, self._manoeuvre, self._time_step = vehicle, manoeuvre, time_step
        control = vehicle.sternplanes
        demand = pitch - sternplane / control.pitch_gain
        self._plane_integral = -demand / (control.depth_integral * (1.0 - self.thruster_share(speed)))
        self._thruster_integral = self._thruster_error = np.zeros_like(pitch)
        self.saturation_speed = np.full_like(pitch, np.nan)

    def thruster_share(self, speed: Array) -> Array:
        """Share of the depth control that the thrusters have at a speed [m/s]."""
        if not self._vehicle.thrusters:
            return np.zeros_like(speed)
        return np.asarray(interchange(speed, self._manoeuvre.mid_speed, self._manoeuvre.steepness))

    def sternplane(self, state: Array, share: Array) -> Array:
        """Deflection of the sternplanes [rad].

        Its depth integral is held while the plane is at its limit, and reset at low speed.
        """
        control, (u, _, q, pitch, depth) = self._vehicle.sternplanes, state
        proportion, error = 1.0 - share, -depth
        held = self._plane_integral
        demand = -proportion * (control.depth_gain * error + control.depth_integral * held)
        limited = np.clip(demand, -control.pitch_limit, control.pitch_limit)
        wanted = control.pitch_gain * (pitch - limited) + control.rate_gain * q
        plane: Array = np.clip(wanted, -control.limit, control.limit)
        at_limit = wanted != plane
        self.saturation_speed = np.fmax(self.saturation_speed, np.where(at_limit, u, np.nan))
        grown = held + np.where(at_limit | (limited != demand), 0.0, self._time_step * proportion * error)
        if self._vehicle.thrusters:
            low = u < self._manoeuvre.mid_speed - ZONE * np.asarray(self._manoeuvre.steepness)
            grown = np.where(low, 0.0, grown)
        self._plane_integral = grown
        return plane

    def shaft_rates(self, state: Array, share: Array) -> tuple[Array, Array]:
        """Shaft rates of forward (or only) and aft thruster, positive down [rev/s]; zero without thrusters.

        The controller works on the error scaled by the interchange, its derivative included: a steep interchange acts
        as a kick. The integral gain is scaled once more (sect. 5.1).
        """
        u, _, q, pitch, depth = state
        if not self._vehicle.thrusters:
            return np.zeros_like(u), np.zeros_like(u)
        control = self._vehicle.thruster_control
        error = -share * depth
        change = (error - self._thruster_error) / self._time_step
        wanted = control.depth_gain * error + control.depth_rate * change
        wanted = wanted + share * control.depth_integral * self._thruster_integral
        total = np.clip(wanted, -control.limit, control.limit)
        high = u > self._manoeuvre.mid_speed + ZONE * np.asarray(self._manoeuvre.steepness)
        grown = self._thruster_integral + np.where(wanted != total, 0.0, self._time_step * error)
        self._thruster_integral, self._thruster_error = np.where(high, 0.0, grown), error
        if len(self._vehicle.thrusters) == 1:
            return total, np.zeros_like(total)
        demand = share * (pitch + control.pair_lead * q)
        forward = np.asarray(allocation(demand, control.pair_steepness, control.pair_limit))
        return np.sqrt(forward) * total, np.sqrt(1.0 - forward) * total
