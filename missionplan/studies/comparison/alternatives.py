"""Result of `compare` of missions, or of reports of what was chosen: which is better, by how much, or that none is."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar

import pandas as pd

from missionplan.montecarlo.statistics import Probability
from missionplan.results.axis import Aim
from missionplan.results.base import Provenance, Result, to_csv
from missionplan.results.entries import Entry, Record
from missionplan.results.simulation import RequirementOutcome
from missionplan.studies.comparison.changes import DifferingValue, parts_of_task, phase_names

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
    """A cell of an exploration.

    Attributes
    ----------
    values : tuple of str
        Of the keys varied, as a script reads them.
    meets_all : bool
        Whether it meets all requirements, undecided or not; False where there are none.
    success : Probability
        nan where the cell cannot be run.
    """

    values: tuple[str, ...]
    meets_all: bool
    success: Probability


@dataclass(frozen=True)
class Chosen:
    """What a report of `explore` or `optimise` chose, and from what.

    Attributes
    ----------
    values : mapping of str to str
        By key, as a script reads them; empty where nothing could be compared.
    count : int
        Cells or combinations to choose from.
    windows : tuple of (str, str)
        Ranges of the only key in which all requirements are met.
    cells : tuple of TriedCell
        Of an exploration.
    """

    values: Mapping[str, str]
    count: int
    windows: tuple[tuple[str, str], ...] = ()
    cells: tuple[TriedCell, ...] = ()


@dataclass(frozen=True)
class Alternative(Record):
    """A mission, or a report: of one mission, or of the best of several.

    Attributes
    ----------
    quantities : mapping of str to Estimate
        ``duration_s`` and ``energy_wh``, where known.
    chosen : Chosen or None
        Of a report of `explore` or `optimise`.
    """

    name: Annotated[str, Entry("short, unlike the others'")]
    source: Annotated[str, Entry("file or folder as given")]
    success: Annotated[Probability, Entry("of the whole mission")]
    quantities: Mapping[str, Estimate]
    requirements: Annotated[tuple[RequirementOutcome, ...], Entry("in the mission's order")]
    trials: Annotated[int, Entry("of the Monte Carlo")]
    seed: Annotated[int, Entry("of the Monte Carlo")]
    contrasts: Annotated[
        Mapping[str, Contrast],
        Entry("``success``, ``duration_s``, ``energy_wh``; empty for the best itself", key="against_best"),
    ]
    chosen: Chosen | None = None

    @property
    def means(self) -> Annotated[dict[str, dict[str, float]], Entry(key="quantities")]:
        """Means of ``duration_s`` and ``energy_wh``, where known."""
        return {name: {"mean": mean, "standard_error": error} for name, (mean, error) in self.quantities.items()}

    @property
    def choice(self) -> Annotated[Mapping[str, str] | None, Entry(key="chosen", when="is_choice")]:
        """What a report of `explore` or `optimise` chose, by key."""
        return None if self.chosen is None else self.chosen.values

    @property
    def choices(self) -> Annotated[int | None, Entry(when="is_choice")]:
        """Cells or combinations to choose from."""
        return None if self.chosen is None else self.chosen.count

    @property
    def windows(self) -> Annotated[list[dict[str, str]], Entry(when="is_choice")]:
        """Ranges of the only key in which all requirements are met, ``from`` and ``to``."""
        return [{"from": first, "to": last} for first, last in (self.chosen.windows if self.chosen else ())]

    @property
    def is_choice(self) -> bool:
        """Whether it is what a report of `explore` or `optimise` chose."""
        return self.chosen is not None

    @property
    def missed(self) -> tuple[RequirementOutcome, ...]:
        """Requirements that are not met."""
        return tuple(item for item in self.requirements if not item.met)


@dataclass(frozen=True, repr=False)
class Alternatives(Result):
    """Missions, or what was chosen of each, side by side; the `data` of its provenance holds the missions by name.

    Attributes
    ----------
    best : int
        The one that misses the fewest requirements, then is first in what is aimed at, then takes the least energy.
    """

    report: ClassVar[str] = "missionplan.studies.comparison.alternatives_page"

    provenance: Provenance
    alternatives: Annotated[tuple[Alternative, ...], Entry("in the order given")]
    best: int
    compared: Annotated[
        str, Entry("``simulate`` of missions and its reports; ``explore`` or ``optimise`` of reports of these")
    ] = "simulate"
    aim: Annotated[Aim, Entry("what is compared first")] = "success"
    differing: Annotated[tuple[DifferingValue, ...], Entry("values in which the missions differ")] = ()

    @property
    def task_differs(self) -> Mapping[str, Sequence[str]]:
        """Key paths in which the tasks of the missions differ, by their parts; empty where they have one task."""
        phases = {phase_names(self.provenance.data.get(each.name)) for each in self.alternatives}
        return parts_of_task([*(["phases"] if len(phases) > 1 else []), *(each.path for each in self.differing)])

    @property
    def best_one(self) -> Alternative:
        """The best."""
        return self.alternatives[self.best]

    @property
    def others(self) -> tuple[Alternative, ...]:
        """All but the best."""
        return tuple(each for each in self.alternatives if each is not self.best_one)

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
        return pd.DataFrame([_row(each) for each in self.alternatives])

    def files(self) -> dict[str, str | bytes]:
        """Return `alternatives.csv`."""
        return {"alternatives.csv": to_csv(self.to_frame())}


def _row(each: Alternative) -> dict[str, object]:
    row: dict[str, object] = {"name": each.name, "source": each.source, "trials": each.trials}
    row |= {} if each.chosen is None else each.chosen.values
    row |= {"success": each.success.value, "success_low": each.success.low, "success_high": each.success.high}
    for name, (mean, error) in each.quantities.items():
        row |= {name: mean, f"{name} standard error": error}
    for name, contrast in each.contrasts.items():
        row |= {f"{name} against best": contrast.difference, f"{name} against best standard error": contrast.error}
        row[f"{name} differs"] = contrast.differs
    return row | {"requirements missed": len(each.missed)}
