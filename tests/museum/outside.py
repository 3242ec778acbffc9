"""Effects that the catalogue does not name, each a recipe of a size; those unseen were not looked at while tuning."""

from collections.abc import Callable

import numpy as np
from scipy.optimize import least_squares

from .sailing import Array, Log, Moment, Recipe, velocity_errors

TIDE = 44712.0
"""Period of M2 [s]."""
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
    """The hull turns into a current from the side, by an angle that goes with it over the vehicle's speed."""
    phase = rng.uniform(0.0, 2.0 * np.pi)
    flow = 0.15 * np.array([np.sin(phase), np.cos(phase)])
    return Recipe(
        turn=lambda m: -2.0 * size * float(flow @ [np.cos(m.heading), -np.sin(m.heading)]) / m.speed,
        water=lambda m: flow,
    )


def _eddy(size: float, rng: np.random.Generator, span: float) -> Recipe:
    """A vortex somewhere among the legs."""
    centre, radius = rng.normal(0.0, 1500.0, 2), rng.uniform(800.0, 2000.0)

    def water(m: Moment) -> Array:
        d = (m.place - centre) / radius
        return 0.2 * size * np.array([-d[1], d[0]]) * np.exp(0.5 - 0.5 * float(d @ d))

    return Recipe(water=water)


def _wreck(size: float, rng: np.random.Generator, span: float) -> Recipe:
    """Iron on the ground turns the compass of whoever passes near."""
    centre, radius = rng.normal(0.0, 1500.0, 2), rng.uniform(600.0, 1500.0)

    def turn(m: Moment) -> float:
        d = (m.place - centre) / radius
        return 0.3 * size * float(np.exp(-0.5 * float(d @ d)))

    return Recipe(turn=turn)


def _plume(size: float, rng: np.random.Generator, span: float) -> Recipe:
    """On one side of a line in the sea the water moves otherwise."""
    across, along = rng.uniform(0.0, 2.0 * np.pi, 2)
    normal, offset = np.array([np.sin(across), np.cos(across)]), rng.normal(0.0, 800.0)
    flow = 0.1 * size * np.array([np.sin(along), np.cos(along)])
    return Recipe(water=lambda m: flow * float(m.place @ normal > offset))


def _packet(size: float, rng: np.random.Generator, span: float) -> Recipe:
    """Internal waves pass: the water goes to and fro along one direction for an hour or two."""
    when, toward = rng.uniform(0.3, 0.7) * span, rng.uniform(0.0, 2.0 * np.pi)
    period, lasts = rng.uniform(1200.0, 3600.0), rng.uniform(2400.0, 6000.0)
    flow = 0.15 * size * np.array([np.sin(toward), np.cos(toward)])
    return Recipe(
        water=lambda m: flow * np.cos(2.0 * np.pi * (m.t - when) / period) * np.exp(-0.5 * ((m.t - when) / lasts) ** 2)
    )


def _ekman(size: float, rng: np.random.Generator, span: float) -> Recipe:
    """A current by the wind, which turns and fades with depth."""
    toward, deep = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(20.0, 60.0)

    def water(m: Moment) -> Array:
        angle = toward + m.depth / deep
        return 0.15 * size * np.exp(-m.depth / deep) * np.array([np.sin(angle), np.cos(angle)])

    return Recipe(water=water)


def _jet(size: float, rng: np.random.Generator, span: float) -> Recipe:
    """A narrow current along a line in the sea."""
    toward, offset, width = rng.uniform(0.0, 2.0 * np.pi), rng.normal(0.0, 800.0), rng.uniform(300.0, 1000.0)
    along = np.array([np.sin(toward), np.cos(toward)])
    across = np.array([along[1], -along[0]])
    return Recipe(water=lambda m: 0.2 * size * along * np.exp(-0.5 * ((float(m.place @ across) - offset) / width) ** 2))


def _two_layers(size: float, rng: np.random.Generator, span: float) -> Recipe:
    """Above a depth the water goes to and fro with the tide, below it stands."""
    toward, phase, deep = *rng.uniform(0.0, 2.0 * np.pi, 2), rng.uniform(40.0, 110.0)
    flow = 0.2 * size * np.array([np.sin(toward), np.cos(toward)])
    return Recipe(water=lambda m: flow * float(m.depth < deep) * np.cos(2.0 * np.pi * m.t / TIDE + phase))


