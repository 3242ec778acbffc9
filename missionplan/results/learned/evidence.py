"""Parts of the answer of a diagnosis: sets of causes with their evidence and estimates, held-out gain, discrepancy."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from missionplan.arrays import Array

Verdict = Literal["adequate", "explained", "ambiguous", "partly-explained", "unexplained"]
Causes = tuple[str, ...]
SURE = 0.95
"""Probability from which something is said to be so."""


@dataclass(frozen=True)
class ParameterEstimate:
    """A parameter of a cause: value, standard deviation and 90 % interval [unit]."""

    effect: str
    name: str
    value: float
    sd: float
    low: float
    high: float
    unit: str

    def quantity_summary(self) -> dict[str, float | str]:
        """Return value, standard deviation, interval and unit."""
        return {"value": self.value, "sd": self.sd, "low": self.low, "high": self.high, "unit": self.unit}


@dataclass(frozen=True)
class GroupScore:
    """How one held-out run or block of legs was predicted by the base model and by the extended one."""

    group: str
    """Run, or first and last leg."""
    log_score_base: float
    log_score_extended: float
    """ln p(group | the others)."""
    rmse_base: float
    rmse_extended: float
    """[m] for depths, [m/s] for velocity errors."""


@dataclass(frozen=True)
class HeldOutGain:
    """Held-out scores of an extended model beside the base model's, as in ``diagnosis.json``."""

    log_score_gain: float
    """Sum over groups of the difference in ln p(group | the others)."""
    paired_se: float
    """Standard error of that sum, from the groups' differences."""
    groups_improved: int
    groups: int
    """How many groups the extended model predicts better, of how many."""
    rmse_base: float
    rmse_extended: float
    """Root mean square error of the predictions [units of the data]."""
    coverage_90_base: float
    coverage_90_extended: float
    """Share of values inside their 90 % prediction intervals."""

    def __str__(self) -> str:
        """Gain and its standard error, which a single group does not have."""
        spread = f" ± {self.paired_se:.1f}" if math.isfinite(self.paired_se) else ""
        return f"{self.log_score_gain:.1f}{spread}"


@dataclass(frozen=True)
class Coverage:
    """How many held-out values lie inside their 90 % prediction intervals."""

    inside: int
    count: int
    """Values inside, of how many."""
    scale: float
    """Factor on the random errors with which 90 % would have been inside; 1 where chance allows the difference."""
    inside_scaled: int
    """Values inside when the errors of each group are scaled by the factor fitted to the others."""

    @property
    def is_off(self) -> bool:
        """Whether the binomial interval of the coverage excludes 90 %."""
        return self.scale != 1.0


@dataclass(frozen=True)
class ExplanationOdds:
    """One of several explanations, as the extended mission carries them."""

    causes: Causes
    """Its effects; empty where none of the others holds."""
    prior: float | None
    """Probability in the mission given; None where that had no doubt."""
    probability: float
    """After the data."""

    def summary(self) -> dict[str, object]:
        """Return the entry of ``explanations``."""
        before = {} if self.prior is None else {"prior": self.prior}
        return {"causes": list(self.causes), **before, "probability": self.probability}


@dataclass(frozen=True)
class Alias:
    """An effect that does to these data what a claimed cause does, but not on the way back."""

    claimed: str
    other: str
    matters_from: float
    """Distance from which it would matter which it is [m]."""
    trial: str
    """What tells them apart."""


@dataclass(frozen=True)
class WrongFix:
    """A GPS fix by which one leg errs, and the next the other way."""

    leg: str
    """After which it was taken."""
    east_m: float
    north_m: float
    """Where it lies of where it should [m]."""
    probability: float
    """Beside one of both legs erring alone, and neither."""


