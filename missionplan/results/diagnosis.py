"""The answer of a diagnosis: what the simulation gets wrong, why, and what the extended model gains."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import ClassVar, Literal

import pandas as pd

from missionplan.arrays import Array
from missionplan.results.base import Provenance, Result, to_csv, to_json, to_yaml

Verdict = Literal["adequate", "explained", "ambiguous", "partly-explained", "unexplained"]
Causes = tuple[str, ...]


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


@dataclass(frozen=True)
class GroupScore:
    """How one held-out run or block of legs was predicted by the base model and by the extended one.

    Attributes
    ----------
    group : str
        Run, or first and last leg.
    log_score_base, log_score_extended : float
        ln p(group | the others).
    rmse_base, rmse_extended : float
        [m] for depths, [m/s] for velocity errors.
    """

    group: str
    log_score_base: float
    log_score_extended: float
    rmse_base: float
    rmse_extended: float


@dataclass(frozen=True)
class HeldOutGain:
    """Held-out scores of an extended model beside the base model's, as in ``diagnosis.json``.

    Attributes
    ----------
    log_score_gain : float
        Sum over groups of the difference in ln p(group | the others).
    paired_se : float
        Standard error of that sum, from the groups' differences.
    groups_improved, groups : int
        How many groups the extended model predicts better, of how many.
    rmse_base, rmse_extended : float
        Root mean square error of the predictions [units of the data].
    coverage_90_base, coverage_90_extended : float
        Share of values inside their 90 % prediction intervals.
    """

    log_score_gain: float
    paired_se: float
    groups_improved: int
    groups: int
    rmse_base: float
    rmse_extended: float
    coverage_90_base: float
    coverage_90_extended: float


@dataclass(frozen=True)
class RankedSet:
    """A set of causes in the ranking.

    Attributes
    ----------
    causes : tuple of str
    log_bayes_factor : float
        Over the base model.
    score : float
        Less 3 nats for each cause beyond the first.
    posterior : float or None
        Probability; None for a superset of the claimed set, which is no rival.
    parameters : tuple of ParameterEstimate
    held_out : HeldOutGain or None
        Where it was measured: the best few.
    share_explained : float
        Share of the base model's squared residuals that goes with these causes.
    importance : float or None
        ln Bayes factor by importance sampling, where it was checked.
    """

    causes: Causes
    log_bayes_factor: float
    score: float
    posterior: float | None
    parameters: tuple[ParameterEstimate, ...]
    held_out: HeldOutGain | None
    share_explained: float
    importance: float | None = None

    def summary(self) -> dict[str, object]:
        """Return the entry of ``ranking``."""
        return {
            "causes": list(self.causes),
            "log_bayes_factor": self.log_bayes_factor,
            "score": self.score,
            "posterior": self.posterior,
            "parameters": [asdict(parameter) for parameter in self.parameters],
            "held_out": asdict(self.held_out) if self.held_out else None,
            "share_explained": self.share_explained,
            "log_bayes_factor_importance": self.importance,
        }


@dataclass(frozen=True)
class ResidualTest:
    """A test that the residuals' innovations are independent and of constant spread."""

    name: str
    p_value: float


@dataclass(frozen=True)
class DiscrepancyShape:
    """A discrepancy along its axis, to first order: the likeliest smooth function and its uncertainty.

    Attributes
    ----------
    place, value : str
        Labels with units.
    at, mean, sd : array, shape (m,)
        Places on the axis, the function's posterior mean there and its standard deviation.
    """

    place: str
    value: str
    at: Array
    mean: Array
    sd: Array


@dataclass(frozen=True)
class Discrepancy:
    """What a model leaves of the data beyond its noise.

    Attributes
    ----------
    log_bayes_factor : float
        Of a smooth discrepancy along some axis over none; the axes share the prior equally.
    axis : str or None
        Along which, where there is one: ``time`` where only a residual test says so.
    by_axis : tuple
        What would be smooth along each axis, in words, and its own ln Bayes factor, greatest first.
    tests : tuple of ResidualTest
        Tests of the innovations.
    resembles : str or None
        What it resembles most, in words, where it is smooth.
    shape : DiscrepancyShape or None
        That function, where it is a single one of one dimension.
    """

    log_bayes_factor: float
    axis: str | None
    by_axis: tuple[tuple[str, float], ...]
    tests: tuple[ResidualTest, ...]
    resembles: str | None = None
    shape: DiscrepancyShape | None = None

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


Plan = Mapping[str, float | None]
"""What is chosen, and how it fares; keys end with their units."""


