"""Effects that the catalogue does not name, each a recipe of a size; half of them were not looked at while tuning."""

from collections.abc import Callable

import numpy as np

from .sailing import Array, Log, Moment, Recipe, velocity_errors

DAY = 86400.0
Build = Callable[[float, np.random.Generator, float], Recipe]
"""From a size, a generator and the log's span [s]."""


def _turn(shape: Callable[[Moment, float, float], float]) -> Build:
    def build(size: float, rng: np.random.Generator, span: float) -> Recipe:
        phase, when = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(0.3, 0.7)
        return Recipe(turn=lambda m: 0.08 * size * shape(m, phase, when * span))

    return build


def _pace(shape: Callable[[Moment, float, float], float]) -> Build:
    def build(size: float, rng: np.random.Generator, span: float) -> Recipe:
        phase, when = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(0.3, 0.7)
        return Recipe(pace=lambda m: 1.0 - 0.08 * size * shape(m, phase, when * span))

    return build


def _water(shape: Callable[[Moment, float], Array]) -> Build:
    def build(size: float, rng: np.random.Generator, span: float) -> Recipe:
        phase, when = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(0.3, 0.7)
        toward = np.array([np.sin(phase), np.cos(phase)])
        return Recipe(water=lambda m: 0.1 * size * np.asarray(shape(m, when * span)) * toward)

    return build


def _weathervane(size: float, rng: np.random.Generator, span: float) -> Recipe:
    """The hull turns into a current from the side, by an angle that goes with it."""
    phase = rng.uniform(0.0, 2.0 * np.pi)
    flow = 0.15 * np.array([np.sin(phase), np.cos(phase)])
    return Recipe(
        turn=lambda m: -3.0 * 0.08 * size * float(flow @ [np.cos(m.heading), -np.sin(m.heading)]) / 0.15,
        water=lambda m: flow,
    )


def _eddy(size: float, rng: np.random.Generator, span: float) -> Recipe:
    """A vortex somewhere among the legs."""
    centre, radius = rng.normal(0.0, 1500.0, 2), rng.uniform(800.0, 2000.0)

    def water(m: Moment) -> Array:
        d = (m.place - centre) / radius
        return 0.2 * size * np.array([-d[1], d[0]]) * np.exp(0.5 - 0.5 * float(d @ d))

    return Recipe(water=water)


SEEN: dict[str, Build] = {
    "soft iron": _turn(lambda m, phase, when: np.sin(2.0 * m.heading + phase)),
    "third harmonic of the compass": _turn(lambda m, phase, when: np.sin(3.0 * m.heading + phase)),
    "compass drift": _turn(lambda m, phase, when: m.t / 20000.0),
    "gyro creep": _turn(lambda m, phase, when: m.since / 600.0),
    "battery sag": _pace(lambda m, phase, when: m.t / 20000.0),
    "weed": _pace(lambda m, phase, when: float(when * 0.7 < m.t < when * 1.3)),
    "front": _water(lambda m, when: np.array(float(m.t > when))),
    "slow start": _pace(lambda m, phase, when: 10.0 * float(m.since < 60.0)),
    "speed by course": _pace(lambda m, phase, when: np.sin(m.heading + phase)),
    "speed changed": _pace(lambda m, phase, when: float(m.t > when)),
}
UNSEEN: dict[str, Build] = {
    "compass drift that grows": _turn(lambda m, phase, when: (m.t / 20000.0) ** 2),
    "compass off for a while": _turn(lambda m, phase, when: float(when * 0.7 < m.t < when * 1.3)),
    "fourth harmonic of the compass": _turn(lambda m, phase, when: np.sin(4.0 * m.heading + phase)),
    "heading by the square of depth": _turn(lambda m, phase, when: (m.depth / 100.0) ** 2),
    "speed by depth": _pace(lambda m, phase, when: m.depth / 100.0),
    "speed twice by course": _pace(lambda m, phase, when: np.sin(2.0 * m.heading + phase)),
    "speed in turns of three hours": _pace(lambda m, phase, when: np.sin(2.0 * np.pi * m.t / 10800.0 + phase)),
    "current by depth": _water(lambda m, when: np.array(m.depth / 100.0)),
    "weathervane": _weathervane,
    "eddy": _eddy,
}


def beyond_the_named(log: Log, errors: Array) -> float:
    """Nats that errors add to a log beyond what a current, and errors of compass and speed by heading, could be.

    Half the squared size of what least squares on these columns leaves, over the noise of the legs.
    """
    sin, cos = np.sin(log.headings), np.cos(log.headings)
    ahead, abeam = np.array([sin, cos]), np.array([cos, -sin])
    ones, none = np.ones_like(sin), np.zeros_like(sin)
    columns = [np.array([ones, none]), np.array([none, ones]), log.speeds * ahead, log.speeds * abeam]
    columns += [log.speeds * sin * abeam, log.speeds * cos * abeam]
    noise = np.sqrt(log.sigma**2 + 2.0 * log.fix**2 / log.under_way**2)
    design = np.stack([(column / noise).ravel() for column in columns], axis=1)
    wanted = (errors.T / noise).ravel()
    left = wanted - design @ np.linalg.lstsq(design, wanted, rcond=None)[0]
    return 0.5 * float(left @ left)


def sized(build: Build, log: Log, nats: float, seed: int) -> Array | None:
    """Errors of an effect whose size makes it worth so many nats; None where these legs cannot show it at any."""
    span, size = float(np.sum(log.under_way + log.surface)), 1.0
    for _ in range(6):
        errors = velocity_errors(log, build(size, np.random.default_rng(seed), span))
        held = beyond_the_named(log, errors)
        if held < 1e-3 or size > 8.0:
            return None
        size *= float(np.clip(np.sqrt(nats / held), 0.1, 5.0))
    return errors
