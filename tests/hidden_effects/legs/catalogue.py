"""Effects hidden in navigation logs: the catalogue's twelve, with shapes different from the library's.

Times are seconds since the log's first fix, headings radians clockwise from north, velocities (east, north) in m/s.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Parameters = dict[str, float]
HOUR = 3600.0
PERIODS = {"M2": 12.4206 * HOUR, "S2": 12.0 * HOUR, "K1": 23.9345 * HOUR, "O1": 25.8193 * HOUR}
SIDEREAL_DAY = 86164.0905
STEPS_OF_A_LEG = 64
"""Steps of a random velocity in a leg's usual time: with eight, means of a walk over legs vary a seventh too little."""


@dataclass(frozen=True)
class LegConditions:
    """Conditions of the survey that a builder depends on."""

    origin_latitude: float
    """Latitude of the first fix [deg]."""
    span: float
    """Duration of the record [s]."""
    extent: float
    """Root mean square distance from the first fix [m]."""
    legs: int
    leg_time: float
    """Typical duration of a leg [s]."""
    speed: float
    sigma: float
    """Standard deviation of the independent velocity error, each axis [m/s]."""


@dataclass(frozen=True)
class LegEffect:
    """Changes of a leg by an effect; every field is neutral by default."""

    turn: Callable[[float, float], float] | None = None
    """Angle by which the true course is clockwise of the one steered, from time and heading [rad]."""
    pace: Callable[[float], float] | None = None
    """Factor on the speed through the water, from time."""
    current: Callable[[float, Array], Array] | None = None
    """Unknown velocity of the water from time and position."""
    surface: Callable[[float], Array] | None = None
    """Drift at the surface, from time."""
    push: Callable[[float, float, float], Array] | None = None
    """Displacement of a leg [m], from heading, speed through the water and time under way."""
    fix_sd: float = 0.0
    stretch: Array | None = None
    """Factor on each leg's independent velocity error, shape (legs,)."""
    wander: tuple[Array, Array] | None = None
    """Times and a random velocity at them, shapes (m,) and (2, m)."""
    statistic: tuple[str, float, float] | None = None
    """For the strength: kind of random effect and its two parameters."""


Builder = Callable[[float, np.random.Generator, LegConditions], tuple[LegEffect, Parameters]]


@dataclass(frozen=True)
class EffectKind:
    """Range of sizes that are distinguishable from the nuisances, and the builder."""

    low: float
    high: float
    build: Builder


def sign(rng: np.random.Generator) -> float:
    return 1.0 if rng.random() < 0.5 else -1.0


def toward(rng: np.random.Generator, speed: float) -> Array:
    angle = rng.uniform(0.0, 2.0 * np.pi)
    return speed * np.array([np.sin(angle), np.cos(angle)])


def ellipse(rng: np.random.Generator, major: float, rotary: float) -> tuple[complex, complex]:
    """Anticlockwise and clockwise complex amplitudes of a tidal ellipse; `rotary` in (-1, 1) is minor over major."""
    tilt, phase = rng.uniform(0.0, np.pi), rng.uniform(0.0, 2.0 * np.pi)
    left, right = 0.5 * major * (1.0 + rotary), 0.5 * major * (1.0 - rotary)
    return left * np.exp(1j * (tilt + phase)), right * np.exp(1j * (tilt - phase))


def tide(parts: list[tuple[float, complex, complex]], t: float) -> complex:
    """East + i north of constituents, each of angular frequency, anticlockwise and clockwise amplitude."""
    return sum(left * np.exp(1j * omega * t) + right * np.exp(-1j * omega * t) for omega, left, right in parts)


def _mean_current(size, rng, conditions):
    """A steady current with a slight oscillation over days."""
    current = toward(rng, size)
    swing, phase = rng.uniform(0.0, 0.05), rng.uniform(0.0, 2.0 * np.pi)

    def velocity(t, position):
        return current * (1.0 + swing * np.sin(2.0 * np.pi * t / (0.37 * conditions.span) + phase))

    return LegEffect(current=velocity), {"east": float(current[0]), "north": float(current[1])}


def _tidal_current(size, rng, conditions):
    """Ellipses of four constituents, semidiurnal or diurnal, slowly modulated as between springs and neaps."""
    strong = ("M2", "S2") if rng.random() < 0.7 else ("K1", "O1")
    parts = []
    for name, period in PERIODS.items():
        share = {strong[0]: 1.0, strong[1]: rng.uniform(0.1, 0.4)}.get(name, rng.uniform(0.02, 0.12))
        parts.append((2.0 * np.pi / period, *ellipse(rng, size * share, rng.uniform(-0.4, 0.4))))
    depth, phase = rng.uniform(0.0, 0.1), rng.uniform(0.0, 2.0 * np.pi)

    def velocity(t, position):
        w = tide(parts, t) * (1.0 + depth * np.cos(2.0 * np.pi * t / (13.66 * 86400.0) + phase))
        return np.array([w.real, w.imag])

    return LegEffect(current=velocity), {}


def _inertial_current(size, rng, conditions):
    """Circles at a frequency slightly above the inertial one, steady or excited by one or two gusts and decaying."""
    f = 4.0 * np.pi / SIDEREAL_DAY * np.sin(np.radians(conditions.origin_latitude))
    omega = f * (1.0 + rng.uniform(0.0, 0.02))
    steady = rng.random() < 0.5
    gusts = [(-1e9, 1.0, rng.uniform(0.0, 2.0 * np.pi), 1e15)]
    if not steady:
        times = np.sort(rng.uniform(-0.3, 0.1, int(rng.integers(1, 3)))) * conditions.span
        fade = rng.uniform(1.0, 2.5) * conditions.span
        gusts = [(float(when), 1.3, rng.uniform(0.0, 2.0 * np.pi), fade) for when in times]

    def velocity(t, position):
        # positive f (north) turns clockwise
        w = sum(
            amplitude * np.exp(-(t - when) / fade + 1j * (phase - omega * t)) if t > when else 0.0
            for when, amplitude, phase, fade in gusts
        )
        w = size * complex(w)
        return np.array([w.real, w.imag])

    return LegEffect(current=velocity), {}


