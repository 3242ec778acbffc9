"""Strength of effects on dives, in standard errors under the nuisances' covariance."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from .catalogue import CATALOGUE, DiveConditions
from .drag import Craft
from .dynamics import Array, Dive, DiveEffect, Track, simulate_dive
from .outside import OUTSIDE
from .trials import DRAG_SD, RELEASE_SD, WEIGHT_SD, ZERO_SD, Nuisances, Plan, conditions_of

TURBULENCE_RATE = 2.2e-4
"""Rate of the random walk of depth due to turbulence of 0.006 m/s over 3 s [m²/s]."""
MINIMUM_STRENGTH = 12.0
"""Smallest strength of an effect [standard errors]; a weaker one is made larger."""
MAXIMUM_STRENGTH = 60.0
"""Largest strength, approximately: beyond it the shape of an effect is measured rather than its kind."""
MINIMUM_MISFIT = 5.0
"""Misfit left by the nearest effect of the catalogue, at any size, for an effect outside it [standard errors]."""


def read_depth(track: Track, dive: Dive, effects: Sequence[DiveEffect], t: Array, late: float = 0.0) -> Array:
    """Return the noise-free depth readings at times ``t`` of the log's clock."""
    late = late + sum(effect.delay(dive.line, dive.number) for effect in effects if effect.delay)
    depth = track.depth
    for effect in effects:
        if effect.reading:
            depth = effect.reading(track.t, depth, dive.number)
    return np.interp(t - late, track.t, depth)


@lru_cache(maxsize=64)
def _without_effects(craft: Craft, dive: Dive) -> Track:
    return simulate_dive(craft, dive, (), 90.0, followed=False)


def _dived(craft: Craft, dive: Dive, effects: Sequence[DiveEffect]) -> Track:
    """Track with effects; those that only change what is logged leave it as it is without them."""
    moving = [each for each in effects if replace(each, delay=None, reading=None, pitch=None) != DiveEffect()]
    return simulate_dive(craft, dive, moving, 90.0, followed=False) if moving else _without_effects(craft, dive)


def strength(plan: Plan, noise: Nuisances, effects: Sequence[DiveEffect]) -> tuple[float, Array]:
    """Return the standard errors by which effects change noise-free dives, and the whitened change.

    The covariance is that of the nuisances at their usual size: white noise averaged over four samples, a random walk
    for turbulence, and the scatter of separation, depth zero, drag and weight from dive to dive.
    """
    pieces = []
    for dive in plan.dives:
        base = _without_effects(plan.craft, dive)
        other = _dived(plan.craft, dive, effects)
        t = np.linspace(0.3, 0.97 * min(base.t_touchdown, other.t_touchdown, 85.0), 40)
        y = read_depth(base, dive, (), t)
        factor = np.linalg.cholesky(_covariance(plan.craft, dive, noise, t))
        pieces.append(np.linalg.solve(factor, read_depth(other, dive, effects, t) - y))
    whitened = np.concatenate(pieces)
    return float(np.linalg.norm(whitened)), whitened


def _covariance(craft: Craft, dive: Dive, noise: Nuisances, t: Array) -> Array:
    base = _without_effects(craft, dive)
    y = read_depth(base, dive, (), t)
    heavier = replace(dive, wet_weight=dive.wet_weight * (1.0 + WEIGHT_SD))
    draggier = replace(dive, drag_factor=1.0 + DRAG_SD)
    columns = [read_depth(base, dive, (), t, RELEASE_SD) - y, np.full(t.size, ZERO_SD)]
    columns += [read_depth(_without_effects(craft, run), run, (), t) - y for run in (heavier, draggier)]
    jacobian = np.array(columns)
    white = noise.sensor**2 / 4.0 + noise.resolution**2 / 12.0 + 1e-5
    return white * np.eye(t.size) + TURBULENCE_RATE * np.minimum.outer(t, t) + jacobian.T @ jacobian


@dataclass(frozen=True)
class BuiltEffect:
    """An effect with its comparable parameters and its size."""

    effect: DiveEffect
    parameters: dict[str, float]
    size: float


