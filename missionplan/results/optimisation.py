"""Result of `optimise`: the choice, its check on fresh numbers, the front, what binds, or what the obstacle is."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

import pandas as pd

from missionplan.montecarlo.statistics import Probability
from missionplan.results import Provenance, Result, to_csv, to_yaml
from missionplan.results.decision import Axis, MemberOutcome
from missionplan.results.entries import Entry, Record
from missionplan.results.simulation import Outcome, PhaseOutcome, RequirementOutcome

_SURELY = 3.0
"""Standard errors by which a choice misses a requirement for certain."""


@dataclass(frozen=True)
class Tried(Record):
    """A choice that was tried."""

    values: Annotated[Mapping[str, str], Entry("by what is chosen")]
    success: Annotated[Probability, Entry("of the whole mission")]
    energy: Annotated[float, Entry("mean", "W h")]
    duration: Annotated[float, Entry("mean", "s")]
    slack: Annotated[Mapping[str, float], Entry("by requirement: probability reached less that required")]
    feasible: Annotated[bool, Entry("whether its trials meet all requirements")]
    on_front: Annotated[bool, Entry("whether no other choice succeeds as often with no more of both")]
    trials: Annotated[int, Entry("of the choice")]

    def row(self) -> dict[str, object]:
        """Return the row of the table: a column for each key chosen, and for each requirement."""
        entries = super().row()
        values, slack, trials = entries.pop("values"), entries.pop("slack"), entries.pop("trials")
        return {**values, **entries, **{f"slack {name}": value for name, value in slack.items()}, "trials": trials}


@dataclass(frozen=True)
class Relaxation(Record):
    """What relaxing one requirement would buy."""

    quantity: Annotated[str, Entry("that is required")]
    change: Annotated[str, Entry("how it is relaxed, in words")]
    saved: Annotated[
        float,
        Entry("cost of the best choice less that with the requirement relaxed, on the same random numbers [W h or s]"),
    ]
    error: Annotated[float, Entry("standard error")]
    values: Annotated[Mapping[str, str], Entry("the choice then")]


@dataclass(frozen=True)
class RuledOut(Record):
    """A requirement that alone rules out the least costly choice tried."""

    quantity: Annotated[str, Entry("that is required")]
    saves: Annotated[float, Entry("what that choice would save [W h or s]")]
    values: Annotated[Mapping[str, str], Entry("that choice")]


@dataclass(frozen=True)
class Obstacle(Record):
    """A requirement that no choice meets while it meets the others, and how near one comes to it."""

    quantity: Annotated[str, Entry("that is required")]
    required: Annotated[float, Entry("probability required")]
    reached: Annotated[
        Probability,
        Entry(
            "of the choice that comes nearest to it among those that meet all others; where there are none, of the "
            "choice that comes nearest to meeting all"
        ),
    ]
    column: Annotated[str, Entry("of the trials, such as ``total.energy_wh``")]
    limit: Annotated[float, Entry("the bound, in the column's unit; null for an event")]
    would_do: Annotated[
        float,
        Entry(
            "a bound with which this choice would meet the requirement, on fresh trials too as far as its own can "
            "tell; null for an event, and where too few trials have the quantity"
        ),
    ]
    alone: Annotated[bool, Entry("whether a choice would do without this requirement")]


@dataclass(frozen=True)
class Optimised(Result):
    """Choices that meet all requirements at the least cost."""

    report: ClassVar[str] = "missionplan.report.optimisation"

    provenance: Provenance
    aim: Annotated[Literal["energy", "duration"], Entry("what is least")]
    axes: tuple[Axis, ...]
    """What could be chosen."""
    chosen: Annotated[Mapping[str, str], Entry("the choice; of an infeasible problem the one that comes nearest")]
    feasible: Annotated[
        bool, Entry("whether it meets all requirements, on the mission's random numbers and on fresh ones")
    ]
    mission: Mapping[str, object]
    """The mission with the choice."""
    checked: Outcome | None
    """The choice simulated with the mission's seed; None where there is no choice to check."""
    fresh: Annotated[
        Outcome | None,
        Entry(
            "the choice simulated with a fresh seed; null where there is none to check",
            parts=("seed", "total", "requirements"),
        ),
    ]
    tried: tuple[Tried, ...]
    relaxations: Annotated[tuple[Relaxation, ...], Entry("what relaxing each requirement would buy", key="relaxing")]
    obstacles: Annotated[tuple[Obstacle, ...], Entry("what no choice meets, of an infeasible problem")]
    combinations: Annotated[int, Entry("of all values")]
    search_trials: Annotated[int, Entry("that the search took", key="trials_of.search")]
    check_trials: Annotated[int, Entry("that its checks took", key="trials_of.checks")]
    relaxation_trials: Annotated[int, Entry("that the relaxed problems took", key="trials_of.relaxations")]

    @property
    def judged(self) -> Outcome | None:
        """The choice on fresh draws."""
        return self.fresh

    @property
    def recommended_values(self) -> Mapping[str, object]:
        """The choice, where it meets all requirements: each key of those that take the same value."""
        keys = ((key, axis.name) for axis in self.axes for key in axis.keys)
        return {key: self.chosen[name] for key, name in keys} if self.feasible else {}

    @property
    def key(self) -> str:
        """Key of the mean that is least."""
        return "energy_wh" if self.aim == "energy" else "duration_s"

    @property
    def members(self) -> Annotated[tuple[MemberOutcome, ...], Entry(optional=True)]:
        """How often the choice succeeds in each member of the current's ensemble; empty without one."""
        return self.checked.sailed if self.checked is not None else ()

    @property
    def ruled_out(self) -> Annotated[RuledOut | None, Entry()]:
        """The requirement that alone rules out the least costly choice tried.

        None where every choice tried that costs less misses several requirements, or one by no more than chance.
        """
        chosen = next((choice for choice in self.tried if choice.values == self.chosen), None)
        if chosen is None or self.checked is None:
            return None
        least, ruled_out = self.cost_of(chosen), None
        for choice in self.tried:
            missed = [name for name, slack in choice.slack.items() if slack < 0.0]
            if len(missed) != 1 or self.cost_of(choice) >= least:
                continue
            quantity, _, place = missed[0].rpartition(" ")
            required = self.checked.requirements[int(place) - 1].required
            if choice.slack[missed[0]] < -_SURELY * math.sqrt(required * (1.0 - required) / choice.trials):
                least, ruled_out = (
                    self.cost_of(choice),
                    RuledOut(quantity, self.cost_of(chosen) - self.cost_of(choice), choice.values),
                )
        return ruled_out

    def cost_of(self, choice: Tried) -> float:
        """Return the mean of what is to be least [W h or s]."""
        return choice.energy if self.aim == "energy" else choice.duration

    @property
    def total(self) -> Annotated[PhaseOutcome | None, Entry(parts=("quantities", "events"))]:
        """The whole mission with the choice."""
        return None if self.checked is None else self.checked.total

    @property
    def requirements(self) -> Annotated[tuple[RequirementOutcome, ...], Entry()]:
        """Requirements with the choice."""
        return () if self.checked is None else self.checked.requirements

    @property
    def front(self) -> Annotated[list[dict[str, object]], Entry()]:
        """Choices that no other beats, as rows of the table."""
        return [choice.row() for choice in self.tried if choice.on_front]

    def to_frame(self) -> pd.DataFrame:
        """One row per choice tried."""
        return pd.DataFrame([choice.row() for choice in self.tried])

    def files(self) -> dict[str, str | bytes]:
        """Return `mission-optimised.yaml`, where there is one, `front.csv` and `tried.csv`."""
        frame = self.to_frame()
        front = frame[frame["on_front"]] if len(frame) else frame
        written: dict[str, str | bytes] = {"front.csv": to_csv(front), "tried.csv": to_csv(frame)}
        return written | ({"mission-optimised.yaml": to_yaml(self.mission)} if self.feasible else {})
