"""Verdicts, posteriors and credible sets by the rules of the contract."""

import itertools
import math
from dataclasses import replace
from types import SimpleNamespace

import pytest

from missionplan.diagnosis import diagnose as diagnosing
from missionplan.diagnosis import pipeline
from missionplan.diagnosis.inference.model import CauseFit, HeldOutScore, compare_held_out
from missionplan.diagnosis.inference.selection import (
    Candidate,
    Selection,
    credible_set,
    inclusion,
    log_prior,
    probabilities,
    rivals,
)
from missionplan.diagnosis.next_trial import belief
from missionplan.diagnosis.pipeline import claimed_set, verdict_of
from missionplan.results.learned.evidence import GroupScore

GOOD, BAD = (
    compare_held_out(
        [HeldOutScore(name, 0.0, 1.0, 1, 1) for name in "abc"], [HeldOutScore(name, gain, 1.0, 1, 1) for name in "abc"]
    )
    for gain in (1.0, -1.0)
)


def posterior(*entries):
    """Probabilities of sets with these log Bayes factors over none, in a catalogue of twelve."""
    return probabilities({(): 0.0} | {causes: log + log_prior(len(causes), 12) for causes, log in entries})


def selection(*entries):
    ranking = tuple(
        sorted((Candidate(CauseFit(c, 0.0, (), {}, True, None), b) for c, b in entries), key=lambda one: -one.score)
    )
    return Selection(CauseFit((), 0.0, (), {}, True, None), ranking, (), 12)


def reading(posterior, nothing, none_of_these):
    """What a posterior says, by its probabilities, of nothing and of what has no name."""
    return replace(selection(), posterior=posterior, nothing=nothing, responses=(("time", "a drift", none_of_these),))


def test_score_charges_each_further_cause():
    ranking = selection((("a",), 10.0), (("a", "b"), 14.0), (("a", "b", "c"), 14.5)).ranking
    assert [candidate.score for candidate in ranking] == [11.0, 10.0, 8.5]


A, B, STATISTICAL = ("compass-bias",), ("speed-scale",), ("persistent-error",)
BOTH = ("compass-bias", "speed-scale")


@pytest.mark.parametrize(
    ("posterior", "nothing", "none_of_these", "expected"),
    [
        ({(): 0.06, A: 0.94}, 0.06, 0.0, "adequate"),
        ({(): 0.9, A: 0.1}, 0.01, 0.9, "unexplained"),
        ({(): 0.8, A: 0.2}, 0.2, 0.7, "unexplained"),
        ({(): 0.8, A: 0.2}, 0.45, 0.4, "adequate"),
        ({STATISTICAL: 0.97, A: 0.03}, 0.0, 0.0, "unexplained"),
        ({A: 0.97, B: 0.03}, 0.0, 0.0, "explained"),
        ({A: 0.7, BOTH: 0.27, B: 0.03}, 0.0, 0.0, "explained"),
        ({A: 0.7, B: 0.3}, 0.0, 0.0, "ambiguous"),
        ({A: 0.97, B: 0.03}, 0.0, 0.6, "partly-explained"),
        ({A: 0.97, B: 0.03}, 0.0, 0.1, "ambiguous"),
        ({A: 0.6, B: 0.4}, 0.0, 0.6, "unexplained"),
        ({("response",): 0.97, A: 0.03}, 0.0, 0.97, "unexplained"),
        ({("compass-bias", "response"): 0.6, A: 0.4}, 0.0, 0.6, "partly-explained"),
        ({("compass-bias", "response"): 0.6, ("response",): 0.4}, 0.0, 1.0, "unexplained"),
    ],
)
def test_verdict_is_the_first_that_fits(posterior, nothing, none_of_these, expected):
    assert verdict_of(reading(posterior, nothing, none_of_these)) == expected


def test_a_cause_in_the_place_of_which_something_without_a_name_may_be_is_not_claimed():
    assert claimed_set(reading({A: 0.6, B: 0.4}, 0.0, 0.6)) == ()
    assert claimed_set(reading({A: 0.96, B: 0.04}, 0.0, 0.6)) == A
    assert claimed_set(reading({("response",): 0.6, A: 0.4}, 0.0, 0.6)) == ("response",)
    doubtful = {("compass-bias", "response"): 0.6, ("speed-scale", "response"): 0.3}
    assert claimed_set(reading({**doubtful, ("response",): 0.1}, 0.0, 1.0)) == ("response",)
    assert claimed_set(reading({**doubtful, B: 0.1}, 0.0, 0.9)) == ()
    assert claimed_set(reading({("compass-bias", "response"): 0.96, B: 0.04}, 0.0, 0.96)) == (
        "compass-bias",
        "response",
    )


def test_a_cause_that_changes_explains_a_part():
    assert verdict_of(reading({A: 1.0}, 0.0, 0.0), is_constant=False) == "partly-explained"


