"""MOOS-IvP, as its documentation has it: reads a `.bhv`, runs its behaviours, and moves a simple vehicle by them.

Semantics after "An Overview of MOOS-IvP and a Users Guide to the IvP Helm": a behaviour runs while all its conditions
hold, and a condition on a variable that was never posted does not; flags are posted on completion and are mail of the
next iteration; a perpetual behaviour may complete again; `duration` counts from when it first ran, idle time too, anew
after `duration_reset`; BHV_Waypoint completes within `capture_radius`, or within `slip_radius` once the distance grows;
BHV_PeriodicSurface is marked by a changed variable and posts the time left of its period. Parameters that a behaviour
does not have are errors, as they are in pHelmIvP. Of several wishes for a variable the weightiest wins.
"""

import math
import operator
import re
from dataclasses import dataclass, field

from sea import Voyage

COMMON = {"name", "pwt", "condition", "endflag", "duration", "duration_reset", "perpetual", "post_mapping"}
PARAMETERS = {
    "BHV_Waypoint": {"points", "speed", "capture_radius", "slip_radius", "repeat"},
    "BHV_ConstantDepth": {"depth", "peakwidth", "basewidth"},
    "BHV_ConstantSpeed": {"speed"},
    "BHV_ConstantHeading": {"heading"},
    "BHV_Timer": set(),
    "BHV_PeriodicSurface": {"period", "mark_variable", "pending_status_var", "max_time_at_surface"},
}
NEEDS_DURATION = {"BHV_ConstantDepth", "BHV_ConstantSpeed", "BHV_ConstantHeading"}
"""Whose duration is zero unless it is given."""
OPERATORS = {"=": operator.eq, "==": operator.eq, "<=": operator.le, ">": operator.gt}
STEPS = {"leg": 1.0, "hold": 5.0, "ascend": 2.0}
"""Of the helm and its vehicle, by state [s]."""
STEP = 0.5
"""In all other states [s]."""
LOG_STEP = 15.0
"""Under way [s]."""


@dataclass
class Behaviour:
    kind: str
    values: dict[str, str]
    conditions: list[tuple[str, str, str]]
    flags: list[tuple[str, str]]
    phase: str = ""
    began: float | None = None
    reset_seen: float = -1.0
    pending: bool = False
    completed: bool = False
    running: bool = False
    nearest: float = math.inf
    mark: object = None
    marked: float = 0.0

    def number(self, key: str) -> float:
        return float(self.values[key])


def read(text: str) -> tuple[dict[str, str], list[Behaviour]]:
    """Initial variables and behaviours of a file; a word that is none is an error."""
    lines = [line.split("//")[0].strip() for line in text.splitlines()]
    body = "\n".join(line for line in lines if line)
    behaviours = []
    for kind, inner in re.findall(r"^Behavior = (\w+)\n\{\n(.*?)\n\}$", body, re.S | re.M):
        pairs = [tuple(part.strip() for part in line.split("=", 1)) for line in inner.splitlines()]
        keys = {key for key, _ in pairs}
        assert keys <= COMMON | PARAMETERS[kind], f"{kind} has no {keys - COMMON - PARAMETERS[kind]}"
        assert kind not in NEEDS_DURATION or "duration" in keys
        conditions = [
            re.fullmatch(r"(\w+) (==|=|<=|>) (\S+)", value).groups() for key, value in pairs if key == "condition"
        ]
        flags = [tuple(part.strip() for part in value.split("=")) for key, value in pairs if key == "endflag"]
        values = {key: value for key, value in pairs if key not in ("condition", "endflag")}
        phase = next((value for name, _, value in conditions if name == "PHASE"), "")
        behaviours.append(Behaviour(kind, values, conditions, flags, phase))
    names = [each.values["name"] for each in behaviours]
    assert len(set(names)) == len(names)
    return dict(re.findall(r"^initialize (\w+) = (\S+)$", body, re.M)), behaviours


@dataclass
class Sailed:
    """What happened: way through the water of each leg [m], where and how the anchor was released, and the log.

    `states` are (time, reckoned east and north, depth, heading, speed) [s, m, rad, m/s], `fixes` (time, east, north).
    """

    legs: list[float] = field(default_factory=list)
    phases: list[str] = field(default_factory=list)
    release: dict[str, float] | None = None
    arrived: list[tuple[float, float]] = field(default_factory=list)
    aborted: str = ""
    states: list[tuple[float, ...]] = field(default_factory=list)
    fixes: list[tuple[float, float, float]] = field(default_factory=list)


