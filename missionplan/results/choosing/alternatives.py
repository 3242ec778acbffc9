"""Result of `compare` of missions, or of more than two reports: which is better, by how much, or that none is."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import pandas as pd

from missionplan.montecarlo.statistics import Probability
from missionplan.results.base import Provenance, Result, to_csv
from missionplan.results.simulation import RequirementOutcome

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
class Alternative:
    """A mission, or the report of one.

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
    """

    name: str
    source: str
    success: Probability
    quantities: Mapping[str, Estimate]
    requirements: tuple[RequirementOutcome, ...]
    trials: int
    seed: int
    contrasts: Mapping[str, Contrast]

    @property
    def missed(self) -> tuple[RequirementOutcome, ...]:
        """Requirements that are not met."""
        return tuple(item for item in self.requirements if not item.met)


@dataclass(frozen=True, repr=False)
class Alternatives(Result):
    """Missions side by side.

    Attributes
    ----------
    provenance : Provenance
        Its `data` holds the missions by name.
    alternatives : tuple of Alternative
        In the order given.
    best : int
        The one that misses the fewest requirements, then succeeds most often, then takes the least energy.
    """

    report: ClassVar[str] = "alternatives"

    provenance: Provenance
    alternatives: tuple[Alternative, ...]
    best: int

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
            "best": self.best_one.name,
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
    }


def _row(each: Alternative) -> dict[str, object]:
    row: dict[str, object] = {"name": each.name, "source": each.source, "trials": each.trials}
    row |= {"success": each.success.value, "success_low": each.success.low, "success_high": each.success.high}
    for name, (mean, error) in each.quantities.items():
        row |= {name: mean, f"{name} standard error": error}
    for name, contrast in each.contrasts.items():
        row |= {f"{name} against best": contrast.difference, f"{name} against best standard error": contrast.error}
        row[f"{name} differs"] = contrast.differs
    return row | {"requirements missed": len(each.missed)}
