"""What the inference asks of a model of the data, what a fit says, and how much better one predicts data held out.

A model has a catalogue of effects, any of which may be causes of what a base model gets wrong. Every parameter of every
effect has a normal prior: a wide one (slab) where its effect is a cause, a narrow one (spike) otherwise (George &
McCulloch 1993, *J. Am. Stat. Assoc.* 88). A set of causes is compared with another by the evidence, ln p(data |
causes); and by leave-one-group-out cross-validation: each group (a run, a block of legs) is predicted from the others
and scored by the log density (Gneiting & Raftery 2007, *J. Am. Stat. Assoc.* 102, section 4.1: a strictly proper rule).
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Protocol, runtime_checkable

import numpy as np

from missionplan.arrays import Array
from missionplan.diagnosis.inference.discrepancy import Residuals
from missionplan.diagnosis.inference.marginal_likelihood import QUANTILE_95
from missionplan.montecarlo.blocks import parallel_map
from missionplan.montecarlo.statistics import wilson
from missionplan.results.learned.evidence import Causes, Coverage, HeldOutGain, ParameterEstimate

FitRequest = tuple[Causes, Sequence["CauseFit"]]
"""A set to fit, and fits of subsets of it to start from."""


@dataclass(frozen=True)
class CauseFit:
    """A set of causes fitted to the data."""

    causes: Causes
    """Effects under their slab priors; the others are under their spikes."""
    log_evidence: float
    """ln p(data | causes)."""
    estimates: tuple[ParameterEstimate, ...]
    """The causes' parameters."""
    calibration: Mapping[str, float]
    """Nuisance parameters of the base model as fitted, such as ``sigma_v_m_s``."""
    possible: bool
    """Whether signs and sizes are physically possible, and the fit lies where the model can be trusted."""
    state: Any
    """The model's own: linearisation, posterior and what else it needs to go on from here."""
    given: tuple[ParameterEstimate, ...] = ()
    """The mission's own effects after this record; those among the causes or replaced by one are left out."""
    posterior: Any = None
    """Joint posterior of all of these, and of the noise, for a record to come (`coordinates.JointPosterior`)."""


@dataclass(frozen=True)
class FailedFit:
    """A set that could not be fitted, and why."""

    causes: Causes
    reason: str


@dataclass(frozen=True)
class HeldOutScore:
    """How well one held-out group was predicted from the others."""

    group: str
    """Run, or block of legs."""
    log_score: float
    """ln p(group | the others)."""
    squared_error: float
    """Sum of squared errors of the predictive mean; of legs as their errors of position count."""
    inside: int
    """Values inside their 90 % predictive interval."""
    count: int
    """Values."""
    standardised: tuple[float, ...] = ()
    """Errors over their predictive standard deviations, where the model gives them."""


class Model(Protocol):
    """A model of a data set under any set of causes."""

    @property
    def candidates(self) -> Causes:
        """Effects of the catalogue that these data could show."""
        ...

    @property
    def alternatives(self) -> Sequence[frozenset[str]]:
        """Groups of effects that exclude each other: a set holds at most one of each."""
        ...

    @property
    def untestable(self) -> Mapping[str, str]:
        """Effects of the catalogue that these data could not show, and why."""
        ...

    def fit_all(self, wanted: Sequence[FitRequest]) -> list[CauseFit | FailedFit]:
        """Fit several sets of causes, each started from the fits given with it and independent of the other sets."""
        ...

    def residuals(self, fit: CauseFit) -> Residuals:
        """Residuals and their covariance under a fit."""
        ...

    def held_out(self, fits: Sequence[CauseFit]) -> list[list[HeldOutScore]]:
        """Predict each group of the data from the others, under several fits."""
        ...

    @property
    def designs(self) -> Sequence[str]:
        """Designs of further measurements, in words, cheapest first."""
        ...

    def discrimination(self, first: CauseFit, second: CauseFit, entry: int | None) -> float:
        """Expected log Bayes factor of the first fit over the second if the first is true, with or without a design."""
        ...


@runtime_checkable
class FitsTogether(Protocol):
    """A model whose sets are fitted faster together than one by one, and relinearised once the best is known."""

    def relinearised(self, fits: Sequence[CauseFit | FailedFit], best: float) -> list[CauseFit | FailedFit]:
        """Linearise the best fits anew where their posteriors lie off the point of linearisation.

        Fits far below the best log evidence of those fitted together need no improvement.
        """
        ...


