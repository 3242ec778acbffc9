"""Effects on legs that the catalogue does not have, and which of them its authors have studied."""

import numpy as np

from .leg_effects import HOUR, PERIODS, Bend, Cause, ellipse, sign, tide, toward


def _eddy(size, rng, survey):
    """A vortex sits somewhere in the area."""
    centre = rng.standard_normal(2) * 0.7 * survey.extent
    radius = rng.uniform(0.3, 0.7) * survey.extent
    spin = sign(rng)

    def velocity(t, position):
        d = (position - centre) / radius
        return size * spin * np.array([-d[1], d[0]]) * np.exp(0.5 - 0.5 * float(d @ d))

    return Bend(current=velocity), {}


def _battery_sag(size, rng, survey):
    """The motor slows as the battery empties; dead reckoning does not know."""
    bend = rng.uniform(0.8, 2.5)
    return Bend(pace=lambda t: 1.0 - size * min(1.5, t / survey.span) ** bend), {}


def _compass_drift(size, rng, survey):
    """A gyro compass that turns away steadily."""
    angle = sign(rng) * size
    return Bend(turn=lambda t, heading: angle * t / survey.span), {}


def _front(size, rng, survey):
    """At some hour another water mass arrives."""
    when = rng.uniform(0.3, 0.7) * survey.span
    after = toward(rng, size)
    return Bend(current=lambda t, position: after if t > when else np.zeros(2)), {}


def _leeway(size, rng, survey):
    """The vehicle crabs to one side before the wind and to the other beside it."""
    wind = rng.uniform(0.0, 2.0 * np.pi)
    return Bend(turn=lambda t, heading: size * np.sin(2.0 * (heading - wind))), {}


def _storm_drift(size, rng, survey):
    """Stokes drift while a storm passes."""
    when = rng.uniform(0.25, 0.75) * survey.span
    width = rng.uniform(0.05, 0.12) * survey.span
    drift = toward(rng, size)
    return Bend(current=lambda t, position: drift * np.exp(-0.5 * ((t - when) / width) ** 2)), {}


def _slow_start(size, rng, survey):
    """Every leg loses the same distance at the start, while the vehicle gathers way."""
    lost = size * survey.sigma * survey.leg_time
    return Bend(push=lambda heading, speed, time: -lost * np.array([np.sin(heading), np.cos(heading)])), {}


def _weed(size, rng, survey):
    """Weed winds itself round the propeller at some hour and costs way until it comes off, if it does."""
    caught = rng.uniform(0.1, 0.7) * survey.span
    shed = caught + rng.uniform(0.1, 0.6) * survey.span
    return Bend(pace=lambda t: 1.0 - size if caught < t < shed else 1.0), {}


def _gyro_creep(size, rng, survey):
    """Under water a rate gyro holds the heading: right at every dive, it turns away evenly until the next fix.

    The Earth's own rotation, if left in, is 15 degrees an hour times the sine of the latitude.
    """
    rate = sign(rng) * size

    def aside(heading, speed, time):
        half = 0.5 * rate * time
        chord = np.sinc(half / np.pi) * np.array([np.sin(heading + half), np.cos(heading + half)])
        return speed * time * (chord - np.array([np.sin(heading), np.cos(heading)]))

    return Bend(push=aside), {}


def _tidal_race(size, rng, survey):
    """Off a headland the tide runs hard; some way from it hardly."""
    centre = rng.standard_normal(2) * 0.7 * survey.extent
    radius = rng.uniform(0.3, 0.7) * survey.extent
    parts = []
    for name, share in (("M2", 1.0), ("S2", rng.uniform(0.1, 0.4))):
        parts.append((2.0 * np.pi / PERIODS[name], *ellipse(rng, size * share, rng.uniform(-0.3, 0.3))))

    def velocity(t, position):
        d = (position - centre) / radius
        w = tide(parts, t) * np.exp(-0.5 * float(d @ d))
        return np.array([w.real, w.imag])

    return Bend(current=velocity), {}


OUTSIDE: dict[str, Cause] = {
    "eddy": Cause(0.08, 0.30, _eddy),
    "battery-sag": Cause(0.06, 0.25, _battery_sag),
    "compass-drift": Cause(np.radians(4.0), np.radians(20.0), _compass_drift),
    "front": Cause(0.05, 0.20, _front),
    "leeway": Cause(np.radians(3.0), np.radians(12.0), _leeway),
    "storm-drift": Cause(0.10, 0.40, _storm_drift),
    "slow-start": Cause(0.5, 2.5, _slow_start),
    "weed": Cause(0.08, 0.30, _weed),
    "gyro-creep": Cause(np.radians(3.0) / HOUR, np.radians(20.0) / HOUR, _gyro_creep),
    "tidal-race": Cause(0.10, 0.50, _tidal_race),
}
STUDIED = frozenset({"slow-start"})
"""Seen in a study to pass for a speed scale, and used while developing since: no blind test any more."""
