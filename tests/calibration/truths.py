"""Truths drawn from the prior that the documentation states, and some from outside the catalogue.

Usual sizes are those of the pages of the effects, typed in by hand; a size has a Student-t law of three degrees of
freedom about zero, sizes and times of random errors its logarithm.
"""

import itertools
from collections.abc import Callable

import numpy as np

from .voyages import SIDEREAL_DAY, Array, Truth

RANDOM = ("persistent-error", "random-walk", "fix-error", "heavy-tails")
STEADY = ("mean-current", "tidal-current", "inertial-current", "compass-bias", "compass-deviation", "speed-scale")
EFFECTS = (*STEADY, *RANDOM)
CATALOGUE = 18
"""Effects on a transit in the catalogue; those that are not drawn here are as probable as each that is."""
FURTHER = np.exp(-3.0)
M2 = 12.4206012 * 3600.0
OUTSIDE = ("soft-iron", "slipping-log", "weed")


def prior() -> tuple[list[tuple[str, ...]], Array]:
    """Sets of causes with their prior: none 1, each single one 1/18, each pair e⁻³/18, without two alike."""
    sets: list[tuple[str, ...]] = [(), *((name,) for name in EFFECTS)]
    exclusive = {"persistent-error", "random-walk", "heavy-tails"}
    sets += [pair for pair in itertools.combinations(EFFECTS, 2) if not set(pair) <= exclusive]
    weights = np.array([{0: 1.0, 1: 1.0 / CATALOGUE, 2: FURTHER / CATALOGUE}[len(each)] for each in sets])
    return sets, weights / weights.sum()


def names(rng: np.random.Generator) -> tuple[str, ...]:
    """Draw a set of causes by its prior."""
    sets, weights = prior()
    return sets[int(rng.choice(len(sets), p=weights))]


def some(rng: np.random.Generator) -> tuple[str, ...]:
    """A set with at least a cause."""
    while not (found := names(rng)):
        continue
    return found


def truth(causes: tuple[str, ...], rng: np.random.Generator, latitude: float) -> Truth:
    """Draw sizes of causes and put them together."""
    found: dict[str, object] = {"names": causes, "current": (), "parameters": {}}
    for name in causes:
        BUILDERS[name](found, float(1.0 / np.sqrt(rng.chisquare(3.0) / 3.0)), rng, latitude)
    return Truth(**found)  # type: ignore[arg-type]


def _known(found: dict, **parameters: float) -> None:
    found["parameters"] |= {name.replace("__", ".").replace("_", "-", 1): value for name, value in parameters.items()}


def _mean_current(found: dict, wide: float, rng: np.random.Generator, latitude: float) -> None:
    flow = 0.15 * wide * rng.standard_normal(2)
    found["current"] += (lambda t, place: flow,)
    found["parameters"] |= {"mean-current.east": float(flow[0]), "mean-current.north": float(flow[1])}


def _wave(period: float, cosine: Array, sine: Array) -> Callable[[float, Array], Array]:
    def velocity(t: float | Array, place: Array) -> Array:
        angle = 2.0 * np.pi * t / period
        return np.multiply.outer(cosine, np.cos(angle)) + np.multiply.outer(sine, np.sin(angle))

    return velocity


def _polar(found: dict, name: str, cosine: float, sine: float) -> None:
    found["parameters"] |= {f"{name}.cosine": float(cosine), f"{name}.sine": float(sine)}


def _tidal_current(found: dict, wide: float, rng: np.random.Generator, latitude: float) -> None:
    cosine, sine = 0.12 * wide * rng.standard_normal((2, 2))
    found["current"] += (_wave(M2, cosine, sine),)
    for place, of in enumerate(("east", "north")):
        _polar(found, f"tidal-current.m2_{of}", cosine[place], sine[place])


def _inertial_current(found: dict, wide: float, rng: np.random.Generator, latitude: float) -> None:
    a, b = 0.15 * wide * rng.standard_normal(2)
    period = 0.5 * SIDEREAL_DAY / np.sin(np.radians(latitude))
    found["current"] += (_wave(period, np.array([a, b]), np.array([b, -a])),)  # clockwise north of the equator
    _polar(found, "inertial-current.amplitude", a, b)


