"""Dynamics of shaft, axial flow and surge together (Blanke et al. 2000, Eqs. 24 to 31), stepped in time, and power."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.physics.propeller import Propeller, Resistance, flow_acceleration, steady_axial_flow, thrust, torque

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

    The number of steps is fixed and the flow is stepped linearly implicitly, so that the result is a smooth function
    of the propeller's constants, as fitting requires.

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

    Raises
    ------
    ValueError
        When not exactly one of shaft rate and torque is given.
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
    """Electrical power of propulsion, F u/η = ½ρAC_d u³/η.

    Parameters
    ----------
    drag : float or array, shape (n,)
        F at that speed [N].
    speed : float or array, shape (n,)
        u through the water [m/s].
    efficiency : float or array, shape (n,)
        η, from the battery to the work against drag.

    Returns
    -------
    float or array, shape (n,)
        [W]
    """
    return drag * speed / efficiency
