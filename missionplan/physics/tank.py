"""Towing-tank results of a vehicle: drag coefficient, scaling to full size, speed under thrust (Avila et al.).

Free oscillation on springs: added mass from its frequency, damping from its decay (Avila et al., section 4.2).
"""

import math
from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array, Scalars, magnitude


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


STEPS_PER_PERIOD = 40
"""The error is 2e-5 of the initial amplitude A at βA = 0.1, 2e-4 at 1; zero without quadratic damping."""
NODE = 0.5 - math.sqrt(3.0) / 6.0
"""First of the two Gauss nodes of a step, in steps."""


def natural_frequency(stiffness: Scalars, total_mass: Scalars) -> Scalars:
    """f_n = √(k/(m + m_ad))/2π [Hz] (Avila et al., Eq. 3), from k [N/m] and the total mass [kg]."""
    frequency: Scalars = np.sqrt(stiffness / total_mass) / (2.0 * math.pi)
    return frequency


def added_mass(frequency: Scalars, stiffness: Scalars, mass: Scalars) -> Scalars:
    """m_ad = k/(2πf_n)² - m [kg]: Avila et al., Eq. 3 solved.

    Two of k, m and m_ad determine the third: frequencies alone cannot determine all of them.

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
    """2πA/D of an oscillation (Avila et al., Eq. 4); below 10 inertia exceeds drag. 2.6 for 50 mm on 121 mm."""
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

    ẍ + 2δẋ + βẋ|ẋ| + ω²x = 0 with ω² = k/(m + m_ad), split into its linear part and the quadratic damping, each
    solved exactly: SABA2 (Laskar and Robutel 2001, Celest. Mech. 80), with an error of order βA h⁴ + (βA)²h². Stable
    for any step, below and above critical damping.

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
    since = time - time[0]
    count = max(1, math.ceil(float(since[-1]) * float(np.max(frequency)) * STEPS_PER_PERIOD))
    h = float(since[-1]) / count or 1.0
    step = _Step.of(h, frequency, linear, quadratic)
    x, v = _plain(start), _plain(start_velocity)
    positions, velocities = np.empty((count, *shape)), np.empty((count, *shape))
    for k in range(count):
        positions[k], velocities[k] = x, v
        x, v = step(x, v)
    # each sample is computed from the step before it, by a shorter step
    before = np.minimum((since / h).astype(int), count - 1)
    rest = (since - before * h).reshape(-1, *(1 for _ in shape))
    return np.asarray(_Step.of(rest, frequency, linear, quadratic)(positions[before], velocities[before])[0])


Flow = tuple[Scalars, Scalars, Scalars, Scalars]
"""Rows of the matrix that advances displacement and velocity over a time."""


@dataclass(frozen=True)
class _Step:
    """A step of `displacement`: linear flow between the Gauss nodes, half a step of quadratic damping at each."""

    outer: Flow
    inner: Flow
    damping: Scalars

    @classmethod
    def of(cls, time: Scalars, frequency: Scalars, linear: Scalars, quadratic: Scalars) -> "_Step":
        """Step of a length [s], with the constants of `displacement`."""
        outer = _linear_flow(NODE * time, frequency, linear)
        inner = _linear_flow((1.0 - 2.0 * NODE) * time, frequency, linear)
        return cls(outer, inner, _plain(0.5 * time * quadratic))

    def __call__(self, x: Scalars, v: Scalars) -> tuple[Scalars, Scalars]:
        """Displacement and velocity at the end of the step."""
        (a, b, c, d), (e, f, g, h), damping = self.outer, self.inner, self.damping
        x, v = a * x + b * v, c * x + d * v
        v = v / (1.0 + damping * magnitude(v))
        x, v = e * x + f * v, g * x + h * v
        v = v / (1.0 + damping * magnitude(v))
        return a * x + b * v, c * x + d * v


def _linear_flow(time: Scalars, frequency: Scalars, linear: Scalars) -> Flow:
    """Solve ẍ + 2δẋ + ω²x = 0 over a time, at any damping."""
    square = (2.0 * math.pi * frequency) ** 2
    root = np.sqrt(np.asarray(linear**2 - square, dtype=complex))
    slow, fast = np.exp((root - linear) * time), np.exp((-root - linear) * time)
    critical = np.abs(root * time) < 1e-6
    cosine: Array = np.real(slow + fast) / 2.0
    sine: Array = np.where(critical, time * cosine, np.real((slow - fast) / np.where(critical, 1.0, 2.0 * root)))
    return _plain(cosine + linear * sine), _plain(sine), _plain(-square * sine), _plain(cosine - linear * sine)


def _plain(value: Scalars) -> Scalars:
    """Return a single number as a float: stepping is several times faster on floats than on numpy's."""
    return np.asarray(value, dtype=float) if np.ndim(value) else float(value)


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
