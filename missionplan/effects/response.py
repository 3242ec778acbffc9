"""What a vehicle responds to, outside of every cause with a name: a sum of terms made of a direction and a factor.

A term is a velocity error ahead or abeam, or fixed to the Earth, times something that differs from leg to leg: the
current, speed, depth, time, course. It says what the errors follow and names no cause.
"""

from collections.abc import Callable
from dataclasses import dataclass, make_dataclass
from functools import cached_property
from typing import cast

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars
from missionplan.effects.info import EffectInfo, Finding, LegRecord, Parameter, Term, lacks_nothing
from missionplan.phases.hooks import Leg, TransitEffect

DAY = 86400.0
HOUR = 3600.0
Wave = NDArray[np.complex128]
DEEPER = 100.0
"""Depth for which a response to depth is told [m]."""


@dataclass(frozen=True)
class ShapedResponse(TransitEffect):
    """Shapes on which a response may depend, and what it does with strengths of the names in `_STRENGTHS`.

    It acts from a `moment` [s] or until it, from that `until` another [s], `below` a depth [m], `above` a speed [m/s],
    comes and goes with a `period` [s], or so many `times` in a circle of courses.
    """

    moment: Scalars = 0.0
    until: Scalars = 0.0
    below: Scalars = 0.0
    above: Scalars = 0.0
    period: Scalars = DAY
    times: Scalars = 1.0

    @cached_property
    def _acting(self) -> tuple[str, ...]:
        strengths = ((name, getattr(self, name)) for name in _FACTORS)
        return tuple(name for name, value in strengths if (value if isinstance(value, float) else np.any(value)))

    def velocity(self, leg: Leg) -> Array:
        """Return the velocity error of each leg but for what the current does, shape (2, n) [m/s]."""
        total = np.zeros(leg.along.shape)
        for name in self._acting:
            total = total + getattr(self, name) * _direction(name, leg) * _FACTORS[name](self, leg)
        return total

    def answer_to_current(self, leg: Leg, water: Array) -> Array:
        """Return the velocity error that the current causes, shape (2, n) [m/s]."""
        along, across = np.sum(water * leg.along, axis=0), np.sum(water * starboard(leg), axis=0)
        across, along = (getattr(self, name) * part for name, part in zip(_BY_CURRENT, (across, along), strict=True))
        return np.asarray(across * leg.along + along * starboard(leg))


def starboard(leg: Leg) -> Array:
    """Unit vectors to starboard of the course, shape (2, n)."""
    return np.stack([leg.along[1], -leg.along[0]])


def _direction(name: str, leg: Leg) -> Array:
    """What a strength is multiplied with, its factor apart, shape (2, n): the speed, or a unit vector."""
    side = name.split("_")[0]
    if side in ("east", "north"):
        return np.repeat([[float(side == "east")], [float(side == "north")]], leg.along.shape[1], axis=1)
    unit = leg.along if side == "ahead" else starboard(leg)
    return unit if name in _NOT_OF_SPEED else np.asarray(leg.speed * unit)


def _middle(leg: Leg) -> Array:
    return leg.t_start + 0.5 * leg.duration


def _by_course(response: ShapedResponse, leg: Leg) -> Wave:
    return np.asarray(np.exp(1j * response.times * np.arctan2(*leg.along)))


def _in_turns(response: ShapedResponse, leg: Leg) -> Wave:
    """Mean over each leg of what comes and goes."""
    return np.asarray(np.sinc(leg.duration / response.period) * np.exp(2j * np.pi * _middle(leg) / response.period))


def _per_leg(response: ShapedResponse, leg: Leg) -> Array:
    return np.asarray(1.0 / np.where(leg.duration > 0.0, leg.duration, np.inf))


Factor = Callable[[ShapedResponse, Leg], Array]


def _part(of: Callable[[Wave], Array], wave: Callable[[ShapedResponse, Leg], Wave]) -> Factor:
    return lambda response, leg: np.asarray(of(wave(response, leg)))


