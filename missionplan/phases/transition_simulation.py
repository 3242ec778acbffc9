"""From survey speed to hover: a buoyant vehicle slows down, and tunnel thrusters take over from its sternplanes.

Palmer, Hearn & Stevenson, sections 2 to 7, in the vertical plane. All trials of a block are stepped together by
Runge-Kutta, with the controls held over each step (`controllers`).

Depth controllers of a transition: sternplanes at speed, tunnel thrusters at low speed, and the interchange between.

Palmer, Hearn & Stevenson, sections 2, 5.1 and 7.2. Controls are held over each step. The gains are not in the paper:
they come from outside.
"""

import math

import numpy as np

from missionplan.arrays import Array
from missionplan.phases.transition_plan import (
    History,
    Manoeuvre,
    TransitionRecord,
    TransitionVehicle,
    allocation,
    interchange,
)
from missionplan.physics.tunnel_thruster import (
    TunnelThruster,
    force_factor,
    jet_speed,
    moment,
    out_of_range,
    speed_ratio,
    static_thrust,
    suction_centre,
    thruster_power,
)
from missionplan.physics.vehicle_dynamics import (
    Load,
    Motion,
    accelerations,
    depth_rate,
    hydrodynamic_load,
    hydrostatic_load,
    inverse_inertia,
    level_trim,
    propeller_force,
    rigid_body_load,
)

ZONE = 2.0
"""Half width of the transition zone in steepnesses: the interchange is at 1.8 and 98.2 % there. Assumed."""


