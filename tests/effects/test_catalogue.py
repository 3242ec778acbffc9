"""The catalogue as a whole: the contract's names, neutral at zero strength, linear where the diagnosis relies on it."""

import dataclasses

import numpy as np
import pytest

from missionplan.effects import CATALOGUE, effects_of, named_effects
from missionplan.phases.hooks import DescentEffect, Leg, TransitEffect, velocity_error

CONTRACT = {
    "drag-bias": ["fraction"],
    "line-payout": ["delay_per_length"],
    "slow-flooding": ["fraction", "time"],
    "trapped-gas": ["lift", "height"],
    "stratification": ["lift", "depth", "thickness"],
    "broadside-start": ["extra_drag", "time"],
    "added-mass": ["fraction"],
    "sensor-lag": ["time", "averaging"],
    "clock-offset": ["time"],
    "clock-rate": ["fraction"],
    "sensor-position": ["aft"],
    "depth-scale": ["fraction"],
    "vertical-current": ["speed"],
    "drag-crisis": ["fraction", "speed", "width"],
    "mean-current": ["east", "north"],
    "inertial-current": ["amplitude", "phase", "modulation", "coherence_time"],
    "compass-bias": ["angle"],
    "compass-deviation": ["amplitude", "phase"],
    "speed-scale": ["fraction"],
    "current-response": ["along"],
    "sideslip": ["angle"],
    "heading-by-depth": ["rate"],
    "speed-loss": ["fraction", "threshold"],
    "compass-jump": ["angle", "moment"],
    "surface-drift": ["east", "north"],
    "persistent-error": ["sigma", "time"],
    "random-walk": ["rate"],
    "position-random-walk": ["rate"],
    "fix-error": ["sd"],
    "heavy-tails": ["dof"],
    "reynolds-drag": ["exponent"],
    "quadratic-damping": ["rate"],
    "jet-suction": ["decay"],
    "thrust-asymmetry": ["fraction"],
    "axial-flow": ["mass_factor"],
}


def legs(n=7, latitude=0.5):
    rng = np.random.default_rng(3)
    heading = rng.uniform(0, 2 * np.pi, n)
    return Leg(
        t_start=np.sort(rng.uniform(0, 1e5, n)),
        duration=rng.uniform(300, 3000, n),
        start=rng.normal(0, 4000, (2, n)),
        along=np.stack([np.sin(heading), np.cos(heading)]),
        speed=np.full(n, 1.5),
        latitude=latitude,
    )


def test_names_are_the_contract():
    assert len(CATALOGUE) == 49
    assert (len(effects_of("descent")), len(effects_of("transit"))) == (25, 19)
    assert len(named_effects("descent")) == 14
    for name, parameters in CONTRACT.items():
        assert list(CATALOGUE[name].parameters) == parameters


@pytest.mark.parametrize("info", CATALOGUE.values(), ids=lambda info: info.id)
def test_entry_is_complete(info):
    assert info.what
    assert info.sizes
    assert info.distinguished_by
    assert set(info.confused_with) <= set(CATALOGUE)
    assert {p.field or name for name, p in info.parameters.items()} == {f.name for f in dataclasses.fields(info.effect)}
    for first, second in info.polar:
        assert {first, second} <= set(info.parameters)


@pytest.mark.parametrize("info", effects_of("descent"), ids=lambda info: info.id)
def test_descent_effect_is_neutral_at_zero_strength(info):
    effect = info.make({})
    assert isinstance(effect, DescentEffect)
    t = np.linspace(0.0, 10.0, 101)
    depth = np.stack([1.2 * t, 0.9 * t], axis=1)
    assert effect.lone_drag_factor() == 1.0
    np.testing.assert_array_equal(np.broadcast_to(effect.drag_factor(t, 1.3), t.shape), 1.0)
    np.testing.assert_array_equal(np.broadcast_to(effect.wet_weight_factor(t), t.shape), 1.0)
    np.testing.assert_array_equal(np.broadcast_to(effect.lift(t), t.shape), 0.0)
    assert effect.mass_factor() == 1.0
    assert effect.water_velocity() == effect.delay(5.0) == 0.0
    np.testing.assert_array_equal(effect.reading(t, depth), depth)


@pytest.mark.parametrize("info", effects_of("transit"), ids=lambda info: info.id)
def test_transit_effect_is_neutral_at_zero_strength(info):
    effect = info.make({})
    assert isinstance(effect, TransitEffect)
    normals = np.random.default_rng(1).normal(size=(2, 7))
    leg = legs()
    assert np.all(velocity_error((effect,), leg) == 0.0)
    assert np.all(np.asarray(effect.surface_velocity(leg.t_start, leg.duration, leg.start)) == 0.0)
    assert effect.fix_variance() == 0.0
    assert np.all(np.asarray(effect.error_scale(normals)) == 1.0)
    memory, velocity = effect.step(None, leg.duration, normals, leg)
    _, later = effect.step(memory, leg.duration, normals, leg)
    assert np.all(np.asarray(velocity) == 0.0)
    assert np.all(np.asarray(later) == 0.0)


@pytest.mark.parametrize("name", ["tidal-current", "inertial-current", "mean-current", "speed-scale"])
def test_velocity_is_linear_in_strength(name):
    info = CATALOGUE[name]
    strengths = {key: 0.01 * p.scale for key, p in info.parameters.items() if p.scale}
    single = velocity_error((info.make(strengths),), legs())
    double = velocity_error((info.make({key: 2 * value for key, value in strengths.items()}),), legs())
    np.testing.assert_allclose(double, 2 * single, rtol=1e-12, atol=1e-16)


@pytest.mark.parametrize(
    ("name", "positive", "negative"),
    [
        ("drag-bias", "more drag", "less drag"),
        ("stratification", "lighter", "heavier"),  # a lift is upward
        ("lift-by-depth", "lighter", "heavier"),
        ("lift-in-layer", "held back", "drawn down"),
        ("added-mass", "heavier", "lighter"),
        ("sensor-lag", "lags", "leads"),
        ("clock-offset", "late", "early"),
        ("clock-rate", "fast", "slow"),
        ("depth-scale", "too deep", "too shallow"),
        ("reading-by-time", "too deep", "too shallow"),
        ("reading-at-first", "too deep", "too shallow"),
        ("vertical-current", "sinks", "rises"),
        ("compass-bias", "low", "high"),  # what goes to starboard of its course has steered by too small a heading
        ("compass-jump", "lower", "higher"),
        ("heading-by-depth", "lower", "higher"),
        ("speed-scale", "faster", "slower"),
        ("sideslip", "to starboard", "to port"),
        ("speed-loss", "loses", "gains"),
        ("drag-by-line", "adds", "takes"),
        ("delay-by-line", "late", "early"),
        ("weight-from-moment", "more than", "less than"),
        ("weight-until-moment", "more than", "less than"),
        ("reynolds-drag", "rises with", "falls as"),
    ],
)
def test_what_is_told_of_either_sign_is_what_the_sign_means(name, positive, negative):
    finding = CATALOGUE[name].finding
    assert positive in finding.positive
    assert positive not in finding.negative
    assert negative in finding.negative
    assert negative not in finding.positive
