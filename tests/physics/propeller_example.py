"""The propeller and vehicle of the worked example of Blanke, Lindegaard & Fossen (2000), its Tables 1 and 2.

Its simulation too: shaft, axial flow and surge together (Eqs. 24 to 31), stepped in time.
"""

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.physics.propeller import Propeller, Resistance, flow_acceleration, from_open_water, thrust, torque

Damping = Literal["surge", "momentum"]

TABLE_1_RESISTANCE = Resistance(mass=1050.0, linear=0.2, quadratic=500.0)
"""The vehicle of Table 1: 1000 kg and 5 % added mass."""


def table_1(damping: Damping = "surge") -> Propeller:
    """Propeller of Table 1, with the T° and Q° that its a = 0.25 gives.

    m_f = ρ A_p l with γ = 1 (21.74 kg) is assumed; the paper does not give γ.

    Parameters
    ----------
    damping : {"surge", "momentum"}
        Axial-flow damping by Eqs. 34 and 35, or by Eq. 12.
    """
    hull = TABLE_1_RESISTANCE
    paper = {"axial_flow_factor": 0.25, "wake_fraction": 0.2, "thrust_deduction": 0.1}
    made = replace(
        from_open_water(0.30, (0.4243, -0.9435), (0.0626, -0.1212), density=1025.0, **paper), shaft_inertia=1.0
    )
    if damping != "surge":
        return made
    linear, quadratic = surge_flow_damping(float(hull.linear), float(hull.quadratic), **paper)
    return replace(made, flow_damping_linear=linear, flow_damping_quadratic=quadratic)


def as_printed(damping: Damping = "surge") -> Propeller:
    """Propeller with the constants of Table 2, whose T° and Q° are those of a = 0.1, not of Table 1's a."""
    turn = 2.0 * math.pi
    return replace(
        table_1(damping),
        thrust_nn=3.523 / turn**2,
        thrust_nu=-23.74 / turn,
        torque_nn=0.1559 / turn**2,
        torque_nu=-0.9148 / turn,
    )


def eq_36_torque(time_step: float, final_time: float = 100.0) -> Array:
    """Motor torque of the paper's simulation [N m]: 5, -5 and 2.5 N m; t_f = 100 s is assumed."""
    time = time_step * (np.arange(round(final_time / time_step)) + 0.5)
    return np.select([time <= 0.3 * final_time, time <= 0.6 * final_time], [5.0, -5.0], 2.5)


def surge_flow_damping(
    resistance_linear: float,
    resistance_quadratic: float,
    axial_flow_factor: float,
    wake_fraction: float,
    thrust_deduction: float,
) -> tuple[float, float]:
    """Axial-flow damping that makes the steady flow (1 + a)(1 - w) times the speed, Eqs. 34 and 35.

    It relates the water in the disc to the hull's resistance. For the paper's Table 1 it gives 2777.8 kg/m, nineteen
    times the 2ρA_p = 144.9 kg/m of momentum theory (Eq. 12); the two agree for a resistance near 26 kg/m.

    Parameters
    ----------
    resistance_linear, resistance_quadratic : float
        -X_u [kg/s] and -X_u|u| [kg/m] of Eq. 29.
    axial_flow_factor, wake_fraction, thrust_deduction : float
        a, w and t.

    Returns
    -------
    linear, quadratic : float
        d_f0 [kg/s] and d_f [kg/m].
    """
    a, w, t = axial_flow_factor, wake_fraction, thrust_deduction
    linear = resistance_linear / ((1.0 - t) * (1.0 + a) * (1.0 - w))
    quadratic = resistance_quadratic / ((1.0 - t) * (1.0 + a) * a * (1.0 - w) ** 2)
    return linear, quadratic


def thrust_coefficient(propeller: Propeller, advance: Scalars, density: float) -> Scalars:
    """Open-water K_T at an advance ratio, Eq. 19: steady thrust over ρ (n/2π)² D⁴ (checked: K_T(0) = 0.4243)."""
    flow = (1.0 + propeller.axial_flow_factor) * advance * propeller.diameter / (2.0 * math.pi)
    return (propeller.thrust_nn + propeller.thrust_nu * flow) * (2.0 * math.pi) ** 2 / (density * propeller.diameter**4)


def torque_coefficient(propeller: Propeller, advance: Scalars, density: float) -> Scalars:
    """Open-water K_Q at an advance ratio, Eq. 19: steady torque over ρ (n/2π)² D⁵ (checked: K_Q(0) = 0.0626)."""
    flow = (1.0 + propeller.axial_flow_factor) * advance * propeller.diameter / (2.0 * math.pi)
    return (propeller.torque_nn + propeller.torque_nu * flow) * (2.0 * math.pi) ** 2 / (density * propeller.diameter**5)


