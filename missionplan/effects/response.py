"""What a vehicle responds to, outside of every cause with a name: a sum of terms made of a direction and a factor.

A term is a velocity error ahead or abeam, or fixed to the Earth, times something that differs from leg to leg: the
current, speed, depth, time, course. It says what the errors follow and names no cause.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.effects.info import EffectInfo, Finding, LegRecord, Parameter, Term, lacks_nothing
from missionplan.phases.hooks import Leg, TransitEffect

DAY = 86400.0
HOUR = 3600.0
DEEPER = 100.0
"""Depth for which a response to depth is told [m]."""


@dataclass(frozen=True)
class Response(TransitEffect):
    """Terms by their names: a share of the speed ahead, an angle abeam to starboard, or as their units say.

    A mission's response has the strengths of one term, and the shape on which it depends: the `moment` [s] from which
    or before which it acts, the depth `below` [m] which it does, or the `period` [s] in which it comes and goes.
    """

    ahead_by_current_across: Scalars = 0.0
    abeam_by_current_along: Scalars = 0.0
    ahead_constant: Scalars = 0.0
    ahead_by_speed: Scalars = 0.0
    ahead_by_depth: Scalars = 0.0
    east_by_depth: Scalars = 0.0
    north_by_depth: Scalars = 0.0
    ahead_by_time_under_way: Scalars = 0.0
    abeam_by_time_under_way: Scalars = 0.0
    ahead_each_leg: Scalars = 0.0
    abeam_each_leg: Scalars = 0.0
    east_each_leg: Scalars = 0.0
    north_each_leg: Scalars = 0.0
    ahead_by_time: Scalars = 0.0
    abeam_by_time: Scalars = 0.0
    ahead_in_turns_cosine: Scalars = 0.0
    ahead_in_turns_sine: Scalars = 0.0
    abeam_in_turns_cosine: Scalars = 0.0
    abeam_in_turns_sine: Scalars = 0.0
    ahead_by_course_cosine: Scalars = 0.0
    ahead_by_course_sine: Scalars = 0.0
    ahead_by_twice_course_cosine: Scalars = 0.0
    ahead_by_twice_course_sine: Scalars = 0.0
    ahead_by_thrice_course_cosine: Scalars = 0.0
    ahead_by_thrice_course_sine: Scalars = 0.0
    abeam_by_twice_course_cosine: Scalars = 0.0
    abeam_by_twice_course_sine: Scalars = 0.0
    abeam_by_thrice_course_cosine: Scalars = 0.0
    abeam_by_thrice_course_sine: Scalars = 0.0
    ahead_changed: Scalars = 0.0
    abeam_before: Scalars = 0.0
    east_changed: Scalars = 0.0
    north_changed: Scalars = 0.0
    ahead_deep: Scalars = 0.0
    abeam_deep: Scalars = 0.0
    moment: Scalars = 0.0
    below: Scalars = 0.0
    period: Scalars = DAY

    @cached_property
    def _acting(self) -> tuple[str, ...]:
        return tuple(each.name for each in fields(self) if each.name in _FACTORS and np.any(getattr(self, each.name)))

    def velocity(self, leg: Leg) -> Array:
        """Return the velocity error of each leg but for what the current does, shape (2, n) [m/s]."""
        total = np.zeros(leg.along.shape)
        for name in self._acting:
            total = total + getattr(self, name) * _direction(name, leg) * _FACTORS[name](self, leg)
        return total

    def answer_to_current(self, leg: Leg, water: Array) -> Array:
        """Return the velocity error that the current causes, shape (2, n) [m/s]."""
        along, across = np.sum(water * leg.along, axis=0), np.sum(water * starboard(leg), axis=0)
        across, along = self.ahead_by_current_across * across, self.abeam_by_current_along * along
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


def _harmonic(order: int, sine: int) -> Callable[[Response, Leg], Array]:
    function = np.sin if sine else np.cos

    def factor(response: Response, leg: Leg) -> Array:
        return np.asarray(function(order * np.arctan2(*leg.along)))

    return factor


def _in_turns(sine: int) -> Callable[[Response, Leg], Array]:
    """Mean over each leg of what comes and goes."""
    function = np.sin if sine else np.cos

    def factor(response: Response, leg: Leg) -> Array:
        at = 2.0 * np.pi * _middle(leg) / response.period
        return np.asarray(np.sinc(leg.duration / response.period) * function(at))

    return factor


def _per_leg(response: Response, leg: Leg) -> Array:
    return np.asarray(1.0 / np.where(leg.duration > 0.0, leg.duration, np.inf))


def _changed(response: Response, leg: Leg) -> Array:
    """Share of each leg after the moment."""
    return leg.share_after(response.moment)


_NOT_OF_SPEED = ("ahead_constant", "ahead_each_leg", "abeam_each_leg")
_FACTORS: dict[str, Callable[[Response, Leg], Array]] = {
    "ahead_constant": lambda response, leg: np.ones_like(leg.t_start),
    "ahead_by_speed": lambda response, leg: np.asarray(leg.speed + 0.0 * leg.t_start),
    **dict.fromkeys(
        ("ahead_by_depth", "east_by_depth", "north_by_depth"), lambda response, leg: np.asarray(leg.depth + 0.0)
    ),
    **dict.fromkeys(("ahead_by_time_under_way", "abeam_by_time_under_way"), lambda response, leg: leg.duration),
    **dict.fromkeys(("ahead_each_leg", "abeam_each_leg", "east_each_leg", "north_each_leg"), _per_leg),
    **dict.fromkeys(("ahead_by_time", "abeam_by_time"), lambda response, leg: _middle(leg)),
    **{
        f"{side}_in_turns_{part}": _in_turns(i)
        for side in ("ahead", "abeam")
        for i, part in enumerate(("cosine", "sine"))
    },
    **{
        f"{side}_by_{words}course_{part}": _harmonic(order, i)
        for side, orders in (("ahead", (1, 2, 3)), ("abeam", (2, 3)))
        for order, words in enumerate(("", "twice_", "thrice_"), start=1)
        if order in orders
        for i, part in enumerate(("cosine", "sine"))
    },
    **dict.fromkeys(("ahead_changed", "east_changed", "north_changed"), _changed),
    "abeam_before": lambda response, leg: 1.0 - _changed(response, leg),
    **dict.fromkeys(("ahead_deep", "abeam_deep"), lambda own, leg: (leg.depth > own.below) + 0.0 * leg.t_start),
}


def _needs(quantity: str, least: float, words: str) -> Callable[[LegRecord], str]:
    return lambda record: "" if getattr(record, quantity) > least else f"needs {words}"


_needs_speeds = _needs("speeds", 0.1, "legs at different speeds")
_needs_durations = _needs("durations", 0.1, "legs of different lengths")
_needs_depths = _needs("depths", 2.0, "the depth of the legs, and different ones")


def _two(stem: str, words: str, searched: str = "") -> Term:
    """A term of a cosine and a sine."""
    parts = (f"{stem}_cosine", f"{stem}_sine")
    finding = Finding(parts[0], words, in_percent=stem.startswith("ahead"), toward=parts)
    return Term(parts, searched, finding)


def _one(name: str, positive: str, negative: str, lacking: Callable[[LegRecord], str], each: float = 1.0) -> Term:
    in_percent = _PARAMETERS[name].unit in ("", "1/m", "1/s", "s/m")
    unit = _PARAMETERS[name].unit.split("/")[0] if each != 1.0 else ""
    finding = Finding(name, positive, negative, in_percent=in_percent, each=each, unit=unit)
    return Term((name,), finding=finding, lacking=lacking)


def _turned(name: str, of: str, side: str) -> Term:
    words = f"a current {of} moves the vehicle {side} by {{size}} of its speed"
    return Term((name,), finding=Finding(name, words, words, in_percent=True))


def _strengths() -> dict[str, Parameter]:
    found = {}
    for each in fields(Response):
        side = each.name.split("_")[0]
        if each.name in ("moment", "below", "period"):
            continue
        unit, scale = {"ahead": ("", 0.05), "abeam": ("rad", 0.05)}.get(side, ("m/s", 0.05))
        if "current" in each.name:
            unit, scale = "", 0.5
        elif each.name == "ahead_constant":
            unit, scale = "m/s", 0.05
        elif "by_speed" in each.name:
            unit, scale = "s/m", 0.1
        elif "by_depth" in each.name:
            unit, scale = {"": "1/m", "m/s": "1/s"}[unit], 1e-3
        elif "time" in each.name:
            unit, scale = ("1/s" if side == "ahead" else "rad/s"), 0.05 / HOUR
        elif "each_leg" in each.name:
            unit, scale = "m", 20.0
        doc = each.name.replace("_", " ")
        found[each.name] = Parameter(unit, f"velocity error {doc}", scale=scale, spike=1e-3 * scale)
    return found


_PARAMETERS = _strengths()
TERMS = (
    _turned("ahead_by_current_across", "from port to starboard", "ahead"),
    _turned("abeam_by_current_along", "from astern", "to starboard"),
    _one(
        "ahead_constant",
        "it goes {size} faster at any speed",
        "it goes {size} slower at any speed",
        _needs_speeds,
    ),
    _one(
        "ahead_by_speed",
        "it goes {size} faster than it reckons for each m/s of its speed",
        "it goes {size} slower than it reckons for each m/s of its speed",
        _needs_speeds,
    ),
    _one(
        "ahead_by_depth",
        "it goes {size} faster for each 100 m of depth",
        "it goes {size} slower for each 100 m of depth",
        _needs_depths,
        DEEPER,
    ),
    Term(
        ("east_by_depth", "north_by_depth"),
        finding=Finding(
            "east_by_depth",
            "it drifts {size} toward {direction} more for each 100 m of depth",
            toward=("east_by_depth", "north_by_depth"),
            each=DEEPER,
            unit="m/s",
        ),
        lacking=_needs_depths,
    ),
    _one(
        "ahead_by_time_under_way",
        "it goes {size} faster for each hour that a leg lasts",
        "it goes {size} slower for each hour that a leg lasts",
        _needs_durations,
        HOUR,
    ),
    _one(
        "abeam_by_time_under_way",
        "its course turns to starboard, by {size} for each hour that a leg lasts",
        "its course turns to port, by {size} for each hour that a leg lasts",
        _needs_durations,
        HOUR,
    ),
    _one("ahead_each_leg", "it gains {size} on each leg", "it loses {size} on each leg", _needs_durations),
    _one(
        "abeam_each_leg",
        "it ends each leg {size} to starboard",
        "it ends each leg {size} to port",
        _needs_durations,
    ),
    Term(
        ("east_each_leg", "north_each_leg"),
        finding=Finding(
            "east_each_leg",
            "it ends each leg, whatever its length, {size} toward {direction}",
            toward=("east_each_leg", "north_each_leg"),
        ),
        lacking=_needs_durations,
    ),
    _one(
        "ahead_by_time",
        "it becomes faster, by {size} an hour",
        "it becomes slower, by {size} an hour",
        lacks_nothing,
        HOUR,
    ),
    _one(
        "abeam_by_time",
        "its course turns to starboard with time, by {size} an hour",
        "its course turns to port with time, by {size} an hour",
        lacks_nothing,
        HOUR,
    ),
    _two("ahead_in_turns", "its speed differs by up to {size} in turns of {at}", searched="period"),
    _two("abeam_in_turns", "its course is turned by up to {size} in turns of {at}", searched="period"),
    _two("ahead_by_course", "its speed differs by up to {size} with its course"),
    _two("ahead_by_twice_course", "its speed differs by up to {size} twice in a circle of courses"),
    _two("ahead_by_thrice_course", "its speed differs by up to {size} thrice in a circle of courses"),
    _two("abeam_by_twice_course", "its course is turned by up to {size} twice in a circle of courses"),
    _two("abeam_by_thrice_course", "its course is turned by up to {size} thrice in a circle of courses"),
    Term(
        ("ahead_changed",),
        "moment",
        Finding(
            "ahead_changed", "it is {size} faster from {at} on", "it is {size} slower from {at} on", in_percent=True
        ),
    ),
    Term(
        ("abeam_before",),
        "moment",
        Finding("abeam_before", "it goes {size} to starboard until {at}", "it goes {size} to port until {at}"),
    ),
    Term(
        ("east_changed", "north_changed"),
        "moment",
        Finding(
            "east_changed",
            "it drifts {size} toward {direction} from {at} on",
            toward=("east_changed", "north_changed"),
        ),
    ),
    Term(
        ("ahead_deep",),
        "below",
        Finding("ahead_deep", "it is {size} faster below {at}", "it is {size} slower below {at}", in_percent=True),
        _needs_depths,
    ),
    Term(
        ("abeam_deep",),
        "below",
        Finding("abeam_deep", "it is turned {size} to starboard below {at}", "it is turned {size} to port below {at}"),
        _needs_depths,
    ),
)
RESPONSE = EffectInfo(
    id="response",
    tier="neutral",
    effect=Response,
    parameters={
        **_PARAMETERS,
        "moment": Parameter("s", "from or until which it acts", 0.0, median=6.0 * HOUR, factor=4.0, searched="time"),
        "period": Parameter("s", "of coming and going", 0.0, median=3 * HOUR, factor=3, default=DAY, searched="period"),
        "below": Parameter("m", "depth below which it acts", 0.0, median=50.0, factor=3.0, searched="depth"),
    },
    what="The vehicle responds to something that no effect with a name responds to.",
    sizes="a few per cent of the speed, or degrees.",
    confused_with=(),
    distinguished_by="Legs on which what it responds to differs and nothing else does.",
    linear=False,
    terms=TERMS,
)