@dataclass(frozen=True)
class PlanGain:
    """What the planner would choose before and after a diagnosis.

    Attributes
    ----------
    before, after : mapping
        Plans with the base and with the extended mission; empty where there is none.
    base_choice_under_extended : mapping or None
        How the base mission's choice fares when the extended mission is true.
    reason : str or None
        Why there is no plan to compare.
    """

    before: Plan = field(default_factory=dict)
    after: Plan = field(default_factory=dict)
    base_choice_under_extended: Plan | None = None
    reason: str | None = None

    def summary(self) -> dict[str, object]:
        """Return the entry of ``decision``."""
        found: dict[str, object] = {"before": dict(self.before), "after": dict(self.after)}
        if self.base_choice_under_extended is not None:
            found["base_choice_under_extended"] = dict(self.base_choice_under_extended)
        if self.reason is not None:
            found["reason"] = self.reason
        return found


@dataclass(frozen=True)
class Diagnosis(Result):
    """What the simulation gets wrong, why, the extended model, the gain.

    Attributes
    ----------
    provenance : Provenance
    kind, data, source : str
        Of the data set.
    verdict : str
    causes : tuple of str
        The claimed set; empty if none.
    misfit : str
        Size of the base model's misfit in the planner's terms.
    credible_set : tuple
        Sets that hold 95 % of the probability, best first.
    ranking : tuple of RankedSet
        Best first.
    rivals : tuple
        Sets within 3 nats of the claimed one.
    discrepancy, base_discrepancy : Discrepancy
        What the claimed model leaves, and the base model.
    scores : tuple of GroupScore
        Held-out scores of the best set, group by group; empty where there are none.
    outlying_groups : tuple
        Group and p-value.
    indistinguishable : tuple
        Pairs of sets that these data cannot tell apart.
    next_measurements : tuple of NextMeasurement
    decision : PlanGain
        What the planner would choose before and after.
    calibration : mapping
        Nuisance parameters of the base model as fitted.
    untestable, failures : mapping
        Effects that the data could not show and sets that could not be fitted, and why.
    residuals : DataFrame
        Row by row: data, base model, extended model, residuals.
    extended : mapping
        The mission's data with the causes as effects.
    """

    report: ClassVar[str] = "diagnosis.page"

    provenance: Provenance
    kind: str
    data: str
    source: str
    verdict: Verdict
    causes: Causes
    misfit: str
    credible_set: tuple[Causes, ...]
    ranking: tuple[RankedSet, ...]
    rivals: tuple[Causes, ...]
    discrepancy: Discrepancy
    base_discrepancy: Discrepancy
    scores: tuple[GroupScore, ...]
    outlying_groups: tuple[tuple[str, float], ...]
    indistinguishable: tuple[tuple[Causes, Causes], ...]
    next_measurements: tuple[NextMeasurement, ...]
    decision: PlanGain
    calibration: Mapping[str, float]
    untestable: Mapping[str, str]
    failures: Mapping[str, str]
    residuals: pd.DataFrame
    extended: Mapping[str, object]

    @property
    def best(self) -> RankedSet | None:
        """The claimed set's entry; the first of the ranking where nothing is claimed; None without any."""
        return self.ranking[0] if self.ranking else None

    def diagnosis(self) -> dict[str, object]:
        """Return the dictionary of ``diagnosis.json``."""
        return {
            "verdict": self.verdict,
            "causes": list(self.causes),
            "misfit": self.misfit,
            "credible_set": [list(causes) for causes in self.credible_set],
            "ranking": [entry.summary() for entry in self.ranking],
            "remainder": self.discrepancy.summary(),
            "base_remainder": self.base_discrepancy.summary(),
            "outlying_groups": [{"group": group, "p_value": p_value} for group, p_value in self.outlying_groups],
            "indistinguishable": [["+".join(causes) for causes in pair] for pair in self.indistinguishable],
            "next_measurements": [entry.summary() for entry in self.next_measurements],
            "decision": self.decision.summary(),
            "calibration": dict(self.calibration),
            "untestable": dict(self.untestable),
            "failures": dict(self.failures),
            "extended_mission": "mission.yaml",
        }

    def summary(self) -> dict[str, object]:
        """Return the dictionary of ``summary.json``."""
        return {**self.provenance.summary(), "dataset": self.data, "kind": self.kind, **self.diagnosis()}

    def to_frame(self) -> pd.DataFrame:
        """One row a set of the ranking."""
        rows = [
            {
                "causes": "+".join(entry.causes),
                "log_bayes_factor": entry.log_bayes_factor,
                "score": entry.score,
                "posterior": entry.posterior,
                "log_score_gain": entry.held_out.log_score_gain if entry.held_out else None,
                "share_explained": entry.share_explained,
            }
            for entry in self.ranking
        ]
        columns = ["causes", "log_bayes_factor", "score", "posterior", "log_score_gain", "share_explained"]
        return pd.DataFrame(rows, columns=columns)

    def files(self) -> dict[str, str | bytes]:
        """``diagnosis.json``, ``residuals.csv``, ``ranking.csv`` and the extended mission as ``mission.yaml``."""
        return {
            "diagnosis.json": to_json(self.diagnosis()),
            "residuals.csv": to_csv(self.residuals),
            "ranking.csv": to_csv(self.to_frame()),
            "mission.yaml": to_yaml(self.extended),
        }
