"""The plan as a state machine: what the vehicle does in each state, and which guards take it to the next one.

`simulate` runs these states and exporters translate them guard by guard. Arrival means one thing: the vehicle steers
for the point until its dead reckoning is there, surfaces, and has arrived where its *fix* lies within the radius.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Literal

from missionplan.results.entries import Entry, Record
from missionplan.results.plan import SURFACE_DEPTH, Plan, PlannedMooring, PlannedTransit

StateKind = Literal["leg", "surfacing", "fix", "decide", "release", "descend", "hold", "ascend", "done", "abort"]
GuardKind = Literal[
    "reckoned-within",
    "way-made",
    "at-surface",
    "fix-received",
    "fix-within",
    "fix-beyond",
    "since-fix",
    "at-depth",
    "in-state",
    "in-phase",
    "energy-used",
]

GUARDS: dict[GuardKind, tuple[str, Literal["m", "s", "Wh"] | None]] = {
    "reckoned-within": ("dead reckoning within {} of the point", "m"),
    "way-made": ("{} made through the water since the last fix", "m"),
    "at-surface": ("at the surface, above {}", "m"),
    "fix-received": ("a fix since surfacing", None),
    "fix-within": ("the fix within {} of the goal", "m"),
    "fix-beyond": ("the fix farther than {} from the goal", "m"),
    "since-fix": ("{} since the last fix", "s"),
    "at-depth": ("deeper than {}", "m"),
    "in-state": ("{} in this state", "s"),
    "in-phase": ("{} since the phase began", "s"),
    "energy-used": ("more than {} used", "Wh"),
}
"""What each guard asks, in words, and the unit of its value."""
ACTIONS = {
    "leg": "steer for the point at run depth and speed",
    "surfacing": "steer on for the point, to the surface",
    "fix": "stopped at the surface, wait for a fix",
    "decide": "compare the fix with the goal",
    "release": "stopped at the surface, above the place",
    "descend": "the anchor is released and takes the vehicle down",
    "hold": "moored",
    "ascend": "the galvanic release is triggered; the vehicle rises when it has parted",
    "done": "stopped at the surface",
    "abort": "stopped at the surface, calling for recovery",
}
"""What the vehicle does in a state of each kind."""


def amount_in_si(value: float, unit: str) -> str:
    """Write a value with its unit, long times in minutes, hours and days."""
    if unit == "s":
        scales = {"days": 86400.0, "h": 3600.0, "min": 60.0}
        unit, scale = next(((name, scale) for name, scale in scales.items() if value >= 2.0 * scale), (unit, 1.0))
        value /= scale
    number = f"{value:.4g}" if value < 1000.0 else f"{value:.0f}"
    return f"{number}\u00a0" + ("W\u202fh" if unit == "Wh" else unit)


@dataclass(frozen=True)
class Guard(Record):
    """A condition; `value` in SI, or Wh, nan for a guard without one."""

    kind: Annotated[GuardKind, Entry("what it asks")]
    value: Annotated[float, Entry("with which it compares; null for a guard without one", digits=3)] = math.nan

    @property
    def unit(self) -> Annotated[Literal["m", "s", "Wh"] | None, Entry()]:
        """Unit of the value."""
        return GUARDS[self.kind][1]

    @property
    def words(self) -> str:
        """In words."""
        text, unit = GUARDS[self.kind]
        if self.kind == "reckoned-within" and not self.value:
            return "dead reckoning at the point"
        return text.format(amount_in_si(self.value, unit)) if unit else text


@dataclass(frozen=True)
class Transition(Record):
    """To another state once all guards hold; the first transition that may be taken is."""

    to: Annotated[str, Entry("name of a state")]
    guards: Annotated[tuple[Guard, ...], Entry("all of which are to hold")]


@dataclass(frozen=True)
class State(Record):
    """A state."""

    name: Annotated[str, Entry("unlike that of any other state: number of the phase and kind")]
    kind: Annotated[StateKind, Entry("what is done in it")]
    phase: Annotated[str | None, Entry("name of the phase; null for the ends")] = None
    transitions: Annotated[
        tuple[Transition, ...], Entry("in the order in which they are tried, each taken once all its guards hold")
    ] = ()

    @property
    def does(self) -> Annotated[str, Entry(after="phase")]:
        """What the vehicle does in it, in words."""
        return ACTIONS[self.kind]


def states_of(plan: Plan) -> tuple[State, ...]:
    """Return the states of a plan, the first one to begin with."""
    parts = plan.parts
    firsts = [f"{number}-{_first(phase)}" for number, phase in parts]
    states: list[State] = []
    for (number, phase), after in zip(parts, [*firsts[1:], "done"], strict=True):
        if isinstance(phase, PlannedMooring):
            states += _mooring(phase, number, after)
        else:
            states += _transit(phase, number, after, plan.capacity)
    return (*states, State("done", "done"), State("abort", "abort"))


def _first(phase: PlannedTransit | PlannedMooring) -> StateKind:
    return "release" if isinstance(phase, PlannedMooring) else "leg"


def _transit(transit: PlannedTransit, number: str, after: str, capacity: float) -> Iterator[State]:
    def state(kind: StateKind, *transitions: Transition) -> State:
        return State(f"{number}-{kind}", kind, transit.name, (*transitions, *aborts))

    margin, rule = transit.ascent_margin, transit.surfacing
    aborts = [Transition("abort", (Guard("in-phase", transit.abort_time),))]
    if math.isfinite(capacity):
        aborts.append(Transition("abort", (Guard("energy-used", capacity),)))
    up = f"{number}-surfacing"
    yield state(
        "leg",
        Transition(up, (Guard("reckoned-within", margin),)),
        Transition(up, (Guard("way-made", rule.interval - margin),)),
    )
    yield state(
        "surfacing",
        Transition(f"{number}-fix", (Guard("at-surface", SURFACE_DEPTH), Guard("reckoned-within", 0.0))),
        Transition(f"{number}-fix", (Guard("at-surface", SURFACE_DEPTH), Guard("way-made", rule.interval))),
    )
    yield state(
        "fix",
        Transition(f"{number}-decide", (Guard("fix-received"),)),
        Transition("abort", (Guard("in-state", rule.fix_wait),)),
    )
    yield state(
        "decide",
        Transition(after, (Guard("fix-within", transit.arrival_radius),)),
        Transition(f"{number}-leg", (Guard("fix-beyond", transit.arrival_radius),)),
    )


def _mooring(mooring: PlannedMooring, number: str, after: str) -> Iterator[State]:
    def state(kind: StateKind, *transitions: Transition) -> State:
        return State(f"{number}-{kind}", kind, mooring.name, transitions)

    down, ascent = f"{number}-hold", f"{number}-ascend"
    yield state("release", Transition(f"{number}-descend", (Guard("since-fix", mooring.release_time),)))
    sunk = [Transition(down, (Guard("in-state", mooring.longest_sinking),))]
    if math.isfinite(mooring.touchdown_depth):
        sunk.insert(0, Transition(down, (Guard("at-depth", mooring.touchdown_depth),)))
    yield state("descend", *sunk)
    yield state("hold", Transition(ascent, (Guard("in-state", mooring.hold),)))
    yield state(
        "ascend",
        Transition(f"{number}-fix", (Guard("in-state", mooring.galvanic_release), Guard("at-surface", SURFACE_DEPTH))),
        Transition("abort", (Guard("in-state", mooring.longest_release),)),
    )
    yield state(
        "fix", Transition(after, (Guard("fix-received"),)), Transition("abort", (Guard("in-state", mooring.fix_wait),))
    )
