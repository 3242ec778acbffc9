"""What a result tells the crew to do, and parts that several results share.

Assumptions, explanations, members, axes; and the ranges in which the models were checked, with what shows it.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Annotated, Literal

from missionplan.arrays import Array
from missionplan.montecarlo.statistics import Probability, Statistic
from missionplan.results.entries import Entry, Record

FAILURE_LOSS = 10.0
"""Missions that work, of whose mean cost a mission that fails costs as much besides."""


@dataclass(frozen=True)
class Assumption(Record):
    """Something that a mission leaves out or states as exact, with the answer when it is off by its usual size."""

    what: Annotated[str, Entry("what is taken for granted")]
    otherwise: Annotated[str, Entry("what was put in its place")]
    worth: Annotated[float, Entry("by how much P(success) then changes")]
    success: Annotated[float, Entry("P(success) then")]
    missed: Annotated[tuple[str, ...], Entry("requirements that are met as it stands, and then no longer")] = ()
    is_required: Annotated[bool, Entry("whether the mission requires P(success)", key="success_required")] = False
    spoils: Annotated[str, Entry("phase in which most of the trials are lost that then fail; empty where none")] = ""
    first: Annotated[str, Entry("what settles it, as an order")] = ""
    missed_of: tuple[str, ...] = ()
    """Phases of those requirements, ``total`` of the whole mission."""

    @property
    def turns(self) -> Annotated[bool, Entry()]:
        """Whether it could turn the answer: a requirement, or a mission that works more often than not.

        Where no requirement says how often the mission has to succeed, also failures that cost as much as the mission.
        """
        costs = not self.is_required and -self.worth * FAILURE_LOSS >= 1.0
        return bool(self.missed) or costs or self.success < 0.5 <= self.success - self.worth

    @property
    def mends(self) -> bool:
        """Whether a mission that fails more often than not would then succeed more often."""
        return self.success - self.worth < 0.5 <= self.success

    @property
    def turned(self) -> set[str]:
        """Phases whose choice it could turn; that of which the mission then fails for the mission as a whole."""
        whole = self.spoils or "total"
        return {whole if phase == "total" else phase for phase in self.missed_of or ("total",)} if self.turns else set()


_STEP = re.compile(r"([^.\[\]]+)|\[(\d+)\]")


@dataclass(frozen=True)
class Change(Record):
    """A key of the mission that is to have another value."""

    key: Annotated[str, Entry("key path, as ``--vary`` and ``Mission.with_`` take it")]
    was: Annotated[object, Entry("value in the mission file; null where it has none")]
    now: Annotated[object, Entry("value as a mission file has it")]


@dataclass(frozen=True)
class Decision(Record):
    """What to do, how sure that is, on which assumptions, and what changes in the mission."""

    do: Annotated[str, Entry("what to do, as the headline says it")]
    sure: Annotated[Mapping[str, object] | None, Entry("how sure: a probability with its interval; null where none")]
    assumes: Annotated[tuple[Assumption, ...], Entry("what is taken for granted, each with its worth")]
    changes: Annotated[tuple[Change, ...], Entry("keys of the mission, was and now")]
    not_in_this_probability: Annotated[tuple[str, ...], Entry("what a mission may fail of that this does not hold")]


def written(data: Mapping[str, object], key: str) -> object:
    """Return what a mission's data has at a key path that begins with a section, or with what stands for a phase.

    That is its name, or its place: ``phases[1].anchor_wet_weight``. None where there is nothing.
    """
    first, *rest = (name or int(number) for name, number in _STEP.findall(key))
    value: object = data.get(str(first))
    if first == "phases":
        value = _phases(data)
    elif value is None:
        value = next((phase for phase in _phases(data) if phase.get("name") == first), None)
    for step in rest:
        if isinstance(value, Mapping):
            value = value.get(step)
        elif isinstance(value, Sequence) and not isinstance(value, str) and isinstance(step, int) and step < len(value):
            value = value[step]
        else:
            return None
    return value


def _phases(data: Mapping[str, object]) -> list[Mapping[str, object]]:
    """Return each phase with its name, its kind where it has none."""
    entries = data.get("phases")
    phases: list[Mapping[str, object]] = []
    for entry in entries if isinstance(entries, Sequence) else ():
        for kind, phase in entry.items() if isinstance(entry, Mapping) else ():
            phases.append({"name": kind, **phase} if isinstance(phase, Mapping) else {"name": kind})
    return phases


def changes_of(data: Mapping[str, object], values: Mapping[str, object]) -> tuple[Change, ...]:
    """Return the keys whose values differ from the mission's."""
    pairs = ((key, written(data, key), now) for key, now in values.items())
    return tuple(Change(key, was, now) for key, was, now in pairs if was != now)


