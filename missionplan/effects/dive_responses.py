"""What a dive responds to, outside of every cause with a name: a force or a reading, and what it follows."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy

from missionplan.arrays import Array, Scalars, row_and_next
from missionplan.effects.dive_log import LinePayout
from missionplan.effects.info import EffectInfo, Finding, Parameter
from missionplan.phases.hooks import DescentEffect

LEAST_DRAG = 0.05
"""Factor on the drag below which none falls."""
ABRUPT = 0.1
"""Time scale of a change that happens at once: a few steps of a simulation [s]."""


@dataclass(frozen=True)
class LiftByDepth(DescentEffect):
    """Extra upward force that comes below the depth `start` [m] and tends to `lift_below` [N] over `over` [m]."""

    lift_below: Scalars = 0.0
    start: Scalars = 5.0
    over: Scalars = 10.0

    def lift(self, depth: Scalars) -> Scalars:
        """Return the upward force [N]."""
        return self.lift_below * _approach(depth, self.start, self.over)


@dataclass(frozen=True)
class DragByDepth(DescentEffect):
    """Extra share of the drag that comes below the depth `start` [m] and tends to `fraction` over `over` [m]."""

    fraction: Scalars = 0.0
    start: Scalars = 5.0
    over: Scalars = 10.0

    def local_drag_factor(self, depth: Scalars, line_length: Scalars) -> Scalars:
        """Return the factor on both bodies' drag."""
        return np.maximum(1.0 + self.fraction * _approach(depth, self.start, self.over), LEAST_DRAG)


@dataclass(frozen=True)
class LiftInLayer(DescentEffect):
    """Extra upward force in a layer: `lift_inside` [N] times ``exp(−½((z − depth)/thickness)²)``."""

    lift_inside: Scalars = 0.0
    depth: Scalars = 10.0
    thickness: Scalars = 3.0

    def lift(self, depth: Scalars) -> Scalars:
        """Return the upward force [N]."""
        return self.lift_inside * np.exp(-0.5 * np.square((depth - self.depth) / self.thickness))


@dataclass(frozen=True)
class DragBySpeed(DescentEffect):
    """Extra share `fraction` of both bodies' drag for each part of the speed beyond `start` [m/s]."""

    fraction: Scalars = 0.0
    start: Scalars = 1.0

    def drag_factor(self, since_taut: Scalars, speed: Scalars) -> Scalars:
        """Return the factor on both bodies' drag."""
        return np.maximum(1.0 + self.fraction * np.maximum(speed / self.start - 1.0, 0.0), LEAST_DRAG)


@dataclass(frozen=True)
class DragInSwings(DescentEffect):
    """Extra share of the drag of a hull that swings, ``fraction·sin²(πt/period)·exp(−t/fade)`` from the taut line on.

    Drag goes with the square of the angle to the flow, and so twice in a swing.
    """

    fraction: Scalars = 0.0
    period: Scalars = 2.5
    fade: Scalars = 10.0

    def drag_factor(self, since_taut: Scalars, speed: Scalars) -> Scalars:
        """Return the factor on both bodies' drag."""
        since = np.maximum(since_taut, 0.0)
        turned = np.square(np.sin(np.pi * since / self.period)) * np.exp(-since / self.fade)
        return np.maximum(1.0 + self.fraction * turned, LEAST_DRAG)


@dataclass(frozen=True)
class DragByLine(DescentEffect):
    """Extra share `rate` of both bodies' drag for each metre of line."""

    rate: Scalars = 0.0

    def local_drag_factor(self, depth: Scalars, line_length: Scalars) -> Scalars:
        """Return the factor on both bodies' drag."""
        return np.maximum(1.0 + self.rate * line_length, LEAST_DRAG)


@dataclass(frozen=True)
class WeightFromMoment(DescentEffect):
    """Extra share `fraction` of the anchor's wet weight from `moment` [s] after the separation on."""

    fraction: Scalars = 0.0
    moment: Scalars = 10.0

    def wet_weight_factor(self, since_separation: Scalars) -> Scalars:
        """Return the factor on the anchor's wet weight."""
        return 1.0 + self.fraction * scipy.special.expit((since_separation - self.moment) / ABRUPT)


