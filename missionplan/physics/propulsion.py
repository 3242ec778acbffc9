"""A propeller in a measured run (Blanke et al. 2000, Eqs. 24 and 30), and the power of propulsion."""

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.physics.propeller import Propeller, flow_acceleration, steady_axial_flow, torque

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
