"""Effects hidden in dives: the catalogue's twelve, with shapes different from those that an inference would choose.

Each builder takes a size, a random generator for its shape and the conditions of the dives, and returns the effect
with those of its parameters whose definition the contract shares exactly.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .dynamics import STEP, DiveEffect

Parameters = dict[str, float]


@dataclass(frozen=True)
class DiveConditions:
    """Conditions of the dives that a builder depends on."""

    lightest: float
    """Smallest wet weight [N]."""
    slowest: float
    fastest: float
    """Terminal speeds of the lightest and the heaviest anchor [m/s]."""
    shallowest: float
    """Smallest depth of the vehicle at touchdown [m]."""
    longest_time: float
    """Approximate duration of the longest dive [s]."""
    lines: tuple[float, ...]
    """Line length by the dive's number [m]."""


Builder = Callable[[float, np.random.Generator, DiveConditions], tuple[DiveEffect, Parameters]]


@dataclass(frozen=True)
class EffectKind:
    """Range of sizes that are distinguishable from the nuisances, and the builder."""

    low: float
    high: float
    build: Builder


def sign(rng: np.random.Generator, positive: float = 0.5) -> float:
    """Random sign, positive with this probability."""
    return 1.0 if rng.random() < positive else -1.0


def _drag_bias(size, rng, conditions):
    """Rough or fouled skin: a factor that depends slightly on speed."""
    fraction = size if rng.random() < 0.7 else -0.6 * size
    lean = rng.uniform(-0.08, 0.08)
    middle = 0.5 * (conditions.slowest + conditions.fastest)

    def factor(t, u, z, number):
        return 1.0 + fraction * max(abs(u) / middle, 0.1) ** lean

    return DiveEffect(lone_drag=1.0 + fraction, drag=factor), {"fraction": fraction}


def _line_payout(size, rng, conditions):
    """Wraps that catch: one short stop per wrap, so the delay is a sum over the line's length."""
    wraps_per_metre = rng.uniform(20.0, 60.0)
    seed = int(rng.integers(2**32))

    def delay(line, number):
        wraps = max(1, round(wraps_per_metre * line))
        stops = np.random.default_rng([seed, number]).gamma(2.0, 0.5 / wraps_per_metre, wraps)
        return size * float(stops.sum())

    return DiveEffect(delay=delay), {"delay_per_length": size}


def _slow_flooding(size, rng, conditions):
    """Air that escapes at a constant rate, or through an orifice under its own falling head."""
    power = float(rng.choice([1.0, 2.0]))
    full = rng.uniform(0.35, 0.8) * conditions.longest_time

    def weight(t, z):
        return 1.0 - size * max(0.0, 1.0 - t / full) ** power

    return DiveEffect(weight=weight), {}


def _trapped_gas(size, rng, conditions):
    """A few gas pockets along the hull, each by Boyle's law at its own height above the nose."""
    lift = size * conditions.lightest
    shares = rng.dirichlet([3.0, 3.0, 2.0])
    heights = rng.uniform(0.0, 1.0, 3)
    head = 10.13

    def up(z):
        return float(np.sum(lift * shares * head / (head + np.maximum(z - heights, 0.0))))

    return DiveEffect(lift=up), {"lift": lift}


def _stratification(size, rng, conditions):
    """Denser water below a pycnocline: linear between two depths, or two close steps."""
    lift = size * conditions.lightest
    top = rng.uniform(0.2, 0.5) * conditions.shallowest
    thick = rng.uniform(0.05, 0.3) * conditions.shallowest
    corner = rng.uniform(0.3, 0.7) if rng.random() < 0.5 else 0.5

    def up(z):
        return lift * float(np.interp(z, [top, top + corner * thick, top + thick], [0.0, 0.5, 1.0]))

    return DiveEffect(lift=up), {}


