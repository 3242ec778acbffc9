"""Result of `simulate --rare`: how probable a rare failure is, and how it comes about."""

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar

import pandas as pd

from missionplan.montecarlo.statistics import Probability
from missionplan.results.base import Provenance, Result, to_csv
from missionplan.results.entries import Entry, Record


@dataclass(frozen=True)
class Cause(Record):
    """An input that is not as usual where a mission fails; numbers in SI."""

    source: Annotated[str, Entry("such as ``moor.release_time``")]
    mean: Annotated[float, Entry("of the trials that fail so")]
    usual: Annotated[float, Entry("mean of all trials")]
    usual_sd: Annotated[float, Entry("standard deviation of all trials")]

    @property
    def shift(self) -> Annotated[float, Entry()]:
        """How far it lies from usual, in standard deviations of all trials."""
        return (self.mean - self.usual) / self.usual_sd


@dataclass(frozen=True)
class FailureMode(Record):
    """A way in which the failure comes about."""

    step: Annotated[
        str,
        Entry("where such missions fail first, ``moor: anchor outside the radius``; empty where they succeed yet"),
    ]
    share: Annotated[float, Entry("of the failures")]
    causes: Annotated[tuple[Cause, ...], Entry("what is not as usual in them, the most unusual first")]


@dataclass(frozen=True)
class WayDriven(Record):
    """A way to fail towards which trials were driven by its own margin."""

    way: Annotated[str, Entry("such as ``moor: anchor outside the radius``; empty for failures that no margin tells")]
    probability: Annotated[float, Entry("of failing so, alone or with others; zero where no failure was found")]
    nearest: Annotated[float, Entry("probability, roughly, of coming as near to it as the nearest trials")]
    bound: Annotated[float, Entry("upper end of the 95 % interval by plain trials")]


@dataclass(frozen=True)
class RareFailure(Result):
    """Result of `simulate --rare`."""

    report: ClassVar[str] = "missionplan.studies.rare_failure.page"

    provenance: Provenance
    event: Annotated[str, Entry("such as ``not total.success``", key="rare.event")]
    probability: Annotated[Probability, Entry("with its 95 % interval", key="rare.probability")]
    variation: Annotated[
        float,
        Entry(
            "of the probability, from the scatter of the repetitions; infinite without failures",
            key="rare.coefficient_of_variation",
        ),
    ]
    repetitions: Annotated[int, Entry("independent repetitions", key="rare.repetitions")]
    levels: Annotated[int, Entry("the most levels of one repetition", key="rare.levels")]
    reached: Annotated[bool, Entry("whether a failure was found", key="rare.found")]
    nearest: float
    """Where no failure was found: probability, roughly, of coming as near to one as the nearest trials."""
    ways: Annotated[tuple[WayDriven, ...], Entry("ways to fail towards which trials were driven", key="rare.ways")]
    modes: Annotated[tuple[FailureMode, ...], Entry("the commonest first", key="rare.modes")]
    sample: pd.DataFrame
    """Trials that fail: their weight, the step at which they fail, what was drawn, and what came of it."""

    @property
    def plain_trials(self) -> Annotated[float, Entry(key="rare.plain_trials")]:
        """Trials after which a plain Monte Carlo knows the probability as well; infinite without failures."""
        value = self.probability.value
        return (1.0 - value) / (value * self.variation**2) if value > 0.0 and self.variation > 0.0 else math.inf

    def to_frame(self) -> pd.DataFrame:
        """One row per way to fail and unusual input."""
        rows = [{"step": mode.step, "share": mode.share, **cause.row()} for mode in self.modes for cause in mode.causes]
        return pd.DataFrame(rows, columns=["step", "share", "source", "mean", "usual", "usual_sd", "shift"])

    def files(self) -> dict[str, str | bytes]:
        """Return `rare.csv`, the ways to fail, and `failures.csv`, trials that fail."""
        return {"rare.csv": to_csv(self.to_frame()), "failures.csv": to_csv(self.sample)}
