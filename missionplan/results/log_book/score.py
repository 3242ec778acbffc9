"""Result of `score`: how well a mission as it stands predicts measured data."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pandas as pd

from missionplan.arrays import Array
from missionplan.montecarlo.statistics import wilson
from missionplan.results.base import Provenance, Result, to_csv, to_json

STATED = 0.9
"""Probability of the intervals by which a mission is judged."""
PIT_BINS = 10


@dataclass(frozen=True)
class Yardstick:
    """Another way to predict the same values.

    Attributes
    ----------
    rmse, log_score, crps : float
        As in `Prediction`.
    """

    rmse: float
    log_score: float
    crps: float


@dataclass(frozen=True)
class Prediction:
    """Predictions of all values of a record, scored.

    Attributes
    ----------
    rmse : float
        Root mean square error: of a leg in two dimensions, of a reading of the depth [m].
    log_score : float
        Mean ln density of a value, greater is better [nats; density per metre].
    crps : float
        Mean continuous ranked probability score, less is better [m].
    inside_50, inside_90 : int
        Values inside their central intervals.
    chance_90 : tuple of float
        Coverages of the 90 % intervals that chance allows, were the mission true.
    mean, sd, z, pit : array, shape (v,)
        Of each value: expected, its standard deviation, error over it, probability of less.
    yardsticks : mapping
        By name.
    """

    rmse: float
    log_score: float
    crps: float
    inside_50: int
    inside_90: int
    chance_90: tuple[float, float]
    mean: Array
    sd: Array
    z: Array
    pit: Array
    yardsticks: Mapping[str, Yardstick]

    @property
    def coverage_90(self) -> float:
        """Share of values inside their 90 % intervals."""
        return self.inside_90 / len(self.z)

    @property
    def is_within_chance(self) -> bool:
        """Whether the coverage of the 90 % intervals is one that chance allows."""
        return self.chance_90[0] <= self.coverage_90 <= self.chance_90[1]

    def skill(self, yardstick: str) -> float:
        """Part of a yardstick's root mean square error that is avoided; negative for one that is better."""
        other = self.yardsticks[yardstick].rmse
        return 1.0 - self.rmse / other if other > 0.0 else 0.0

    def summary(self, uses: str) -> dict[str, object]:
        """Return the entry of ``predictions``."""
        return {
            "uses": uses,
            "rmse": self.rmse,
            "log_score": self.log_score,
            "crps": self.crps,
            "coverage_50": _probability(self.inside_50, len(self.z)),
            "coverage_90": _probability(self.inside_90, len(self.z)),
            "chance_90": {"low": self.chance_90[0], "high": self.chance_90[1]},
            "within_chance": self.is_within_chance,
            "z": {"mean": float(np.mean(self.z)), "sd": float(np.std(self.z))},
            "pit_histogram": pit_counts(self.pit).tolist(),
            "yardsticks": {
                name: {
                    "rmse": each.rmse,
                    "log_score": each.log_score,
                    "crps": each.crps,
                    "skill": self.skill(name),
                    "log_score_gain": self.log_score - each.log_score,
                    "crps_skill": 1.0 - self.crps / each.crps if each.crps > 0.0 else 0.0,
                }
                for name, each in self.yardsticks.items()
            },
        }


def pit_counts(pit: Array) -> Array:
    """Values in each of the equal bins of their probability integral transforms."""
    return np.asarray(np.histogram(pit, bins=PIT_BINS, range=(0.0, 1.0))[0])


def _probability(inside: int, count: int) -> dict[str, float]:
    interval = wilson(inside, count)
    return {"value": inside / count, "low": interval.low, "high": interval.high}


USES = {
    "one_step": "the record before each leg or dive, as the vehicle could",
    "whole": "nothing of the record, as the plan must",
}
"""What each prediction may use of the record."""