class Controllers:
    """The two depth controllers with their integrators, arrays over trials of shape (n,).

    Parameters
    ----------
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
        integral = self._plane_integral
        demand = -proportion * (control.depth_gain * error + control.depth_integral * integral)
        limited = np.clip(demand, -control.pitch_limit, control.pitch_limit)
        wanted = control.pitch_gain * (pitch - limited) + control.rate_gain * q
        plane: Array = np.clip(wanted, -control.limit, control.limit)
        at_limit = wanted != plane
        self.saturation_speed = np.fmax(self.saturation_speed, np.where(at_limit, u, np.nan))
        grown = integral + np.where(at_limit | (limited != demand), 0.0, self._time_step * proportion * error)
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


HOVER_BAND = 0.02
"""Distance from the target depth within which the vehicle hovers (sect. 6) [m]."""
STEADY = 100.0
"""Last part of a run, from which the pitch in hover is computed [s]."""


def simulate_transition(
    vehicle: TransitionVehicle, manoeuvre: Manoeuvre, *, time_step: float = 0.5, sample: float | None = None
) -> TransitionRecord:
    """Simulate a block of transitions from level flight at survey speed to hover.

    Raises ArithmeticError when the vehicle cannot fly level at survey speed; FloatingPointError when a run diverges.

    Parameters
    ----------
    vehicle : TransitionVehicle
        Floats, or arrays over trials.
    manoeuvre : Manoeuvre
        Floats, or arrays over trials.
    time_step : float
        Of the Runge-Kutta method and of the controllers [s].
    sample : float, optional
        Interval of the time histories, a multiple of the step [s]; default: the start alone.
    """
    run = _Run(vehicle, manoeuvre, time_step)
    slowest = manoeuvre.start_speed / float(np.min(manoeuvre.deceleration))
    steps = math.ceil((manoeuvre.before + slowest + manoeuvre.after) / time_step)
    every = max(1, round(sample / time_step)) if sample else steps + 1
    samples = [run.sample()]
    for step in range(steps):
        run.advance(steady=step >= steps - round(STEADY / time_step))
        if (step + 1) % every == 0:
            samples.append(run.sample())
    if not np.all(np.isfinite(run.state)):
        raise FloatingPointError(f"a transition diverged at a step of {time_step} s")
    time: Array = every * time_step * np.arange(len(samples), dtype=float) - manoeuvre.before
    return run.record(History(time, *np.moveaxis(np.array(samples), 1, 0)))


class _Run:
    """A block of trials under way: state (u, w, q, θ, depth below the target), shape (5, n)."""

    def __init__(self, vehicle: TransitionVehicle, manoeuvre: Manoeuvre, time_step: float) -> None:
        body = vehicle.body
        self.vehicle, self.manoeuvre, self.h = vehicle, manoeuvre, time_step
        varying = [manoeuvre.deceleration, manoeuvre.mid_speed, manoeuvre.steepness, body.excess_buoyancy, body.x_g]
        varying += [value for unit in vehicle.thrusters for value in (unit.thrust_constant, unit.decay)]
        shape = np.broadcast_shapes((1,), *(np.shape(value) for value in varying))
        self.inverse = inverse_inertia(body)
        speed = np.full(shape, manoeuvre.start_speed)
        trim = level_trim(body, speed)
        self.start_pitch = trim.pitch
        still = np.zeros(shape)
        self.state = np.array([speed, speed * np.tan(trim.pitch), still, trim.pitch, still])
        self.time, self.energy, self.plane = -manoeuvre.before, still, trim.sternplane
        self.energy_beyond = still
        self.revolutions = (still, still)
        self.controllers = Controllers(vehicle, manoeuvre, time_step, speed, trim.pitch, trim.sternplane)
        self.stopped = manoeuvre.start_speed / np.asarray(manoeuvre.deceleration)
        self.depth_excursion, self.pitch_excursion = still, still
        self.hover_time, self.energy_to_hover = still, still
        self.pitch_sums = np.zeros((3, *shape))

    def sample(self) -> Array:
        """Row of the time histories, shape (6, n)."""
        u, _, _, pitch, depth = self.state
        return np.array([u, pitch, depth, self.plane, self.revolutions[0], self.energy])

    def advance(self, *, steady: bool) -> None:
        """One step: controls, forces held, Runge-Kutta, energy; `steady` when it counts for the pitch in hover."""
        u = self.state[0]
        fallen = np.asarray(self.manoeuvre.deceleration) * max(self.time, 0.0)
        required: Array = np.maximum(self.manoeuvre.start_speed - fallen, 0.0)
        command = required + self.vehicle.speed_gain * (required - u)
        share = self.controllers.thruster_share(u)
        self.plane = self.controllers.sternplane(self.state, share)
        self.revolutions = self.controllers.shaft_rates(self.state, share)
        static = [
            np.asarray(static_thrust(t.thrust_constant, n))
            for t, n in zip(self.vehicle.thrusters, self.revolutions, strict=False)
        ]
        h, y = self.h, self.state
        k1 = self._slope(y, command, static)
        k2 = self._slope(y + h / 2.0 * k1, command, static)
        k3 = self._slope(y + h / 2.0 * k2, command, static)
        k4 = self._slope(y + h * k3, command, static)
        self.state = y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        self._account(static, u)
        self.time += h
        self._observe(steady)

    def _slope(self, state: Array, command: Array, static: list[Array]) -> Array:
        """Time derivative of the state, Eqs. 4 to 6, shape (5, n)."""
        body = self.vehicle.body
        u, w, q, pitch, _ = state
        motion = Motion(u, w, q, pitch)
        load = (
            hydrodynamic_load(body, motion, self.plane) + hydrostatic_load(body, pitch) + rigid_body_load(body, motion)
        )
        load = load + Load(propeller_force(body, self.vehicle.propeller, u, command), 0.0, 0.0)
        for thruster, thrust in zip(self.vehicle.thrusters, static, strict=True):
            load = load + self._thruster_load(thruster, thrust, u)
        du, dw, dq = accelerations(self.inverse, load)
        slope: Array = np.array([du, dw, dq, q, depth_rate(motion)])
        return slope

    def _thruster_load(self, thruster: TunnelThruster, static: Array, speed: Array) -> Load:
        """Downward force, and nose-up moment of force and suction; Eqs. 11, 15 and 17 to 19."""
        ratio = np.asarray(speed_ratio(speed, jet_speed(static, thruster.area, self.vehicle.body.density)))
        factor = force_factor(ratio, thruster.decay)
        if not self.vehicle.suction_moment:
            return Load(0.0, static * factor, -static * factor * thruster.position)
        centre = suction_centre(thruster, np.where(np.isfinite(ratio), ratio, 0.0))
        return Load(0.0, static * factor, -moment(static, factor, thruster.position, centre))

    def _account(self, static: list[Array], speed: Array) -> None:
        """Add the step's energy, Eq. 14, and the part of it that is beyond the model's range."""
        if self.time < 0.0:
            return
        density = self.vehicle.body.density
        for thruster, thrust in zip(self.vehicle.thrusters, static, strict=True):
            spent = self.h * np.asarray(thruster_power(thrust, thruster.area, density))
            ratio = speed_ratio(speed, jet_speed(thrust, thruster.area, density))
            self.energy = self.energy + spent
            self.energy_beyond = self.energy_beyond + np.where(out_of_range(ratio, thruster.decay), spent, 0.0)

    def _observe(self, steady: bool) -> None:
        """Update excursions, the end of the last departure from the target depth, and sums of the pitch."""
        if self.time <= 0.0:
            return
        pitch, depth = self.state[3:]
        self.depth_excursion = np.maximum(self.depth_excursion, np.abs(depth))
        self.pitch_excursion = np.maximum(self.pitch_excursion, np.abs(pitch - self.start_pitch))
        away = (np.abs(depth) > HOVER_BAND) | (self.time < self.stopped)
        self.hover_time = np.where(away, self.time, self.hover_time)
        self.energy_to_hover = np.where(away, self.energy, self.energy_to_hover)
        if steady:
            self.pitch_sums += np.array([np.ones_like(pitch), pitch, pitch**2])

    def record(self, history: History) -> TransitionRecord:
        """Return the record of the run."""
        hovers = self.hover_time < self.time
        count, total, squares = self.pitch_sums
        variance = np.maximum(squares / count - (total / count) ** 2, 0.0)
        return TransitionRecord(
            depth_excursion=self.depth_excursion,
            pitch_excursion=self.pitch_excursion,
            hover_time=np.where(hovers, self.hover_time, np.nan),
            energy_to_hover=np.where(hovers, self.energy_to_hover, np.nan),
            hover_pitch=np.sqrt(variance),
            saturation_speed=self.controllers.saturation_speed,
            out_of_range=self.energy_beyond / np.maximum(self.energy, 1e-9),
            end_energy=self.energy,
            end_time=self.time,
            history=history,
        )
