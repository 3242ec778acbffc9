"""Which measurement discriminates, on a model whose expected log Bayes factors are written down."""

import numpy as np
import pytest
from scipy import stats

from missionplan.diagnosis.experiment_design import discriminations
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.effects import CATALOGUE
from missionplan.results.learned.evidence import ParameterEstimate

FLOODING, GAS = (CauseFit((name,), 0.0, (), {}, True, None) for name in ("slow-flooding", "trapped-gas"))
"""Sets that no instrument measures by itself."""
CLOCK = CauseFit(
    ("clock-offset",), 0.0, (ParameterEstimate("clock-offset", "time", 0.2, 0.1, 0.0, 0.4, "s"),), {}, True, None
)


class Written:
    """A model with designs whose expected log Bayes factors are given, cheapest first; `in_hand` of no further data."""

    def __init__(self, in_hand: float, **designs: float) -> None:
        self.in_hand, self.designs, self.expected = in_hand, tuple(designs), tuple(designs.values())

    def discrimination(self, first: CauseFit, second: CauseFit, design: int | None) -> float:
        return self.in_hand if design is None else self.expected[design]


def found(model: Written, first: CauseFit = FLOODING):
    return discriminations(model, first, [GAS])[0]


def test_the_cheapest_sufficient_design_is_chosen_else_the_best():
    assert found(Written(0.0, dive=2.0, two_dives=5.0, ten_dives=50.0))[0].measurement == "two_dives"
    assert found(Written(0.0, dive=2.0, two_dives=4.9, ten_dives=3.0))[0].measurement == "two_dives"


def test_a_direct_measurement_is_worth_the_mean_log_ratio_of_its_readings():
    measurement = found(Written(0.0), CLOCK)[0]
    rng = np.random.default_rng(1)
    readings = rng.normal(0.2, 0.05, 200_000)
    ratios = stats.norm.logpdf(readings, 0.2, 0.05) - stats.norm.logpdf(readings, 0.0, 0.05)
    assert measurement.measurement == CATALOGUE["clock-offset"].instrument.description
    assert measurement.expected_log_bayes_factor == pytest.approx(ratios.mean(), rel=0.01)


@pytest.mark.parametrize(("in_hand", "indistinguishable"), [(0.99, True), (1.01, False)])
def test_sets_are_indistinguishable_below_one_nat(in_hand, indistinguishable):
    assert found(Written(in_hand))[1] is indistinguishable