_SHAPES = {
    "moment": Parameter("s", "from or until which it acts", 0.0, median=6.0 * HOUR, factor=4.0, searched="time"),
    "until": Parameter("s", "until which it acts", 0.0, median=9.0 * HOUR, factor=4.0, searched="time"),
    "below": Parameter("m", "depth below which it acts", 0.0, median=50.0, factor=3.0, searched="depth"),
    "above": Parameter("m/s", "speed above which it acts", 0.0, median=1.2, factor=1.5, searched="speed"),
    "period": Parameter("s", "of coming and going", 0.0, median=3 * HOUR, factor=3, default=DAY, searched="period"),
    "times": Parameter("", "in a circle of courses", 0.0, median=2.0, factor=2.0, default=1.0, searched="course"),
}
_NOT_OF_SPEED = ("ahead_constant", "ahead_each_leg", "abeam_each_leg")
_FACTORS: dict[str, Factor] = {
    "ahead_constant": lambda response, leg: np.ones_like(leg.t_start),
    "ahead_by_speed": lambda response, leg: np.asarray(leg.speed + 0.0 * leg.t_start),
    **dict.fromkeys(
        ("ahead_by_depth", "east_by_depth", "north_by_depth"), lambda response, leg: np.asarray(leg.depth + 0.0)
    ),
    **dict.fromkeys(("ahead_by_time_under_way", "abeam_by_time_under_way"), lambda response, leg: leg.duration),
    **dict.fromkeys(("ahead_each_leg", "abeam_each_leg", "east_each_leg", "north_each_leg"), _per_leg),
    **dict.fromkeys(("ahead_by_time", "abeam_by_time"), lambda response, leg: _middle(leg)),
    **{
        f"{side}_{words}_{part}": _part(of, wave)
        for words, wave in (("in_turns", _in_turns), ("by_course", _by_course))
        for side in ("ahead", "abeam")
        for part, of in (("cosine", np.real), ("sine", np.imag))
    },
    **dict.fromkeys(
        ("ahead_changed", "east_changed", "north_changed"), lambda response, leg: leg.share_after(response.moment)
    ),
    "abeam_before": lambda response, leg: 1.0 - leg.share_after(response.moment),
    **dict.fromkeys(
        ("ahead_while", "abeam_while", "east_while", "north_while"),
        lambda response, leg: leg.share_after(response.moment) - leg.share_after(response.until),
    ),
    **dict.fromkeys(
        ("ahead_deep", "abeam_deep", "east_deep", "north_deep"),
        lambda response, leg: (leg.depth > response.below) + 0.0 * leg.t_start,
    ),
    "abeam_fast": lambda response, leg: (leg.speed > response.above) + 0.0 * leg.t_start,
}
_BY_CURRENT = ("ahead_by_current_across", "abeam_by_current_along")
_STRENGTHS = (*_BY_CURRENT, *_FACTORS)
Response = cast(
    type[ShapedResponse],
    make_dataclass(
        "Response",
        [(name, Scalars, 0.0) for name in _STRENGTHS],
        bases=(ShapedResponse,),
        namespace={"__module__": __name__, "__doc__": "A share of the speed, an angle abeam, or as their units say."},
        frozen=True,
    ),
)


Lacking = Callable[[LegRecord], str]


def _needs(quantity: str, least: float, words: str) -> Lacking:
    return lambda record: "" if getattr(record, quantity) > least else f"needs {words}"


_needs_speeds = _needs("speeds", 0.1, "legs at different speeds")
_needs_durations = _needs("durations", 0.1, "legs of different lengths")
_needs_depths = _needs("depths", 2.0, "the depth of the legs, and different ones")


def _two(stem: str, words: str, searched: str) -> Term:
    """A term of a cosine and a sine."""
    parts = (f"{stem}_cosine", f"{stem}_sine")
    finding = Finding(parts[0], words, in_percent=stem.startswith("ahead"), toward=parts)
    return Term(parts, (searched,), finding)


def _drifts(what: str, words: str, lacking: Lacking, searched: tuple[str, ...] = (), change: float = 1.0) -> Term:
    """A term fixed to the Earth."""
    parts = (f"east_{what}", f"north_{what}")
    words, unit = f"it drifts {{size}} toward {{direction}} {words}", "m/s" if change != 1.0 else ""
    return Term(parts, searched, Finding(parts[0], words, toward=parts, each=change, unit=unit), lacking)


def _aside(name: str, words: str, searched: tuple[str, ...], lacking: Lacking) -> Term:
    """A turn of the course."""
    clause = f"it goes {{size}} to starboard {words}"
    return Term((name,), searched, Finding(name, clause, clause.replace("starboard", "port")), lacking)


def _where(what: str, when: str, searched: tuple[str, ...], lacking: Lacking) -> tuple[Term, ...]:
    """Terms ahead, fixed to the Earth and abeam that act at times, or at some depths."""
    faster, slower = f"it is {{size}} faster {when}", f"it is {{size}} slower {when}"
    ahead = Term((f"ahead_{what}",), searched, Finding(f"ahead_{what}", faster, slower, in_percent=True), lacking)
    return ahead, _drifts(what, when, lacking, searched), _aside(f"abeam_{what}", when, searched, lacking)


