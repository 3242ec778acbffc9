"""Result of `history`: what was learned of each parameter, from mission to mission."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

import pandas as pd

from missionplan.results.base import Provenance, Result, to_csv, to_json
from missionplan.results.entries import Entry, Record, stated
from missionplan.results.learned.levels import ParameterLevels

State = Literal["found", "confirmed", "changed"]
"""Whether a parameter is new to the mission, as the mission knew it, or not so."""


@dataclass(frozen=True)
class Learned(Record):
    """What one diagnosis says of one parameter."""

    report: Annotated[str, Entry("its folder, below that of the history")]
    mission: Annotated[str, Entry("the mission's name")]
    dataset: Annotated[str, Entry("the data set's name")]
    time: Annotated[
        str,
        Entry(
            "start of the mission where each report's mission has one, else when the report was made (UTC, ISO 8601)"
        ),
    ]
    effect: Annotated[str, Entry("whose parameter it is")]
    name: Annotated[str, Entry("of the parameter")]
    value: Annotated[float, Entry("of the parameter, in its unit")]
    sd: Annotated[float, Entry("standard deviation")]
    low: Annotated[float, Entry("lower end of the 90 % interval")]
    high: Annotated[float, Entry("upper end of the 90 % interval")]
    unit: Annotated[str, Entry("of the parameter")]
    state: Annotated[State, Entry("whether it is new to the mission, as the mission knew it, or not so")]
    probability: Annotated[
        float, Entry("that the explanation holds in which it was found; 1 where the diagnosis left no doubt")
    ] = 1.0

    @property
    def key(self) -> tuple[str, str]:
        """Effect and name of the parameter."""
        return self.effect, self.name

    @property
    def is_change(self) -> Annotated[bool, Entry(key="changed")]:
        """Whether the vehicle or the water was no longer as before: the diagnosis says so, or the level jumped."""
        return self.state == "changed"


_VALUES = "report", "time", "value", "sd", "low", "high", "state", "probability", "changed"


@dataclass(frozen=True)
class LearnedParameter(Record):
    """What was learned of one parameter, in the order of time."""

    effect: Annotated[str, Entry("whose parameter it is")]
    name: Annotated[str, Entry("of the parameter")]
    values: Annotated[list[Learned], Entry("what each diagnosis says", parts=_VALUES)]

    @property
    def unit(self) -> Annotated[str, Entry()]:
        """Unit of the values."""
        return self.values[-1].unit


@dataclass(frozen=True)
class FailureRate(Record):
    """Rate of a hazard of the vehicle's equipment, with the counts of a fleet in it."""

    per: Annotated[str, Entry("what it counts by")]
    leaves: Annotated[str, Entry("what its failures leave of the vehicle; empty for the default")]
    failures: Annotated[float, Entry("of the fleet that are new to the mission")]
    exposure: Annotated[float, Entry("hours, kilometres or events in which they were")]
    prior: Annotated[
        str,
        Entry("in which form the mission holds the rate; ``fixed`` and ``Weibull`` laws are not updated but replaced"),
    ]
    prior_failures: Annotated[float, Entry("that the mission's rate is worth")]
    prior_exposure: Annotated[float, Entry("likewise")]
    rate: Annotated[float, Entry("mean, per hour, kilometre or event")]
    low: Annotated[float, Entry("lower end of its 90 % interval")]
    high: Annotated[float, Entry("upper end of its 90 % interval")]
    surprise: Annotated[float, Entry("probability of counts as far out, by the mission's rate; 1 where it has none")]
    learned_from: Annotated[tuple[str, ...], Entry("hashes of the rows counted, those before among them")]

    @property
    def unit(self) -> Annotated[str, Entry()]:
        """Unit of the exposure."""
        return {"hour": "h", "km": "km"}.get(self.per, f"{self.per}s")


@dataclass(frozen=True)
class History(Result):
    """Learned parameters from mission to mission, and failure rates of a fleet."""

    report: ClassVar[str] = "missionplan.studies.history.page"

    provenance: Provenance
    reports: Annotated[tuple[str, ...], Entry("diagnoses, in the order of time")]
    entries: tuple[Learned, ...]
    """In the order of time."""
    by_start: bool
    """Whether times are those of the missions' starts, not those at which the reports were made."""
    levels: Annotated[tuple[ParameterLevels, ...], Entry("how parameters of the vehicle go", optional=True)] = ()
    rates: Annotated[tuple[FailureRate, ...], Entry("failure rates, where the folder has counts", optional=True)] = ()
    rates_file: str = ""
    """`reliability.yaml`; empty without counts."""

    @property
    def parameters(self) -> dict[tuple[str, str], list[Learned]]:
        """What was learned of each parameter, in the order of time."""
        found: dict[tuple[str, str], list[Learned]] = {}
        for entry in self.entries:
            found.setdefault(entry.key, []).append(entry)
        return found

    @property
    def changes(self) -> list[Learned]:
        """Where a parameter was no longer as before."""
        return [entry for entry in self.entries if entry.is_change]

    @property
    def ordered_by(self) -> Annotated[str, Entry()]:
        """``start`` of the missions, or when the reports were ``created``."""
        return "start" if self.by_start else "created"

    @property
    def values(self) -> Annotated[list[LearnedParameter], Entry(key="parameters")]:
        """What was learned of each parameter."""
        return [LearnedParameter(*key, entries) for key, entries in self.parameters.items()]

    def to_frame(self) -> pd.DataFrame:
        """One row for what each diagnosis says of each parameter."""
        columns = [entry.key for entry in stated(Learned)]
        return pd.DataFrame([each.row() for each in self.entries], columns=columns)

    def files(self) -> dict[str, str | bytes]:
        """``history.csv``, ``history.json``, and ``reliability.yaml`` where failures were counted."""
        found: dict[str, str | bytes] = {
            "history.csv": to_csv(self.to_frame()),
            "history.json": to_json(self.summary()),
        }
        return found | ({"reliability.yaml": self.rates_file} if self.rates_file else {})
