"""A propeller in a measured run (Blanke et al. 2000, Eqs. 24 and 30), and the power of propulsion.

Cruise and acceleration with steady flow in the propeller disc (Blanke et al. 2000, Eqs. 26 to 28).

In the quasi-steady model the flow in the disc is (1 + a)(1 - w) times the vehicle's speed, so that speed, power and
the acceleration after each surfacing have closed forms.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from missionplan.arrays import Array, Scalars, magnitude
from missionplan.physics.propeller import Propeller, Resistance, flow_acceleration, steady_axial_flow, torque

SUBSTEPS = 5
"""Steps of `propeller_response` between two samples."""


def propeller_response(
    propeller: Propeller,
    time: Array,
    speed: Array,
    *,
    shaft_rate: Array | None = None,
    motor_torque: Array | None = None,
) -> tuple[Array, Array]:
    """Simulate a propeller in a measured run, with its measured speed through the water.

    The number of steps is fixed and the flow is stepped linearly implicitly, so that the result is a smooth function of
    the propeller's constants, as fitting requires. Raises ValueError when not exactly one of shaft rate and torque is
    given.

    Parameters
    ----------
    time, speed : array, shape (samples,)
        Ascending times [s] and the vehicle's speed [m/s].
    shaft_rate : array, shape (samples,), optional
        Measured n [rad/s], which is then imposed too.
    motor_torque : array, shape (samples,), optional
        Measured Q_m [N m], which drives the shaft from rest. One of the two must be given.

    Returns
    -------
    shaft_rate, axial_flow : array, shape (samples,)
        n [rad/s] and u_p [m/s]; the flow is steady at the start.
    """
    if shaft_rate is not None and motor_torque is None:
        drive, advance, rate = shaft_rate, _imposed_step, float(shaft_rate[0])
    elif motor_torque is not None and shaft_rate is None:
        drive, advance, rate = motor_torque, _driven_step, 0.0
    else:
        raise ValueError("give either the shaft rate or the motor torque")
    flow = float(steady_axial_flow(propeller, rate, float(speed[0]))) if rate else 0.0
    steps = np.linspace(0.5, SUBSTEPS - 0.5, SUBSTEPS) / SUBSTEPS
    drives, speeds = ((v[:-1, None] + np.diff(v)[:, None] * steps).tolist() for v in (drive, speed))
    rates_out, flows_out = [rate], [flow]
    for interval, drive_between, speed_between in zip(np.diff(time).tolist(), drives, speeds, strict=True):
        for applied, vehicle in zip(drive_between, speed_between, strict=True):
            rate, flow = advance(propeller, rate, flow, applied, vehicle, interval / SUBSTEPS)
        rates_out.append(rate)
        flows_out.append(flow)
    return (np.array(rates_out) if shaft_rate is None else shaft_rate), np.array(flows_out)


def _imposed_step(
    propeller: Propeller, rate: float, flow: float, applied: float, speed: float, h: float
) -> tuple[float, float]:
    """Shaft rate and flow after a step at the `applied` shaft rate."""
    return applied, _implicit_flow_step(propeller, applied, flow, speed, h)


def _driven_step(
    propeller: Propeller, rate: float, flow: float, applied: float, speed: float, h: float
) -> tuple[float, float]:
    """Shaft rate and flow after a step under the `applied` motor torque: half a step of the shaft before and after."""
    rate = rate + h / 2.0 * _shaft_acceleration(propeller, rate, flow, applied)
    flow = _implicit_flow_step(propeller, rate, flow, speed, h)
    return rate + h / 2.0 * _shaft_acceleration(propeller, rate, flow, applied), flow


def _shaft_acceleration(propeller: Propeller, rate: float, flow: float, applied: float) -> float:
    return float((applied - torque(propeller, rate, flow)) / propeller.shaft_inertia)


def _implicit_flow_step(propeller: Propeller, rate: float, flow: float, speed: float, h: float) -> float:
    """Step the flow in the disc by the second-order, L-stable Rosenbrock method with γ = 1 - 1/√2.

    With 1 + 1/√2 (Verwer et al. 1999, SIAM J. Sci. Comput. 20) its error is thirty times as large: of a change that
    decays as exp(-t/τ), it is (h/τ)³/25 a step.
    """
    gamma = 1.0 - 0.5**0.5
    inflow = (1.0 - propeller.wake_fraction) * speed
    towards = 2.0 * abs(flow) - (inflow if flow >= 0.0 else -inflow)
    damping = propeller.flow_damping_linear + propeller.flow_damping_quadratic * towards
    slope = (float(propeller.thrust_nu) * abs(rate) - damping) / propeller.flow_mass
    factor: float = 1.0 / (1.0 - gamma * h * slope)
    first = factor * float(flow_acceleration(propeller, rate, flow, speed))
    second = factor * (float(flow_acceleration(propeller, rate, flow + h * first, speed)) - 2.0 * first)
    return flow + h * (1.5 * first + 0.5 * second)


JOULES_PER_WATT_HOUR = 3600.0
"""J in 1 Wh: batteries are rated, and energies reported, in watt-hours."""


def propulsive_power(drag: Scalars, speed: Scalars, efficiency: Scalars) -> Scalars:
    """Electrical power of propulsion, F u/η = ½ρAC_d u³/η, shape (n,) [W].

    Parameters
    ----------
    drag : float or array, shape (n,)
        F at that speed [N].
    speed : float or array, shape (n,)
        u through the water [m/s].
    efficiency : float or array, shape (n,)
        η, from the battery to the work against drag.
    """
    return drag * speed / efficiency


@dataclass(frozen=True)
class Surge:
    """Coefficients of m u̇ = A - B u - C u²: quasi-steady surge ahead at a constant shaft rate; floats or arrays.

    `push` A [N], `slope` B [kg/s] and `curve` C [kg/m] over the `mass` [kg].
    """

    mass: Scalars
    push: Scalars
    slope: Scalars
    curve: Scalars

    @property
    def stiffness(self) -> Scalars:
        """√(B² + 4AC) [kg/s]: divided by the mass, the rate at which the speed converges."""
        root: Scalars = np.sqrt(self.slope**2 + 4.0 * self.push * self.curve)
        return root

    @property
    def speed(self) -> Scalars:
        """Speed at which thrust and resistance balance [m/s]."""
        return 2.0 * self.push / (self.slope + self.stiffness)


def quasi_steady_surge(propeller: Propeller, resistance: Resistance, shaft_rate: Scalars) -> Surge:
    """Coefficients of surge at a constant shaft rate n > 0 [rad/s] with the flow in the disc (1 + a)(1 - w)u.

    Closed form of Eqs. 26 to 28 in steady state: C u² + B u = A with A = (1 - t)T_nn n² and
    B = R₁ - (1 - t)T°(1 + a)(1 - w) n.
    """
    share = 1.0 - propeller.thrust_deduction
    return Surge(
        mass=resistance.mass,
        push=share * propeller.thrust_nn * shaft_rate**2,
        slope=resistance.linear - share * propeller.thrust_nu * propeller.flow_ratio * shaft_rate,
        curve=resistance.quadratic,
    )


def cruise_speed(propeller: Propeller, shaft_rate: Scalars, drag: Callable[[Scalars], Scalars]) -> Scalars:
    """Speed through the water at a shaft rate, for any drag law.

    Raises ArithmeticError when a hundred iterations do not converge.

    Parameters
    ----------
    shaft_rate : float or array
        n > 0 [rad/s].
    drag : callable
        Drag [N] from speed [m/s]; nearly quadratic, so that iteration of C = drag/u² converges.

    Returns
    -------
    float or array
        u [m/s], to 1e-10 of itself.
    """
    speed: Scalars = np.ones_like(np.asarray(shaft_rate))
    for _ in range(100):
        resistance = Resistance(mass=1.0, linear=0.0, quadratic=drag(speed) / speed**2)
        last, speed = speed, quasi_steady_surge(propeller, resistance, shaft_rate).speed
        if np.all(magnitude(speed - last) <= 1e-10 * speed):
            return speed
    raise ArithmeticError("the speed for this shaft rate did not converge: is the drag nearly quadratic?")


def shaft_rate_for(propeller: Propeller, drag: Scalars, speed: Scalars) -> Scalars:
    """Shaft rate that holds a speed [m/s] against a drag [N], the inverse of `cruise_speed` [rad/s]."""
    share = 1.0 - propeller.thrust_deduction
    slope = -share * propeller.thrust_nu * propeller.flow_ratio * speed
    quadratic = share * propeller.thrust_nn
    rate: Scalars = (slope + np.sqrt(slope**2 + 4.0 * quadratic * drag)) / (2.0 * quadratic)
    return rate


def shaft_power(propeller: Propeller, shaft_rate: Scalars, speed: Scalars) -> Scalars:
    """Power of the shaft under way, Qω with steady flow [W]."""
    return shaft_rate * torque(propeller, shaft_rate, propeller.flow_ratio * speed)


@dataclass(frozen=True)
class SpeedUp:
    """State at a time after a start from rest: `speed` [m/s], `distance` [m], `work` of the shaft [J]."""

    speed: Scalars
    distance: Scalars
    work: Scalars


def speed_up(propeller: Propeller, resistance: Resistance, shaft_rate: Scalars, time: Scalars) -> SpeedUp:
    """Acceleration from rest at a constant shaft rate, as after each surfacing: closed form of `quasi_steady_surge`.

    With λ = √(B² + 4AC)/m, U the cruising speed and r = C U²/A: u = U(1 - e^(-λt))/(1 + r e^(-λt)).

    Parameters
    ----------
    shaft_rate : float or array
        n > 0 [rad/s].
    time : float or array
        Since the start [s].
    """
    surge = quasi_steady_surge(propeller, resistance, shaft_rate)
    cruise, rate = surge.speed, surge.stiffness / surge.mass
    ratio = surge.curve * cruise**2 / surge.push
    fading = np.exp(-rate * np.asarray(time))
    delay = (1.0 + ratio) / (ratio * rate) * np.log((1.0 + ratio) / (1.0 + ratio * fading))
    distance = cruise * (time - delay)
    work = shaft_rate**2 * (
        propeller.torque_nn * shaft_rate * time + propeller.torque_nu * propeller.flow_ratio * distance
    )
    return SpeedUp(cruise * (1.0 - fading) / (1.0 + ratio * fading), distance, work)


def distance_lost(propeller: Propeller, resistance: Resistance, shaft_rate: Scalars) -> Scalars:
    """Distance by which a leg from rest falls short of one at cruising speed, the limit of `speed_up` [m]."""
    surge = quasi_steady_surge(propeller, resistance, shaft_rate)
    ratio = surge.curve * surge.speed**2 / surge.push
    return surge.speed * (1.0 + ratio) * np.log1p(ratio) / (ratio * surge.stiffness / surge.mass)


def speed_error(
    propeller: Propeller,
    resistance: Resistance,
    shaft_rate: Scalars,
    duration: Scalars,
    *,
    thrust_factor: Scalars = 1.0,
    drag_factor: Scalars = 1.0,
) -> Scalars:
    """Mean velocity error along the course over a leg when speed is inferred from the shaft rate.

    The vehicle assumes the cruising speed of the nominal propeller and hull from the start; in truth it accelerates
    from rest, with its own thrust and drag.

    Parameters
    ----------
    shaft_rate : float or array
        n > 0 [rad/s].
    duration : float or array
        Of the leg [s].
    thrust_factor, drag_factor : float or array
        True over nominal thrust constants and resistance.

    Returns
    -------
    float or array
        True minus inferred mean speed [m/s].
    """
    inferred = quasi_steady_surge(propeller, resistance, shaft_rate).speed
    true_propeller = replace(
        propeller, thrust_nn=propeller.thrust_nn * thrust_factor, thrust_nu=propeller.thrust_nu * thrust_factor
    )
    true_resistance = Resistance(resistance.mass, resistance.linear * drag_factor, resistance.quadratic * drag_factor)
    return speed_up(true_propeller, true_resistance, shaft_rate, duration).distance / duration - inferred
