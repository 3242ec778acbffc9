"""Result of `history`: what was learned of each parameter, from mission to mission."""

from dataclasses import dataclass
from typing import ClassVar, Literal

import pandas as pd

from missionplan.results.base import Provenance, Result, to_csv, to_json

State = Literal["found", "confirmed", "changed"]
"""Whether a parameter is new to the mission, as the mission knew it, or not so."""


@dataclass(frozen=True)
class Learned:
    """What one diagnosis says of one parameter.

    Attributes
    ----------
    report : str
        Its folder, below that of the history.
    mission, dataset : str
    time : str
        Start of the mission where each report's mission has one, else when the report was made (UTC, ISO 8601).
    effect, name : str
        The parameter.
    value, sd, low, high : float
        With its 90 % interval [unit].
    unit : str
    state : str
    probability : float
        That the explanation holds in which it was found; 1 where the diagnosis left no doubt.
    jump : float or None
        Difference from the diagnosis before, over the standard deviation of the difference; None for the first.
    """

    report: str
    mission: str
    dataset: str
    time: str
    effect: str
    name: str
    value: float
    sd: float
    low: float
    high: float
    unit: str
    state: State
    probability: float = 1.0
    jump: float | None = None

    @property
    def key(self) -> tuple[str, str]:
        """Effect and name of the parameter."""
        return self.effect, self.name

    @property
    def is_change(self) -> bool:
        """Whether the vehicle or the water was no longer as before: the diagnosis says so, or the values do."""
        return self.state == "changed" or (self.jump is not None and abs(self.jump) > JUMP)


JUMP = 3.0
"""Standard deviations by which a value that was found anew differs from the one before, to be called a change."""


@dataclass(frozen=True)
class History(Result):
    """Learned parameters from mission to mission.

    Attributes
    ----------
    provenance : Provenance
    reports : tuple of str
        Diagnoses, in the order of time.
    entries : tuple of Learned
        In the order of time.
    by_start : bool
        Whether times are those of the missions' starts, not those at which the reports were made.
    """

    report: ClassVar[str] = "missionplan.report.history"

    provenance: Provenance
    reports: tuple[str, ...]
    entries: tuple[Learned, ...]
    by_start: bool

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

    def summary(self) -> dict[str, object]:
        """Return the dictionary of ``summary.json``."""
        return {
            **self.provenance.summary(),
            "reports": list(self.reports),
            "ordered_by": "start" if self.by_start else "created",
            "parameters": [
                {
                    "effect": effect,
                    "name": name,
                    "unit": entries[-1].unit,
                    "values": [
                        {
                            "report": each.report,
                            "time": each.time,
                            "value": each.value,
                            "sd": each.sd,
                            "low": each.low,
                            "high": each.high,
                            "state": each.state,
                            "probability": each.probability,
                            "changed": each.is_change,
                        }
                        for each in entries
                    ],
                }
                for (effect, name), entries in self.parameters.items()
            ],
        }

    def to_frame(self) -> pd.DataFrame:
        """One row for what each diagnosis says of each parameter."""
        columns = [
            *("report", "mission", "dataset", "time", "effect", "name", "value", "sd", "low", "high", "unit"),
            *("state", "probability"),
        ]
        rows = [{**{name: getattr(each, name) for name in columns}, "changed": each.is_change} for each in self.entries]
        return pd.DataFrame(rows, columns=[*columns, "changed"])

    def files(self) -> dict[str, str | bytes]:
        """``history.csv`` and ``history.json``."""
        return {"history.csv": to_csv(self.to_frame()), "history.json": to_json(self.summary())}
