"""Parts of the answer of a diagnosis: sets of causes with their evidence and estimates, held-out gain, discrepancy."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Literal, NamedTuple

from missionplan.arrays import Array
from missionplan.results.entries import Entry, Record

Verdict = Literal["adequate", "explained", "ambiguous", "partly-explained", "unexplained"]
Causes = tuple[str, ...]
SURE = 0.95
"""Probability from which something is said to be so."""


@dataclass(frozen=True)
class ParameterEstimate(Record):
    """A parameter of a cause, in its unit."""

    effect: Annotated[str, Entry("whose parameter it is")]
    name: Annotated[str, Entry("of the parameter")]
    value: Annotated[float, Entry("estimate, in the parameter's unit")]
    sd: Annotated[float, Entry("its standard deviation")]
    low: Annotated[float, Entry("lower end of the 90 % interval")]
    high: Annotated[float, Entry("upper end of the 90 % interval")]
    unit: Annotated[str, Entry("of the parameter")]


@dataclass(frozen=True)
class TakenAsExact(Record):
    """Something that a data set or its mission takes as exact, and the answer when it is off by its usual size."""

    what: Annotated[str, Entry("what is taken as exact")]
    otherwise: Annotated[str, Entry("what was put in its place")]
    moves: Annotated[
        ParameterEstimate | None,
        Entry("how far the parameter then moves that moves most of its standard deviations; null: none is claimed"),
    ]
    likeliest: Annotated[Causes, Entry("likeliest set then, of the claimed one and those nearest to it")]
    turns: Annotated[bool, Entry("whether that is another than now")]

    @property
    def in_sd(self) -> float:
        """Standard deviations by which the parameter moves."""
        return 0.0 if self.moves is None else abs(self.moves.value) / max(self.moves.sd, 1e-30)


_QUANTITY = ("value", "sd", "low", "high", "unit")


@dataclass(frozen=True)
class KnownParameter(Record):
    """A parameter of one of the mission's own effects, before the data and after them."""

    effect: Annotated[str, Entry("whose parameter it is")]
    name: Annotated[str, Entry("of the parameter")]
    prior: Annotated[ParameterEstimate, Entry("as the mission knew it", parts=_QUANTITY)]
    posterior: Annotated[ParameterEstimate, Entry("by these data too", parts=_QUANTITY)]
    probability: Annotated[float, Entry("of the effect, after these data")]


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
    """[m] for depths, [m/s] for velocity errors, of which those of longer legs count more."""


@dataclass(frozen=True)
class HeldOutGain(Record):
    """Held-out scores of an extended model beside the base model's."""

    log_score_gain: Annotated[float, Entry("sum over groups of the difference in ln p(group | the others)")]
    paired_se: Annotated[float, Entry("standard error of that sum, from the groups' differences")]
    groups_improved: Annotated[int, Entry("how many groups the extended model predicts better")]
    groups: Annotated[int, Entry("of how many")]
    rmse_base: Annotated[float, Entry("root mean square error of the base model's predictions, in the data's unit")]
    rmse_extended: Annotated[float, Entry("the same of the extended model's")]
    coverage_90_base: Annotated[float, Entry("share of values inside the base model's 90 % prediction intervals")]
    coverage_90_extended: Annotated[float, Entry("the same of the extended model's")]

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
class ExplanationOdds(Record):
    """One of several explanations, as the extended mission carries them."""

    causes: Annotated[Causes, Entry("its effects; empty where none of the others holds")]
    prior: Annotated[float | None, Entry("in the mission given; left out where that had no doubt", optional=True)]
    probability: Annotated[float, Entry("after the data")]


@dataclass(frozen=True)
class Alias(Record):
    """An effect that does to these data what a claimed cause does, but not on the way back."""

    claimed: Annotated[str, Entry("the cause claimed")]
    other: Annotated[str, Entry("the effect that does the same to these data")]
    matters_from: Annotated[float, Entry("distance from which it would matter which it is [m]")]
    trial: Annotated[str, Entry("what tells them apart")]


@dataclass(frozen=True)
class WrongFix(Record):
    """A GPS fix by which one leg errs, and the next the other way."""

    leg: Annotated[str, Entry("after which it was taken")]
    east_m: Annotated[float, Entry("where it lies east of where it should", "m", ending=False)]
    north_m: Annotated[float, Entry("and north", "m", ending=False)]
    probability: Annotated[float, Entry("beside one of both legs erring alone, and neither")]


