"""Towing-tank results of a vehicle: drag coefficient, scaling to full size, speed under thrust (Avila et al.)."""

import numpy as np

from missionplan.arrays import Array, Scalars


def characteristic_length(displaced_volume: Scalars) -> Scalars:
    """∇^(1/3) [m], the reference length of an open-frame vehicle's Reynolds number, from ∇ [m³] (Avila, sect. 4.1)."""
    return displaced_volume ** (1.0 / 3.0)


def characteristic_area(displaced_volume: Scalars) -> Scalars:
    """∇^(2/3) [m²], the reference area of an open-frame vehicle's drag coefficient; 0.3288 for ∇ = 0.1885 m³."""
    return displaced_volume ** (2.0 / 3.0)


def drag_coefficient(force: Scalars, speed: Scalars, area: Scalars, density: Scalars) -> Scalars:
    """C_D = F/(½ρAU²) (Avila et al., sect. 4.1), from drag [N], speed [m/s], area [m²] and ρ [kg/m³].

    Table 1 results from ∇ = 0.0236 m³ (its 2.243 at 0.6 m/s), Table 6 from 0.02356 m³; the 0.0222 m³ of Eq. 5's
    example agrees with neither.
    """
    return force / (0.5 * density * area * speed**2)


def reynolds_drag_coefficient(
    reynolds: Scalars, coefficient: Scalars, exponent: Scalars, at_reynolds: float
) -> Scalars:
    """C_D = C (Re/Re₀)^p: a drag coefficient that varies slowly with the Reynolds number.

    Parameters
    ----------
    reynolds : float or array
        Re.
    coefficient : float or array
        C, the value at Re₀.
    exponent : float or array
        p; 0 for a bluff body with fixed separation, about -1/6 for turbulent friction.
    at_reynolds : float
        Re₀, the middle of the measured range.
    """
    return coefficient * (reynolds / at_reynolds) ** exponent


def full_size_mass(model_mass: Scalars, scale: float) -> Scalars:
    """Added mass of the full-size vehicle from that of a model 1:λ, m λ³ (Avila et al., Eq. 5) [kg].

    λ = 2 gives a factor of 8 and 77.2/118.8/236.3 kg; the paper's 8.49 is 0.1885/0.0222, a wrong model volume.
    """
    return model_mass * scale**3


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
