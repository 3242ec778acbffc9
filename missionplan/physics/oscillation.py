"""Free oscillation on springs: added mass from its frequency, damping from its decay (Avila et al., section 4.2)."""

import math

import numpy as np

from missionplan.physics.arrays import Array, Scalars

STEPS_A_PERIOD = 60
"""Runge-Kutta steps in a period: 2e-7 of the amplitude a period."""


def natural_frequency(stiffness: Scalars, total_mass: Scalars) -> Scalars:
    """f_n = √(k/(m + m_ad))/2π [Hz] (Avila et al., Eq. 3), from k [N/m] and the total mass [kg]."""
    frequency: Scalars = np.sqrt(stiffness / total_mass) / (2.0 * math.pi)
    return frequency


def added_mass(frequency: Scalars, stiffness: Scalars, mass: Scalars) -> Scalars:
    """m_ad = k/(2πf_n)² - m [kg]: Avila et al., Eq. 3 solved.

    Only the two of k, m and m_ad that are given fix the third: no set of frequencies finds all of them.

    Parameters
    ----------
    frequency : float or array
        Of the free oscillation in water [Hz].
    stiffness : float or array
        k of all springs together [N/m]. Table 3 agrees with 4165.9 N/m and m = 24.00 kg; the printed 4585.8 N/m
        gives 13.04/18.77/34.93 kg.
    mass : float or array
        In air [kg].
    """
    return stiffness / (2.0 * math.pi * frequency) ** 2 - mass


def added_mass_sd(frequency: Scalars, frequency_sd: Scalars, stiffness: Scalars) -> Scalars:
    """Standard deviation of `added_mass` from that of the frequency alone, 2 k/(2πf)² σ_f/f [kg]."""
    return 2.0 * stiffness / (2.0 * math.pi * frequency) ** 2 * frequency_sd / frequency


def keulegan_carpenter(amplitude: Scalars, diameter: Scalars) -> Scalars:
    """2πA/D of an oscillation (Avila et al., Eq. 4); below 10 inertia is more than drag. 2.6 for 50 mm on 121 mm."""
    return 2.0 * math.pi * amplitude / diameter


def displacement(
    time: Array,
    start: Scalars,
    start_velocity: Scalars,
    frequency: Scalars,
    linear: Scalars,
    quadratic: Scalars,
) -> Array:
    """Displacement of a mass on a spring with linear and quadratic damping.

    ẍ + 2δẋ + βẋ|ẋ| + ω²x = 0 with ω² = k/(m + m_ad), stepped by Runge-Kutta at `STEPS_A_PERIOD` or finer.

    Parameters
    ----------
    time : array, shape (samples,)
        Ascending [s]; the first is the start.
    start, start_velocity : float or array, shape (n,)
        Displacement [m] and velocity [m/s] at the first time.
    frequency : float or array
        ω/2π [Hz], of the undamped oscillation.
    linear, quadratic : float or array
        δ [1/s] and β [1/m], both over the total mass.

    Returns
    -------
    array, shape (samples,) or (samples, n)
        Displacement [m].
    """
    shape = np.broadcast_shapes(*(np.shape(value) for value in (start, start_velocity, frequency, linear, quadratic)))
    x, v = np.broadcast_to(start, shape).astype(float), np.broadcast_to(start_velocity, shape).astype(float)
    square = (2.0 * math.pi * frequency) ** 2

    def force(x: Array, v: Array) -> Array:
        acceleration: Array = -square * x - (2.0 * linear + quadratic * np.abs(v)) * v
        return acceleration

    longest = 1.0 / (STEPS_A_PERIOD * float(np.max(frequency)))
    result = np.empty((len(time), *shape))
    result[0] = x
    for sample, interval in enumerate(np.diff(time), start=1):
        substeps = max(1, math.ceil(interval / longest))
        h = interval / substeps
        for _ in range(substeps):
            k1 = force(x, v)
            k2 = force(x + h / 2 * v, v + h / 2 * k1)
            k3 = force(x + h / 2 * v + h * h / 4 * k1, v + h / 2 * k2)
            k4 = force(x + h * v + h * h / 2 * k2, v + h * k3)
            x, v = x + h * v + h * h / 6 * (k1 + k2 + k3), v + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        result[sample] = x
    return result


def envelope(time: Array, amplitude: Scalars, frequency: Scalars, linear: Scalars, quadratic: Scalars) -> Array:
    """Amplitude of a lightly damped oscillation, averaged over its periods (Krylov and Bogoliubov) [m].

    dA/dt = -δA - 4βωA²/3π, so A = A₀e^(-δt)/(1 + g(1 - e^(-δt))/δ) with g = 4βωA₀/3π.

    Parameters
    ----------
    time : array
        Since the start [s].
    amplitude : float or array
        A₀ [m].
    frequency, linear, quadratic : float or array
        As in `displacement`.
    """
    rate = 8.0 / 3.0 * quadratic * frequency * amplitude
    product = np.asarray(linear * time)
    decayed = np.where(np.abs(product) > 1e-9, -np.expm1(-product) / np.where(product == 0.0, 1.0, product), 1.0) * time
    result: Array = amplitude * np.exp(-product) / (1.0 + rate * decayed)
    return result