class Response(NamedTuple):
    """A smooth error outside the catalogue."""

    axis: Annotated[str, Entry("along which it is smooth")]
    what: Annotated[str, Entry("what it does, in words")]
    probability: Annotated[float, Entry("of it")]


class OutlyingGroup(NamedTuple):
    """A dive, run or block of legs that the others do not predict."""

    group: Annotated[str, Entry("its name")]
    p_value: Annotated[float, Entry("for all groups together (Bonferroni)")]


@dataclass(frozen=True)
class Readings(Record):
    """What else the posterior says."""

    inclusion: Annotated[Mapping[str, float], Entry("probability of each effect")] = field(default_factory=dict)
    responses: Annotated[tuple[Response, ...], Entry("smooth errors outside the catalogue, likeliest first")] = ()
    not_computed: Annotated[float, Entry("estimate of the probability of sets that were not computed")] = 0.0
    families: Annotated[
        tuple[tuple[Causes, ...], ...], Entry("sets that are reported as one, as the data cannot separate them")
    ] = ()
    aliases: Annotated[tuple[Alias, ...], Entry("effects that do to these data what a claimed cause does")] = ()
    plan_with: Annotated[
        bool | None,
        Entry("whether the extended mission predicts data kept away better, one step and all the way; null: unknown"),
    ] = None
    wrong_fixes: Annotated[tuple[WrongFix, ...], Entry("GPS fixes that look wrong")] = ()
    confounded_with_reckoning: Annotated[
        Causes, Entry("causes no larger than the doubt of a dead reckoning made without a logged speed")
    ] = ()


@dataclass(frozen=True)
class RankedSet(Record):
    """A set of causes in the ranking."""

    causes: Annotated[Causes, Entry("effects of the set")]
    log_bayes_factor: Annotated[float, Entry("over the base model")]
    score: Annotated[float, Entry("less 3 nats for each cause beyond the first")]
    posterior: Annotated[float | None, Entry("probability; null where it was not computed")]
    parameters: Annotated[tuple[ParameterEstimate, ...], Entry("of its effects")]
    held_out: Annotated[HeldOutGain | None, Entry("on data held out, where measured: the best few")]
    share_explained: Annotated[float, Entry("of the base model's squared residuals, what goes with these causes")]


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
class Discrepancy(Record):
    """What a model leaves of the data beyond its noise."""

    log_bayes_factor: Annotated[
        float, Entry("of a smooth discrepancy along some axis over none; the axes share the prior equally")
    ]
    axis: Annotated[str | None, Entry("along which, where there is one: ``time`` where only a residual test says so")]
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


@dataclass(frozen=True)
class NextMeasurement(Record):
    """A measurement that would separate two sets of causes."""

    separates: tuple[Causes, Causes]
    measurement: Annotated[str, Entry("what to measure, in words")]
    expected_log_bayes_factor: Annotated[float, Entry("of the set that holds over the other, after it")]

    @property
    def separated(self) -> Annotated[tuple[str, ...], Entry(key="separates")]:
        """Both sets, each with plus signs between its causes."""
        return tuple(map(joined, self.separates))


def joined(causes: Causes) -> str:
    """Write a set of causes as tables do: with plus signs."""
    return "+".join(causes)


@dataclass(frozen=True)
class Judgement:
    """What may be said after a diagnosis."""

    verdict: Annotated[Verdict, Entry("what may be said of the causes")]
    credible_set: Annotated[
        tuple[Causes, ...],
        Entry(
            "sets that hold 95 % of the probability, best first; a set counts with a part of it where the data speak "
            "against the rest"
        ),
    ]
    rivals: tuple[Causes, ...]
    """Sets within 3 nats of the claimed one, and those that the data cannot separate from it."""
    not_constant: Annotated[Causes, Entry("claimed causes that do not hold still over the record")]
    suspect_labels: Annotated[
        str, Entry("which labels of the record look wrong, such as weights of dives; empty where none do")
    ]
    none_of_these: Annotated[float, Entry("probability that something outside the catalogue is left")]
    nothing: Annotated[float, Entry("probability that there is no cause, and nothing else that the mission lacks")]
    coverage: Coverage | None
    """Of the 90 % intervals of the model claimed, else of the base model's, on data held out; None where unknown."""