Causes = tuple[str, ...]


@dataclass(frozen=True)
class ExplainedOutcome(Record):
    """The trials of a simulation in which one explanation holds."""

    place: Annotated[str, Entry("key path of the `one-of`, or `posterior`")]
    number: Annotated[int, Entry("of the explanation there; how many there are, for none")]
    causes: Annotated[Causes, Entry("its effects; empty for none")]
    probability: Annotated[float, Entry("of the explanation, as the mission gives it")]
    success: Annotated[Probability, Entry("of the whole mission in these trials")]
    duration: Annotated[Statistic, Entry("of the whole mission", "s")]
    energy: Annotated[Statistic, Entry("of the whole mission", "W h")]
    trials: Annotated[int, Entry("in which it holds")]


def differ(shares: Sequence[Probability]) -> bool:
    """Whether one is likelier than another, beyond chance: 95 % intervals apart."""
    return bool(shares) and max(share.low for share in shares) > min(share.high for share in shares)


def label(causes: Iterable[str]) -> str:
    """Name an explanation: its effects in words."""
    words = [cause.replace("-", " ") for cause in causes]
    return " and ".join(words) if words else "none of them"


@dataclass(frozen=True)
class MemberOutcome(Record):
    """What a plan does in one member."""

    name: Annotated[str, Entry("name of the member", key="member")]
    probability: Annotated[float, Entry("of the member")]
    good: Annotated[Probability, Entry("success, arrival or a dive within the radius, where the member comes true")]


@dataclass(frozen=True)
class PlaceContact(Record):
    """Trials that a phase loses to one cause."""

    phase: Annotated[str, Entry("as the mission's file has it")]
    cause: Annotated[str, Entry("``aground``, ``on-land``, ``keep-out`` or ``left the grid of depths``")]
    lost: Annotated[Probability, Entry("of all trials")]
    legs: Annotated[Mapping[str, int], Entry("trials by the leg on which it happened, from 1; 0 at a mooring")]
    east: Annotated[float, Entry("mean of the places, east of the origin", "m")]
    north: Annotated[float, Entry("mean of the places, north of the origin", "m")]


@dataclass(frozen=True)
class SeaChart:
    """Depths, land and zones kept out of about the tracks, for maps."""

    east: Array
    north: Array
    """[m], shape (columns,) and (rows,)."""
    depth: Array | None
    """Of the water at the mission's start, nan where unknown; None without a grid of depths; shape (rows, columns) [m].
    """
    shapes: tuple[tuple[str, tuple[Array, ...]], ...] = ()
    """``land`` or ``keep-out``, with the outline of each polygon and its holes, east and north, shape (k, 2)) [m]."""


@dataclass(frozen=True)
class Coverage(Record):
    """Something that a mission may fail of, and whether its probability of success holds it."""

    what: Annotated[str, Entry("``ground``, ``coast``, ``wind``, ``waves``, ``traffic``, ``equipment``, …")]
    held: Annotated[bool, Entry("whether the probability holds it")]
    why: Annotated[str, Entry("what is held of it, or why it matters here")]


Aim = Literal["success", "energy", "duration"]


@dataclass(frozen=True)
class Axis(Record):
    """What is varied along one axis."""

    keys: Annotated[tuple[str, ...], Entry("key paths that take the same value")]
    values: tuple[object, ...]
    """As the mission file takes them."""
    labels: tuple[str, ...]
    """As people read them, without the unit."""
    numbers: tuple[float, ...] | None = None
    """In `unit`, or for `start` seconds since 1970; None where the values are no numbers."""
    unit: Annotated[str, Entry("as given; ``UTC`` for `start`; empty for bare numbers and for what has no number")] = ""

    @property
    def exact_values(self) -> Annotated[list[str], Entry(key="values")]:
        """Values as a script reads them."""
        return [self.exact(index) for index in range(len(self.values))]

    @property
    def name(self) -> str:
        """The keys in one word."""
        return "+".join(self.keys)

    @property
    def is_time(self) -> bool:
        """Whether the values are moments."""
        return self.keys == ("start",)

    def shown(self, index: int) -> str:
        """Return a value with its unit."""
        return f"{self.labels[index]} {self.unit}".strip()

    def exact(self, index: int) -> str:
        """Return a value as a script reads it: moments by ISO 8601."""
        if self.is_time and self.numbers is not None:
            return datetime.fromtimestamp(self.numbers[index], UTC).isoformat(timespec="seconds")
        return self.shown(index)