def test_sets_told_as_one_are_one_explanation():
    found = reading({A: 0.6, B: 0.38, (): 0.02}, 0.02, 0.0)
    assert verdict_of(found) == "ambiguous"
    assert verdict_of(replace(found, families=((A, B),))) == "explained"


def test_rivals_are_within_3_nats():
    assert rivals(posterior((("a",), 11.2), (("b",), 7.0)), ("a",)) == []
    found = posterior((("a",), 9.1), (("b",), 7.0))
    assert rivals(found, ("a",)) == [("b",)]
    assert found["a",] / found["b",] == pytest.approx(math.exp(2.1))


def test_supersets_of_the_claimed_set_count_and_are_no_rivals():
    found = posterior((("a",), 10.0), (("a", "b"), 12.0), (("c",), 9.0))
    assert rivals(found, ("a",)) == [("c",)]
    assert found["a", "b"] / found["a",] == pytest.approx(math.exp(2.0 - 3.0))
    assert inclusion(found)["a"] == pytest.approx(found["a",] + found["a", "b"])


def test_each_set_has_the_prior_of_the_contract():
    found = posterior((("a",), 0.0), (("b",), 0.0))
    assert found[()] == pytest.approx(12.0 / 14.0)
    assert sum(found.values()) == pytest.approx(1.0)


def test_credible_set_is_the_smallest_that_holds_95_percent():
    shares = {("a",): 0.6, ("b",): 0.3, (): 0.08, ("c",): 0.02}
    chosen = credible_set(shares)
    assert chosen == [("a",), ("b",), ()]
    for smaller in itertools.combinations(shares, 2):
        assert sum(shares[causes] for causes in smaller) < 0.95


def test_gain_is_paired():
    assert GOOD.gain.log_score_gain == 3.0
    assert GOOD.gain.paired_se == 0.0
    assert (GOOD.gain.groups_improved, GOOD.gain.groups) == (3, 3)


def scored(*groups):
    """Held-out scores of groups by log score, sum of squared errors and count."""
    return tuple(
        SimpleNamespace(group=name, log_score=log, squared_error=squares, count=count)
        for name, log, squares, count in groups
    )


def test_held_out_scores_are_those_of_the_set_that_is_believed():
    base, extended = (
        scored(("a", -3.0, 8.0, 2), ("b", -1.0, 27.0, 3)),
        scored(("a", -2.0, 2.0, 2), ("b", -4.0, 12.0, 3)),
    )
    comparison = SimpleNamespace(base=base, extended=extended, gain=SimpleNamespace(log_score_gain=0.1))
    ranking = (SimpleNamespace(causes=("x",)),)
    found = SimpleNamespace(
        held_out={("x",): comparison},
        best=SimpleNamespace(causes=("x",)),
        selection=SimpleNamespace(ranking=ranking, base=None),
    )
    assert [vars(each) for each in diagnosing.group_scores(found)] == [
        vars(GroupScore("a", -3.0, -2.0, 2.0, 1.0)),
        vars(GroupScore("b", -1.0, -4.0, 3.0, 2.0)),
    ]
    assert pipeline._held_out_scores(found) == extended
    ahead = SimpleNamespace(is_better_ahead=lambda base, best: ahead.said)
    for gain, said, better in ((0.1, True, True), (0.1, False, False), (-0.1, True, False)):
        comparison.gain.log_score_gain, ahead.said = gain, said
        assert pipeline._predicts_better(ahead, found) is better
    found.best.causes = ()
    assert pipeline._held_out_scores(found) == base
    found.best.causes = ("y",)
    assert (pipeline._held_out_scores(found), pipeline._predicts_better(ahead, found)) == ((), None)
    found.selection.ranking = ()
    assert diagnosing.group_scores(found) == ()


@pytest.mark.parametrize(
    ("best", "score", "contends"), [(4.0, 0.1, True), (4.0, -0.1, False), (9.0, 3.1, True), (9.0, 2.9, False)]
)
def test_what_is_held_out_is_better_than_nothing_and_near_the_best(best, score, contends):
    """Within six nats of the best."""
    selection = SimpleNamespace(ranking=(SimpleNamespace(score=best),))
    assert bool(pipeline._contends(SimpleNamespace(score=score), selection)) is contends


def test_trials_are_designed_for_the_likeliest_sets_whose_probabilities_are_shared_anew(monkeypatch):
    """Of weights 10, 5, 4, 0.3 and two more, five are looked at, and those below a fiftieth of these are left out."""
    weights = (10.0, 5.0, 4.0, 0.3, 0.2, 0.1)
    monkeypatch.setattr(belief, "possible_fits", lambda *_: [(str(k), k, weight) for k, weight in enumerate(weights)])
    kept, left = belief.likely_fits((), None)
    assert [(fit, weight) for _, fit, weight in kept] == [(k, pytest.approx(weights[k] / 19.0)) for k in (0, 1, 2)]
    assert [(fit, weight) for _, fit, weight in left] == [(k, pytest.approx(weights[k] / 19.6)) for k in (3, 4, 5)]