@dataclass(frozen=True)
class DatasetScore:
    """How one data set was predicted.

    Attributes
    ----------
    name, kind : str
        Of the data set.
    groups : int
        Legs or dives.
    labels, places : array, shape (v,)
        Group of each value, and which of its values it is: ``east``, ``north``, or the time [s].
    measured : array, shape (v,)
        Position error of a leg, or depth [m].
    one_step, whole : Prediction
    effective : float
        Effective number of draws of the sizes of random errors at the end of the record.
    notices : tuple of str
    learned : int
        Legs or dives from which the mission has learned: to it they are no data held out.
    """

    name: str
    kind: str
    groups: int
    labels: Array
    places: Array
    measured: Array
    one_step: Prediction
    whole: Prediction
    effective: float
    notices: tuple[str, ...] = ()
    learned: int = 0

    @property
    def predictions(self) -> dict[str, Prediction]:
        """Both predictions, by name."""
        return {"one_step": self.one_step, "whole": self.whole}

    @property
    def is_within_chance(self) -> bool:
        """Whether both coverages are ones that chance allows."""
        return all(prediction.is_within_chance for prediction in self.predictions.values())

    def summary(self) -> dict[str, object]:
        """Return the entry of ``datasets``."""
        return {
            "name": self.name,
            "kind": self.kind,
            "unit": "m",
            "groups": self.groups,
            "learned_from": self.learned,
            "values": len(self.measured),
            "within_chance": self.is_within_chance,
            "effective_draws": self.effective,
            "predictions": {name: each.summary(USES[name]) for name, each in self.predictions.items()},
        }

    def residuals(self) -> pd.DataFrame:
        """One row a value."""
        columns: dict[str, object] = {
            "dataset": self.name,
            "kind": self.kind,
            "group": self.labels,
            "value": self.places,
            "measured_m": self.measured,
        }
        for name, each in self.predictions.items():
            columns |= {
                f"{name}_mean_m": each.mean,
                f"{name}_sd_m": each.sd,
                f"{name}_z": each.z,
                f"{name}_pit": each.pit,
            }
        return pd.DataFrame(columns)


@dataclass(frozen=True)
class Score(Result):
    """How well a mission as it stands predicts data sets.

    Attributes
    ----------
    provenance : Provenance
    datasets : tuple of DatasetScore
    """

    report: ClassVar[str] = "missionplan.report.scoring"

    provenance: Provenance
    datasets: tuple[DatasetScore, ...]

    @property
    def is_within_chance(self) -> bool:
        """Whether the coverage of the 90 % intervals is one that chance allows on every data set."""
        return all(each.is_within_chance for each in self.datasets)

    def score(self) -> dict[str, object]:
        """Return the dictionary of ``score.json``."""
        return {
            "command": "score",
            "mission": self.provenance.mission,
            "within_chance": self.is_within_chance,
            "datasets": [each.summary() for each in self.datasets],
        }

    def summary(self) -> dict[str, object]:
        """Return the dictionary of ``summary.json``."""
        return {**self.provenance.summary(), **self.score()}

    def to_frame(self) -> pd.DataFrame:
        """One row a data set and prediction."""
        rows = [
            {
                "dataset": each.name,
                "kind": each.kind,
                "prediction": name,
                "groups": each.groups,
                "values": len(each.measured),
                "rmse_m": prediction.rmse,
                "log_score": prediction.log_score,
                "crps_m": prediction.crps,
                "coverage_50": prediction.inside_50 / len(each.measured),
                "coverage_90": prediction.coverage_90,
                "within_chance": prediction.is_within_chance,
                **{f"skill_{other}": prediction.skill(other) for other in prediction.yardsticks},
            }
            for each in self.datasets
            for name, prediction in each.predictions.items()
        ]
        return pd.DataFrame(rows)

    def residuals(self) -> pd.DataFrame:
        """One row a value of every data set."""
        return pd.concat([each.residuals() for each in self.datasets], ignore_index=True)

    def files(self) -> dict[str, str | bytes]:
        """``score.json``, ``scores.csv`` and ``residuals.csv``."""
        return {
            "score.json": to_json(self.score()),
            "scores.csv": to_csv(self.to_frame()),
            "residuals.csv": to_csv(self.residuals()),
        }