@dataclass(frozen=True)
class Readings:
    """What else the posterior says."""

    inclusion: Mapping[str, float] = field(default_factory=dict)
    """Probability of each effect."""
    responses: tuple[tuple[str, str, float], ...] = ()
    """Smooth errors outside the catalogue by axis and in words, with their probabilities."""
    not_computed: float = 0.0
    """Estimate of the probability of sets that were not computed."""
    families: tuple[tuple[Causes, ...], ...] = ()
    """Sets that are reported as one, as the data cannot separate them."""
    aliases: tuple[Alias, ...] = ()
    plan_with: bool | None = None
    """Whether the extended mission predicts data kept away better, one step and all the way; None where unknown."""
    wrong_fixes: tuple[WrongFix, ...] = ()
    confounded_with_reckoning: Causes = ()
    """Causes no larger than the doubt of a dead reckoning that was made without a logged speed."""


@dataclass(frozen=True)
class RankedSet:
    """A set of causes in the ranking."""

    causes: Causes
    log_bayes_factor: float
    """Over the base model."""
    score: float
    """Less 3 nats for each cause beyond the first."""
    posterior: float | None
    """Probability; None where it was not computed."""
    parameters: tuple[ParameterEstimate, ...]
    held_out: HeldOutGain | None
    """Where it was measured: the best few."""
    share_explained: float
    """Share of the base model's squared residuals that goes with these causes."""


@dataclass(frozen=True)
class ResidualTest:
    """A test that the residuals' innovations are independent and of constant spread."""

    name: str
    p_value: float


@dataclass(frozen=True)
class DiscrepancyShape:
    """A discrepancy along its axis, to first order: the likeliest smooth function and its uncertainty."""

    place: str
    value: str
    """Labels with units."""
    at: Array
    mean: Array
    sd: Array
    """Places on the axis, the function's posterior mean there and its standard deviation, shape (m,)."""


@dataclass(frozen=True)
class Discrepancy:
    """What a model leaves of the data beyond its noise."""

    log_bayes_factor: float
    """Of a smooth discrepancy along some axis over none; the axes share the prior equally."""
    axis: str | None
    """Along which, where there is one: ``time`` where only a residual test says so."""
    by_axis: tuple[tuple[str, float], ...]
    """What would be smooth along each axis, in words, and its own ln Bayes factor, greatest first."""
    tests: tuple[ResidualTest, ...]
    """Tests of the innovations."""
    resembles: str | None = None
    """What it resembles most, in words, where it is smooth."""
    shape: DiscrepancyShape | None = None
    """That function, where it is a single one of one dimension."""

    @property
    def significant(self) -> bool:
        """Whether there is a discrepancy."""
        return self.axis is not None

    def summary(self) -> dict[str, object]:
        """Return the entry of ``remainder``."""
        return {"log_bayes_factor": self.log_bayes_factor, "axis": self.axis}


@dataclass(frozen=True)
class NextMeasurement:
    """A measurement that would separate two sets of causes."""

    separates: tuple[Causes, Causes]
    measurement: str
    expected_log_bayes_factor: float

    def summary(self) -> dict[str, object]:
        """Return the entry of ``next_measurements``; a set of several causes is written with plus signs."""
        return {
            "separates": ["+".join(causes) for causes in self.separates],
            "measurement": self.measurement,
            "expected_log_bayes_factor": self.expected_log_bayes_factor,
        }


@dataclass(frozen=True)
class Judgement:
    """What may be said after a diagnosis."""

    verdict: Verdict
    credible_set: tuple[Causes, ...]
    """Sets that hold 95 % of the probability, best first."""
    rivals: tuple[Causes, ...]
    """Sets within 3 nats of the claimed one, and those that the data cannot separate from it."""
    not_constant: Causes
    """Claimed causes that do not hold still over the record."""
    suspect_labels: str
    """Which labels of the record look wrong, such as weights of dives; empty where none do."""
    none_of_these: float
    """Probability that something outside the catalogue is left."""
    coverage: Coverage | None
    """Of the 90 % intervals of the model claimed, else of the base model's, on data held out; None where unknown."""