def fitted(model: Model, requests: Sequence[FitRequest], jobs: int = 1) -> list[CauseFit | FailedFit]:
    """Fit several sets; relinearise what is fitted together.

    Each request is a set, with fits to start from.

    Returns
    -------
    list
        A fit, or why there is none, for each set in their order.
    """
    results = parallel_map(model.fit_all, requests, jobs=jobs, separately=not isinstance(model, FitsTogether))
    fits = [_in_numbers(fit) for fit in results]
    if not isinstance(model, FitsTogether):
        return fits
    best = max((fit.log_evidence for fit in fits if isinstance(fit, CauseFit)), default=0.0)
    return parallel_map(partial(model.relinearised, best=best), fits, jobs=jobs)


def _in_numbers(fit: CauseFit | FailedFit) -> CauseFit | FailedFit:
    """Return a fit whose evidence and estimates are finite; else say that it is none."""
    if isinstance(fit, FailedFit):
        return fit
    numbers = [fit.log_evidence]
    for estimate in (*fit.estimates, *fit.given):
        numbers += [estimate.value, estimate.sd, estimate.low, estimate.high]
    return fit if np.all(np.isfinite(numbers)) else FailedFit(fit.causes, "the data do not determine its parameters")


@dataclass(frozen=True)
class HeldOutComparison:
    """Two models' predictions of the same held-out groups."""

    gain: HeldOutGain
    """Of the extended model over the base model, all groups together."""
    base: tuple[HeldOutScore, ...]
    extended: tuple[HeldOutScore, ...]
    """Group by group."""


def compare_held_out(base: Sequence[HeldOutScore], extended: Sequence[HeldOutScore]) -> HeldOutComparison:
    """Compare two models' scores on the same groups.

    The standard error of the summed difference is √n times the standard deviation of the groups' differences
    (Vehtari, Gelman & Gabry 2017, *Stat. Comput.* 27, Eq. 24).
    """
    difference = np.array([b.log_score - a.log_score for a, b in zip(base, extended, strict=True)])
    spread = float(difference.std(ddof=1)) if len(difference) > 1 else math.nan
    (rmse_base, coverage_base), (rmse_extended, coverage_extended) = _overall(base), _overall(extended)
    gain = HeldOutGain(
        log_score_gain=float(difference.sum()),
        paired_se=spread * math.sqrt(len(difference)),
        groups_improved=int((difference > 0.0).sum()),
        groups=len(difference),
        rmse_base=rmse_base,
        rmse_extended=rmse_extended,
        coverage_90_base=coverage_base,
        coverage_90_extended=coverage_extended,
    )
    return HeldOutComparison(gain, tuple(base), tuple(extended))


def _overall(scores: Sequence[HeldOutScore]) -> tuple[float, float]:
    """Root mean square error, and share of values inside their 90 % intervals, of all groups together."""
    count = sum(score.count for score in scores)
    rmse = math.sqrt(sum(score.squared_error for score in scores) / count)
    return rmse, sum(score.inside for score in scores) / count


STATED = 0.9
"""Probability of the intervals."""


def interval_coverage(scores: Sequence[HeldOutScore]) -> Coverage | None:
    """Count values inside their intervals, and fit the factor where they are too many or too few.

    A conformal factor: the quantile of the standardised errors of held-out groups (Vovk, Gammerman & Shafer 2005,
    *Algorithmic Learning in a Random World*), assessed on groups that it was not fitted to.

    Returns
    -------
    Coverage or None
        None without standardised errors, or of a single group.
    """
    groups = [np.abs(np.array(score.standardised)) for score in scores if score.standardised]
    if len(groups) < 2:
        return None
    together = np.concatenate(groups)
    inside, count = _inside(together, 1.0), len(together)
    interval = wilson(inside, count)
    if interval.low <= STATED <= interval.high:
        return Coverage(inside, count, 1.0, inside)
    others = (np.concatenate([*groups[:index], *groups[index + 1 :]]) for index in range(len(groups)))
    scaled = sum(_inside(group, _factor(rest)) for group, rest in zip(groups, others, strict=True))
    return Coverage(inside, count, _factor(together), scaled)


def _factor(sizes: Array) -> float:
    return float(np.quantile(sizes, STATED)) / QUANTILE_95


def _inside(sizes: Array, factor: float) -> int:
    return int(np.count_nonzero(sizes <= factor * QUANTILE_95))
