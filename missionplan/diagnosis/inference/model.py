"""What selection, remainder, gain and next measurement ask of a model of the data, whatever its phase."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from missionplan.diagnosis.inference.importance_sampling import SampledEvidence
from missionplan.diagnosis.inference.residuals import Residuals
from missionplan.results.diagnosis import Causes, ParameterEstimate

FitRequest = tuple[Causes, Sequence["CauseFit"]]
"""A set to fit, and fits of its parts to start from."""
MINIMUM_EVIDENCE_GAIN = 0.02
"""Share of the others' evidence that a further cause must add, where a model knows no better."""


@dataclass(frozen=True)
class CauseFit:
    """A set of causes fitted to the data.

    Attributes
    ----------
    causes : tuple of str
        Effects under their wide priors; the others stay under their narrow ones.
    log_evidence : float
        ln p(data | causes).
    estimates : tuple of ParameterEstimate
        The causes' parameters.
    calibration : mapping
        Nuisances of the base model as fitted, such as ``sigma_v_m_s``.
    possible : bool
        Whether signs and sizes are physically possible.
    state : Any
        What the model needs to go on from here.
    """

    causes: Causes
    log_evidence: float
    estimates: tuple[ParameterEstimate, ...]
    calibration: Mapping[str, float]
    possible: bool
    state: Any


@dataclass(frozen=True)
class FailedFit:
    """A set that could not be fitted, and why."""

    causes: Causes
    reason: str


@dataclass(frozen=True)
class HeldOutScore:
    """How well one held-out group was predicted.

    Attributes
    ----------
    group : str
        Run, or block of legs.
    log_score : float
        ln p(group | the others).
    squared_error : float
        Sum of squared errors of the predictive mean.
    inside : int
        Values inside their 90 % predictive interval.
    count : int
        Values.
    """

    group: str
    log_score: float
    squared_error: float
    inside: int
    count: int


class Model(Protocol):
    """A model of a data set under any set of causes."""

    @property
    def candidates(self) -> Causes:
        """Effects of the catalogue that this data set could show."""
        ...

    @property
    def alternatives(self) -> Sequence[frozenset[str]]:
        """Groups of effects of which a set holds at most one."""
        ...

    def minimum_evidence_gain(self, causes: Causes) -> float:
        """Share of the causes' evidence that a further one must add: no shape fits a large effect to the letter."""
        ...

    def may_be_multimodal(self, causes: Causes) -> bool:
        """Whether their likelihood may have several maxima: a search that ended badly is worth starting afresh."""
        ...

    @property
    def untestable(self) -> Mapping[str, str]:
        """Effects of the catalogue that it could not show, and why."""
        ...

    def fit_all(self, wanted: Sequence[FitRequest]) -> list[CauseFit | FailedFit]:
        """Fit several sets of causes, each started from the fits of its parts and independent of the others."""
        ...

    def relinearised(self, fits: Sequence[CauseFit | FailedFit], best: float) -> list[CauseFit | FailedFit]:
        """Improve fits where that could matter, given the greatest log evidence of those fitted together."""
        ...

    def estimated_gain(self, causes: Causes, parent: CauseFit) -> float:
        """A quick bound on what further causes would add to a parent's log evidence, prices aside; inf if unknown."""
        ...

    def sampled_evidence(self, fit: CauseFit) -> SampledEvidence:
        """Evidence of a fit by importance sampling."""
        ...

    def residuals(self, fit: CauseFit) -> Residuals:
        """Residuals and their covariance under a fit."""
        ...

    def held_out(self, fits: Sequence[CauseFit]) -> list[list[HeldOutScore]]:
        """Predict each group of the data from the others, under several fits."""
        ...

    @property
    def designs(self) -> Sequence[str]:
        """Measurements that could be made next, in words, cheapest first."""
        ...

    def discrimination(self, first: CauseFit, second: CauseFit, entry: int | None) -> float:
        """Expected ln Bayes factor of the first set over the second, were the first true: with an entry of the menu."""
        ...
