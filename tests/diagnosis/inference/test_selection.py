"""The posterior over all sets of causes, on a model whose evidence is written down."""

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pytest

from missionplan.diagnosis.inference.evidence_approximations import SampledEvidence
from missionplan.diagnosis.inference.model import CauseFit, FailedFit, FitRequest
from missionplan.diagnosis.inference.selection import credible_set, rivals, told_together
from missionplan.diagnosis.inference.weighing import NeutralResponses, weigh
from missionplan.errors import RunError
from missionplan.results.learned.evidence import Causes

DRAG, FLOODING, LIFT, CLOCK = "drag-bias", "slow-flooding", "stratification", "clock-offset"
NAMES = (DRAG, FLOODING, LIFT, CLOCK)


class Written:
    """A model whose sets have the evidence given, and -1 otherwise; estimates of sets of several are off by `error`."""

    def __init__(
        self,
        evidence: Mapping[Causes, float],
        alternatives: Sequence[frozenset[str]] = (),
        failing: Sequence[Causes] = (),
        error: float = 0.0,
        responses: Mapping[Causes, float] | None = None,
        sampled: Mapping[Causes, float] | None = None,
        unnamed: Sequence[str] = (),
    ) -> None:
        self.evidence = {frozenset(causes): value for causes, value in evidence.items()}
        self.alternatives, self.failing = alternatives, [frozenset(causes) for causes in failing]
        self.unnamed = {name: ("time", f"something like {name}") for name in unnamed}
        self.candidates, self.error = (*NAMES, *unnamed), error
        self.responses = {frozenset(causes): value for causes, value in (responses or {}).items()}
        self.sampled = {frozenset(causes): value for causes, value in (sampled or {}).items()}
        self.asked: list[frozenset[str]] = []

    def value(self, causes: Causes) -> float:
        return self.evidence.get(frozenset(causes), -1.0) if causes else 0.0

    def fit_all(self, wanted: Sequence[FitRequest]) -> list[CauseFit | FailedFit]:
        self.asked += [frozenset(causes) for causes, _ in wanted]
        return [
            FailedFit(causes, "no descent")
            if frozenset(causes) in self.failing
            else CauseFit(causes, self.value(causes), (), {}, True, None)
            for causes, _ in wanted
        ]

    def log_gains(self, fits: Sequence[CauseFit], supersets: Sequence[Sequence[Causes]]) -> list[Any]:
        return [
            np.array([self.value(causes) - fit.log_evidence + self.error for causes in sets])
            for fit, sets in zip(fits, supersets, strict=True)
        ]

    def responses_beside(self, fits: Sequence[CauseFit]) -> NeutralResponses:
        gains = [[self.responses.get(frozenset(fit.causes), -1.0)] for fit in fits]
        return NeutralResponses([("time", "drag that changes with time")], np.array(gains))

    def sampled_evidence(self, fit: CauseFit) -> SampledEvidence:
        own = frozenset(fit.causes)
        return SampledEvidence(self.sampled.get(own, fit.log_evidence), 100.0 if own in self.sampled else 1.0)


def selected(evidence: Mapping[Causes, float], **options: Any) -> Any:
    return weigh(Written(evidence, **options))  # type: ignore[arg-type]


def test_probabilities_are_evidence_times_prior_of_every_set() -> None:
    """By hand, over all sets of at most three of four causes and the response beside the sets of at most two."""
    evidence = {(DRAG,): 6.0, (DRAG, CLOCK): 9.0, (DRAG, LIFT, CLOCK): 11.0}
    found = selected(evidence, responses={(DRAG,): 2.0, (): 0.5})
    masses: dict[tuple[frozenset[str], int], float] = {}
    for size in range(4):
        for causes in map(frozenset, itertools.combinations(NAMES, size)):
            known = {frozenset(key): value for key, value in evidence.items()}
            log = known.get(causes, -1.0) if causes else 0.0
            masses[causes, 0] = log - (math.log(4.0) + 3.0 * (size - 1) if causes else 0.0)
            if size < 3:
                gain = {frozenset({DRAG}): 2.0, frozenset(): 0.5}.get(causes, -1.0)
                masses[causes, 1] = log + gain - math.log(4.0) - 3.0 * size
    beside = {frozenset(c) for c in found.posterior if len(c) < 2} | {frozenset({DRAG, CLOCK})}
    total = sum(math.exp(m) for (causes, r), m in masses.items() if not r or causes in beside)
    for causes in ((), (DRAG,), (DRAG, CLOCK), (DRAG, LIFT, CLOCK)):
        own = [m for (key, r), m in masses.items() if key == frozenset(causes) and (not r or key in beside)]
        assert found.posterior[causes] == pytest.approx(sum(map(math.exp, own)) / total, rel=0.02)
    assert found.nothing == pytest.approx(1.0 / total, rel=0.02)
    assert sum(found.posterior.values()) == pytest.approx(1.0)


