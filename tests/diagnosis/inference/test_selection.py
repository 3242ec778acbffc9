"""Selection of causes by evidence, on a model whose evidence is written down."""

from collections.abc import Mapping, Sequence
from typing import Any

import pytest

from missionplan.diagnosis.inference.model import CauseFit, FailedFit, FitRequest
from missionplan.diagnosis.inference.posterior import credible_set, posteriors, rivals
from missionplan.diagnosis.inference.selection import select
from missionplan.errors import RunError
from missionplan.results.learned.evidence import Causes, ParameterEstimate

DRAG, FLOODING, LIFT, CLOCK = "drag-bias", "slow-flooding", "stratification", "clock-offset"


class Written:
    """A model whose sets have the evidence given, and -1 otherwise; a set in `impossible` is so until it is fitted from a fresh start."""

    def __init__(
        self,
        evidence: Mapping[Causes, float],
        share: float = 0.02,
        alternatives: Sequence[frozenset[str]] = (),
        impossible: Mapping[Causes, float] | None = None,
        failing: Sequence[Causes] = (),
    ) -> None:
        self.evidence = {frozenset(causes): value for causes, value in evidence.items()}
        self.share, self.alternatives, self.failing = share, alternatives, [frozenset(causes) for causes in failing]
        self.impossible = {frozenset(causes): value for causes, value in (impossible or {}).items()}
        self.candidates = (DRAG, FLOODING, LIFT, CLOCK)
        self.asked: list[frozenset[str]] = []

    def minimum_evidence_gain(self, causes: Causes) -> float:
        return self.share

    def may_be_multimodal(self, causes: Causes) -> bool:
        return bool({FLOODING, LIFT} & set(causes))

    def value(self, causes: Causes) -> float:
        return self.evidence.get(frozenset(causes), -1.0) if causes else 0.0

    def fit_all(self, wanted: Sequence[FitRequest]) -> list[CauseFit | FailedFit]:
        self.asked += [frozenset(causes) for causes, _ in wanted]
        return [self._fit(causes, bool(near)) for causes, near in wanted]

    def _fit(self, causes: Causes, near: bool) -> CauseFit | FailedFit:
        if frozenset(causes) in self.failing:
            return FailedFit(causes, "no descent")
        shapes = tuple(
            ParameterEstimate(name, "time" if name == FLOODING else "depth", 1.0, 0.1, 0.8, 1.2, "s")
            for name in causes
            if name in (FLOODING, LIFT)
        )
        if near and frozenset(causes) in self.impossible:
            return CauseFit(causes, self.impossible[frozenset(causes)], shapes, {}, False, None)
        return CauseFit(causes, self.value(causes), shapes, {}, True, None)

    def estimated_gain(self, causes: Causes, parent: CauseFit) -> float:
        return self.value(causes) - self.value(parent.causes)


def selected(evidence: Mapping[Causes, float], **options: Any) -> Any:
    return select(Written(evidence, **options))  # type: ignore[arg-type]


def test_a_cause_alone_and_what_hardly_adds_to_it() -> None:
    found = selected({(DRAG,): 40.0, (DRAG, CLOCK): 42.9, (LIFT,): 2.0})
    assert [candidate.causes for candidate in found.ranking[:2]] == [(DRAG,), (DRAG, CLOCK)]
    assert found.ranking[1].score == pytest.approx(39.9)


def test_each_cause_beyond_the_first_is_penalised() -> None:
    found = selected({(DRAG,): 20.0, (CLOCK,): 15.0, (DRAG, CLOCK): 50.0, (DRAG, CLOCK, LIFT): 70.0})
    assert found.ranking[0].causes == (DRAG, LIFT, CLOCK)
    assert found.ranking[0].score == 70.0 - 6.0


@pytest.mark.parametrize(("share", "best"), [(0.02, (FLOODING, CLOCK)), (0.05, (FLOODING,))])
def test_beside_a_cause_of_uncertain_shape_a_further_one_must_add_more(share: float, best: Causes) -> None:
    found = selected({(FLOODING,): 100.0, (FLOODING, CLOCK): 104.0}, share=share)
    assert found.ranking[0].causes == best


def test_causes_that_mask_each_other_are_fitted_together() -> None:
    found = selected({(LIFT, CLOCK): 30.0, (DRAG,): 8.0, (DRAG, LIFT): 8.5})
    assert found.ranking[0].causes == (LIFT, CLOCK)


def test_alternatives_are_never_together() -> None:
    model = Written({(DRAG,): 30.0, (DRAG, CLOCK): 60.0}, alternatives=[frozenset({DRAG, CLOCK})])
    found = select(model)  # type: ignore[arg-type]
    assert found.ranking[0].causes == (DRAG,)
    assert frozenset({DRAG, CLOCK}) not in model.asked


def test_a_pair_whose_search_ended_at_an_impossible_fit_is_fitted_afresh() -> None:
    evidence = {(FLOODING,): 20.0, (LIFT,): 15.0, (FLOODING, LIFT): 60.0}
    found = selected(evidence, impossible={(FLOODING, LIFT): 55.0})
    assert found.ranking[0].causes == (FLOODING, LIFT)
    assert found.ranking[0].log_bayes_factor == 60.0
    assert not found.impossible


def test_failures_are_kept_and_the_others_judged() -> None:
    found = selected({(DRAG,): 20.0}, failing=[(LIFT,)])
    assert found.ranking[0].causes == (DRAG,)
    assert [failure.causes for failure in found.failed if len(failure.causes) == 1] == [(LIFT,)]


def test_without_a_base_model_there_is_no_selection() -> None:
    with pytest.raises(RunError, match="the base model cannot be fitted: no descent"):
        selected({}, failing=[()])


def test_the_credible_set_holds_the_rivals() -> None:
    found = selected({(DRAG,): 20.0, (CLOCK,): 19.0, (LIFT,): 9.0})
    claimed = found.ranking[0]
    posterior = posteriors(found)
    assert rivals(posterior, claimed.causes) == [(CLOCK,)]
    assert sum(posterior.values()) == pytest.approx(1.0)
    assert credible_set(posterior)[:2] == [(DRAG,), (CLOCK,)]


def test_effect_free_data_keep_the_base_model() -> None:
    found = selected({})
    assert credible_set(posteriors(found))[0] == ()
    assert found.ranking[0].score < 0.0
