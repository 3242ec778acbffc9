"""Closed forms of Avila et al.: reference length and area, speed under thrust, a step of it, and Eq. 4."""

import math

import numpy as np

from missionplan.arrays import Array, Scalars


def characteristic_length(displaced_volume: Scalars) -> Scalars:
    """∇^(1/3) [m], the reference length of an open-frame vehicle's Reynolds number, from ∇ [m³] (Avila, sect. 4.1)."""
    return displaced_volume ** (1.0 / 3.0)


def characteristic_area(displaced_volume: Scalars) -> Scalars:
    """∇^(2/3) [m²], the reference area of an open-frame vehicle's drag coefficient; 0.3288 for ∇ = 0.1885 m³."""
    return displaced_volume ** (2.0 / 3.0)


def top_speed(thrust: Scalars, efficiency: Scalars, coefficient: Scalars, area: Scalars, density: Scalars) -> Scalars:
    """Speed at which ητ balances drag, √(2ητ/(C_D ρ A)): Avila et al., Eq. 1 with dU/dt = 0 [m/s].

    Parameters
    ----------
    thrust, efficiency : float or array
        τ [N] and the share η of it that propels.
    coefficient, area, density : float or array
        C_D on an area [m²], and ρ [kg/m³].
    """
    speed: Scalars = np.sqrt(2.0 * efficiency * thrust / (coefficient * density * area))
    return speed


def step_response(time: Array, speed: Scalars, thrust: Scalars, total_mass: Scalars) -> Scalars:
    """Speed after a step of effective thrust from rest, U tanh(t/T) with T = (m + m_ad)U/ητ [m/s].

    The closed form of Avila et al., Eq. 1 (Fig. 5).

    Parameters
    ----------
    time : array
        Since the step [s].
    speed : float or array
        The top speed U [m/s].
    thrust : float or array
        Effective thrust ητ [N].
    total_mass : float or array
        Mass and added mass [kg].
    """
    response: Scalars = speed * np.tanh(time * thrust / (total_mass * speed))
    return response


def keulegan_carpenter(amplitude: Scalars, diameter: Scalars) -> Scalars:
    """2πA/D of an oscillation (Avila et al., Eq. 4); below 10 inertia exceeds drag. 2.6 for 50 mm on 121 mm."""
    return 2.0 * math.pi * amplitude / diameter