def _shear_line(size: float, rng: np.random.Generator, span: float) -> Recipe:
    """Across a line in the sea the current along it turns round."""
    toward, offset, width = rng.uniform(0.0, 2.0 * np.pi), rng.normal(0.0, 800.0), rng.uniform(100.0, 600.0)
    along = np.array([np.sin(toward), np.cos(toward)])
    across = np.array([along[1], -along[0]])
    return Recipe(water=lambda m: 0.1 * size * along * np.tanh((float(m.place @ across) - offset) / width))


def _meander(size: float, rng: np.random.Generator, span: float) -> Recipe:
    """A stream that winds: its cross flow goes to and fro with the way along it."""
    toward, phase, length = *rng.uniform(0.0, 2.0 * np.pi, 2), rng.uniform(3000.0, 8000.0)
    along = np.array([np.sin(toward), np.cos(toward)])
    across = np.array([along[1], -along[0]])
    return Recipe(water=lambda m: 0.15 * size * across * np.cos(2.0 * np.pi * float(m.place @ along) / length + phase))


def _cable(size: float, rng: np.random.Generator, span: float) -> Recipe:
    """A cable on the ground turns the compass along its line."""
    toward, offset, width = rng.uniform(0.0, 2.0 * np.pi), rng.normal(0.0, 800.0), rng.uniform(200.0, 600.0)
    across = np.array([np.cos(toward), -np.sin(toward)])
    return Recipe(turn=lambda m: 0.3 * size * float(np.exp(-0.5 * ((float(m.place @ across) - offset) / width) ** 2)))


def _rotating(size: float, rng: np.random.Generator, span: float) -> Recipe:
    """A current that turns round, faster than any tide."""
    phase, period = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(7200.0, 14400.0)

    def water(m: Moment) -> Array:
        angle = 2.0 * np.pi * m.t / period + phase
        return 0.1 * size * np.array([np.sin(angle), np.cos(angle)])

    return Recipe(water=water)


def _sawtooth(turns: float) -> float:
    return (turns % 1.0) - 0.5


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
    "wreck that turns the compass": _wreck,
    "compass that sticks in steps": _turn(lambda m, phase, when: 3.0 * float(_sawtooth(m.heading / np.radians(50.0)))),
    "edge of a plume": _plume,
    "Ekman spiral": _ekman,
    "torque of the propeller": _turn(lambda m, phase, when: 2.0 * (m.speed / 1.3) ** 2 * np.cos(m.heading + phase)),
    "packet of internal waves": _packet,
    "deviation that fades with depth": _turn(
        lambda m, phase, when: 2.0 * np.exp(-m.depth / 30.0) * np.sin(m.heading + phase)
    ),
    "cell that cuts out": _pace(lambda m, phase, when: 2.0 * float((m.t / 5400.0 + phase) % 1.0 < 0.4)),
    "speed by the square of time under way": _pace(lambda m, phase, when: 4.0 * (m.since / 900.0) ** 2),
    "stream that winds": _meander,
    "current that turns round": _rotating,
    "compass turned by the motor's current": _turn(lambda m, phase, when: 2.0 * float(m.speed > 1.4)),
    "tide of the upper layer": _two_layers,
}
UNSEEN: dict[str, Build] = {
    "compass that warms up": _turn(lambda m, phase, when: 2.0 * float(np.exp(-m.t / 7200.0))),
    "jet": _jet,
    "deviation that decays": _turn(
        lambda m, phase, when: 2.0 * np.exp(-m.t / (0.5 * when)) * np.sin(m.heading + phase)
    ),
    "swell from one side near the surface": _pace(
        lambda m, phase, when: 2.0 * np.exp(-m.depth / 20.0) * np.cos(m.heading + phase)
    ),
    "speed near the ground": _pace(lambda m, phase, when: 2.0 * np.exp((m.depth - 150.0) / 15.0)),
    "course by the place east": _turn(lambda m, phase, when: m.place[0] / 3000.0),
    "compass turned while a pump runs": _turn(lambda m, phase, when: 2.0 * float((m.t / 7200.0 + phase) % 1.0 < 0.5)),
    "battery worn by time and depth": _pace(lambda m, phase, when: m.t / 20000.0 * m.depth / 100.0),
    "turn by the square of time under way": _turn(lambda m, phase, when: 4.0 * (m.since / 900.0) ** 2),
    "ballast that shifts at a depth": _pace(lambda m, phase, when: float(m.depth > 70.0)),
    "compass that settles after each dive": _turn(lambda m, phase, when: 6.0 * float(np.exp(-m.since / 120.0))),
    "growth that is wiped off again": _pace(lambda m, phase, when: 2.0 * ((m.t / 20000.0 + phase) % 1.0)),
    "current that dies after a gale": _water(lambda m, when: np.array(np.exp(-m.t / (0.4 * when)))),
    "lock that opens for a while": _water(lambda m, when: np.array(float(0.8 * when < m.t < 1.2 * when))),
    "shear line": _shear_line,
    "cable on the ground": _cable,
    "propeller that draws air near the surface": _pace(lambda m, phase, when: 2.0 * float(np.exp(-m.depth / 8.0))),
    "drag that falls at a speed": _pace(lambda m, phase, when: float(np.tanh((m.speed - 1.3) / 0.1))),
    "waves that carry near the surface": _water(lambda m, when: np.array(np.exp(-m.depth / 15.0))),
    "compass that reads by quarters": _turn(lambda m, phase, when: float(np.sign(np.sin(2.0 * m.heading + phase)))),
    "a side of the hull that drags": _pace(lambda m, phase, when: 2.0 * max(float(np.sin(m.heading + phase)), 0.0)),
    "current near the ground": _water(lambda m, when: np.array(np.exp((m.depth - 150.0) / 20.0))),
    "compass that warms through": _turn(lambda m, phase, when: float(np.tanh((m.t - when) / 3000.0))),
    "speed by the place north": _pace(lambda m, phase, when: m.place[1] / 3000.0),
    "speed by the distance from the middle": _pace(lambda m, phase, when: float(np.hypot(*m.place)) / 3000.0),
    "course by time and depth": _turn(lambda m, phase, when: m.t / 20000.0 * m.depth / 100.0),
    "speed by time and course": _pace(lambda m, phase, when: 2.0 * m.t / 20000.0 * float(np.sin(m.heading + phase))),
    "current that fades to both sides": _water(lambda m, when: 1.0 / (1.0 + np.square(m.place[0] / 1500.0))),
    "deviation by the motor's current": _turn(
        lambda m, phase, when: 2.0 * float(m.speed > 1.4) * float(np.cos(m.heading + phase))
    ),
    "wind that rises and drives the surface": _water(lambda m, when: m.t / 20000.0 * np.array(np.exp(-m.depth / 15.0))),
    "load every third hour": _pace(lambda m, phase, when: 2.0 * float((m.t / 10800.0 + phase) % 1.0 < 1.0 / 3.0)),
}