@dataclass(frozen=True)
class WeightUntilMoment(DescentEffect):
    """Extra share `fraction` of the anchor's wet weight until `moment` [s] after the separation."""

    fraction: Scalars = 0.0
    moment: Scalars = 6.0

    def wet_weight_factor(self, since_separation: Scalars) -> Scalars:
        """Return the factor on the anchor's wet weight."""
        return 1.0 + self.fraction * scipy.special.expit((self.moment - since_separation) / ABRUPT)


@dataclass(frozen=True)
class ReadingByTime(DescentEffect):
    """Error of the depth read that tends to `offset` [m] over `time` [s] from the separation on."""

    offset: Scalars = 0.0
    time: Scalars = 5.0

    def reading(self, t: Array, depth: Array) -> Array:
        """Return the depth that the sensor reads [m]."""
        since = t.reshape(-1, *(1,) * (depth.ndim - 1))
        return np.asarray(depth - self.offset * np.expm1(-since / self.time))


@dataclass(frozen=True)
class ReadingAtFirst(DescentEffect):
    """Error of the depth read that is `offset` [m] when the vehicle begins to sink, and fades over `time` [s].

    So do mud that leaves the sensor's port, and a sensor's shock of pressure or cold. At rest nothing is read higher.
    """

    offset: Scalars = 0.0
    time: Scalars = 1.5

    def reading(self, t: Array, depth: Array) -> Array:
        """Return the depth that the sensor reads [m]."""
        row = np.minimum(np.argmax(depth > 0.0, axis=0), len(t) - 2)
        low, high = row_and_next(depth, row)
        begin = t[row] - (t[1] - t[0]) * np.minimum(low / np.maximum(high - low, 1e-9), 1.0)
        error = self.offset * np.exp(-np.maximum(t[:, None] - begin, 0.0) / self.time)
        return np.asarray(depth + np.where(depth > 0.0, np.maximum(error, -depth), 0.0))


def _approach(place: Scalars, start: Scalars, over: Scalars) -> Array:
    """Nil above a start, from there on an approach to 1."""
    return np.asarray(-np.expm1(-np.maximum(place - start, 0.0) / over))


def _start(unit: str, what: str, median: float, factor: float, default: float) -> Parameter:
    return Parameter(unit, what, 0.01, 1000.0, median=median, factor=factor, default=default)


def _response(
    name: str,
    follows: Literal["depth", "speed", "time", "line"],
    effect: type[DescentEffect],
    parameters: Mapping[str, Parameter],
    what: str,
    clause: str,
    *,
    changes_plan: bool = True,
) -> EffectInfo:
    """Entry of a response: what it does, and the clause for either sign of its first parameter, ``[more|less]``."""
    first = next(iter(parameters))
    positive, negative = (re.sub(r"\[(.*?)\|(.*?)\]", sign, clause) for sign in (r"\1", r"\2"))
    return EffectInfo(
        id=name,
        tier="neutral",
        effect=effect,
        parameters=parameters,
        what=what,
        sizes="As large as the effects with a name; either sign.",
        confused_with=(),
        distinguished_by="Dives in which what it follows differs and nothing else does.",
        finding=Finding(first, positive, negative, in_percent=parameters[first].unit in ("", "1/m")),
        follows=follows,
        changes_plan=changes_plan,
    )


def _share(scale: float, what: str, unit: str = "") -> Parameter:
    return Parameter(unit, what, -0.95, 10.0, scale=scale, spike=1e-3 * scale)


def _lift(what: str, field: str) -> Parameter:
    return Parameter("N", what, -50.0, 50.0, scale=1.5, spike=1.5e-3, field=field)