@dataclass(frozen=True)
class Range(Record):
    """A range of a quantity in which a model was compared with something that shares no code with it."""

    quantity: Annotated[str, Entry("what it is")]
    low: Annotated[float, Entry("lower end of what was checked, in `unit`")]
    high: Annotated[float, Entry("upper end of what was checked, in `unit`")]
    unit: Annotated[str, Entry("of these numbers; empty for a ratio")]
    rows: Annotated[tuple[str, ...], Entry("IDs of the rows of docs/validation that checked it")]


_MOORED = ("peer.scipy-moored-line", "peer.moordyn-moored-line")
RANGES: Mapping[str, Range] = {
    "speed_error": Range(
        "velocity error over speed", 0.004, 0.6, "", ("closed.transit-loop", "paper.briggs-fig-8", "sea.modena")
    ),
    "leg": Range("longest leg over arrival radius", 0.6, 150.0, "", ("closed.transit-loop", "paper.briggs-fig-8")),
    "transit": Range("length of a transit", 800.0, 20_000.0, "m", ("closed.transit-loop", "closed.adaptive-legs")),
    "depth": Range("depth of a mooring", 8.0, 60.0, "m", ("peer.scipy-tied-drift", "paper.briggs-table-1")),
    "line": Range("length of the line", 2.0, 12.0, "m", ("peer.scipy-tied-drift", "peer.scipy-moored-line")),
    "line_diameter": Range("diameter of the line", 0.0, 0.008, "m", _MOORED),
    "dive_current": Range("current during a dive", 0.0, 1.2, "m/s", ("peer.scipy-tied-drift",)),
    "hold_current": Range("current at the seafloor", 0.0, 0.5, "m/s", _MOORED),
}
"""Of each quantity, the range that all its rows together cover."""
_TRANSIT = ("closed.one-leg", "closed.transit-loop", "paper.briggs-fig-8")
_MOORING = ("closed.dive-stages", "peer.scipy-tied-drift", *_MOORED)
_MISSION = (*_TRANSIT, *_MOORING, "closed.sensitivity", "paper.briggs-chesapeake")
_RARE = ("closed.rare-ways", "calibration.rare-mission", "peer.openturns-problems")
ROWS_OF_COMMAND: Mapping[str, tuple[str, ...]] = {
    "compare": _MISSION,
    "diagnose": (
        "calibration.legs", "calibration.hidden-legs", "calibration.hidden-dives", "calibration.tank",
        "calibration.next-mission", "sea.modena", "sea.saanich",
    ),
    "explore": _MISSION,
    "history": ("calibration.fleets",),
    "identify": ("paper.avila-drag", "paper.avila-added-mass", "calibration.sizes-tank"),
    "import": ("sea.raw-logs",),
    "optimise": (*_MISSION, "closed.optimise"),
    "plan-legs": (*_TRANSIT, "closed.adaptive-legs", "closed.drift-filter"),
    "score": ("calibration.legs", "sea.modena", "sea.saanich"),
    "simulate": _MISSION,
    "simulate --rare": (*_MISSION, *_RARE),
    "size-anchor": (*_MOORING, "paper.briggs-anchor", "paper.briggs-terminal-velocity"),
    "sweep-dmax": _TRANSIT,
    "sweep-transition": ("paper.palmer-transition", "paper.palmer-least-energy", "paper.palmer-tunnel"),
    "tide": ("calibration.tide-forecast", "peer.utide-forecast"),
}  # fmt: skip
"""Rows on which the answer of each command rests."""


@dataclass(frozen=True)
class CheckedRange(Range):
    """A quantity of a mission beside the range in which the model was checked."""

    least: Annotated[float, Entry("in this mission, at the means, in `unit`")]
    greatest: Annotated[float, Entry("in this mission, at the means, in `unit`")]

    @property
    def is_inside(self) -> Annotated[bool, Entry(key="inside")]:
        """Whether all of the mission lies in what was checked."""
        return self.low <= self.least and self.greatest <= self.high