def build(name: str, severity: float, scale: float, shape: int, conditions: DiveConditions) -> BuiltEffect:
    """Build an effect; `severity` 0 to 1 spans its range of sizes, `shape` seeds its random shape."""
    kind = (CATALOGUE | OUTSIDE)[name]
    size = scale * kind.low * (kind.high / kind.low) ** severity
    effect, parameters = kind.build(size, np.random.default_rng(shape), conditions)
    return BuiltEffect(effect, {f"{name}.{key}": float(value) for key, value in parameters.items()}, float(size))


@dataclass(frozen=True)
class HiddenEffects:
    """Effects as drawn: comparable parameters, sizes, and their strength."""

    effects: tuple[DiveEffect, ...]
    parameters: dict[str, float]
    sizes: dict[str, float]
    strength: float


def draw_hidden(
    plan: Plan, noise: Nuisances, names: Sequence[str], rng: np.random.Generator, scale: float, late: bool
) -> HiddenEffects | None:
    """Draw the effects' sizes, enlarging those that are not clearly above the nuisances.

    None if the largest is not, or if ``late`` and a clock offset has the sign that a pay-out delay cannot have.
    """
    conditions = conditions_of(plan)
    severity = {name: rng.uniform(0.0, 0.9 if len(names) == 1 else 0.6) for name in names}
    shape = {name: int(rng.integers(2**32)) for name in names}
    if late and any(
        build(name, 0.5, 1.0, shape[name], conditions).parameters.get("clock-offset.time", 1.0) < 0 for name in names
    ):
        return None
    reached = _adjust(plan, noise, severity, shape) if names else 0.0
    if reached is None:
        return None
    built = {name: build(name, severity[name], scale, shape[name], conditions) for name in names}
    effects = tuple(each.effect for each in built.values())
    if names and scale != 1.0:
        reached = strength(plan, noise, effects)[0]
    parameters = {key: value for each in built.values() for key, value in each.parameters.items()}
    return HiddenEffects(effects, parameters, {name: each.size for name, each in built.items()}, reached)


def _adjust(plan: Plan, noise: Nuisances, severity: dict[str, float], shape: dict[str, int]) -> float | None:
    """Change the severities in place until every effect is clear and none too strong; return the strength."""
    names, conditions = list(severity), conditions_of(plan)
    enlarged = False
    while True:
        effects = {name: build(name, severity[name], 1.0, shape[name], conditions).effect for name in names}
        total, whitened = strength(plan, noise, tuple(effects.values()))
        weak = [name for name in names if not _is_clear(plan, noise, effects, name, whitened, total)]
        if not weak:
            if len(names) == 1 and not enlarged and severity[names[0]] > -1.0 and total > MAXIMUM_STRENGTH:
                severity[names[0]] -= 0.25
                continue
            return total
        if any(severity[name] >= 1.0 for name in weak):
            return None
        severity |= {name: min(1.0, severity[name] + 0.34) for name in weak}
        enlarged = True  # not reduced again: an effect unlike the catalogue may have to be strong


def _is_clear(
    plan: Plan, noise: Nuisances, effects: dict[str, DiveEffect], name: str, whitened: Array, total: float
) -> bool:
    """Alone: strong enough. In a pair: the other effect, at any size, leaves a clear misfit without it."""
    if len(effects) == 1:
        unlike = name in CATALOGUE or misfit_to_catalogue(plan, noise, effects[name]) >= MINIMUM_MISFIT
        return total >= MINIMUM_STRENGTH and unlike
    other = next(each for each in effects if each != name)
    return _misfit(whitened, strength(plan, noise, (effects[other],))[1]) >= 0.6 * MINIMUM_STRENGTH


def _misfit(whitened: Array, rival: Array) -> float:
    """Norm of the change that a rival, scaled to fit best, does not explain [standard errors]."""
    share = float(rival @ whitened) / max(float(rival @ rival), 1e-12)
    return float(np.linalg.norm(whitened - share * rival))


