"""Results of `compare`: what changed between two reports, and which of several missions is better, by how much."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal, NamedTuple

import pandas as pd

from missionplan.montecarlo.statistics import Probability
from missionplan.results import Provenance, Result, to_csv
from missionplan.results.decision import Aim, Assumption
from missionplan.results.entries import Entry, Record
from missionplan.results.simulation import RequirementOutcome
from missionplan.studies.comparison.differing_values import (
    DifferingValue,
    MissionKey,
    PartOfTask,
    parts_of_task,
    phase_names,
)

Bound = Literal["at_most", "at_least"]


class ListItem(NamedTuple):
    """What identifies an item of a list in `summary.json`."""

    name: str = ""
    """Of a phase, or the quantity of a requirement."""
    number: float | None = None
    """σ_v [m/s], d_max [m], or the limit of a requirement, as the list has it."""
    bound: Bound | None = None
    """Of a requirement with a limit."""

    def __str__(self) -> str:
        """Write it as keys of results do: ``moor.offset, 22.86``."""
        return ", ".join(filter(None, (self.name, "" if self.number is None else f"{self.number:.6g}")))


KeyPath = tuple[str | ListItem, ...]
MOST_CHANGES = 40
"""Values in which two missions that are alike may differ."""
ChangeVerdict = Literal["changed", "within noise", "same", "not judged", "only first", "only second"]


@dataclass(frozen=True)
class ComparedRun(Record):
    """One of the two runs."""

    folder: Annotated[str, Entry("report folder as given")]
    mission: Annotated[str, Entry("the mission's name")]
    version: Annotated[str, Entry("of missionplan")]
    created: Annotated[str, Entry("when the report was made, UTC")]
    seed: Annotated[int, Entry("of the Monte Carlo")]
    trials: Annotated[int, Entry("of the Monte Carlo")]


@dataclass(frozen=True)
class ChangedValue(Record):
    """A value of the mission file, or an option of the run, that differs; empty where a run does not have it."""

    path: Annotated[str, Entry("key path, or name of the option")]
    first: Annotated[str, Entry("of the first run")]
    second: Annotated[str, Entry("of the second run")]
    mission_key: MissionKey | None = None
    """Of a value of the mission."""


@dataclass(frozen=True)
class ComparedNumber(Record):
    """A number of the results in both runs; a plain number has no standard error.

    It is ``changed`` where it differs by more than noise, at 5 % for all numbers together (Holm's correction), or at
    all where there is no noise; ``not judged`` where it is noisy and its standard error is not known.
    """

    group: Annotated[str, Entry("such as ``moor``")]
    key: Annotated[str, Entry("such as ``offset_m``")]
    kind: Annotated[Literal["mean", "probability", "number"], Entry("what it is")]
    first: Annotated[float | None, Entry("of the first run; null where it does not have the number")]
    second: Annotated[float | None, Entry("of the second run; null where it does not have the number")]
    standard_error: Annotated[float | None, Entry("of the change, treating the two runs as independent")]
    p_value: Annotated[float | None, Entry("probability of a difference at least as large by Monte-Carlo noise alone")]
    verdict: Annotated[ChangeVerdict, Entry("whether it changed")]
    place: KeyPath
    """Keys that lead to it in `summary.json`; of an item of a list, what identifies it."""

    @property
    def requirement(self) -> ListItem | None:
        """The requirement whose number it is, if it is of one."""
        item = self.place[1] if self.place[0] == "requirements" else None
        return item if isinstance(item, ListItem) else None

    @property
    def of_sweep(self) -> KeyPath:
        """σ_v, part of its curve and the point's d_max, of a number of a sweep; else empty."""
        return self.place[1:-1] if self.place[0] == "sweep" else ()

    @property
    def change(self) -> Annotated[float | None, Entry(after="second")]:
        """Second minus first; None where a run does not have the number."""
        return None if self.first is None or self.second is None else self.second - self.first


@dataclass(frozen=True)
class Comparison(Result):
    """Two runs of one command, side by side; the `data` of its provenance holds both missions."""

    report: ClassVar[str] = "missionplan.studies.comparison.changes_page"

    provenance: Provenance
    compared: Annotated[str, Entry("the command that made both reports")]
    runs: Annotated[tuple[ComparedRun, ComparedRun], Entry("the first and the second")]
    mission_changes: Annotated[tuple[ChangedValue, ...], Entry("values of the missions that differ, by key path")]
    option_changes: Annotated[tuple[ChangedValue, ...], Entry("seeds, trials, versions and options that differ")]
    differences: Annotated[tuple[ComparedNumber, ...], Entry("in the order of the first summary")]
    requirement_changes: Annotated[
        tuple[ChangedValue, ...], Entry("requirements that one run meets and the other does not, or does not have")
    ]

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
        requirements = tuple(item for item in self.differences if item.requirement)
        recommended = tuple(item for item in self.differences if item.of_sweep[1:] == ("recommended",))
        return (*self.success, *requirements, *recommended)

    @property
    def phases(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Names of the phases of both missions."""
        return phase_names(self.provenance.data.get("first")), phase_names(self.provenance.data.get("second"))

    @property
    def task_differs(self) -> Mapping[PartOfTask, Sequence[str]]:
        """Parts in which the tasks of the missions differ, and their phases; empty where they have one task."""
        first, second = self.phases
        keys = (change.mission_key for change in self.mission_changes if change.mission_key is not None)
        return parts_of_task(keys, phases_differ=first != second)

    @property
    def alike(self) -> bool:
        """Whether the missions have the same phases, and few other differences."""
        first, second = self.phases
        return first == second and len(self.mission_changes) <= MOST_CHANGES

    @property
    def parts_that_differ(self) -> Annotated[tuple[str, ...], Entry(key="task_differs")]:
        """Parts in which the tasks of the missions differ."""
        return tuple(self.task_differs)

    def to_frame(self) -> pd.DataFrame:
        """One row per number of the results."""
        return pd.DataFrame([difference.row() for difference in self.differences])

    def files(self) -> dict[str, str | bytes]:
        """Return `differences.csv`."""
        return {"differences.csv": to_csv(self.to_frame())}


DECIDES: Mapping[Aim, str] = {"success": "success", "energy": "energy_wh", "duration": "duration_s"}
"""What is compared first, by what is aimed at."""
Estimate = tuple[float, float]
"""A mean and its standard error."""


@dataclass(frozen=True)
class Contrast(Record):
    """How an alternative differs from the best in one number."""

    difference: Annotated[float, Entry("alternative minus best")]
    error: Annotated[float, Entry("standard error")]
    differs: Annotated[bool, Entry("whether that is more than chance at 5 % for all alternatives together")]
    paired: Annotated[bool, Entry("whether both were run on the same random numbers")]


@dataclass(frozen=True)
class TriedCell:
    """A cell of an exploration."""

    values: tuple[str, ...]
    """Of the keys varied, as a script reads them."""
    meets_all: bool
    """Whether it meets all requirements, undecided or not; False where there are none."""
    success: Probability
    """nan where the cell cannot be run."""


@dataclass(frozen=True)
class Chosen:
    """What a report of `explore` or `optimise` chose, and from what."""

    values: Mapping[str, str]
    """By key, as a script reads them; empty where nothing could be compared."""
    count: int
    """Cells or combinations to choose from."""
    windows: tuple[tuple[str, str], ...] = ()
    """Ranges of the only key in which all requirements are met."""
    cells: tuple[TriedCell, ...] = ()
    """Of an exploration."""


def _is_choice(alternative: "Alternative") -> bool:
    """Whether it is what a report of `explore` or `optimise` chose."""
    return alternative.chosen is not None


@dataclass(frozen=True)
class Alternative(Record):
    """A mission, or a report: of one mission, or of the best of several."""

    name: Annotated[str, Entry("short, unlike the others'")]
    source: Annotated[str, Entry("file or folder as given")]
    success: Annotated[Probability, Entry("of the whole mission")]
    quantities: Mapping[str, Estimate]
    """``duration_s`` and ``energy_wh``, where known."""
    requirements: Annotated[tuple[RequirementOutcome, ...], Entry("in the mission's order")]
    trials: Annotated[int, Entry("of the Monte Carlo")]
    seed: Annotated[int, Entry("of the Monte Carlo")]
    contrasts: Annotated[
        Mapping[str, Contrast],
        Entry("``success``, ``duration_s``, ``energy_wh``; empty for the best itself", key="against_best"),
    ]
    chosen: Chosen | None = None
    """Of a report of `explore` or `optimise`."""

    @property
    def means(self) -> Annotated[dict[str, dict[str, float]], Entry(key="quantities")]:
        """Means of ``duration_s`` and ``energy_wh``, where known."""
        return {name: {"mean": mean, "standard_error": error} for name, (mean, error) in self.quantities.items()}

    @property
    def choice(self) -> Annotated[Mapping[str, str] | None, Entry(key="chosen", when=_is_choice)]:
        """What a report of `explore` or `optimise` chose, by key."""
        return None if self.chosen is None else self.chosen.values

    @property
    def choices(self) -> Annotated[int | None, Entry(when=_is_choice)]:
        """Cells or combinations to choose from."""
        return None if self.chosen is None else self.chosen.count

    @property
    def windows(self) -> Annotated[list[dict[str, str]], Entry(when=_is_choice)]:
        """Ranges of the only key in which all requirements are met, ``from`` and ``to``."""
        return [{"from": first, "to": last} for first, last in (self.chosen.windows if self.chosen else ())]

    @property
    def missed(self) -> tuple[RequirementOutcome, ...]:
        """Requirements that are not met."""
        return tuple(item for item in self.requirements if not item.met)


@dataclass(frozen=True, repr=False)
class Alternatives(Result):
    """Missions, or what was chosen of each, side by side; the `data` of its provenance holds the missions by name."""

    report: ClassVar[str] = "missionplan.studies.comparison.alternatives_page"

    provenance: Provenance
    alternatives: Annotated[tuple[Alternative, ...], Entry("in the order given")]
    best: int
    """The one that misses the fewest requirements, then is first in what is aimed at, then takes the least energy."""
    compared: Annotated[
        str, Entry("``simulate`` of missions and its reports; ``explore`` or ``optimise`` of reports of these")
    ] = "simulate"
    aim: Annotated[Aim, Entry("what is compared first")] = "success"
    differing: Annotated[tuple[DifferingValue, ...], Entry("values in which the missions differ")] = ()
    assumed: tuple[Assumption, ...] = ()
    """What the best takes for granted, where it is a mission."""

    @property
    def task_differs(self) -> Mapping[PartOfTask, Sequence[str]]:
        """Parts in which the tasks of the missions differ, and their phases; empty where they have one task."""
        phases = {phase_names(self.provenance.data.get(case.name)) for case in self.alternatives}
        return parts_of_task((key.mission_key for key in self.differing), phases_differ=len(phases) > 1)

    @property
    def best_one(self) -> Alternative:
        """The best."""
        return self.alternatives[self.best]

    @property
    def others(self) -> tuple[Alternative, ...]:
        """All but the best."""
        return tuple(case for case in self.alternatives if case is not self.best_one)

    @property
    def name_of_best(self) -> Annotated[str, Entry(key="best")]:
        """Name of the best."""
        return self.best_one.name

    @property
    def parts_that_differ(self) -> Annotated[list[str], Entry(key="task_differs")]:
        """Parts in which the tasks of the missions differ."""
        return list(self.task_differs)

    def to_frame(self) -> pd.DataFrame:
        """One row per alternative."""
        return pd.DataFrame([_row(case) for case in self.alternatives])

    def files(self) -> dict[str, str | bytes]:
        """Return `alternatives.csv`."""
        return {"alternatives.csv": to_csv(self.to_frame())}


def _row(case: Alternative) -> dict[str, object]:
    row: dict[str, object] = {"name": case.name, "source": case.source, "trials": case.trials}
    row |= {} if case.chosen is None else case.chosen.values
    row |= {"success": case.success.value, "success_low": case.success.low, "success_high": case.success.high}
    for name, (mean, error) in case.quantities.items():
        row |= {name: mean, f"{name} standard error": error}
    for name, contrast in case.contrasts.items():
        row |= {f"{name} against best": contrast.difference, f"{name} against best standard error": contrast.error}
        row[f"{name} differs"] = contrast.differs
    return row | {"requirements missed": len(case.missed)}