def _compass_bias(found: dict, wide: float, rng: np.random.Generator, latitude: float) -> None:
    angle = float(np.clip(0.08 * wide * rng.standard_normal(), -0.5, 0.5))
    _turned(found, lambda heading: angle)
    found["parameters"] |= {"compass-bias.angle": angle}


def _compass_deviation(found: dict, wide: float, rng: np.random.Generator, latitude: float) -> None:
    cosine, sine = np.clip(0.08 * wide * rng.standard_normal(2), -0.4, 0.4)
    _turned(found, lambda heading: cosine * np.cos(heading) + sine * np.sin(heading))
    found["parameters"] |= {"compass-deviation.amplitude": float(np.hypot(cosine, sine))}
    _polar(found, "compass-deviation.amplitude", cosine, sine)


def _turned(found: dict, angle: Callable[[float], float]) -> None:
    before = found.get("turn", lambda t, heading: 0.0)
    found["turn"] = lambda t, heading: before(t, heading) + angle(heading)  # type: ignore[operator]


def _speed_scale(found: dict, wide: float, rng: np.random.Generator, latitude: float) -> None:
    fraction = float(np.clip(0.08 * wide * rng.standard_normal(), -0.4, 0.4))
    found["pace"] = lambda t, since: 1.0 + fraction
    found["parameters"] |= {"speed-scale.fraction": fraction}


def _spread(median: float, factor: float, rng: np.random.Generator) -> float:
    return float(median * np.exp(np.log(factor) * np.clip(rng.standard_t(3.0), -3.0, 3.0)))


def _persistent_error(found: dict, wide: float, rng: np.random.Generator, latitude: float) -> None:
    sigma, time = min(_spread(0.06, 2.5, rng), 0.5), _spread(30000.0, 6.0, rng)

    def onward(own: np.random.Generator, before: Array | None, apart: Array) -> Array:
        keep, normals = np.exp(-apart / time), own.standard_normal((2, apart.size))
        return sigma * normals if before is None else keep * before + sigma * np.sqrt(1.0 - keep**2) * normals

    def wander(own: np.random.Generator, times: Array) -> Array:
        v = [onward(own, None, np.zeros(1))]
        for apart in np.diff(times):
            v.append(onward(own, v[-1], np.array([apart])))
        return np.concatenate(v, axis=1)

    found["wander"], found["onward"] = wander, onward


def _random_walk(found: dict, wide: float, rng: np.random.Generator, latitude: float) -> None:
    rate = min(_spread(5e-4, 2.5, rng), 3e-3)

    def wander(own: np.random.Generator, times: Array) -> Array:
        steps = np.sqrt(np.diff(times, prepend=times[0])) * own.standard_normal((2, times.size))
        return np.asarray(rate * np.cumsum(steps, axis=1))

    def onward(own: np.random.Generator, before: Array | None, apart: Array) -> Array:
        step = rate * np.sqrt(apart) * own.standard_normal((2, apart.size))
        return np.zeros_like(step) if before is None else before + step

    found["wander"], found["onward"] = wander, onward


def _fix_error(found: dict, wide: float, rng: np.random.Generator, latitude: float) -> None:
    found["fix_sd"] = min(_spread(25.0, 2.5, rng), 300.0)


def _heavy_tails(found: dict, wide: float, rng: np.random.Generator, latitude: float) -> None:
    dof = max(1.0 / rng.uniform(0.0, 0.5), 2.1)
    found["stretch"] = lambda own, count: np.sqrt((dof - 2.0) / own.chisquare(dof, count))


BUILDERS = {name: globals()["_" + name.replace("-", "_")] for name in EFFECTS}


def outside(rng: np.random.Generator) -> Truth:
    """Something that the catalogue does not have."""
    kind, size = str(rng.choice(OUTSIDE)), float(rng.choice([-1.0, 1.0]) * rng.uniform(0.5, 2.0))
    phase = rng.uniform(0.0, 2.0 * np.pi)
    if kind == "soft-iron":
        return Truth(turn=lambda t, heading: 0.07 * size * np.sin(2.0 * heading + phase), outside=kind)
    if kind == "slipping-log":  # what is lost of a leg grows with it
        return Truth(pace=lambda t, since: 1.0 - 0.15 * size * since / 900.0, outside=kind)
    begins = rng.uniform(0.2, 0.7)
    return Truth(
        pace=lambda t, since: 1.0 - 0.12 * abs(size) * (begins * 2e4 < t < (begins + 0.25) * 2e4), outside=kind
    )