def misfit_to_catalogue(plan: Plan, noise: Nuisances, effect: DiveEffect) -> float:
    """Misfit left by the nearest single effect of the catalogue [standard errors]."""
    whitened = strength(plan, noise, (effect,))[1]
    return min(_misfit(whitened, rival) for rival in _rivals(plan, noise))


@lru_cache(maxsize=4)
def _rivals(plan: Plan, noise: Nuisances) -> tuple[Array, ...]:
    """Whitened changes by each effect of the catalogue at a medium size."""
    effects = [build(name, 0.5, 1.0, 0, conditions_of(plan)).effect for name in CATALOGUE]
    return tuple(strength(plan, noise, (effect,))[1] for effect in effects)


LOGGED = (
    DiveEffect(reading=lambda t, depth, number: depth + 0.3),
    DiveEffect(reading=lambda t, depth, number: np.interp(1.03 * t, t, depth)),
)
"""A sensor that sits lower than is written, and a clock that runs slow: named too, and hidden in no case."""


def nats_beyond_the_named(plan: Plan, noise: Nuisances, effects: Sequence[DiveEffect]) -> float:
    """Nats that effects change dives by beyond what all named effects together could, to first order.

    Half the squared misfit that the changes by each of them, of any size, leave under the nuisances' covariance.
    """
    whitened = strength(plan, noise, effects)[1]
    rivals = [*_rivals(plan, noise), *(strength(plan, noise, (each,))[1] for each in LOGGED)]
    columns = np.column_stack([rival / max(float(np.linalg.norm(rival)), 1e-12) for rival in rivals])
    left = whitened - columns @ np.linalg.lstsq(columns, whitened, rcond=1e-6)[0]
    return 0.5 * float(left @ left)


TRIED = 5
"""Sizes of which one must be worth what is wanted."""


def draw_as_worth(
    plan: Plan, noise: Nuisances, name: str, rng: np.random.Generator, nats: tuple[float, float]
) -> HiddenEffects | None:
    """Draw an effect outside the catalogue whose size makes it worth nats in this range; None where none is found.

    Nats grow with the square of the size where there is no threshold.
    """
    kind, shape, wanted = OUTSIDE[name], int(rng.integers(2**32)), float(np.exp(rng.uniform(*np.log(nats))))
    size = float(np.sqrt(kind.low * kind.high))
    for _ in range(TRIED):
        effect, _ = kind.build(size, np.random.default_rng(shape), conditions_of(plan))
        held = nats_beyond_the_named(plan, noise, (effect,))
        if nats[0] <= held < nats[1]:
            return HiddenEffects((effect,), {}, {name: size}, strength(plan, noise, (effect,))[0])
        size *= float(np.clip(np.sqrt(wanted / max(held, 1e-9)), 0.1, 4.0))
        if size > 2.0 * kind.high:
            return None
    return None


LARGEST = {
    "drag-bias": 1.0,
    "line-payout": 0.8,
    "trapped-gas": 0.45,
    "added-mass": 1.5,
    "sensor-lag": 5.0,
    "clock-offset": 5.0,
    "depth-scale": 0.25,
    "vertical-current": 0.5,
}
"""Largest sizes of strong effects: half of what is physically possible, or of what still lets a dive go down."""
STRONG = (3.0, 10.0)
"""Range of a strong effect's size over its usual size, the middle of its range."""
LEAST_DRAG = -0.35
"""Drag that a strong drag bias takes off, at most."""


def draw_strong(plan: Plan, noise: Nuisances, name: str, rng: np.random.Generator) -> HiddenEffects | None:
    """Draw an effect of 3 to 10 times its usual size; None if there is no such dive."""
    kind = CATALOGUE[name]
    factor = float(np.exp(rng.uniform(*np.log(STRONG))))
    size = min(factor * float(np.sqrt(kind.low * kind.high)), LARGEST[name])
    effect, parameters = kind.build(size, np.random.default_rng(int(rng.integers(2**32))), conditions_of(plan))
    if name == "drag-bias" and parameters["fraction"] < LEAST_DRAG:
        return None
    named = {f"{name}.{key}": float(value) for key, value in parameters.items()}
    return HiddenEffects((effect,), named, {name: size}, strength(plan, noise, (effect,))[0])
