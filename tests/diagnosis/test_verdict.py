"""Verdicts, posteriors and credible sets by the rules of the contract."""

import itertools
import math

import pytest

from missionplan.diagnosis.inference.cross_validation import compare_held_out
from missionplan.diagnosis.inference.model import CauseFit, HeldOutScore
from missionplan.diagnosis.inference.posterior import credible_set, posteriors, rivals
from missionplan.diagnosis.inference.selection import Candidate, Selection
from missionplan.diagnosis.verdict import claim, verdict
from missionplan.results.learned.evidence import Discrepancy

GOOD, BAD = (
    compare_held_out(
        [HeldOutScore(name, 0.0, 1.0, 1, 1) for name in "abc"], [HeldOutScore(name, gain, 1.0, 1, 1) for name in "abc"]
    )
    for gain in (1.0, -1.0)
)


def selection(*entries):
    ranking = tuple(
        sorted((Candidate(CauseFit(c, 0.0, (), {}, True, None), b) for c, b in entries), key=lambda one: -one.score)
    )
    return Selection(CauseFit((), 0.0, (), {}, True, None), ranking, (), (), 12)


def left(significant):
    return Discrepancy(5.0 if significant else 0.0, "time" if significant else None, (), ())


def test_score_charges_each_further_cause():
    ranking = selection((("a",), 10.0), (("a", "b"), 14.0), (("a", "b", "c"), 14.5)).ranking
    assert [candidate.score for candidate in ranking] == [11.0, 10.0, 8.5]


@pytest.mark.parametrize(
    ("entries", "gain", "significant", "expected"),
    [
        ([(("a",), 3.9)], GOOD, False, "adequate"),
        ([(("a",), 3.9)], GOOD, True, "unexplained"),
        ([(("a",), 4.1)], GOOD, False, "explained"),
        ([(("a",), 8.0)], BAD, False, "adequate"),
        ([(("a",), 8.0), (("b",), 4.0)], GOOD, False, "explained"),
        ([(("a",), 8.0), (("b",), 5.5)], GOOD, False, "ambiguous"),
        ([(("a",), 8.0), (("b",), 5.5)], GOOD, True, "partly-explained"),
        ([(("a",), 8.0), (("a", "b"), 10.5)], GOOD, False, "explained"),
        ([], None, False, "adequate"),
    ],
)
def test_verdict_is_the_first_that_fits(entries, gain, significant, expected):
    assert verdict(claim(selection(*entries), gain), left(significant)) == expected


def test_evidence_by_importance_sampling_decides_on_rivals_and_probabilities():
    """Linearised, the first is 4.2 nats better; by importance sampling 2.1."""
    found = selection((("a",), 11.2), (("b",), 7.0))
    checked = {("a",): 9.1, ("b",): 7.0}
    assert not rivals(found, found.ranking[0])
    assert [candidate.causes for candidate in rivals(found, found.ranking[0], checked)] == [("b",)]
    assert verdict(claim(found, GOOD, checked), left(False)) == "ambiguous"
    probabilities = posteriors(found, ("a",), checked)
    assert probabilities["a",] / probabilities["b",] == pytest.approx(math.exp(2.1))


def test_supersets_of_the_claimed_set_are_no_rivals():
    found = selection((("a",), 10.0), (("a", "b"), 12.0), (("c",), 9.0))
    assert [candidate.causes for candidate in rivals(found, found.ranking[0])] == [("c",)]
    assert ("a", "b") not in posteriors(found, ("a",))


def test_each_set_has_the_prior_of_the_contract():
    found = posteriors(selection((("a",), 0.0), (("b",), 0.0)), None)
    assert found[()] == pytest.approx(12.0 / 14.0)
    assert sum(found.values()) == pytest.approx(1.0)


def test_credible_set_is_the_smallest_that_holds_95_percent():
    posterior = {("a",): 0.6, ("b",): 0.3, (): 0.08, ("c",): 0.02}
    chosen = credible_set(posterior)
    assert chosen == [("a",), ("b",), ()]
    for smaller in itertools.combinations(posterior, 2):
        assert sum(posterior[causes] for causes in smaller) < 0.95


def test_gain_is_paired():
    assert GOOD.gain.log_score_gain == 3.0
    assert GOOD.gain.paired_se == 0.0
    assert (GOOD.gain.groups_improved, GOOD.gain.groups) == (3, 3)
