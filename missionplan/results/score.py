"""Result of `score`: how well a mission as it stands predicts measured data."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
import pandas as pd

from missionplan.arrays import Array
from missionplan.montecarlo.statistics import Probability, wilson
from missionplan.results import Provenance, Result, to_csv, to_json
from missionplan.results.entries import Entry, Record, summary_of

STATED = 0.9
"""Probability of the intervals by which a mission is judged."""
PIT_BINS = 10


@dataclass(frozen=True)
class Yardstick(Record):
    """Another way to predict the same values."""

    rmse: Annotated[float, Entry("as that of the mission", "m", ending=False)]
    log_score: Annotated[float, Entry("as that of the mission")]
    crps: Annotated[float, Entry("as that of the mission", "m", ending=False)]


@dataclass(frozen=True)
class Gain(Yardstick):
    """A yardstick with what the mission is better by."""

    skill: Annotated[float, Entry("part of its root mean square error that the mission avoids")]
    log_score_gain: Annotated[float, Entry("of the mission")]
    crps_skill: Annotated[float, Entry("part of its CRPS that the mission avoids")]


@dataclass(frozen=True)
class Interval(Record):
    """A range of shares."""

    low: Annotated[float, Entry("lower end")]
    high: Annotated[float, Entry("upper end")]


@dataclass(frozen=True)
class Spread(Record):
    """Mean and standard deviation."""

    mean: Annotated[float, Entry("mean")]
    sd: Annotated[float, Entry("standard deviation")]


@dataclass(frozen=True)
class Prediction(Record):
    """Predictions of all values of a record, scored."""

    rmse: Annotated[
        float, Entry("root mean square error: of a leg in two dimensions, of a reading of the depth", "m", ending=False)
    ]
    log_score: Annotated[float, Entry("mean ln density of a value, greater is better [nats; density per metre]")]
    crps: Annotated[float, Entry("mean continuous ranked probability score, less is better", "m", ending=False)]
    inside_50: int
    inside_90: int
    """Values inside their central intervals."""
    chance_90: tuple[float, float]
    """Coverages of the 90 % intervals that chance allows, were the mission true."""
    p_value: Annotated[
        float, Entry("of the probability integral transforms, by Anderson and Darling, were the mission true")
    ]
    level: Annotated[float, Entry("of the p-value below which chance does not allow it")]
    mean: Array
    sd: Array
    z: Array
    pit: Array
    """Of each value: expected, its standard deviation, error over it, probability of less, shape (v,)."""
    yardsticks: Mapping[str, Yardstick]
    """By name."""

    @property
    def coverage_90(self) -> float:
        """Share of values inside their 90 % intervals."""
        return self.inside_90 / len(self.z)

    @property
    def is_within_chance(self) -> Annotated[bool, Entry(key="within_chance")]:
        """Whether chance allows the whole distribution of the probability integral transforms."""
        return self.p_value >= self.level

    def skill(self, yardstick: str) -> float:
        """Part of a yardstick's root mean square error that is avoided; negative for one that is better."""
        other = self.yardsticks[yardstick].rmse
        return 1.0 - self.rmse / other if other > 0.0 else 0.0

    @property
    def share_inside_50(self) -> Annotated[Probability, Entry(key="coverage_50")]:
        """Share of values inside their 50 % intervals."""
        return _share(self.inside_50, len(self.z))

    @property
    def share_inside_90(self) -> Annotated[Probability, Entry(key="coverage_90")]:
        """Share of values inside their 90 % intervals."""
        return _share(self.inside_90, len(self.z))

    @property
    def chance(self) -> Annotated[Interval, Entry(key="chance_90")]:
        """Coverages of the 90 % intervals that chance allows, were the mission true."""
        return Interval(*self.chance_90)

    @property
    def spread(self) -> Annotated[Spread, Entry(key="z")]:
        """Of errors over their standard deviations."""
        return Spread(float(np.mean(self.z)), float(np.std(self.z)))

    @property
    def pit_histogram(self) -> Annotated[list[int], Entry()]:
        """Values in each of the equal bins of their probability integral transforms."""
        return [int(count) for count in pit_counts(self.pit)]

    @property
    def gains(self) -> Annotated[dict[str, Gain], Entry(key="yardsticks")]:
        """Other ways to predict the same values, with what the mission is better by."""
        return {
            name: Gain(
                yardstick.rmse,
                yardstick.log_score,
                yardstick.crps,
                skill=self.skill(name),
                log_score_gain=self.log_score - yardstick.log_score,
                crps_skill=1.0 - self.crps / yardstick.crps if yardstick.crps > 0.0 else 0.0,
            )
            for name, yardstick in self.yardsticks.items()
        }


