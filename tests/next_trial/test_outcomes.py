"""What outcomes of a trial mean: how they come out, and the rule that tells best whether the choice changes."""

from types import SimpleNamespace

import numpy as np
import pytest

from missionplan.diagnosis.coordinates import Coordinate
from missionplan.diagnosis.next_trial import SimulatedTrial, instruments_for, measured, outcome_rule, outcomes
from missionplan.diagnosis.next_trial.experiment import DecisionProblem
from missionplan.diagnosis.next_trial.leg_trials import _from_record_to_record

DRAWS = 2000
SLOW, CARRIED = ("speed-scale",), ("mean-current",)


def believed(causes, *parameters):
    coordinates = tuple(
        SimpleNamespace(kind="strength", effect=effect, name=name)
        for effect, name in (p.split(".") for p in parameters)
    )
    return SimpleNamespace(causes=causes, coordinates=coordinates)


@pytest.fixture
def sets():
    return believed(SLOW, "speed-scale.fraction"), believed(CARRIED, "mean-current.east")


@pytest.fixture
def trial():
    """Three of ten vehicles are slow, and one that loses more than 0.12 has a shorter d_max chosen."""
    fraction = np.linspace(-0.3, 0.0, DRAWS)
    slow = fraction < -0.12
    probabilities = np.stack([np.where(slow, 1.0, 0.2), np.where(slow, 0.0, 0.8)], axis=1)
    means = (fraction[:, None], 0.1 * np.random.default_rng(1).standard_normal((DRAWS, 1)))
    return SimulatedTrial(probabilities, means, np.where(slow, 0, 1))


@pytest.fixture
def problem(trial):
    losses = np.tile([3.0, 2.0, 4.0], (DRAWS, 1))
    losses[trial.chosen == 0, 1] = 5.0
    weight = np.where(trial.chosen == 0, 0.3, 0.7)
    for chosen in (0, 1):
        weight[trial.chosen == chosen] /= np.sum(trial.chosen == chosen)
    return DecisionProblem(np.array([1000.0, 2000.0, 3000.0]), losses, weight)


def test_outcomes_are_told_by_cause_and_choice_with_what_each_saves(sets, problem, trial):
    assert problem.choice == 1
    found = outcomes(sets, problem, trial)
    assert [(each.causes, each.probability, each.saving) for each in found] == [
        (CARRIED, pytest.approx(0.7), pytest.approx(0.0)),
        (SLOW, pytest.approx(0.3), pytest.approx(2.0)),
    ]
    assert [vars(each)["choice"] for each in found] == [2000.0, 1000.0]


def test_the_rule_is_the_threshold_between_the_choices(sets, problem, trial):
    rule = outcome_rule(sets, problem, trial)
    assert rule is not None
    assert (rule.effect, rule.name, rule.above, rule.causes) == ("speed-scale", "fraction", False, SLOW)
    assert -0.12 <= rule.threshold <= -0.12 * 0.2 + 0.001, "between both, where the others count by their probability"
    assert rule.agreement == pytest.approx(1.0, abs=0.05)
    assert rule.choice == 1000.0


def test_there_is_no_rule_where_no_parameter_tells(sets, problem, trial):
    rng = np.random.default_rng(3)
    blind = SimulatedTrial(trial.probabilities * 0.0 + 0.5, (rng.standard_normal((DRAWS, 1)),) * 2, trial.chosen)
    assert outcome_rule(sets, problem, blind) is None
    kept = SimulatedTrial(trial.probabilities, trial.means, np.ones(DRAWS, dtype=int))
    assert outcome_rule(sets, problem, kept) is None, "the choice never changes"


def test_what_differs_from_record_to_record_is_the_current_s_own_uncertainty_and_a_spike():
    """Toward east and north; of a set that lacks the effect an instrument reads nothing, to within that spike."""
    east, north, angle = (Coordinate.__new__(Coordinate) for _ in range(3))
    for each, effect, name, spike in (
        (east, "mean-current", "east", 0.6),
        (north, "mean-current", "north", 0.6),
        (angle, "compass-bias", "angle", 0.3),
    ):
        vars(each).update(effect=effect, name=name, spike=spike, kind="strength")
    model = SimpleNamespace(coordinates=(east, north, angle), current_sd=(0.8, 2.5))
    assert _from_record_to_record(model) == pytest.approx([1.0, np.hypot(0.6, 2.5), 0.3])
    sets = [
        SimpleNamespace(coordinates=own, explanation=SimpleNamespace(mean=np.full(len(own), 0.05)))
        for own in ((angle,), (east, north))
    ]
    swing = SimpleNamespace(sd=0.4)
    found = measured(swing, angle, sets)
    assert [(each.centre.tolist(), float(each.noise[0, 0])) for each in found] == [
        ([0.05], pytest.approx(0.16)),
        ([0.0], pytest.approx(0.25)),
    ]


def test_instruments_are_offered_for_what_they_measure_of_causes_alone():
    def own(effect, name, kind="strength"):
        return Coordinate(effect, name, kind, 0.0, 1.0, 0.1)

    bias, lift, depth = (
        own("compass-bias", "angle"),
        own("stratification", "lift"),
        own("stratification", "depth", "shape"),
    )
    scale = own("speed-scale", "fraction")
    sets = [SimpleNamespace(causes=("compass-bias",), coordinates=(bias, lift, scale)),
            SimpleNamespace(causes=("stratification", "speed-scale"), coordinates=(lift, depth, scale))]  # fmt: skip
    assert {each.key: instrument.parameter for each, instrument in instruments_for(sets).items()} == {
        bias.key: "angle",
        lift.key: "lift",
    }
    assert list(instruments_for(sets[:1])) == [bias]  # the lift is no cause there
