"""Dives whose truths are drawn from the prior that the documentation states, by the hidden dives' own dynamics.

Forms and usual sizes are those of the pages of the effects, typed in by hand; nothing of the package is used. A size has
a Student-t law of three degrees of freedom about zero inside its physical range, a time, depth or speed of an effect its
logarithm. Forms that no law gives are wrong in their strength by 2 %. What is no cause is there by the little that no
mission can rule out.
"""

import itertools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..hidden_effects.case import Case
from ..hidden_effects.dives.draw import draw as hidden
from ..hidden_effects.dives.dynamics import STEP, DiveEffect
from ..hidden_effects.dives.files import measure, mission_files
from ..hidden_effects.dives.trials import Nuisances, draw_plan

Array = np.ndarray
FURTHER = np.exp(-3.0)
FORM_SD = 0.02
ATMOSPHERE = 10.1
SCATTER_LOG_SD, DIFFUSION_LOG_SD = 0.45, 1.3


@dataclass(frozen=True)
class Kind:
    """An effect: law of its size, those of its shapes, and how it acts."""

    scale: float
    low: float
    high: float
    shapes: dict[str, tuple[float, float, float, float]]
    """Median, factor and range of each."""
    size: str
    by_law: bool
    act: Callable[..., DiveEffect]


def _lagged(size: float, averaging: float) -> Callable[[Array, Array, int], Array]:
    """A first-order filter, then a running mean, which together delay by a time."""
    constant = size / (1.0 + averaging)
    window = max(1, round(2.0 * size * averaging / (1.0 + averaging) / STEP))

    def reading(t: Array, depth: Array, number: int) -> Array:
        keep = np.exp(-STEP / max(constant, 1e-9))
        behind = np.zeros_like(depth)
        rate = np.diff(depth) / STEP
        for k in range(len(rate)):
            behind[k + 1] = keep * behind[k] + (1.0 - keep) * constant * rate[k]
        padded = np.concatenate([np.full(window - 1, depth[0]), depth - behind])
        return np.convolve(padded, np.full(window, 1.0 / window), "valid")

    return reading


def _logistic(x: float) -> float:
    return float(0.5 * (1.0 + np.tanh(0.5 * x)))


KINDS: dict[str, Kind] = {
    "drag-bias": Kind(
        0.3,
        -0.7,
        2.0,
        {},
        "fraction",
        False,
        lambda size: DiveEffect(lone_drag=1.0 + size, drag=lambda t, u, z, n: 1.0 + size),
    ),
    "line-payout": Kind(
        0.2, 0.0, 5.0, {}, "delay_per_length", False, lambda size: DiveEffect(delay=lambda line, n: size * line)
    ),
    "slow-flooding": Kind(
        0.3,
        0.0,
        1.0,
        {"time": (4.0, 2.2, 0.2, 60.0)},
        "fraction",
        False,
        lambda size, time: DiveEffect(weight=lambda t, z: 1.0 - size * float(np.exp(-max(t, 0.0) / time))),
    ),
    "trapped-gas": Kind(
        1.5,
        0.0,
        20.0,
        {"height": (0.4, 2.0, 1e-9, 10.0)},
        "lift",
        True,
        lambda size, height: DiveEffect(lift=lambda z: size / (1.0 + max(z - height, 0.0) / ATMOSPHERE)),
    ),
    "stratification": Kind(
        1.5,
        0.0,
        20.0,
        {"depth": (9.0, 2.0, 0.5, 500.0), "thickness": (2.5, 2.0, 0.05, 100.0)},
        "lift",
        False,
        lambda size, depth, thickness: DiveEffect(lift=lambda z: size * _logistic(4.0 * (z - depth) / thickness)),
    ),
    "broadside-start": Kind(
        4.0,
        0.0,
        60.0,
        {"time": (2.0, 1.9, 0.1, 8.0)},
        "extra_drag",
        False,
        lambda size, time: DiveEffect(drag=lambda t, u, z, n: 1.0 + size / float(np.cosh(max(t, 0.0) / time)) ** 3),
    ),
    "added-mass": Kind(0.4, -0.1, 3.0, {}, "fraction", True, lambda size: DiveEffect(mass=1.0 + size)),
    "sensor-lag": Kind(
        0.5,
        0.0,
        10.0,
        {"averaging": (1.0, 5.0, 1e-9, 1000.0)},
        "time",
        False,
        lambda size, averaging: DiveEffect(reading=_lagged(size, averaging)),
    ),
    "clock-offset": Kind(0.5, -10.0, 10.0, {}, "time", True, lambda size: DiveEffect(delay=lambda line, n: size)),
    "depth-scale": Kind(
        0.06, -0.5, 0.5, {}, "fraction", True, lambda size: DiveEffect(reading=lambda t, z, n: z * (1.0 + size))
    ),
    "vertical-current": Kind(0.12, -1.0, 1.0, {}, "speed", False, lambda size: DiveEffect(water=lambda t, z: size)),
    "drag-crisis": Kind(
        0.3,
        0.0,
        0.9,
        {"speed": (1.2, 1.5, 0.1, 5.0), "width": (0.12, 2.0, 0.01, 2.0)},
        "fraction",
        False,
        lambda size, speed, width: DiveEffect(
            drag=lambda t, u, z, n: 1.0 - size * _logistic(2.0 * (abs(u) - speed) / width)
        ),
    ),
}
SPIKES = {
    "drag-bias": 0.01,
    "added-mass": 0.03,
    "clock-offset": 0.02,
    "depth-scale": 0.003,
    "vertical-current": 0.003,
}
"""What is there without being a cause; what cannot be negative is left out."""