def test_supersets_count_with_what_their_prior_leaves_them() -> None:
    found = selected({(DRAG,): 40.0, (DRAG, CLOCK): 42.9})
    assert [candidate.causes for candidate in found.ranking[:2]] == [(DRAG,), (DRAG, CLOCK)]
    assert found.posterior[DRAG, CLOCK] / found.posterior[DRAG,] == pytest.approx(math.exp(2.9 - 3.0))


def test_each_cause_beyond_the_first_is_charged_once() -> None:
    found = selected({(DRAG,): 20.0, (CLOCK,): 15.0, (DRAG, CLOCK): 50.0, (DRAG, CLOCK, LIFT): 70.0})
    assert found.ranking[0].causes == (DRAG, LIFT, CLOCK)
    assert found.ranking[0].score == 70.0 - 6.0


def test_causes_that_mask_each_other_are_fitted_together() -> None:
    found = selected({(LIFT, CLOCK): 30.0, (DRAG,): 8.0, (DRAG, LIFT): 8.5})
    assert found.ranking[0].causes == (LIFT, CLOCK)


class Misled(Written):
    """A model whose causes, alone, lie so far from where they are together that neither says what the other adds."""

    def log_gains(self, fits: Sequence[CauseFit], supersets: Sequence[Sequence[Causes]]) -> list[Any]:
        found = super().log_gains(fits, supersets)
        return [gains if not fit.causes else np.minimum(gains, 1.0) for fit, gains in zip(fits, found, strict=True)]


def test_a_set_is_estimated_from_whichever_part_has_most_of_it() -> None:
    evidence = {(DRAG,): 80.0, (CLOCK,): 30.0, (FLOODING,): 85.0, (DRAG, CLOCK): 120.0}
    found = weigh(Misled(evidence))  # type: ignore[arg-type]
    assert found.ranking[0].causes == (DRAG, CLOCK)
    assert found.posterior[DRAG, CLOCK] > 0.9


def test_sets_that_add_nothing_are_not_fitted_and_their_probability_is_stated() -> None:
    model = Written({(DRAG,): 40.0, (DRAG, CLOCK): 39.5})
    found = weigh(model)  # type: ignore[arg-type]
    assert frozenset({DRAG, CLOCK}) not in model.asked
    assert found.posterior[DRAG, CLOCK] == pytest.approx(found.posterior[DRAG,] * math.exp(-3.5), rel=0.05)
    assert found.not_computed == pytest.approx(found.posterior[DRAG, CLOCK], rel=0.05)


def test_a_set_that_was_fitted_counts_as_it_was() -> None:
    found = selected({(DRAG,): 40.0, (DRAG, CLOCK): 47.0}, error=3.0)
    assert found.posterior[DRAG, CLOCK] / found.posterior[DRAG,] == pytest.approx(math.exp(7.0 - 3.0))


def test_evidence_by_importance_sampling_decides_where_it_is_known() -> None:
    """Linearised, the first is 3.5 nats better; by importance sampling 1.5."""
    found = selected({(DRAG,): 11.0, (CLOCK,): 7.5}, sampled={(DRAG,): 9.0})
    assert found.posterior[DRAG,] / found.posterior[CLOCK,] == pytest.approx(math.exp(1.5), rel=0.05)


def test_a_response_is_what_no_cause_explains() -> None:
    found = selected({(DRAG,): 10.0}, responses={(DRAG,): 30.0})
    assert found.none_of_these > 0.99
    assert max(found.posterior, key=lambda causes: found.posterior[causes]) == (DRAG,)
    assert found.nothing < 1e-6


OTHER, ANOTHER = "lift-by-depth", "drag-by-depth"


def test_a_response_stands_beside_what_has_no_name_too() -> None:
    """With half the prior of the effect without a name, and half of that of a further cause."""
    found = selected({(OTHER,): 40.0, (DRAG,): 30.0}, unnamed=(OTHER,), responses={(OTHER,): 12.0, (DRAG,): 12.0})
    assert max(found.posterior, key=lambda causes: found.posterior[causes]) == (OTHER,)
    by_words = {what: probability for _, what, probability in found.responses}
    odds = math.exp(12.0 - 3.0 - math.log(2.0))
    assert by_words["drag that changes with time"] == pytest.approx(odds / (1.0 + odds), abs=0.01)