def beyond_the_named(log: Log, errors: Array) -> float:
    """Nats that errors add to a log beyond what named effects could be.

    Half the squared size of what least squares leaves over the noise of the legs: of a current with a shear and a tide, a
    scale of the speed and a loss beyond the middle one, an answer to the current, sideslip, and errors of the compass:
    constant, by heading, by depth, and from the best of some moments on.
    """
    noise = np.sqrt(log.sigma**2 + 2.0 * log.fix**2 / log.under_way**2)[:, None]
    left = []
    for after in (np.zeros_like(log.headings), *np.tri(len(log.headings))[:: max(len(log.headings) // 6, 1)]):
        found = least_squares(
            lambda sizes, after=after: ((errors - _named(log, sizes, after)) / noise).ravel(), np.zeros(19)
        )
        left.append(float(found.cost))
    return min(left)


def _named(log: Log, sizes: Array, after: Array) -> Array:
    """Velocity errors of named effects of these sizes, the jump of the compass where `after` is one, shape (n, 2)."""
    sin, cos = np.sin(log.headings), np.cos(log.headings)
    turn = sizes[0] + sizes[1] * sin + sizes[2] * cos + sizes[3] * log.depths / 100.0 + sizes[4] * after
    turn = turn + sizes[16] / log.speeds**2
    lost = np.maximum(log.speeds - np.median(log.speeds), 0.0)
    course, pace = log.headings + turn, log.speeds * (1.0 + sizes[5]) - sizes[17] * lost
    through = pace * np.array([np.sin(course), np.cos(course)]) - log.speeds * np.array([sin, cos])
    shear = 1e-4 * sizes[8:12].reshape(2, 2) @ _middles(log)
    angle = 2.0 * np.pi / TIDE * (np.cumsum(log.under_way + log.surface) - 0.5 * log.under_way)
    tide = sizes[12:16].reshape(2, 2) @ np.array([np.sin(angle), np.cos(angle)])
    answer = sizes[18] * (sizes[6] * sin + sizes[7] * cos) * np.array([sin, cos])
    return (through + sizes[6:8, None] + answer + shear + tide).T


def _middles(log: Log) -> Array:
    """Where the legs' middles are reckoned, shape (2, n) [m]."""
    paths = log.speeds * log.under_way * np.array([np.sin(log.headings), np.cos(log.headings)])
    return np.asarray(np.cumsum(paths, axis=1) - 0.5 * paths)


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
