"""Causes hidden in navigation logs: the catalogue's twelve in shapes of their own, and others.

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


@dataclass(frozen=True)
class Field:
    """What a builder may know of the survey."""

    origin_latitude: float
    """[deg]"""
    span: float
    """Of the record [s]."""
    extent: float
    """Root mean square distance from the first fix [m]."""
    legs: int
    leg_time: float
    """Typical length of a leg [s]."""
    speed: float
    sigma: float
    """Of the independent velocity error [m/s]."""


@dataclass(frozen=True)
class Bend:
    """What an effect changes in a leg; every field is neutral by default."""

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
    """For the oracle: kind of random effect and its two numbers."""


Builder = Callable[[float, np.random.Generator, Field], tuple[Bend, Parameters]]


@dataclass(frozen=True)
class Cause:
    """Range of sizes that can be told from the nuisances, and the builder."""

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


def _mean_current(size, rng, survey):
    """A steady current with a slight swing over the days."""
    current = toward(rng, size)
    swing, phase = rng.uniform(0.0, 0.05), rng.uniform(0.0, 2.0 * np.pi)

    def velocity(t, position):
        return current * (1.0 + swing * np.sin(2.0 * np.pi * t / (0.37 * survey.span) + phase))

    return Bend(current=velocity), {"east": float(current[0]), "north": float(current[1])}


def _tidal_current(size, rng, survey):
    """Four constituents on ellipses, semidiurnal or diurnal, slowly modulated as between springs and neaps."""
    strong = ("M2", "S2") if rng.random() < 0.7 else ("K1", "O1")
    parts = []
    for name, period in PERIODS.items():
        share = {strong[0]: 1.0, strong[1]: rng.uniform(0.1, 0.4)}.get(name, rng.uniform(0.02, 0.12))
        parts.append((2.0 * np.pi / period, *ellipse(rng, size * share, rng.uniform(-0.4, 0.4))))
    depth, phase = rng.uniform(0.0, 0.1), rng.uniform(0.0, 2.0 * np.pi)

    def velocity(t, position):
        w = tide(parts, t) * (1.0 + depth * np.cos(2.0 * np.pi * t / (13.66 * 86400.0) + phase))
        return np.array([w.real, w.imag])

    return Bend(current=velocity), {}


def _inertial_current(size, rng, survey):
    """Circles at a frequency a touch above the inertial one, steady or set off by one or two gusts and decaying."""
    f = 4.0 * np.pi / SIDEREAL_DAY * np.sin(np.radians(survey.origin_latitude))
    omega = f * (1.0 + rng.uniform(0.0, 0.02))
    steady = rng.random() < 0.5
    gusts = [(-1e9, 1.0, rng.uniform(0.0, 2.0 * np.pi), 1e15)]
    if not steady:
        times = np.sort(rng.uniform(-0.3, 0.1, int(rng.integers(1, 3)))) * survey.span
        fade = rng.uniform(1.0, 2.5) * survey.span
        gusts = [(float(when), 1.3, rng.uniform(0.0, 2.0 * np.pi), fade) for when in times]

    def velocity(t, position):
        # positive f (north) turns clockwise
        w = sum(
            amplitude * np.exp(-(t - when) / fade + 1j * (phase - omega * t)) if t > when else 0.0
            for when, amplitude, phase, fade in gusts
        )
        w = size * complex(w)
        return np.array([w.real, w.imag])

    return Bend(current=velocity), {}


def _compass_bias(size, rng, survey):
    """The true course lies clockwise of the one steered (or the other way)."""
    angle = sign(rng) * size
    return Bend(turn=lambda t, heading: angle), {"angle": angle}


def _compass_deviation(size, rng, survey):
    """Hard iron, with a little soft iron's second harmonic."""
    phase, other = rng.uniform(0.0, 2.0 * np.pi, 2)
    second = rng.uniform(0.0, 0.12) * size
    return Bend(turn=lambda t, heading: size * np.sin(heading + phase) + second * np.sin(2.0 * heading + other)), {
        "amplitude": size
    }


def _speed_scale(size, rng, survey):
    """The propeller makes more or less way than its calibration says."""
    fraction = sign(rng) * size
    return Bend(pace=lambda t: 1.0 + fraction), {"fraction": fraction}