def test_an_effect_and_a_smooth_response_in_the_same_words_count_once() -> None:
    model = Written({(OTHER,): 40.0}, unnamed=(OTHER,), responses={(OTHER,): 12.0})
    model.unnamed[OTHER] = ("time", "drag that changes with time")
    (told,) = weigh(model).responses  # type: ignore[arg-type]
    assert told.probability == pytest.approx(1.0)


def test_what_has_no_name_has_together_the_prior_of_one_effect_with_a_name() -> None:
    """By hand: half of it two effects, half of it something smooth."""
    found = selected({(DRAG,): 20.0, (OTHER,): 20.0, (ANOTHER,): -50.0}, responses={(): 20.0}, unnamed=(OTHER, ANOTHER))
    assert found.posterior[OTHER,] / found.posterior[DRAG,] == pytest.approx(0.25, rel=0.05)
    of_smooth = {what: p for _, what, p in found.responses}["drag that changes with time"]
    assert of_smooth / found.posterior[DRAG,] == pytest.approx(0.5, rel=0.05)
    assert found.catalogue == len(NAMES)


def test_an_effect_without_a_name_is_fitted_beside_named_ones_and_is_none_of_these() -> None:
    found = selected({(DRAG,): 20.0, (OTHER,): 25.0, (DRAG, OTHER): 60.0}, unnamed=(OTHER, ANOTHER))
    assert found.ranking[0].causes == (DRAG, OTHER)
    assert found.none_of_these > 0.99
    assert {what: p for _, what, p in found.responses}[f"something like {OTHER}"] > 0.99


def test_there_is_at_most_one_effect_without_a_name() -> None:
    found = selected({(OTHER, ANOTHER): 90.0, (OTHER, DRAG, CLOCK): 90.0, (DRAG,): 20.0}, unnamed=(OTHER, ANOTHER))
    assert all(sum(name in (OTHER, ANOTHER) for name in causes) < 2 for causes in found.posterior)
    assert all(len(causes) < 3 for causes in found.posterior if OTHER in causes)


def test_alternatives_are_never_together() -> None:
    model = Written({(DRAG,): 30.0, (DRAG, CLOCK): 60.0}, alternatives=[frozenset({DRAG, CLOCK})])
    found = weigh(model)  # type: ignore[arg-type]
    assert found.ranking[0].causes == (DRAG,)
    assert frozenset({DRAG, CLOCK}) not in model.asked


def test_failures_are_kept_and_the_others_judged() -> None:
    found = selected({(DRAG,): 20.0}, failing=[(LIFT,)])
    assert found.ranking[0].causes == (DRAG,)
    assert [failure.causes for failure in found.failed if len(failure.causes) == 1] == [(LIFT,)]


def test_without_a_base_model_there_is_no_selection() -> None:
    with pytest.raises(RunError, match="the base model cannot be fitted: no descent"):
        selected({}, failing=[()])


def test_the_credible_set_holds_the_rivals() -> None:
    found = selected({(DRAG,): 20.0, (CLOCK,): 19.0, (LIFT,): 9.0})
    assert rivals(found.posterior, found.ranking[0].causes) == [(CLOCK,)]
    assert credible_set(found.posterior)[:2] == [(DRAG,), (CLOCK,)]


def test_a_set_that_hardly_can_be_is_told_with_its_part_and_one_that_may_be_by_itself() -> None:
    """A further cause counts by itself from e⁻³ of the odds on, a first one always."""
    posterior = {(): 0.1, (DRAG,): 0.7, (CLOCK,): 0.02, (LIFT,): 0.004, (DRAG, CLOCK): 0.141}
    posterior |= {(DRAG, LIFT): 0.03, (FLOODING, LIFT): 0.018, (DRAG, CLOCK, LIFT): 0.002}
    told = told_together(posterior, 10)
    alone = {(DRAG,): 0.73, (DRAG, CLOCK): 0.143, (): 0.1, (CLOCK,): 0.02, (FLOODING, LIFT): 0.018, (LIFT,): 0.004}
    assert told == pytest.approx(alone)


def test_effect_free_data_keep_the_base_model() -> None:
    found = selected({})
    assert found.credible[0] == ()
    assert found.ranking[0].score < 0.0
