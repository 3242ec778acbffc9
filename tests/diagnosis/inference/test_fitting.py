"""Fits of several sets: which models fit them together, and what is relinearised then."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from missionplan.diagnosis.dives.model import DescentModel
from missionplan.diagnosis.inference.model import CauseFit, FailedFit, FitRequest, FitsTogether, fitted
from missionplan.diagnosis.legs.model import TransitModel
from missionplan.diagnosis.summaries import SummaryModel
from missionplan.diagnosis.tank.model import TankModel

Fits = list[CauseFit | FailedFit]
REQUESTS: list[FitRequest] = [(("drag-bias",), ()), (("clock-offset",), ()), (("slow-flooding",), ())]
EVIDENCE = {"drag-bias": 3.0, "clock-offset": 9.0}


@dataclass(frozen=True)
class OneByOne:
    """A model of which one set cannot be fitted."""

    def fit_all(self, wanted: Sequence[FitRequest]) -> Fits:
        return [
            CauseFit(causes, EVIDENCE[causes[0]], (), {}, True, None)
            if causes[0] in EVIDENCE
            else FailedFit(causes, "no descent")
            for causes, _ in wanted
        ]


@dataclass(frozen=True)
class Together(OneByOne):
    """Its fits gain by another linearisation; the best of all is told to each."""

    def relinearised(self, fits: Sequence[CauseFit | FailedFit], best: float) -> Fits:
        return [replace(fit, log_evidence=best + 1.0) if isinstance(fit, CauseFit) else fit for fit in fits]


def evidence(fits: Sequence[CauseFit | FailedFit]) -> list[float | None]:
    return [fit.log_evidence if isinstance(fit, CauseFit) else None for fit in fits]


def test_sets_fitted_together_are_relinearised_with_the_best_of_all() -> None:
    assert evidence(fitted(Together(), REQUESTS)) == [10.0, 10.0, None]  # type: ignore[arg-type]


def test_sets_fitted_one_by_one_stay_as_they_are() -> None:
    assert evidence(fitted(OneByOne(), REQUESTS)) == [3.0, 9.0, None]  # type: ignore[arg-type]


def test_only_models_that_simulate_all_sets_at_once_fit_them_together() -> None:
    assert issubclass(DescentModel, FitsTogether)
    assert issubclass(SummaryModel, FitsTogether)
    assert not issubclass(TransitModel, FitsTogether)
    assert not issubclass(TankModel, FitsTogether)
