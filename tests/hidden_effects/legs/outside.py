"""Effects on legs outside the catalogue, and those of them that were used in development."""

import numpy as np

from .catalogue import HOUR, PERIODS, EffectKind, LegEffect, ellipse, sign, tide, toward


def _eddy(size, rng, conditions):
    """A vortex somewhere in the area."""
    centre = rng.standard_normal(2) * 0.7 * conditions.extent
    radius = rng.uniform(0.3, 0.7) * conditions.extent
    spin = sign(rng)

    def velocity(t, position):
        d = (position - centre) / radius
        return size * spin * np.array([-d[1], d[0]]) * np.exp(0.5 - 0.5 * float(d @ d))

    return LegEffect(current=velocity), {}


def _battery_sag(size, rng, conditions):
    """The motor slows as the battery empties; dead reckoning does not include this."""
    power = rng.uniform(0.8, 2.5)
    return LegEffect(pace=lambda t: 1.0 - size * min(1.5, t / conditions.span) ** power), {}


def _compass_drift(size, rng, conditions):
    """A gyro compass with a steady drift."""
    angle = sign(rng) * size
    return LegEffect(turn=lambda t, heading: angle * t / conditions.span), {}


def _front(size, rng, conditions):
    """At some time another water mass arrives."""
    when = rng.uniform(0.3, 0.7) * conditions.span
    after = toward(rng, size)
    return LegEffect(current=lambda t, position: after if t > when else np.zeros(2)), {}


def _leeway(size, rng, conditions):
    """The vehicle crabs to one side before the wind and to the other beside it."""
    wind = rng.uniform(0.0, 2.0 * np.pi)
    return LegEffect(turn=lambda t, heading: size * np.sin(2.0 * (heading - wind))), {}


def _storm_drift(size, rng, conditions):
    """Stokes drift while a storm passes."""
    when = rng.uniform(0.25, 0.75) * conditions.span
    width = rng.uniform(0.05, 0.12) * conditions.span
    drift = toward(rng, size)
    return LegEffect(current=lambda t, position: drift * np.exp(-0.5 * ((t - when) / width) ** 2)), {}


def _slow_start(size, rng, conditions):
    """Every leg loses the same distance at the start, while the vehicle accelerates."""
    lost = size * conditions.sigma * conditions.leg_time
    return LegEffect(push=lambda heading, speed, time: -lost * np.array([np.sin(heading), np.cos(heading)])), {}


def _weed(size, rng, conditions):
    """Weed catches in the propeller at some time and reduces the speed until it comes off, if it does."""
    caught = rng.uniform(0.1, 0.7) * conditions.span
    shed = caught + rng.uniform(0.1, 0.6) * conditions.span
    return LegEffect(pace=lambda t: 1.0 - size if caught < t < shed else 1.0), {}


def _gyro_creep(size, rng, conditions):
    """Under water a rate gyro holds the heading: correct at every dive, it drifts uniformly until the next fix.

    The Earth's rotation, if not corrected, is 15 degrees per hour times the sine of the latitude.
    """
    rate = sign(rng) * size

    def aside(heading, speed, time):
        half = 0.5 * rate * time
        chord = np.sinc(half / np.pi) * np.array([np.sin(heading + half), np.cos(heading + half)])
        return speed * time * (chord - np.array([np.sin(heading), np.cos(heading)]))

    return LegEffect(push=aside), {}


def _tidal_race(size, rng, conditions):
    """The tide is strong off a headland and weak at some distance from it."""
    centre = rng.standard_normal(2) * 0.7 * conditions.extent
    radius = rng.uniform(0.3, 0.7) * conditions.extent
    parts = []
    for name, share in (("M2", 1.0), ("S2", rng.uniform(0.1, 0.4))):
        parts.append((2.0 * np.pi / PERIODS[name], *ellipse(rng, size * share, rng.uniform(-0.3, 0.3))))

    def velocity(t, position):
        d = (position - centre) / radius
        w = tide(parts, t) * np.exp(-0.5 * float(d @ d))
        return np.array([w.real, w.imag])

    return LegEffect(current=velocity), {}


OUTSIDE: dict[str, EffectKind] = {
    "eddy": EffectKind(0.08, 0.30, _eddy),
    "battery-sag": EffectKind(0.06, 0.25, _battery_sag),
    "compass-drift": EffectKind(np.radians(4.0), np.radians(20.0), _compass_drift),
    "front": EffectKind(0.05, 0.20, _front),
    "leeway": EffectKind(np.radians(3.0), np.radians(12.0), _leeway),
    "storm-drift": EffectKind(0.10, 0.40, _storm_drift),
    "slow-start": EffectKind(0.5, 2.5, _slow_start),
    "weed": EffectKind(0.08, 0.30, _weed),
    "gyro-creep": EffectKind(np.radians(3.0) / HOUR, np.radians(20.0) / HOUR, _gyro_creep),
    "tidal-race": EffectKind(0.10, 0.50, _tidal_race),
}
STUDIED = frozenset({"slow-start"})
"""Found in a study to resemble a speed scale, and used in development since: no longer a blind test."""
