"""Effects on dives outside the catalogue, and those of them that were used in development."""

import numpy as np

from .catalogue import EffectKind, sign
from .dynamics import DiveEffect


def _spooling_line(size, rng, conditions):
    """The line keeps slipping out: its drag grows with every metre below some depth."""
    begin = rng.uniform(0.1, 0.4) * conditions.shallowest
    return DiveEffect(drag=lambda t, u, z, number: 1.0 + size * max(0.0, z - begin) / conditions.shallowest), {}


def _pitch_oscillation(size, rng, conditions):
    """The hull swings about the line like a pendulum, and its drag varies with it."""
    period = rng.uniform(3.0, 7.0)
    fade = rng.uniform(8.0, 40.0)

    def swing(t):
        return np.exp(-t / fade) * np.sin(2.0 * np.pi * t / period)

    return DiveEffect(
        drag=lambda t, u, z, number: 1.0 + size * float(swing(max(t, 0.0))) ** 2, pitch=lambda t: 35.0 * swing(t)
    ), {}


def _windmilling(size, rng, conditions):
    """Above some speed the flow turns the propeller, which brakes in proportion to the excess speed."""
    start = rng.uniform(0.5, 0.9) * conditions.slowest
    force = size * conditions.lightest

    def resist(t, u):
        return force * max(0.0, u / start - 1.0) if u > start else 0.0

    return DiveEffect(resist=resist), {}


def _temperature_drift(size, rng, conditions):
    """The depth sensor cools and its zero drifts."""
    settle = rng.uniform(3.0, 12.0)
    creep = sign(rng) * size
    return DiveEffect(reading=lambda t, depth, number: depth + creep * (1.0 - np.exp(-t / settle))), {}


def _obstacle(size, rng, conditions):
    """An obstacle stops the vehicle for a while, at the same fraction of the depth in every dive."""
    return DiveEffect(hold=(rng.uniform(0.25, 0.7), size)), {}


def _weight_loss(size, rng, conditions):
    """Part of the anchor falls off at some time during the descent."""
    when = rng.uniform(0.25, 0.6) * conditions.longest_time
    return DiveEffect(weight=lambda t, z: 1.0 - size if t > when else 1.0), {}


def _bio_fouling(size, rng, conditions):
    """Each dive has more drag than the one before."""
    return DiveEffect(drag=lambda t, u, z, number: 1.0 + size * number), {}


def _internal_wave(size, rng, conditions):
    """The vertical current changes sign with depth."""
    length = rng.uniform(0.35, 0.7) * conditions.shallowest
    phase = rng.uniform(0.0, 2.0 * np.pi)
    return DiveEffect(water=lambda t, z: size * np.sin(2.0 * np.pi * z / length + phase)), {}


def _line_drag(size, rng, conditions):
    """Drag of the line along its length: skin friction of about 4 mm of braid is 2 % of the total per metre."""
    return DiveEffect(drag=lambda t, u, z, number: 1.0 + size * conditions.lines[number]), {}


def _motor_runs_on(size, rng, conditions):
    """The motor is still running when the line comes taut and drives the vehicle down until it stops."""
    stop = rng.uniform(3.0, 10.0)
    idle = rng.uniform(1.2, 1.8) * conditions.fastest
    force = size * conditions.lightest

    def resist(t, u):
        return -force * max(0.0, 1.0 - u / idle) if t < stop else 0.0

    return DiveEffect(resist=resist), {}


def _foam_compression(size, rng, conditions):
    """Foam compresses with pressure, from the surface or from its yield on, and loses buoyancy."""
    half = rng.uniform(6.0, 25.0)
    firm = rng.uniform(0.1, 0.5) * conditions.shallowest if rng.random() < 0.5 else 0.0
    lost = size * conditions.lightest

    def up(z):
        squeezed = max(0.0, z - firm)
        return -lost * squeezed / (squeezed + half)

    return DiveEffect(lift=up), {}


def _shear_layer(size, rng, conditions):
    """In a layer where the current turns the hull meets the flow at an angle, larger the slower it sinks."""
    top = rng.uniform(0.15, 0.6) * conditions.shallowest
    thick = rng.uniform(0.05, 0.25) * conditions.shallowest
    relax = rng.uniform(1.0, 4.0)

    def factor(t, u, z, number):
        slip = min(1.0, max(0.0, z - top)) * np.exp(-max(0.0, z - top - thick) / relax)
        incidence = slip * conditions.slowest / max(abs(u), 0.6 * conditions.slowest)
        return 1.0 + size * incidence**2

    return DiveEffect(drag=factor), {}


def _plugged_port(size, rng, conditions):
    """Mud or slush blocks the sensor's port until the pressure breaks it, at a different depth in every dive."""
    burst = size * np.exp(0.35 * rng.standard_normal(len(conditions.lines)))
    catch_up = rng.uniform(0.1, 1.2)

    def reading(t, depth, number):
        opened = np.argmax(depth > burst[number])
        behind = depth[opened] * np.exp(-np.maximum(t - t[opened], 0.0) / catch_up)
        return np.where(depth > burst[number], depth - behind, 0.0)

    return DiveEffect(reading=reading), {}


def _jammed_spool(size, rng, conditions):
    """In some dives a wrap jams and the rest of the line stays on the spool: an early snatch, and a deeper mooring."""
    count = len(conditions.lines)
    jams = rng.random(count) < rng.uniform(0.3, 0.9)
    jams[rng.integers(count)] = True
    left = np.where(jams, np.minimum(0.9, size * rng.uniform(0.5, 1.5, count)), 0.0)
    return DiveEffect(line=lambda number: 1.0 - left[number]), {}


def _elastic_line(size, rng, conditions):
    """A shock cord in the line, or an elastic line: no snatch, and the vehicle lags by the stretch."""
    if rng.random() < 0.5:
        return DiveEffect(stretch=lambda line: size), {}
    typical = float(np.mean(conditions.lines))
    return DiveEffect(stretch=lambda line: size * line / typical), {}


_STUDIED: dict[str, EffectKind] = {
    "spooling-line": EffectKind(0.4, 1.5, _spooling_line),
    "pitch-oscillation": EffectKind(0.8, 3.0, _pitch_oscillation),
    "windmilling": EffectKind(0.15, 0.6, _windmilling),
    "temperature-drift": EffectKind(0.4, 1.5, _temperature_drift),
    "obstacle": EffectKind(0.3, 2.0, _obstacle),
    "weight-loss": EffectKind(0.12, 0.4, _weight_loss),
    "bio-fouling": EffectKind(0.06, 0.20, _bio_fouling),
    "internal-wave": EffectKind(0.10, 0.35, _internal_wave),
    "line-drag": EffectKind(0.008, 0.04, _line_drag),
    "motor-runs-on": EffectKind(0.25, 1.0, _motor_runs_on),
}
_BLIND: dict[str, EffectKind] = {
    "foam-compression": EffectKind(0.15, 0.6, _foam_compression),
    "shear-layer": EffectKind(0.3, 1.5, _shear_layer),
    "plugged-port": EffectKind(0.25, 2.0, _plugged_port),
    "jammed-spool": EffectKind(0.15, 0.6, _jammed_spool),
    "elastic-line": EffectKind(0.015, 0.08, _elastic_line),
}
OUTSIDE = _STUDIED | _BLIND
STUDIED = frozenset(_STUDIED)
"""Effects whose dives were looked at during development: no longer a blind test."""