class Helm:
    """The helm, its vehicle and its database."""

    def __init__(
        self,
        text: str,
        voyage: Voyage,
        climb: float,
        goal: tuple[float, float] = (0.0, 0.0),
        mooring: tuple[float, float] = (0.0, 0.0),
        fix_every: float | None = None,
        power: float = 0.0,
    ) -> None:
        """`climb` is a slope, `mooring` depth and time to part; without `fix_every` [s] a surfacing has one fix.

        A vehicle that knows its `power` [W] posts the energy used.
        """
        self.power = power
        initial, self.behaviours = read(text)
        self.values: dict[str, object] = {**initial, "DEPLOY": "true", "MODE": "ACTIVE"}
        self.posted_at = dict.fromkeys(initial, -0.5)
        self.voyage, self.climb, self.goal = voyage, climb, goal
        self.bottom, self.galvanic = mooring
        self.time, self.depth, self.speed, self.heading, self.wanted_depth = 0.0, 0.0, 0.0, 0.0, 0.0
        self.true, self.nav = [0.0, 0.0], [0.0, 0.0]
        self.error, self.way, self.fixes = (0.0, 0.0), 0.0, 0
        self.surfaced_at: float | None = 0.0
        self.fix_at, self.fix = -math.inf, (0.0, 0.0)
        self.sinking: float | None = None
        self.fix_every = fix_every
        self.got_fix, self.logged = True, 0.0
        self.done = Sailed()

    def sail(self, longest: float = 40_000.0) -> Sailed:
        """Until the mission's end."""
        while self.time < longest and self.values["PHASE"] not in ("done", "abort"):
            self._iterate()
            self._move()
        self.done.aborted = str(self.values.get("ABORTED_BY", ""))
        return self.done

    def _iterate(self) -> None:
        self.values |= {"NAV_DEPTH": self.depth}
        mail: list[tuple[str, object]] = []
        wishes: dict[str, tuple[float, float]] = {}
        phase = self.values["PHASE"]
        for each in self.behaviours:
            if each.phase and each.phase != phase and not each.running:
                continue
            self._run(each, mail, wishes)
        for key, value in mail:
            self._post(key, value)
        assert wishes.keys() == {"speed", "course", "depth"}, f"{phase} leaves a decision without a wish"
        self.speed, self.wanted_depth, self.heading = (wishes[key][1] for key in ("speed", "depth", "course"))

    def _run(self, each: Behaviour, mail: list, wishes: dict) -> None:
        if "duration_reset" in each.values:
            variable, value = each.values["duration_reset"].split("=")
            if self.values.get(variable) == value and self.posted_at[variable] > each.reset_seen:
                each.reset_seen, each.began, each.pending = self.posted_at[variable], None, False
        if each.completed or not all(self._holds(condition) for condition in each.conditions):
            each.running, each.nearest = False, math.inf
            return
        each.running = True
        limit = each.values.get("duration", "no-time-limit")
        if each.pending:
            each.began, each.pending = None, False
        if limit != "no-time-limit":
            each.began = self.time if each.began is None else each.began
            if self.time - each.began >= float(limit):
                self._complete(each, mail)
                each.pending = each.values.get("perpetual") == "true"
                if each.completed:
                    return
        getattr(self, f"_{each.kind[4:].lower()}")(each, mail, wishes)

    def _holds(self, condition: tuple[str, str, str]) -> bool:
        name, relation, wanted = condition
        if name not in self.values:
            return False
        value = self.values[name]
        return OPERATORS[relation](value, type(value)(wanted))

    def _complete(self, each: Behaviour, mail: list) -> None:
        mail += each.flags
        each.completed = each.values.get("perpetual") != "true"

    def _wish(self, each: Behaviour, wishes: dict, **wanted: float) -> None:
        weight = each.number("pwt")
        for key, value in wanted.items():
            if key not in wishes or weight > wishes[key][0]:
                wishes[key] = (weight, value)

    def _timer(self, each: Behaviour, mail: list, wishes: dict) -> None: ...

    def _constantdepth(self, each: Behaviour, mail: list, wishes: dict) -> None:
        self._wish(each, wishes, depth=each.number("depth"))

    def _constantspeed(self, each: Behaviour, mail: list, wishes: dict) -> None:
        self._wish(each, wishes, speed=each.number("speed"))

    def _constantheading(self, each: Behaviour, mail: list, wishes: dict) -> None:
        self._wish(each, wishes, course=math.radians(each.number("heading")))

    def _waypoint(self, each: Behaviour, mail: list, wishes: dict) -> None:
        east, north = (float(part) for part in each.values["points"].split(","))
        ahead = east - self.nav[0], north - self.nav[1]
        distance = math.hypot(*ahead)
        each.nearest = min(each.nearest, distance)
        capture, slip = each.number("capture_radius"), each.number("slip_radius")
        if distance < capture or (slip > capture and distance > each.nearest and each.nearest <= slip):
            each.nearest = math.inf
            self._complete(each, mail)
            return
        self._wish(each, wishes, course=math.atan2(*ahead), speed=each.number("speed"))

    def _periodicsurface(self, each: Behaviour, mail: list, wishes: dict) -> None:
        mail.append((each.values["pending_status_var"], round(each.number("period") - (self.time - each.marked))))
        value = self.values.get(each.values["mark_variable"])
        if value != each.mark:
            each.mark, each.marked = value, self.time
        assert each.number("period") > 1e5, "a period that ends makes it ascend"

    def _post(self, key: str, value: object) -> None:
        before = self.values.get("PHASE")
        self.values[key], self.posted_at[key] = value, self.time
        if key == "ANCHOR_RELEASE" and self.done.release is None:
            self.sinking = self.time
            self.done.release = {
                "depth": self.depth,
                "since_fix": self.time - self.fix_at,
                "fix_off": math.dist(self.fix, self.goal),
                "off": math.dist(self.true, self.goal),
            }
        if key == "PHASE" and value != before:
            self.done.phases.append(str(value))
            if str(value).endswith("_leg"):
                self.error, self.way = self.voyage.leg_error(), 0.0
            elif str(value).endswith("_fix") and str(before).endswith("_surfacing"):
                self.done.legs.append(self.way)
            stage, kind = str(before).rsplit("_", 1)
            if kind == "decide" and not str(value).startswith(stage):
                self.done.arrived.append(tuple(self.true))

    def _move(self) -> None:
        """A step of the vehicle, its receiver and its anchor."""
        step = STEPS.get(str(self.values["PHASE"]).rpartition("_")[2], STEP)
        self.time += step
        if self.sinking is not None:
            self._moored(step)
        elif self.depth < self.wanted_depth:
            self.depth = min(self.depth + 0.3 * self.speed * step, self.wanted_depth)
        else:
            rate = self.climb * self.speed if self.speed else 0.1
            self.depth = max(self.depth - rate * step, self.wanted_depth)
        through = self.speed * math.sin(self.heading), self.speed * math.cos(self.heading)
        self.way += self.speed * step
        made = self.voyage.made(through, self.error, self.depth) if self.sinking is None else (0.0, 0.0)
        for axis in (0, 1):
            self.nav[axis] += through[axis] * step
            self.true[axis] += made[axis] * step
        self._receive()
        if self.power:
            self._post("ENERGY_USED", self.power * self.time / 3600.0)
        if self.time - self.logged >= LOG_STEP or self.depth <= 0.3:
            self.logged = self.time
            self.done.states.append((self.time, *self.nav, self.depth, self.heading, self.speed))

    def _receive(self) -> None:
        """Take one fix of each surfacing, or every one from then on, and give it to the navigation."""
        if self.depth > 0.3:
            self.surfaced_at, self.got_fix = None, False
            return
        self.surfaced_at = self.time if self.surfaced_at is None else self.surfaced_at
        again = self.got_fix and self.fix_every is not None and self.time - self.fix_at >= self.fix_every
        if again or (not self.got_fix and self.time - self.surfaced_at >= self.voyage.fix_time):
            self.got_fix, self.fixes = True, self.fixes + 1
            self.fix, self.fix_at = self.voyage.fix(self.true), self.time
            self.nav = list(self.fix)
            self.done.fixes.append((self.time, *self.fix))
            self._post("GPS_UPDATE_RECEIVED", f"Timestamp={self.time:.2f}")

    def _moored(self, step: float) -> None:
        if "GALVANIC_RELEASE" in self.values and self.time - self.posted_at["GALVANIC_RELEASE"] >= self.galvanic:
            self.depth = max(self.depth - 0.5 * step, 0.0)
            self.sinking = None if self.depth == 0.0 else self.sinking
        else:
            self.depth = min(self.depth + 0.8 * step, self.bottom)