def pit_counts(pit: Array) -> Array:
    """Values in each of the equal bins of their probability integral transforms."""
    return np.asarray(np.histogram(pit, bins=PIT_BINS, range=(0.0, 1.0))[0])


def _share(inside: int, count: int) -> Probability:
    interval = wilson(inside, count)
    return Probability(inside / count, interval.low, interval.high)


USES = {
    "one_step": "the record before each leg or dive, as the vehicle could",
    "whole": "nothing of the record, as the plan must",
}
"""What each prediction may use of the record."""


@dataclass(frozen=True)
class DatasetScore(Record):
    """How one data set was predicted."""

    name: Annotated[str, Entry("of the data set")]
    kind: Annotated[str, Entry("of the data set")]
    groups: Annotated[int, Entry("legs or dives")]
    labels: Array
    places: Array
    """Group of each value, and which of its values it is: ``east``, ``north``, or the time [s], shape (v,)."""
    measured: Array
    """Position error of a leg, or depth, shape (v,) [m]."""
    one_step: Prediction
    whole: Prediction
    effective: Annotated[
        float,
        Entry(
            "effective number of draws of the sizes of random errors at the end of the record", key="effective_draws"
        ),
    ]
    notices: tuple[str, ...] = ()
    learned: Annotated[
        int,
        Entry("legs or dives from which the mission has learned: to it they are no data held out", key="learned_from"),
    ] = 0

    @property
    def unit(self) -> Annotated[str, Entry()]:
        """Unit of the errors."""
        return "m"

    @property
    def values(self) -> Annotated[int, Entry()]:
        """Number of values."""
        return len(self.measured)

    @property
    def stated_predictions(self) -> Annotated[dict[str, dict[str, object]], Entry(key="predictions")]:
        """Both predictions by name, and what each ``uses`` of the record."""
        return {name: {"uses": USES[name], **prediction.summary()} for name, prediction in self.predictions.items()}

    @property
    def predictions(self) -> dict[str, Prediction]:
        """Both predictions, by name."""
        return {"one_step": self.one_step, "whole": self.whole}

    @property
    def is_within_chance(self) -> Annotated[bool, Entry(key="within_chance")]:
        """Whether both predictions are ones that chance allows."""
        return all(prediction.is_within_chance for prediction in self.predictions.values())

    def residuals(self) -> pd.DataFrame:
        """One row a value."""
        columns: dict[str, object] = {"dataset": self.name, "kind": self.kind, "group": self.labels}
        columns |= {"value": self.places, "measured_m": self.measured}
        for name, prediction in self.predictions.items():
            parts = {"mean_m": prediction.mean, "sd_m": prediction.sd, "z": prediction.z, "pit": prediction.pit}
            columns |= {f"{name}_{part}": values for part, values in parts.items()}
        return pd.DataFrame(columns)


@dataclass(frozen=True)
class Score(Result):
    """How well a mission as it stands predicts data sets."""

    report: ClassVar[str] = "missionplan.report.diagnosis.scoring"

    provenance: Provenance
    datasets: Annotated[tuple[DatasetScore, ...], Entry("in the order given")]

    @property
    def is_within_chance(self) -> Annotated[bool, Entry(key="within_chance")]:
        """Whether chance allows the predictions of every data set."""
        return all(dataset.is_within_chance for dataset in self.datasets)

    def score(self) -> dict[str, object]:
        """Return the dictionary of ``score.json``."""
        return {"command": "score", "mission": self.provenance.mission, **summary_of(self)}

    def to_frame(self) -> pd.DataFrame:
        """One row a data set and prediction."""
        rows = [
            {
                "dataset": dataset.name,
                "kind": dataset.kind,
                "prediction": name,
                "groups": dataset.groups,
                "values": len(dataset.measured),
                "rmse_m": prediction.rmse,
                "log_score": prediction.log_score,
                "crps_m": prediction.crps,
                "coverage_50": prediction.inside_50 / len(dataset.measured),
                "coverage_90": prediction.coverage_90,
                "within_chance": prediction.is_within_chance,
                **{f"skill_{other}": prediction.skill(other) for other in prediction.yardsticks},
            }
            for dataset in self.datasets
            for name, prediction in dataset.predictions.items()
        ]
        return pd.DataFrame(rows)

    def residuals(self) -> pd.DataFrame:
        """One row a value of every data set."""
        return pd.concat([dataset.residuals() for dataset in self.datasets], ignore_index=True)

    def files(self) -> dict[str, str | bytes]:
        """``score.json``, ``scores.csv`` and ``residuals.csv``."""
        return {
            "score.json": to_json(self.score()),
            "scores.csv": to_csv(self.to_frame()),
            "residuals.csv": to_csv(self.residuals()),
        }