def open_water_efficiency(propeller: Propeller, advance: Scalars, density: float) -> Scalars:
    """η₀ = J K_T/(2π K_Q): thrust power over shaft power."""
    ratio = thrust_coefficient(propeller, advance, density) / torque_coefficient(propeller, advance, density)
    return advance * ratio / (2.0 * math.pi)


State = tuple[Scalars, Scalars, Scalars]
"""Shaft rate [rad/s], flow in the disc [m/s], speed through the water [m/s]."""


def rates(propeller: Propeller, resistance: Resistance, state: State, motor_torque: Scalars) -> State:
    """Time derivatives of shaft rate, flow in the disc and speed, Eqs. 24, 26, 30 and 31.

    Shaft: J_m ω̇ = Q_m - Q with ω in rad/s; Eq. 24's last term is -Q°|n|u_p. Surge: (m - X_u̇)u̇ = (1 - t)T - R(u); in
    Eqs. 26 and 29 as printed, resistance would propel.

    Parameters
    ----------
    state : tuple
        Shaft rate, flow in the disc and speed: floats or arrays over trials.
    motor_torque : float or array
        Q_m [N m].
    """
    shaft_rate, axial_flow, speed = state
    push = (1.0 - propeller.thrust_deduction) * thrust(propeller, shaft_rate, axial_flow)
    return (
        (motor_torque - torque(propeller, shaft_rate, axial_flow)) / propeller.shaft_inertia,
        flow_acceleration(propeller, shaft_rate, axial_flow, speed),
        (push - resistance.force(speed)) / resistance.mass,
    )


@dataclass(frozen=True)
class PropulsionRun:
    """A simulated run: every array has shape (steps + 1,) or (steps + 1, n), times [s] (steps + 1,).

    `shaft_rate` [rad/s], `axial_flow` and `speed` [m/s], `thrust` [N], `torque` of the water on the shaft [N m].
    """

    time: Array
    shaft_rate: Array
    axial_flow: Array
    speed: Array
    thrust: Array
    torque: Array


def simulate_propulsion(
    propeller: Propeller,
    resistance: Resistance,
    motor_torque: Array,
    time_step: float,
    start: State = (0.0, 0.0, 0.0),
) -> PropulsionRun:
    """Simulate the three states under a motor torque held over each step (fixed-step Runge-Kutta).

    Parameters
    ----------
    motor_torque : array, shape (steps,) or (steps, n)
        Q_m over each step [N m].
    time_step : float
        Step [s]. The flow in the disc is the fast state: keep below about 2 m_f/(d_f |u_p|).
    start : tuple
        Shaft rate, flow in the disc and speed at the start; default at rest.

    Raises
    ------
    FloatingPointError
        When the step is too long for the flow in the disc and the run diverges.
    """
    shape = (len(motor_torque) + 1, *np.shape(motor_torque)[1:])
    history = np.empty((3, *shape))
    state: State = start
    history[:, 0] = np.array([np.broadcast_to(value, shape[1:]) for value in state])
    with np.errstate(over="ignore", invalid="ignore"):
        for step, applied in enumerate(motor_torque.tolist() if motor_torque.ndim == 1 else motor_torque):
            state = _runge_kutta_step(propeller, resistance, state, applied, time_step)
            history[:, step + 1] = state
    if not np.all(np.isfinite(history)):
        raise FloatingPointError(f"the run diverged: a step of {time_step} s is too long for the flow in the disc")
    shaft_rate, axial_flow, speed = history
    return PropulsionRun(
        time=time_step * np.arange(shape[0]),
        shaft_rate=shaft_rate,
        axial_flow=axial_flow,
        speed=speed,
        thrust=np.asarray(thrust(propeller, shaft_rate, axial_flow)),
        torque=np.asarray(torque(propeller, shaft_rate, axial_flow)),
    )


def _runge_kutta_step(propeller: Propeller, resistance: Resistance, state: State, applied: Scalars, h: float) -> State:
    def moved(slope: State, step: float) -> State:
        return (state[0] + step * slope[0], state[1] + step * slope[1], state[2] + step * slope[2])

    k1 = rates(propeller, resistance, state, applied)
    k2 = rates(propeller, resistance, moved(k1, h / 2.0), applied)
    k3 = rates(propeller, resistance, moved(k2, h / 2.0), applied)
    k4 = rates(propeller, resistance, moved(k3, h), applied)
    mean = [(a + 2.0 * b + 2.0 * c + d) / 6.0 for a, b, c, d in zip(k1, k2, k3, k4, strict=True)]
    return moved((mean[0], mean[1], mean[2]), h)
