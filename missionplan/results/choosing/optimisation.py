"""Result of `optimise`: the choice, its check on fresh numbers, the front, what binds, or what the obstacle is."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Literal

import pandas as pd

from missionplan.montecarlo.statistics import Probability
from missionplan.results.base import Provenance, Result, to_csv, to_yaml
from missionplan.results.choosing.axis import Axis
from missionplan.results.members import MemberOutcome
from missionplan.results.simulation import Outcome

_SURELY = 3.0
"""Standard errors by which a choice misses a requirement for certain."""


@dataclass(frozen=True)
class Tried:
    """A choice that was tried.

    Attributes
    ----------
    values : mapping of str to str
        By what is chosen.
    success : Probability
    energy, duration : float
        Means [W h, s].
    slack : mapping of str to float
        By requirement: probability reached less that required.
    feasible, on_front : bool
        Whether its trials meet all requirements; whether no other choice succeeds as often with no more of both.
    trials : int
    """

    values: Mapping[str, str]
    success: Probability
    energy: float
    duration: float
    slack: Mapping[str, float]
    feasible: bool
    on_front: bool
    trials: int


@dataclass(frozen=True)
class Relaxation:
    """What relaxing one requirement would buy.

    Attributes
    ----------
    quantity : str
    change : str
        How it is relaxed, in words.
    saved : float
        Cost of the best choice less that with the requirement relaxed, on the same random numbers [W h or s].
    error : float
        Standard error.
    values : mapping of str to str
        The choice then.
    """

    quantity: str
    change: str
    saved: float
    error: float
    values: Mapping[str, str]


@dataclass(frozen=True)
class Obstacle:
    """A requirement that no choice meets while it meets the others, and how near one comes to it.

    Attributes
    ----------
    quantity : str
    required : float
    reached : Probability
        Of the choice that comes nearest to it among those that meet all others; where there are none, of the choice
        that comes nearest to meeting all.
    column : str
        Of the trials, such as ``total.energy_wh``.
    limit, would_do : float
        The bound, and one with which this choice would meet the requirement, on fresh trials too as far as its own
        can tell, in the column's unit; nan for an event, and where too few trials have the quantity.
    alone : bool
        Whether a choice would do without this requirement.
    """

    quantity: str
    required: float
    reached: Probability
    column: str
    limit: float
    would_do: float
    alone: bool

    def summary(self) -> dict[str, object]:
        """Return the entry of `summary.json`."""
        return vars(self) | {"reached": self.reached.summary()}


@dataclass(frozen=True)
class Optimised(Result):
    """Choices that meet all requirements at the least cost.

    Attributes
    ----------
    provenance : Provenance
    aim : 'energy' or 'duration'
    axes : tuple of Axis
        What could be chosen.
    chosen : mapping of str to str
        The choice; of an infeasible problem the one that comes nearest.
    feasible : bool
        Whether it meets all requirements, on the mission's random numbers and on fresh ones.
    mission : mapping
        The mission with the choice.
    checked, fresh : Outcome or None
        The choice simulated with the mission's seed, and with a fresh one; None where there is no choice to check.
    tried : tuple of Tried
    relaxations : tuple of Relaxation
    obstacles : tuple of Obstacle
    combinations : int
        Of all values.
    search_trials, check_trials, relaxation_trials : int
        Trials that the search took, its checks, and the relaxed problems.
    """

    report: ClassVar[str] = "missionplan.report.optimisation"

    provenance: Provenance
    aim: Literal["energy", "duration"]
    axes: tuple[Axis, ...]
    chosen: Mapping[str, str]
    feasible: bool
    mission: Mapping[str, object]
    checked: Outcome | None
    fresh: Outcome | None
    tried: tuple[Tried, ...]
    relaxations: tuple[Relaxation, ...]
    obstacles: tuple[Obstacle, ...]
    combinations: int
    search_trials: int
    check_trials: int
    relaxation_trials: int

    @property
    def key(self) -> str:
        """Key of the mean that is least."""
        return "energy_wh" if self.aim == "energy" else "duration_s"

    @property
    def members(self) -> tuple[MemberOutcome, ...]:
        """How often the choice succeeds in each member of the current's ensemble; empty without one."""
        found = self.checked.members if self.checked is not None else ()
        return tuple(MemberOutcome(each.causes[0], each.probability, each.success) for each in found if each.trials)

    @property
    def ruled_out(self) -> tuple[str, float, Mapping[str, str]] | None:
        """The requirement that alone rules out the least costly choice tried, what that saves, and the choice.

        None where every choice tried that costs less misses several requirements, or one by no more than chance.
        """
        own = next((each for each in self.tried if each.values == self.chosen), None)
        if own is None or self.checked is None:
            return None
        least, found = self._cost(own), None
        for each in self.tried:
            missed = [name for name, slack in each.slack.items() if slack < 0.0]
            if len(missed) != 1 or self._cost(each) >= least:
                continue
            quantity, _, place = missed[0].rpartition(" ")
            required = self.checked.requirements[int(place) - 1].required
            if each.slack[missed[0]] < -_SURELY * math.sqrt(required * (1.0 - required) / each.trials):
                least, found = self._cost(each), (quantity, self._cost(own) - self._cost(each), each.values)
        return found

    def _cost(self, each: Tried) -> float:
        return each.energy if self.aim == "energy" else each.duration

    def summary(self) -> dict[str, object]:
        """Return the contents of `summary.json`."""
        ruled_out = self.ruled_out
        return {
            **self.provenance.summary(),
            "aim": self.aim,
            "feasible": self.feasible,
            "chosen": dict(self.chosen),
            "combinations": self.combinations,
            "trials_of": {
                "search": self.search_trials,
                "checks": self.check_trials,
                "relaxations": self.relaxation_trials,
            },
            "total": None if self.checked is None else self.checked.total.quantities_and_events(),
            "requirements": [] if self.checked is None else [item.summary() for item in self.checked.requirements],
            "fresh": None
            if self.fresh is None
            else {
                "seed": self.fresh.provenance.seed,
                "total": self.fresh.total.quantities_and_events(),
                "requirements": [item.summary() for item in self.fresh.requirements],
            },
            **({"members": [each.summary() for each in self.members]} if self.members else {}),
            "front": [self._row(each) for each in self.tried if each.on_front],
            "relaxing": [vars(each) | {"values": dict(each.values)} for each in self.relaxations],
            "ruled_out": ruled_out and {"quantity": ruled_out[0], "saves": ruled_out[1], "values": dict(ruled_out[2])},
            "obstacles": [each.summary() for each in self.obstacles],
        }

    def _row(self, each: Tried) -> dict[str, object]:
        row: dict[str, object] = {**each.values, "success": each.success.value, "energy_wh": each.energy}
        row |= {"duration_s": each.duration, "feasible": each.feasible, "on_front": each.on_front}
        return row | {f"slack {name}": value for name, value in each.slack.items()} | {"trials": each.trials}

    def to_frame(self) -> pd.DataFrame:
        """One row per choice tried."""
        return pd.DataFrame([self._row(each) for each in self.tried])

    def files(self) -> dict[str, str | bytes]:
        """Return `mission-optimised.yaml`, where there is one, `front.csv` and `tried.csv`."""
        frame = self.to_frame()
        front = frame[frame["on_front"]] if len(frame) else frame
        written: dict[str, str | bytes] = {"front.csv": to_csv(front), "tried.csv": to_csv(frame)}
        return written | ({"mission-optimised.yaml": to_yaml(self.mission)} if self.feasible else {})