def _surface_drift(size, rng, survey):
    """Wind and waves carry the vehicle while it waits for a fix; the wind wavers."""
    drift = toward(rng, size)
    waver, phase = rng.uniform(0.0, 0.15), rng.uniform(0.0, 2.0 * np.pi)
    return Bend(surface=lambda t: drift * (1.0 + waver * np.sin(2.0 * np.pi * t / 50000.0 + phase))), {
        "east": float(drift[0]),
        "north": float(drift[1]),
    }


def _persistent_error(size, rng, survey):
    """A current that forgets itself: Ornstein–Uhlenbeck on a fine grid, integrated along each leg."""
    sigma = size * survey.sigma
    memory = rng.uniform(2.5, 8.0) * survey.span / survey.legs
    t = np.arange(0.0, 1.3 * survey.span, survey.leg_time / 8.0)
    keep = np.exp(-(t[1] - t[0]) / memory)
    steps = rng.standard_normal((2, t.size)) * np.sqrt(1.0 - keep**2)
    v = np.empty((2, t.size))
    v[:, 0] = rng.standard_normal(2)
    for k in range(1, t.size):
        v[:, k] = keep * v[:, k - 1] + steps[:, k]
    return Bend(wander=(t, sigma * v), statistic=("persistent-error", sigma, memory)), {"sigma": sigma, "time": memory}


def _random_walk(size, rng, survey):
    """An error that accumulates and never returns, from nothing at the first fix."""
    rate = size * survey.sigma / np.sqrt(survey.span)
    t = np.arange(0.0, 1.3 * survey.span, survey.leg_time / 8.0)
    v = np.cumsum(rng.standard_normal((2, t.size)), axis=1) * np.sqrt(t[1])
    return Bend(wander=(t, rate * v), statistic=("random-walk", rate, 0.0)), {"rate": rate}


def _fix_error(size, rng, survey):
    """Fixes far worse than the receiver's data sheet."""
    sd = size * survey.sigma * survey.leg_time
    return Bend(fix_sd=sd, statistic=("fix-error", sd, 0.0)), {"sd": sd}


def _heavy_tails(size, rng, survey):
    """Now and then a leg goes badly wrong: Student's t, or a mixture of good and bad legs."""
    if rng.random() < 0.6:
        dof = 2.0 + 1.6 / size
        stretch = np.sqrt(dof / rng.chisquare(dof, survey.legs))
        return Bend(stretch=stretch, statistic=("student", dof, 0.0)), {"dof": dof}
    share = rng.uniform(0.07, 0.16)
    wild = 1.0 + 2.2 * size
    stretch = np.where(rng.random(survey.legs) < share, wild, 1.0)
    return Bend(stretch=stretch, statistic=("mixture", share, wild)), {}


def _current_shear(size, rng, survey):
    """Strain and rotation of the current about the first fix, levelling off far away."""
    gradient = rng.standard_normal((2, 2))
    gradient *= size / survey.extent / np.linalg.norm(gradient) * np.sqrt(2.0)
    far = 6.0 * survey.extent

    def velocity(t, position):
        r = float(np.hypot(*position))
        return gradient @ position * (np.tanh(r / far) / (r / far) if r > 1.0 else 1.0)

    return Bend(current=velocity), {}


CATALOGUE: dict[str, Cause] = {
    "mean-current": Cause(0.03, 0.15, _mean_current),
    "tidal-current": Cause(0.04, 0.20, _tidal_current),
    "inertial-current": Cause(0.04, 0.15, _inertial_current),
    "compass-bias": Cause(np.radians(2.0), np.radians(8.0), _compass_bias),
    "compass-deviation": Cause(np.radians(3.0), np.radians(10.0), _compass_deviation),
    "speed-scale": Cause(0.03, 0.12, _speed_scale),
    "surface-drift": Cause(0.10, 0.50, _surface_drift),
    "persistent-error": Cause(1.2, 4.0, _persistent_error),
    "random-walk": Cause(1.5, 5.0, _random_walk),
    "fix-error": Cause(0.8, 2.5, _fix_error),
    "heavy-tails": Cause(1.0, 3.5, _heavy_tails),
    "current-shear": Cause(0.03, 0.12, _current_shear),
}