def _one(name: str, positive: str, negative: str, lacking: Lacking, change: float = 1.0) -> Term:
    in_percent = _PARAMETERS[name].unit in ("", "1/m", "1/s", "s/m")
    unit = _PARAMETERS[name].unit.split("/")[0] if change != 1.0 else ""
    finding = Finding(name, positive, negative, in_percent=in_percent, each=change, unit=unit)
    return Term((name,), finding=finding, lacking=lacking)


def _faster(name: str, words: str, lacking: Lacking, change: float = 1.0) -> Term:
    return _one(name, f"it goes {{size}} faster {words}", f"it goes {{size}} slower {words}", lacking, change)


def _by_time(what: str, words: str, lacking: Lacking) -> tuple[Term, Term]:
    """Terms ahead and abeam that grow with a time."""
    right, left = f"its course turns {{size}} to starboard {words}", f"its course turns {{size}} to port {words}"
    return _faster(f"ahead_by_{what}", words, lacking, HOUR), _one(f"abeam_by_{what}", right, left, lacking, HOUR)


def _turned(name: str, of: str, side: str) -> Term:
    words = f"a current {of} moves the vehicle {side} by {{size}} of its speed"
    return Term((name,), finding=Finding(name, words, words, in_percent=True))


def _strengths() -> dict[str, Parameter]:
    parameters = {}
    for name in _STRENGTHS:
        side = name.split("_")[0]
        unit, scale = {"ahead": ("", 0.05), "abeam": ("rad", 0.05)}.get(side, ("m/s", 0.05))
        if "current" in name:
            unit, scale = "", 0.5
        elif name == "ahead_constant":
            unit, scale = "m/s", 0.05
        elif "by_speed" in name:
            unit, scale = "s/m", 0.1
        elif "by_depth" in name:
            unit, scale = {"": "1/m", "m/s": "1/s"}[unit], 1e-3
        elif "time" in name:
            unit, scale = ("1/s" if side == "ahead" else "rad/s"), 0.05 / HOUR
        elif "each_leg" in name:
            unit, scale = "m", 20.0
        doc = name.replace("_", " ")
        parameters[name] = Parameter(unit, f"velocity error {doc}", scale=scale, spike=1e-3 * scale)
    return parameters


_PARAMETERS = _strengths()
TERMS = (
    _turned("ahead_by_current_across", "from port to starboard", "ahead"),
    _turned("abeam_by_current_along", "from astern", "to starboard"),
    _faster("ahead_constant", "at any speed", _needs_speeds),
    _faster("ahead_by_speed", "than it reckons for each m/s of its speed", _needs_speeds),
    _faster("ahead_by_depth", "for each 100 m of depth", _needs_depths, DEEPER),
    _drifts("by_depth", "more for each 100 m of depth", _needs_depths, change=DEEPER),
    *_by_time("time_under_way", "for each hour that a leg lasts", _needs_durations),
    _one("ahead_each_leg", "it gains {size} on each leg", "it loses {size} on each leg", _needs_durations),
    _aside("abeam_each_leg", "on each leg", (), _needs_durations),
    _drifts("each_leg", "on each leg, whatever its length", _needs_durations),
    *_by_time("time", "each hour", lacks_nothing),
    _two("ahead_in_turns", "its speed differs by up to {size} in turns of {at}", "period"),
    _two("abeam_in_turns", "its course is turned by up to {size} in turns of {at}", "period"),
    _two("ahead_by_course", "its speed differs by up to {size}, {at} in a circle of courses", "times"),
    _two("abeam_by_course", "its course is turned by up to {size}, {at} in a circle of courses", "times"),
    *_where("changed", "from {at} on", ("moment",), lacks_nothing)[:2],
    _aside("abeam_before", "until {at}", ("moment",), lacks_nothing),
    *_where("while", "from {at}", ("moment", "until"), lacks_nothing),
    *_where("deep", "below {at}", ("below",), _needs_depths),
    _aside("abeam_fast", "above {at}", ("above",), _needs_speeds),
)
RESPONSE = EffectInfo(
    id="response",
    tier="neutral",
    effect=Response,
    parameters={**_PARAMETERS, **_SHAPES},
    what="The vehicle responds to something that no effect with a name responds to.",
    sizes="a few per cent of the speed, or degrees.",
    confused_with=(),
    distinguished_by="Legs on which what it responds to differs and nothing else does.",
    linear=False,
    terms=TERMS,
)