def _broadside_start(size, rng, conditions):
    """The hull is level when the line comes taut and pitches down as a damped second-order motion."""
    relax = rng.uniform(1.2, 3.0)

    def slope(t):
        return 90.0 * (1.0 + t / relax) * np.exp(-t / relax)

    def factor(t, u, z, number):
        return 1.0 + size * float(np.sin(np.radians(slope(max(t, 0.0)))) ** 2)

    return DiveEffect(drag=factor, pitch=slope), {}


def _added_mass(size, rng, conditions):
    """Water carried in the fairing: part of the momentum from the snatch on."""
    return DiveEffect(mass=1.0 + size), {"fraction": size}


def _sensor_lag(size, rng, conditions):
    """Two poles in series, or a moving average over the last seconds, with the same mean delay."""
    if rng.random() < 0.5:
        second = rng.uniform(0.15, 0.4) * size
        lags = (size - second, second)

        def reading(t, depth, number):
            out = depth
            for lag in lags:
                share = 1.0 - np.exp(-STEP / lag)
                filtered = np.empty_like(out)
                state = out[0]
                for i, value in enumerate(out):
                    state += share * (value - state)
                    filtered[i] = state
                out = filtered
            return out

    else:
        window = max(1, round(2.0 * size / STEP))

        def reading(t, depth, number):
            padded = np.concatenate([np.full(window - 1, depth[0]), depth])
            return np.convolve(padded, np.full(window, 1.0 / window), "valid")

    return DiveEffect(reading=reading), {"time": size}


def _clock_offset(size, rng, conditions):
    """The log's zero is not the separation, with a slight variation from dive to dive."""
    offset = sign(rng, 0.6) * size
    seed = int(rng.integers(2**32))

    def delay(line, number):
        return offset + 0.03 * float(np.random.default_rng([seed, number]).standard_normal())

    return DiveEffect(delay=delay), {"time": offset}


def _depth_scale(size, rng, conditions):
    """Wrong gain of the pressure sensor, with a slight curvature."""
    fraction = sign(rng) * size
    curvature = rng.uniform(-1e-4, 1e-4)
    return DiveEffect(reading=lambda t, depth, number: depth * (1.0 + fraction + curvature * depth)), {
        "fraction": fraction
    }


def _vertical_current(size, rng, conditions):
    """Upwelling or downwelling that vanishes towards the surface within about a metre."""
    speed = sign(rng) * size
    skin = rng.uniform(0.2, 1.0)
    return DiveEffect(water=lambda t, z: speed * (1.0 - np.exp(-max(z, 0.0) / skin))), {"speed": speed}


def _drag_crisis(size, rng, conditions):
    """Drag falls linearly to its lower value over a band of speeds that some of the dives cross."""
    span = conditions.fastest - conditions.slowest
    critical = rng.uniform(max(0.6 * conditions.slowest, conditions.slowest - span), conditions.slowest + 0.6 * span)
    band = rng.uniform(0.06, 0.25) * critical

    def factor(t, u, z, number):
        return 1.0 - size * min(1.0, max(0.0, (abs(u) - critical + 0.5 * band) / band))

    return DiveEffect(drag=factor), {}


CATALOGUE: dict[str, EffectKind] = {
    "drag-bias": EffectKind(0.18, 0.7, _drag_bias),
    "line-payout": EffectKind(0.12, 0.5, _line_payout),
    "slow-flooding": EffectKind(0.15, 0.5, _slow_flooding),
    "trapped-gas": EffectKind(0.10, 0.35, _trapped_gas),
    "stratification": EffectKind(0.08, 0.30, _stratification),
    "broadside-start": EffectKind(0.6, 4.0, _broadside_start),
    "added-mass": EffectKind(0.15, 0.8, _added_mass),
    "sensor-lag": EffectKind(0.35, 1.5, _sensor_lag),
    "clock-offset": EffectKind(0.4, 1.5, _clock_offset),
    "depth-scale": EffectKind(0.03, 0.10, _depth_scale),
    "vertical-current": EffectKind(0.06, 0.20, _vertical_current),
    "drag-crisis": EffectKind(0.15, 0.5, _drag_crisis),
}
