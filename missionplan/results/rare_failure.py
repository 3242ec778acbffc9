"""Result of `simulate --rare`: how probable a rare failure is, and how it comes about."""

import math
from dataclasses import dataclass
from typing import ClassVar

import pandas as pd

from missionplan.montecarlo.statistics import Probability
from missionplan.results.base import Provenance, Result, to_csv


@dataclass(frozen=True)
class Cause:
    """An input that is not as usual where a mission fails.

    Attributes
    ----------
    source : str
        Such as ``moor.release_time``.
    mean : float
        Of the trials that fail so [SI].
    usual, usual_sd : float
        Mean and standard deviation of all trials [SI].
    """

    source: str
    mean: float
    usual: float
    usual_sd: float

    @property
    def shift(self) -> float:
        """How far it lies from usual, in standard deviations of all trials."""
        return (self.mean - self.usual) / self.usual_sd


@dataclass(frozen=True)
class FailureMode:
    """A way in which the failure comes about.

    Attributes
    ----------
    step : str
        Where such missions fail first, ``moor: anchor outside the radius``; empty where they succeed all the same.
    share : float
        Of the failures.
    causes : tuple of Cause
        What is not as usual in them, the most unusual first.
    """

    step: str
    share: float
    causes: tuple[Cause, ...]


@dataclass(frozen=True)
class WayDriven:
    """A way to fail towards which trials were driven by its own margin.

    Attributes
    ----------
    way : str
        Such as ``moor: anchor outside the radius``; empty for failures that no margin tells.
    probability : float
        Of failing so, alone or with others; zero where no failure was found.
    nearest : float
        Probability, roughly, of coming as near to it as the nearest trials.
    bound : float
        Upper end of the 95 % interval by plain trials.
    """

    way: str
    probability: float
    nearest: float
    bound: float


@dataclass(frozen=True)
class RareFailure(Result):
    """Result of `simulate --rare`.

    Attributes
    ----------
    event : str
        Such as ``not total.success``.
    probability : Probability
        With its 95 % interval.
    variation : float
        Coefficient of variation of the probability, from the scatter of the repetitions; infinite without failures.
    repetitions, levels : int
        Independent repetitions, and the most levels of one.
    reached : bool
        Whether a failure was found.
    nearest : float
        Where none was found: probability, roughly, of coming as near to one as the nearest trials.
    ways : tuple of WayDriven
        Every way to fail towards which trials were driven.
    modes : tuple of FailureMode
        The commonest first.
    sample : DataFrame
        Trials that fail: their weight, the step at which they fail, what was drawn, and what came of it.
    """

    report: ClassVar[str] = "missionplan.report.simulation.rare_failure"

    provenance: Provenance
    event: str
    probability: Probability
    variation: float
    repetitions: int
    levels: int
    reached: bool
    nearest: float
    ways: tuple[WayDriven, ...]
    modes: tuple[FailureMode, ...]
    sample: pd.DataFrame

    @property
    def plain_trials(self) -> float:
        """Trials after which a plain Monte Carlo knows the probability as well; infinite without failures."""
        value = self.probability.value
        return (1.0 - value) / (value * self.variation**2) if value > 0.0 and self.variation > 0.0 else math.inf

    def summary(self) -> dict[str, object]:
        """Return the contents of `summary.json`."""
        return {
            **self.provenance.summary(),
            "rare": {
                "event": self.event,
                "probability": self.probability.summary(),
                "coefficient_of_variation": self.variation,
                "repetitions": self.repetitions,
                "levels": self.levels,
                "found": self.reached,
                "plain_trials": self.plain_trials,
                "ways": [vars(way) for way in self.ways],
                "modes": [
                    {
                        "step": mode.step,
                        "share": mode.share,
                        "causes": [{**vars(cause), "shift": cause.shift} for cause in mode.causes],
                    }
                    for mode in self.modes
                ],
            },
        }

    def to_frame(self) -> pd.DataFrame:
        """One row per way to fail and unusual input."""
        rows = [
            {"step": mode.step, "share": mode.share, **vars(cause), "shift": cause.shift}
            for mode in self.modes
            for cause in mode.causes
        ]
        return pd.DataFrame(rows, columns=["step", "share", "source", "mean", "usual", "usual_sd", "shift"])

    def files(self) -> dict[str, str | bytes]:
        """Return `rare.csv`, the ways to fail, and `failures.csv`, trials that fail."""
        return {"rare.csv": to_csv(self.to_frame()), "failures.csv": to_csv(self.sample)}
