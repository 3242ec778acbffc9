"""Thrust and torque of a fixed-pitch propeller with axial-flow dynamics (Blanke, Lindegaard & Fossen 2000).

Shaft rates are in rad/s throughout. The paper's constants are for revolutions per second, with the advance ratio
J = 2π u_a/(n D) for n in rad/s (its Fig. 3); `from_open_water` converts them.
"""

import math
from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Scalars, magnitude
from missionplan.physics.drag import disc_area


@dataclass(frozen=True)
class Propeller:
    """A propeller and the water that it sets in motion."""

    diameter: float
    """Of the disc [m]."""
    thrust_nn: Scalars
    thrust_nu: Scalars
    """T_n|n| [N s²/rad²] and T°_|n|u of the flow in the disc (negative) [N s²/(rad m)], Eq. 28."""
    torque_nn: Scalars
    torque_nu: Scalars
    """Q_n|n| [N m s²/rad²] and Q°_|n|u of the flow in the disc (negative) [N s²/rad], Eq. 22."""
    axial_flow_factor: float
    """a: in steady state the flow in the disc is (1 + a) times the advance speed."""
    wake_fraction: float
    thrust_deduction: float
    """w of Eq. 27 and t of Eq. 26."""
    shaft_inertia: float
    """Of motor, shaft and propeller [kg m²]."""
    flow_mass: float
    """Of the water in the control volume, m_f [kg]."""
    flow_damping_linear: float
    flow_damping_quadratic: float
    """d_f0 [kg/s] and d_f [kg/m] of Eq. 30."""

    @property
    def flow_ratio(self) -> float:
        """Steady flow in the disc over the vehicle's speed, (1 + a)(1 - w)."""
        return (1.0 + self.axial_flow_factor) * (1.0 - self.wake_fraction)


def from_open_water(
    diameter: float,
    thrust_coefficient: tuple[Scalars, Scalars],
    torque_coefficient: tuple[Scalars, Scalars],
    *,
    density: float,
    axial_flow_factor: float = 0.0,
    wake_fraction: float = 0.0,
    thrust_deduction: float = 0.0,
) -> Propeller:
    """Convert open-water characteristics K_T = α₀ + α₁J, K_Q = β₀ + β₁J, Eqs. 19 to 23.

    The shaft's inertia is infinite, which keeps its rate constant; the flow's mass is ρ A_p D, as the paper does not
    give its factor γ, and its damping 0 and 2ρA_p, momentum theory (Eq. 12).

    Parameters
    ----------
    diameter : float
        Of the disc [m].
    thrust_coefficient, torque_coefficient : (float or array, float or array)
        (α₀, α₁) and (β₀, β₁); the slopes are negative. J is the advance speed over rev/s times diameter.
    density : float
        Of the water [kg/m³].
    axial_flow_factor, wake_fraction, thrust_deduction : float
        a, w and t.

    Returns
    -------
    Propeller
        With constants for rad/s: T_nn 0.08923, Q_nn 0.003950, (1 + a) T°_nu -4.1558 for the paper's Table 1.
    """
    turn = 2.0 * math.pi
    area = float(disc_area(diameter))
    scale = 1.0 + axial_flow_factor
    return Propeller(
        diameter=diameter,
        thrust_nn=density * diameter**4 * thrust_coefficient[0] / turn**2,
        thrust_nu=density * diameter**3 * thrust_coefficient[1] / turn / scale,
        torque_nn=density * diameter**5 * torque_coefficient[0] / turn**2,
        torque_nu=density * diameter**4 * torque_coefficient[1] / turn / scale,
        axial_flow_factor=axial_flow_factor,
        wake_fraction=wake_fraction,
        thrust_deduction=thrust_deduction,
        shaft_inertia=math.inf,
        flow_mass=density * area * diameter,
        flow_damping_linear=0.0,
        flow_damping_quadratic=2.0 * density * area,
    )


def thrust(propeller: Propeller, shaft_rate: Scalars, axial_flow: Scalars) -> Scalars:
    """Thrust at a shaft rate and a flow in the disc, Eq. 28.

    T = T_n|n||n|n + T°_|n|u|n|u_p with T° < 0 (with the minus of Eq. 20 the sign would count twice). Odd in (n, u_p):
    valid ahead and astern, but not for flow separated from the blades.

    Parameters
    ----------
    shaft_rate : float or array
        n [rad/s].
    axial_flow : float or array
        u_p, the speed of the water through the disc [m/s].

    Returns
    -------
    float or array
        Thrust, positive ahead [N].
    """
    return magnitude(shaft_rate) * (propeller.thrust_nn * shaft_rate + propeller.thrust_nu * axial_flow)


def torque(propeller: Propeller, shaft_rate: Scalars, axial_flow: Scalars) -> Scalars:
    """Torque of the water on the shaft [N m], Eq. 22; arguments as in `thrust`."""
    return magnitude(shaft_rate) * (propeller.torque_nn * shaft_rate + propeller.torque_nu * axial_flow)


def flow_acceleration(propeller: Propeller, shaft_rate: Scalars, axial_flow: Scalars, speed: Scalars) -> Scalars:
    """Acceleration of the water in the disc, Eqs. 27, 30 and 31.

    m_f u̇_p = T - d_f0 u_p - d_f|u_p|(u_p - (1 - w)u); with d_f0 = 0 and d_f = 2ρA_p it is Eq. 12.

    Parameters
    ----------
    shaft_rate, axial_flow, speed : float or array
        n [rad/s], u_p and the vehicle's speed u [m/s].

    Returns
    -------
    float or array
        u̇_p [m/s²].
    """
    slip = axial_flow - (1.0 - propeller.wake_fraction) * speed
    damping = (
        propeller.flow_damping_linear * axial_flow + propeller.flow_damping_quadratic * magnitude(axial_flow) * slip
    )
    return (thrust(propeller, shaft_rate, axial_flow) - damping) / propeller.flow_mass


def steady_axial_flow(propeller: Propeller, shaft_rate: Scalars, speed: Scalars) -> Scalars:
    """Steady flow in the disc: the closed form of `flow_acceleration` = 0.

    For a turning shaft and flow in its direction (u_p has the sign of n), which holds at rest and whenever speed and
    shaft rate have the same sign.

    Parameters
    ----------
    shaft_rate, speed : float or array
        n [rad/s] and the vehicle's speed [m/s].

    Returns
    -------
    float or array
        u_p [m/s].
    """
    turn, sign = magnitude(shaft_rate), np.sign(shaft_rate)
    inflow = sign * (1.0 - propeller.wake_fraction) * speed
    quadratic = propeller.flow_damping_quadratic
    linear = propeller.flow_damping_linear - propeller.thrust_nu * turn - quadratic * inflow
    constant = propeller.thrust_nn * turn**2
    root = np.sqrt(linear**2 + 4.0 * quadratic * constant)
    return sign * (root - linear) / (2.0 * quadratic)


@dataclass(frozen=True)
class Resistance:
    """Resistance of the vehicle, R(u) = R₁u + R₂u|u| (Eq. 29 with the sign of a resistance), and its mass."""

    mass: Scalars
    """Of the vehicle, axial added mass included [kg]."""
    linear: Scalars
    quadratic: Scalars
    """-X_u [kg/s] and -X_u|u| [kg/m]."""

    def force(self, speed: Scalars) -> Scalars:
        """Resistance at a speed through the water [N]."""
        return self.linear * speed + self.quadratic * magnitude(speed) * speed
