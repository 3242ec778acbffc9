"""Effects on dives that the catalogue does not have, and which of them its authors have studied."""

import numpy as np

from .dive import Twist
from .dive_effects import Cause, sign


def _spooling_line(size, rng, scenario):
    """The line slips on: its drag grows with every metre of depth below some depth."""
    begin = rng.uniform(0.1, 0.4) * scenario.shallowest
    return Twist(drag=lambda t, u, z, number: 1.0 + size * max(0.0, z - begin) / scenario.shallowest), {}


def _pitch_oscillation(size, rng, scenario):
    """The hull swings about the line like a pendulum, and its drag with it."""
    period = rng.uniform(3.0, 7.0)
    fade = rng.uniform(8.0, 40.0)

    def swing(t):
        return np.exp(-t / fade) * np.sin(2.0 * np.pi * t / period)

    return Twist(
        drag=lambda t, u, z, number: 1.0 + size * float(swing(max(t, 0.0))) ** 2, pitch=lambda t: 35.0 * swing(t)
    ), {}


def _windmilling(size, rng, scenario):
    """Above some speed the propeller is turned by the flow and brakes in proportion to the excess."""
    start = rng.uniform(0.5, 0.9) * scenario.slowest
    force = size * scenario.lightest

    def resist(t, u):
        return force * max(0.0, u / start - 1.0) if u > start else 0.0

    return Twist(resist=resist), {}


def _temperature_drift(size, rng, scenario):
    """The depth sensor cools and its zero creeps."""
    settle = rng.uniform(3.0, 12.0)
    creep = sign(rng) * size
    return Twist(reading=lambda t, depth, number: depth + creep * (1.0 - np.exp(-t / settle))), {}


def _obstacle(size, rng, scenario):
    """Something stops the vehicle on its way, for a while, in every dive at the same share of the way."""
    return Twist(hold=(rng.uniform(0.25, 0.7), size)), {}


def _weight_loss(size, rng, scenario):
    """Part of the anchor falls off at some time on the way down."""
    when = rng.uniform(0.25, 0.6) * scenario.longest_time
    return Twist(weight=lambda t, z: 1.0 - size if t > when else 1.0), {}


def _bio_fouling(size, rng, scenario):
    """Each dive has more drag than the one before."""
    return Twist(drag=lambda t, u, z, number: 1.0 + size * number), {}


def _internal_wave(size, rng, scenario):
    """The vertical current changes sign on the way down."""
    length = rng.uniform(0.35, 0.7) * scenario.shallowest
    phase = rng.uniform(0.0, 2.0 * np.pi)
    return Twist(water=lambda t, z: size * np.sin(2.0 * np.pi * z / length + phase)), {}


def _line_drag(size, rng, scenario):
    """The line itself drags along its length: skin friction of some 4 mm of braid is 2 % of the whole a metre."""
    return Twist(drag=lambda t, u, z, number: 1.0 + size * scenario.lines[number]), {}


def _motor_runs_on(size, rng, scenario):
    """The motor is still on when the line comes taut and drives the vehicle down until it is stopped."""
    stop = rng.uniform(3.0, 10.0)
    idle = rng.uniform(1.2, 1.8) * scenario.fastest
    force = size * scenario.lightest

    def resist(t, u):
        return -force * max(0.0, 1.0 - u / idle) if t < stop else 0.0

    return Twist(resist=resist), {}


def _foam_compression(size, rng, scenario):
    """Foam gives way as the pressure grows, from the surface or from its yield on, and no longer carries the hull."""
    half = rng.uniform(6.0, 25.0)
    firm = rng.uniform(0.1, 0.5) * scenario.shallowest if rng.random() < 0.5 else 0.0
    lost = size * scenario.lightest

    def up(z):
        squeezed = max(0.0, z - firm)
        return -lost * squeezed / (squeezed + half)

    return Twist(lift=up), {}


def _shear_layer(size, rng, scenario):
    """Through a layer where the current turns the hull meets the flow at an angle, the more so the slower it sinks."""
    top = rng.uniform(0.15, 0.6) * scenario.shallowest
    thick = rng.uniform(0.05, 0.25) * scenario.shallowest
    relax = rng.uniform(1.0, 4.0)

    def factor(t, u, z, number):
        slip = min(1.0, max(0.0, z - top)) * np.exp(-max(0.0, z - top - thick) / relax)
        incidence = slip * scenario.slowest / max(abs(u), 0.6 * scenario.slowest)
        return 1.0 + size * incidence**2

    return Twist(drag=factor), {}


def _plugged_port(size, rng, scenario):
    """Mud or slush shuts the sensor's port until the pressure breaks it, at another depth in every dive."""
    burst = size * np.exp(0.35 * rng.standard_normal(len(scenario.lines)))
    catch_up = rng.uniform(0.1, 1.2)

    def reading(t, depth, number):
        opened = np.argmax(depth > burst[number])
        behind = depth[opened] * np.exp(-np.maximum(t - t[opened], 0.0) / catch_up)
        return np.where(depth > burst[number], depth - behind, 0.0)

    return Twist(reading=reading), {}


def _jammed_spool(size, rng, scenario):
    """In some dives a wrap jams and the rest of the line stays on the spool: an early snatch, and a deeper mooring."""
    count = len(scenario.lines)
    jams = rng.random(count) < rng.uniform(0.3, 0.9)
    jams[rng.integers(count)] = True
    left = np.where(jams, np.minimum(0.9, size * rng.uniform(0.5, 1.5, count)), 0.0)
    return Twist(line=lambda number: 1.0 - left[number]), {}


def _elastic_line(size, rng, scenario):
    """A shock cord in the line, or a line that is one: no snatch, and the vehicle hangs back by the stretch."""
    if rng.random() < 0.5:
        return Twist(stretch=lambda line: size), {}
    typical = float(np.mean(scenario.lines))
    return Twist(stretch=lambda line: size * line / typical), {}


_SEEN: dict[str, Cause] = {
    "spooling-line": Cause(0.4, 1.5, _spooling_line),
    "pitch-oscillation": Cause(0.8, 3.0, _pitch_oscillation),
    "windmilling": Cause(0.15, 0.6, _windmilling),
    "temperature-drift": Cause(0.4, 1.5, _temperature_drift),
    "obstacle": Cause(0.3, 2.0, _obstacle),
    "weight-loss": Cause(0.12, 0.4, _weight_loss),
    "bio-fouling": Cause(0.06, 0.20, _bio_fouling),
    "internal-wave": Cause(0.10, 0.35, _internal_wave),
    "line-drag": Cause(0.008, 0.04, _line_drag),
    "motor-runs-on": Cause(0.25, 1.0, _motor_runs_on),
}
_UNSEEN: dict[str, Cause] = {
    "foam-compression": Cause(0.15, 0.6, _foam_compression),
    "shear-layer": Cause(0.3, 1.5, _shear_layer),
    "plugged-port": Cause(0.25, 2.0, _plugged_port),
    "jammed-spool": Cause(0.15, 0.6, _jammed_spool),
    "elastic-line": Cause(0.015, 0.08, _elastic_line),
}
OUTSIDE = _SEEN | _UNSEEN
STUDIED = frozenset(_SEEN)
"""Those whose dives the method's authors have looked at while working on it: no blind test any more."""