def _compass_bias(size, rng, conditions):
    """The true course is clockwise (or anticlockwise) of the one steered."""
    angle = sign(rng) * size
    return LegEffect(turn=lambda t, heading: angle), {"angle": angle}


def _compass_deviation(size, rng, conditions):
    """Hard iron, with a little soft iron's second harmonic."""
    phase, other = rng.uniform(0.0, 2.0 * np.pi, 2)
    second = rng.uniform(0.0, 0.12) * size
    return LegEffect(turn=lambda t, heading: size * np.sin(heading + phase) + second * np.sin(2.0 * heading + other)), {
        "amplitude": size
    }


def _speed_scale(size, rng, conditions):
    """The propeller gives more or less speed than its calibration."""
    fraction = sign(rng) * size
    return LegEffect(pace=lambda t: 1.0 + fraction), {"fraction": fraction}


def _surface_drift(size, rng, conditions):
    """Wind and waves move the vehicle while it waits for a fix; the wind is modulated."""
    drift = toward(rng, size)
    modulation, phase = rng.uniform(0.0, 0.15), rng.uniform(0.0, 2.0 * np.pi)
    return LegEffect(surface=lambda t: drift * (1.0 + modulation * np.sin(2.0 * np.pi * t / 50000.0 + phase))), {
        "east": float(drift[0]),
        "north": float(drift[1]),
    }


def _persistent_error(size, rng, conditions):
    """A slowly varying current: Ornstein–Uhlenbeck process on a fine grid, integrated along each leg."""
    sigma = size * conditions.sigma
    memory = rng.uniform(2.5, 8.0) * conditions.span / conditions.legs
    t = np.arange(0.0, 1.3 * conditions.span, conditions.leg_time / STEPS_OF_A_LEG)
    keep = np.exp(-(t[1] - t[0]) / memory)
    steps = rng.standard_normal((2, t.size)) * np.sqrt(1.0 - keep**2)
    v = np.empty((2, t.size))
    v[:, 0] = rng.standard_normal(2)
    for k in range(1, t.size):
        v[:, k] = keep * v[:, k - 1] + steps[:, k]
    return LegEffect(wander=(t, sigma * v), statistic=("persistent-error", sigma, memory)), {
        "sigma": sigma,
        "time": memory,
    }


def _random_walk(size, rng, conditions):
    """A velocity error that walks from zero at the first fix."""
    rate = size * conditions.sigma / np.sqrt(conditions.span)
    t = np.arange(0.0, 1.3 * conditions.span, conditions.leg_time / STEPS_OF_A_LEG)
    v = np.cumsum(rng.standard_normal((2, t.size)), axis=1) * np.sqrt(t[1])
    return LegEffect(wander=(t, rate * v), statistic=("random-walk", rate, 0.0)), {"rate": rate}


def _fix_error(size, rng, conditions):
    """Fixes much worse than the receiver's data sheet."""
    sd = size * conditions.sigma * conditions.leg_time
    return LegEffect(fix_sd=sd, statistic=("fix-error", sd, 0.0)), {"sd": sd}


def _heavy_tails(size, rng, conditions):
    """Occasional large errors: Student's t, or a mixture of good and bad legs."""
    if rng.random() < 0.6:
        dof = 2.0 + 1.6 / size
        stretch = np.sqrt(dof / rng.chisquare(dof, conditions.legs))
        return LegEffect(stretch=stretch, statistic=("student", dof, 0.0)), {"dof": dof}
    share = rng.uniform(0.07, 0.16)
    wild = 1.0 + 2.2 * size
    stretch = np.where(rng.random(conditions.legs) < share, wild, 1.0)
    return LegEffect(stretch=stretch, statistic=("mixture", share, wild)), {}


def _current_shear(size, rng, conditions):
    """Strain and rotation of the current about the first fix, saturating far away."""
    gradient = rng.standard_normal((2, 2))
    gradient *= size / conditions.extent / np.linalg.norm(gradient) * np.sqrt(2.0)
    far = 6.0 * conditions.extent

    def velocity(t, position):
        r = float(np.hypot(*position))
        return gradient @ position * (np.tanh(r / far) / (r / far) if r > 1.0 else 1.0)

    return LegEffect(current=velocity), {}


CATALOGUE: dict[str, EffectKind] = {
    "mean-current": EffectKind(0.03, 0.15, _mean_current),
    "tidal-current": EffectKind(0.04, 0.20, _tidal_current),
    "inertial-current": EffectKind(0.04, 0.15, _inertial_current),
    "compass-bias": EffectKind(np.radians(2.0), np.radians(8.0), _compass_bias),
    "compass-deviation": EffectKind(np.radians(3.0), np.radians(10.0), _compass_deviation),
    "speed-scale": EffectKind(0.03, 0.12, _speed_scale),
    "surface-drift": EffectKind(0.10, 0.50, _surface_drift),
    "persistent-error": EffectKind(1.2, 4.0, _persistent_error),
    "random-walk": EffectKind(1.5, 5.0, _random_walk),
    "fix-error": EffectKind(0.8, 2.5, _fix_error),
    "heavy-tails": EffectKind(1.0, 3.5, _heavy_tails),
    "current-shear": EffectKind(0.03, 0.12, _current_shear),
}
