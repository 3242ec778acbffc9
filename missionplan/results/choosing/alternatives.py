"""Result of `compare` of missions, or of reports of what was chosen: which is better, by how much, or that none is."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import pandas as pd

from missionplan.montecarlo.statistics import Probability
from missionplan.results.base import Provenance, Result, to_csv
from missionplan.results.choosing.axis import Aim
from missionplan.results.simulation import RequirementOutcome
from missionplan.results.task import DifferingValue, parts_of_task, phase_names

DECIDES: Mapping[Aim, str] = {"success": "success", "energy": "energy_wh", "duration": "duration_s"}
"""What is compared first, by what is aimed at."""
Estimate = tuple[float, float]
"""A mean and its standard error."""


@dataclass(frozen=True)
class Contrast:
    """How an alternative differs from the best in one number.

    Attributes
    ----------
    difference, error : float
        Alternative minus best, and the standard error.
    differs : bool
        Whether that is more than chance at 5 % for all alternatives together.
    paired : bool
        Whether both were run on the same random numbers.
    """

    difference: float
    error: float
    differs: bool
    paired: bool


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
class Alternative:
    """A mission, or a report: of one mission, or of the best of several.

    Attributes
    ----------
    name : str
        Short, unlike the others'.
    source : str
        File or folder as given.
    success : Probability
    quantities : mapping of str to Estimate
        ``duration_s`` and ``energy_wh``, where known.
    requirements : tuple of RequirementOutcome
    trials, seed : int
    contrasts : mapping of str to Contrast
        Against the best: ``success``, ``duration_s``, ``energy_wh``; empty for the best itself.
    chosen : Chosen or None
        Of a report of `explore` or `optimise`.
    """

    name: str
    source: str
    success: Probability
    quantities: Mapping[str, Estimate]
    requirements: tuple[RequirementOutcome, ...]
    trials: int
    seed: int
    contrasts: Mapping[str, Contrast]
    chosen: Chosen | None = None

    @property
    def missed(self) -> tuple[RequirementOutcome, ...]:
        """Requirements that are not met."""
        return tuple(item for item in self.requirements if not item.met)


@dataclass(frozen=True, repr=False)
class Alternatives(Result):
    """Missions, or what was chosen of each, side by side.

    Attributes
    ----------
    provenance : Provenance
        Its `data` holds the missions by name.
    alternatives : tuple of Alternative
        In the order given.
    best : int
        The one that misses the fewest requirements, then is first in what is aimed at, then takes the least energy.
    compared : str
        ``simulate`` of missions and its reports; ``explore`` or ``optimise`` of reports of these.
    aim : 'success', 'energy' or 'duration'
    differing : tuple of DifferingValue
        Values in which the missions differ.
    """

    report: ClassVar[str] = "missionplan.report.compared.alternatives"

    provenance: Provenance
    alternatives: tuple[Alternative, ...]
    best: int
    compared: str = "simulate"
    aim: Aim = "success"
    differing: tuple[DifferingValue, ...] = ()

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

    def summary(self) -> dict[str, object]:
        """Return the contents of `summary.json`."""
        return {
            **self.provenance.summary(),
            "compared": self.compared,
            "aim": self.aim,
            "best": self.best_one.name,
            "task_differs": list(self.task_differs),
            "differing": [{"path": each.path, "values": list(each.values)} for each in self.differing],
            "alternatives": [_entry(each) for each in self.alternatives],
        }

    def to_frame(self) -> pd.DataFrame:
        """One row per alternative."""
        return pd.DataFrame([_row(each) for each in self.alternatives])

    def files(self) -> dict[str, str | bytes]:
        """Return `alternatives.csv`."""
        return {"alternatives.csv": to_csv(self.to_frame())}


def _entry(each: Alternative) -> dict[str, object]:
    return {
        "name": each.name,
        "source": each.source,
        "trials": each.trials,
        "seed": each.seed,
        "success": each.success.summary(),
        "quantities": {
            name: {"mean": mean, "standard_error": error} for name, (mean, error) in each.quantities.items()
        },
        "requirements": [item.summary() for item in each.requirements],
        "against_best": {name: vars(contrast) for name, contrast in each.contrasts.items()},
        **({} if each.chosen is None else _chosen(each.chosen)),
    }


def _chosen(chosen: Chosen) -> dict[str, object]:
    windows = [{"from": first, "to": last} for first, last in chosen.windows]
    return {"chosen": dict(chosen.values), "choices": chosen.count, "windows": windows}


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