_DEPTH = _start("m", "depth from which it comes", 4.0, 2.5, 5.0)
_OVER = _start("m", "depth over which it comes", 10.0, 2.5, 10.0)
RESPONSES = (
    _response(
        "lift-by-depth",
        "depth",
        LiftByDepth,
        {"lift": _lift("extra upward force far down", "lift_below"), "start": _DEPTH, "over": _OVER},
        "a lift that changes with depth",
        "far down the vehicle is {size} [lighter|heavier] than near the surface",
    ),
    _response(
        "drag-by-depth",
        "depth",
        DragByDepth,
        {"fraction": _share(0.3, "extra share of the drag far down"), "start": _DEPTH, "over": _OVER},
        "drag that changes with depth",
        "far down vehicle and anchor have {size} [more|less] drag than near the surface",
    ),
    _response(
        "lift-in-layer",
        "depth",
        LiftInLayer,
        {
            "lift": _lift("extra upward force in the middle of the layer", "lift_inside"),
            "depth": _start("m", "middle of the layer", 10.0, 2.0, 10.0),
            "thickness": _start("m", "standard deviation of its profile", 2.5, 2.0, 3.0),
        },
        "a lift in a layer",
        "in a layer the vehicle is [held back|drawn down] by {size}",
    ),
    _response(
        "drag-by-speed",
        "speed",
        DragBySpeed,
        {
            "fraction": _share(0.5, "extra share of the drag at twice the speed"),
            "start": _start("m/s", "speed from which it comes", 0.9, 1.5, 1.0),
        },
        "drag that changes with speed",
        "at twice some speed vehicle and anchor have {size} [more|less] drag than the law of drag has it",
    ),
    _response(
        "drag-in-swings",
        "time",
        DragInSwings,
        {
            "fraction": _share(0.5, "extra share of the drag at the end of the first swings"),
            "period": _start("s", "time from one swing to the next", 2.5, 1.6, 2.5),
            "fade": _start("s", "time over which the swings fade", 8.0, 2.0, 10.0),
        },
        "drag that comes and goes with time",
        "as if it swung, vehicle and anchor have up to {size} [more|less] drag at first",
    ),
    _response(
        "drag-by-line",
        "line",
        DragByLine,
        {"rate": _share(0.02, "extra share of the drag for each metre of line", "1/m")},
        "drag that changes with the line's length",
        "each metre of line [adds {size} of|takes {size} off] the drag",
    ),
    _response(
        "delay-by-line",
        "time",
        LinePayout,
        {"delay_per_length": Parameter("s/m", "delay for each metre of line", -5.0, 0.0, scale=0.1, spike=1e-4)},
        "a dive that begins early for its line",
        "the dive begins {size} [late|early] for its line[|, as where a part of it stays on the spool]",
        changes_plan=False,
    ),
    _response(
        "weight-from-moment",
        "time",
        WeightFromMoment,
        {
            "fraction": _share(0.2, "extra share of the anchor's wet weight"),
            "moment": _start("s", "time since the separation from which it acts", 12.0, 1.8, 10.0),
        },
        "a pull that changes at a moment",
        "from some moment of the dive on the anchor pulls {size} [more|less] than its wet weight",
    ),
    _response(
        "weight-until-moment",
        "time",
        WeightUntilMoment,
        {
            "fraction": _share(0.2, "extra share of the anchor's wet weight"),
            "moment": _start("s", "time since the separation until which it acts", 6.0, 1.8, 6.0),
        },
        "a pull that differs at first",
        "at first the dive is pulled by {size} [more|less] than the anchor's wet weight",
    ),
    _response(
        "reading-by-time",
        "time",
        ReadingByTime,
        {
            "offset": Parameter("m", "error of the depth read in the end", -20.0, 20.0, scale=0.5, spike=5e-4),
            "time": _start("s", "time over which it comes", 6.0, 2.0, 5.0),
        },
        "an error of the depth read that changes with time",
        "in the course of a dive the depth sensor comes to read {size} too [deep|shallow]",
        changes_plan=False,
    ),
    _response(
        "reading-at-first",
        "time",
        ReadingAtFirst,
        {
            "offset": Parameter("m", "error of the depth read at first", -20.0, 20.0, scale=0.5, spike=5e-4),
            "time": _start("s", "time over which it fades", 1.5, 2.5, 1.5),
        },
        "an error of the depth read that fades with time",
        "when the dive begins the depth sensor reads {size} too [deep|shallow], and comes right",
        changes_plan=False,
    ),
)
"""Entries of all responses of a dive."""
