"""Cruise and acceleration with steady flow in the propeller disc (Blanke et al. 2000, Eqs. 26 to 28).

In the quasi-steady model the flow in the disc is (1 + a)(1 - w) times the vehicle's speed, so that speed, power and
the acceleration after each surfacing have closed forms.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from missionplan.arrays import Scalars, magnitude
from missionplan.physics.propeller import Propeller, Resistance, torque


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

    Raises
    ------
    ArithmeticError
        When a hundred iterations do not converge.
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
