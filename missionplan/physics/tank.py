"""Towing-tank results of a vehicle: drag coefficient and scaling to full size (Avila et al.).

Free oscillation on springs: added mass from its frequency, damping from its decay (Avila et al., section 4.2).
"""

import math
from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array, Scalars, magnitude


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