def names(rng: np.random.Generator) -> tuple[str, ...]:
    """A set of causes by its prior: none 1, each single one 1/12, each pair e⁻³/12, each triple e⁻⁶/12."""
    sets = [causes for size in range(4) for causes in itertools.combinations(KINDS, size)]
    weights = np.array([FURTHER ** (len(each) - 1) / len(KINDS) if each else 1.0 for each in sets])
    return sets[int(rng.choice(len(sets), p=weights / weights.sum()))]


def _drawn(rng: np.random.Generator, law: Callable[[float], float], low: float, high: float) -> float:
    while not low <= (value := law(float(rng.standard_t(3.0)))) <= high:
        continue
    return value


def _effect(name: str, rng: np.random.Generator) -> tuple[DiveEffect, dict[str, float]]:
    kind = KINDS[name]
    size = _drawn(rng, lambda z: kind.scale * z, kind.low, kind.high)
    shapes = {
        key: _drawn(rng, lambda z, m=median, f=factor: float(m * f ** np.clip(z, -300.0, 300.0)), low, high)
        for key, (median, factor, low, high) in kind.shapes.items()
    }
    acting = size if kind.by_law else size * (1.0 + FORM_SD * rng.standard_normal())
    known = {f"{name}.{kind.size}": size} | {f"{name}.{key}": value for key, value in shapes.items()}
    return kind.act(acting, **shapes), known


def dives(seed: int, is_outside: bool) -> Case:
    """Draw a record of dives with causes of the catalogue, or with something that it does not have."""
    if is_outside:
        return hidden(seed, "outside")
    rng = np.random.default_rng([seed, 12])
    for _ in range(50):
        plan, causes = draw_plan(rng, "single", ()), names(rng)
        built = [_effect(name, rng) for name in causes]
        built += [(KINDS[n].act(sd * rng.standard_normal()), {}) for n, sd in SPIKES.items() if n not in causes]
        effects = [effect for effect, _ in built]
        parameters = {key: value for _, known in built for key, value in known.items()}
        scale = float(np.exp(np.clip(SCATTER_LOG_SD * rng.standard_normal(), -0.7, 0.7)))
        time = float(rng.choice([1.0, 4.0]))
        rate = 3e-4 * float(np.exp(DIFFUSION_LOG_SD * np.clip(rng.standard_normal(), -1.5, 1.5)))
        sensor = float(np.exp(rng.uniform(np.log(0.01), np.log(0.06))))
        noise = Nuisances(scale, sensor, 0.0, float(np.sqrt(rate / (2.0 * time))), time)
        try:
            header, rows, stated = measure(plan, noise, effects, rng)
        except RuntimeError:  # a vehicle that cannot sink at all
            continue
        mission, vehicle = mission_files(plan, rng)
        inside = tuple(sorted(causes))
        return Case(seed, "descent", "prior", inside, (), "", parameters, 0.0, mission, vehicle, stated, header, rows)
    raise RuntimeError(f"no dives that sink (seed {seed})")
