"""Result of `compare`: what changed between two runs, in the mission and in its results."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Literal

import pandas as pd

from missionplan.results.base import Provenance, Result, to_csv
from missionplan.results.task import parts_of_task, phase_names

MOST_CHANGES = 40
"""Values in which two missions that are alike may differ."""
ChangeVerdict = Literal["changed", "within noise", "same", "not judged", "only first", "only second"]


@dataclass(frozen=True)
class ComparedRun:
    """One of the two runs.

    Attributes
    ----------
    folder, mission, version, created : str
        Report folder as given; the mission's name; version of missionplan; when the report was made, UTC.
    seed, trials : int
    """

    folder: str
    mission: str
    version: str
    created: str
    seed: int
    trials: int


@dataclass(frozen=True)
class ChangedValue:
    """A value of the mission file, or an option of the run, that differs; empty where a run does not have it."""

    path: str
    first: str
    second: str


@dataclass(frozen=True)
class ComparedNumber:
    """A number of the results in both runs.

    Attributes
    ----------
    group, key : str
        Such as ``moor`` and ``offset_m``.
    kind : 'mean', 'probability' or 'number'
        A plain number has no standard error.
    first, second : float or None
        None where a run does not have the number.
    standard_error : float or None
        Of second − first, treating the two runs as independent.
    p_value : float or None
        Probability of a difference at least as large by Monte-Carlo noise alone.
    verdict : str
        ``changed``: beyond noise, at 5 % for all numbers together (Holm's correction), or any difference where there
        is no noise; ``not judged``: a noisy number whose standard error is not known.
    """

    group: str
    key: str
    kind: Literal["mean", "probability", "number"]
    first: float | None
    second: float | None
    standard_error: float | None
    p_value: float | None
    verdict: ChangeVerdict

    @property
    def change(self) -> float | None:
        """Second minus first; None where a run does not have the number."""
        return None if self.first is None or self.second is None else self.second - self.first

    def row(self) -> dict[str, object]:
        """Return the entry of `summary.json`, which is also the row of the table."""
        return {
            "group": self.group,
            "key": self.key,
            "kind": self.kind,
            "first": self.first,
            "second": self.second,
            "change": self.change,
            "standard_error": self.standard_error,
            "p_value": self.p_value,
            "verdict": self.verdict,
        }


@dataclass(frozen=True)
class Comparison(Result):
    """Two runs of one command, side by side.

    Attributes
    ----------
    provenance : Provenance
        Its `data` holds both missions.
    compared : str
        The command that made both reports.
    runs : (ComparedRun, ComparedRun)
    mission_changes, option_changes : tuple of ChangedValue
        Values by key path; and seeds, trials, versions and options.
    differences : tuple of ComparedNumber
        In the order of the first summary.
    requirement_changes : tuple of ChangedValue
        Requirements that one run meets and the other does not, or does not have.
    """

    report: ClassVar[str] = "missionplan.report.compared.two_runs"

    provenance: Provenance
    compared: str
    runs: tuple[ComparedRun, ComparedRun]
    mission_changes: tuple[ChangedValue, ...]
    option_changes: tuple[ChangedValue, ...]
    differences: tuple[ComparedNumber, ...]
    requirement_changes: tuple[ChangedValue, ...]

    @property
    def changed(self) -> tuple[ComparedNumber, ...]:
        """Numbers that differ by more than Monte-Carlo noise."""
        return tuple(difference for difference in self.differences if difference.verdict == "changed")

    @property
    def success(self) -> tuple[ComparedNumber, ...]:
        """The probability that the whole mission works, where both runs have it."""
        return tuple(item for item in self.differences if item.key == "success" and item.change is not None)

    @property
    def deciding(self) -> tuple[ComparedNumber, ...]:
        """What a plan is judged by: success, requirements, the d_max that is recommended."""
        requirements = tuple(item for item in self.differences if item.group == "requirement")
        recommended = tuple(item for item in self.differences if item.group.endswith(", recommended"))
        return (*self.success, *requirements, *recommended)

    @property
    def phases(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Names of the phases of both missions."""
        return phase_names(self.provenance.data.get("first")), phase_names(self.provenance.data.get("second"))

    @property
    def task_differs(self) -> Mapping[str, Sequence[str]]:
        """Key paths in which the tasks of the missions differ, by their parts; empty where they have one task."""
        first, second = self.phases
        return parts_of_task([*(["phases"] if first != second else []), *(each.path for each in self.mission_changes)])

    @property
    def alike(self) -> bool:
        """Whether the missions have the same phases, and few other differences."""
        first, second = self.phases
        return first == second and len(self.mission_changes) <= MOST_CHANGES

    def summary(self) -> dict[str, object]:
        """Return the contents of `summary.json`."""
        return {
            **self.provenance.summary(),
            "compared": self.compared,
            "runs": [vars(run) for run in self.runs],
            "mission_changes": [vars(change) for change in self.mission_changes],
            "task_differs": list(self.task_differs),
            "option_changes": [vars(change) for change in self.option_changes],
            "differences": [difference.row() for difference in self.differences],
            "requirement_changes": [vars(change) for change in self.requirement_changes],
        }

    def to_frame(self) -> pd.DataFrame:
        """One row per number of the results."""
        return pd.DataFrame([difference.row() for difference in self.differences])

    def files(self) -> dict[str, str | bytes]:
        """Return `differences.csv`."""
        return {"differences.csv": to_csv(self.to_frame())}
