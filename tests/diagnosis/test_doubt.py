"""Ambiguous verdicts are carried as explanations, and explanations are prior odds of the next diagnosis."""

from types import SimpleNamespace

import numpy as np
import pytest
import yaml

from missionplan import diagnose
from missionplan.diagnosis import explanations
from missionplan.diagnosis.explanations import Weighed, explained_missions, log_gain
from missionplan.diagnosis.given.priors import given_priors
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.inference.selection import CREDIBLE, Candidate, Selection
from missionplan.effects import CATALOGUE
from missionplan.mission import Mission, load
from missionplan.report.diagnosis.kind_report import explanations_in_words
from missionplan.report.render import render_report
from tests.fixtures import TRANSIT, dated, make_legs

KIND = {"kind": "transit", "name": "legs", "noise": {"fix": "3 m"}}
CAUSES = ("mean-current", "speed-scale", "persistent-error")
EASTWARD = (0.5 * np.pi, np.radians(10.0))


def slow(t, heading):
    return -0.06 * 1.2 * np.stack([np.sin(heading), np.cos(heading)])


def slow_and_aside(t, heading):
    """What one current does as well as a slow vehicle with a little current across."""
    return slow(t, heading) + np.array([[0.0], [0.015]])


@pytest.fixture(scope="module")
def ambiguous(tmp_path_factory, causes):
    """Diagnose legs within a narrow range of headings of a vehicle that is slow, or meets a current."""
    place = tmp_path_factory.mktemp("legs")
    (place / "dataset.yaml").write_text(yaml.safe_dump({"file": "rows.csv", **KIND}))
    dated(make_legs(30, seed=3, about=EASTWARD, error=slow_and_aside)).to_csv(place / "rows.csv", index=False)
    with causes():
        return diagnose(Mission.from_data(TRANSIT), place, plan=False), place


def shares(extended):
    """Probabilities of the sets of the draws, statistical descriptions left out."""
    found = {}
    draws = extended["posterior"].draws
    for causes, share in zip(draws.sets, draws.probabilities, strict=True):
        physical = tuple(name for name in causes if CATALOGUE[name].part == "mean")
        found[physical] = found.get(physical, 0.0) + share
    return found


def test_an_ambiguous_verdict_is_carried_as_draws(ambiguous, tmp_path):
    found, _ = ambiguous
    assert found.verdict == "ambiguous"
    folder = found.save(tmp_path / "report")
    draws = load(folder / "mission.yaml").effect_list.learned.as_seen
    assert {("speed-scale",), ("mean-current",)} <= set(draws.sets)
    named = {each.causes: each.probability for each in found.explanations if each.causes}
    told = shares(found.extended)
    total = sum(told[each.causes] for each in found.explanations)
    assert {causes: told[causes] / total for causes in named} == pytest.approx(named, abs=0.01)
    by_causes = {entry.causes: entry for entry in found.ranking}
    for causes in named:
        own = draws.of_set(draws.sets.index(causes))
        for estimate in by_causes[causes].parameters:
            values, weights = own.column((estimate.effect, estimate.name))
            assert np.average(values, weights=weights) == pytest.approx(estimate.value, rel=1e-3)
            assert np.std(values) == pytest.approx(estimate.sd, rel=0.01)
    assert list(explanations_in_words(found)) == [], "one probability of a cause is told, that of the ranking"
    assert "in each trial one of the explanations" in render_report(found).html


@pytest.mark.usefixtures("among_few")
def test_nothing_grows_on_the_same_data(ambiguous):
    found, place = ambiguous
    again = diagnose(Mission.from_data(found.extended), place, plan=False)
    assert again.verdict == "adequate"
    assert again.extended["posterior"] == found.extended["posterior"]
    carried, listed = shares(found.extended), {each.causes for each in found.explanations}
    assert listed <= {each.causes for each in again.explanations}
    total = sum(carried[each.causes] for each in again.explanations)
    assert total > CREDIBLE
    for each in again.explanations:
        assert each.prior == pytest.approx(carried[each.causes] / total, abs=0.01)
        assert each.probability == pytest.approx(each.prior, abs=1e-6)
    (words,) = explanations_in_words(again)
    assert f"(was {100.0 * again.explanations[0].prior:.1f}" in words.replace("\u202f", " ")


@pytest.mark.usefixtures("among_few")
def test_data_that_can_tell_end_the_doubt(ambiguous, folder, legs):
    found, _ = ambiguous
    later = dated(legs(30, seed=5, error=slow), hours=12.0)
    resolved = diagnose(Mission.from_data(found.extended), folder(KIND, later), plan=False)
    assert resolved.verdict == "adequate"
    assert resolved.explanations[0].causes == ("speed-scale",)
    assert resolved.explanations[0].probability > 0.995
    draws = resolved.extended["posterior"].draws
    assert draws.probability("speed-scale") > 0.995
    assert shares(resolved.extended)["speed-scale",] > 0.95
    (estimate,) = resolved.confirmed
    assert abs(estimate.value + 0.06) < 3.0 * estimate.sd


def carried(t, heading):
    return np.broadcast_to([[-0.1], [0.05]], (2, len(t)))


@pytest.mark.usefixtures("among_few")
def test_a_law_of_errors_in_doubt_does_not_take_a_new_current_for_itself(folder, transit_mission, legs):
    """The law describes the current better than nothing does, but not better than a current."""
    law = {"sigma": {"median": "0.02 m/s", "factor": 1.6}, "time": {"median": "9000 s", "factor": 2.5}}
    doubtful = transit_mission.with_(
        effects=[{"one-of": [{"probability": 0.25, "effects": [{"persistent-error": law}]}]}]
    )
    found = diagnose(doubtful, folder(KIND, legs(20, seed=4, sigma=0.02, error=carried)), plan=False)
    assert found.causes == ("mean-current",)
    assert found.explanations[0].causes == ()


@pytest.mark.parametrize(("bayes_factor", "nothing"), [(30.0, None), (5000.0, 0.0)])
def test_causes_are_worth_their_evidence_also_where_nothing_has_no_number(bayes_factor, nothing):
    """One cause of a catalogue of 20, of a record of many legs: e⁻⁵⁰⁰⁰ is none."""
    fit = CauseFit(("mean-current",), bayes_factor, (), {}, True, None)
    odds = bayes_factor - np.log(20.0)
    nothing = 1.0 / (1.0 + np.exp(odds)) if nothing is None else nothing
    share = {("mean-current",): 1.0 - nothing, (): nothing}
    found = Selection(fit, (Candidate(fit, bayes_factor),), (), 20, share, nothing=nothing)
    assert log_gain(found) == pytest.approx(odds)


@pytest.mark.usefixtures("among_few")
def test_what_was_learned_after_the_start_in_the_file_is_handed_on_until_that_is_moved(folder, transit_mission, legs):
    """Who diagnoses one mission file again and again leaves its start as it was."""
    began = "2026-04-20T00:00:00Z"  # the legs are of 28 May
    found = diagnose(
        transit_mission.with_(start=began), folder(KIND, dated(legs(12, seed=4, error=carried))), plan=False
    )
    assert found.causes == ("mean-current",)
    extended = Mission.from_data(found.extended)
    assert "mean-current" in extended.effect_list.learned.draws.effects
    moved = extended.with_(start="2026-04-21T00:00:00Z")
    assert "mean-current" not in moved.effect_list.learned.draws.effects


@pytest.mark.usefixtures("among_few")
def test_what_is_found_leaves_a_doubt_of_which_the_data_say_nothing(folder, transit_mission, legs):
    """Dives left two explanations; legs that find something else are as likely with either."""
    dives = [
        {"probability": 0.6, "effects": [{"drag-bias": {"fraction": {"mean": 0.3, "sd": 0.02}}}]},
        {"probability": 0.4, "effects": [{"depth-scale": {"fraction": {"mean": 0.05, "sd": 0.01}}}]},
    ]
    doubtful = transit_mission.with_(effects=[{"one-of": dives}])
    found = diagnose(doubtful, folder(KIND, legs(30, seed=5, error=slow)), plan=False)
    assert found.causes == ("speed-scale",)
    assert [each.probability for each in found.explanations] == pytest.approx([0.6, 0.4], abs=1e-6)
    draws = found.extended["posterior"].draws
    assert draws.probability("drag-bias") == pytest.approx(0.6, abs=1e-3)
    assert draws.probability("depth-scale") == pytest.approx(0.4, abs=1e-3)
    assert draws.probability("speed-scale") > 0.98  # with either; a response without a name has the rest
    drag, scale = (draws.column(each)[0] for each in (("drag-bias", "fraction"), ("speed-scale", "fraction")))
    assert (drag.mean(), drag.std()) == pytest.approx((0.3, 0.02), rel=0.01)
    assert abs(scale.mean() + 0.06) < 3.0 * scale.std()


@pytest.mark.slow
def test_an_explanation_that_fits_is_not_weighed_against_others_with_more_causes(folder, transit_mission, legs):
    """The explanation that the data fit needs no further cause, and the other is not rescued by one."""
    known = [
        {"probability": 0.5, "effects": [{"speed-scale": {"fraction": {"mean": -0.06, "sd": 0.01}}}]},
        {"probability": 0.5, "effects": [{"compass-bias": {"angle": {"mean": "10 deg", "sd": "1 deg"}}}]},
    ]
    found = diagnose(
        transit_mission.with_(effects=[{"one-of": known}]), folder(KIND, legs(30, seed=5, error=slow)), plan=False
    )
    assert found.verdict == "adequate"
    assert found.explanations[0].causes == ("speed-scale",)
    assert found.explanations[0].probability > 0.999


@pytest.mark.slow
def test_probabilities_are_prior_odds(folder, transit_mission, legs):
    place = folder(KIND, legs(30, seed=3, about=EASTWARD, error=slow_and_aside))
    odds = []
    for share in (0.5, 0.1):
        slower = {"probability": share, "effects": [{"speed-scale": {"fraction": {"mean": -0.05, "sd": 0.02}}}]}
        carried = {"east": {"mean": "-6 cm/s", "sd": "2 cm/s"}, "north": {"mean": "0 m/s", "sd": "2 cm/s"}}
        current = {"probability": 1.0 - share, "effects": [{"mean-current": carried}]}
        doubtful = transit_mission.with_(effects=[{"one-of": [slower, current]}])
        after = {e.causes: e.probability for e in diagnose(doubtful, place, plan=False).explanations}
        odds.append(after["speed-scale",] / after["mean-current",])
    assert odds[0] / odds[1] == pytest.approx(9.0, rel=1e-6)


def one_of(*explanations):
    return [{"speed-scale": {"fraction": 0.01}}, {"one-of": list(explanations)}]


COMPASS = {
    "probability": 0.3,
    "effects": [{"compass-bias": {"angle": {"mean": "3 deg", "sd": "1 deg"}}}, {"fix-error": {"sd": "20 m"}}],
}
CURRENT = {
    "probability": 0.5,
    "effects": [
        {"mean-current": {"east": {"mean": "0.1 m/s", "sd": "0.1 m/s"}, "north": {"mean": "0 m/s", "sd": "20 cm/s"}}}
    ],
    "correlations": [{"between": ["mean-current.east", "mean-current.north"], "rho": 0.5}],
}


def test_each_explanation_is_a_mission_in_which_it_is_known_to_hold(transit_mission):
    doubtful = transit_mission.with_(effects=one_of(CURRENT, COMPASS))
    each = explained_missions(doubtful)
    assert [explained.prior for explained in each] == pytest.approx([0.5, 0.3, 0.2])
    assert [explained.causes for explained in each] == [("mean-current",), ("compass-bias", "fix-error"), ()]
    wanted = [CATALOGUE[name] for name in ("mean-current", "compass-bias")]
    (current,) = given_priors(each[0].mission, wanted)
    assert current.mean == pytest.approx([0.1, 0.0], abs=1e-3)
    assert current.covariance == pytest.approx(np.array([[0.01, 0.01], [0.01, 0.04]]), rel=0.01)


def test_effects_of_explanations_that_may_not_hold_are_no_given_effects(transit_mission):
    mission = transit_mission.with_(effects=one_of(CURRENT, {**COMPASS, "probability": 0.5}))
    wanted = [CATALOGUE[name] for name in ("speed-scale", "compass-bias", "mean-current", "fix-error")]
    assert [each.effect for each in given_priors(mission, wanted)] == ["speed-scale"]
    known = mission.knowing(mission.doubts[0].place, 1)
    assert [each.effect for each in given_priors(known, wanted)] == ["speed-scale", "compass-bias", "fix-error"]


def test_other_explanations_gain_what_causes_add_to_their_own_base_models(monkeypatch):
    """12 nats found, of which 10 are the evidence beside the first; the same causes add 8 and 1 beside the others."""
    evidence = {"first": (-100.0, -90.0), "second": (-500.0, -492.0), "third": (-60.0, -59.0)}

    def weighed(name):
        model = SimpleNamespace(name=name, candidates=("mean-current",), alternatives=())
        base = CauseFit((), evidence[name][0], (), {}, True, None)
        return Weighed(None, SimpleNamespace(model=model), base, 0.0)

    def fits(model, requests, jobs):
        return [CauseFit(requests[0][0], evidence[model.name][1], (), {}, True, None)]

    monkeypatch.setattr(explanations, "fitted", fits)
    monkeypatch.setattr(explanations, "log_gain", lambda selection: 12.0)
    found = SimpleNamespace(best=SimpleNamespace(causes=("mean-current",)), selection=None)
    gains = [each.gain for each in explanations.with_found([weighed(name) for name in evidence], found, 1)]
    assert gains == [12.0, 12.0 - 10.0 + 8.0, 12.0 - 10.0 + 1.0]


def test_sets_that_differ_in_a_law_of_errors_alone_are_told_as_one():
    listed = [(("mean-current", "persistent-error"), 0.2, 0.3), (("mean-current",), 0.1, 0.4), (("compass-bias",), 0.6, 0.1),
              (("speed-scale", "heavy-tails"), 0.1, 0.2)]  # fmt: skip
    told = [(each.causes, each.prior, each.probability) for each in explanations._merged(listed)]
    assert told == [
        (("mean-current",), pytest.approx(0.3), pytest.approx(0.7)),
        (("speed-scale", "heavy-tails"), 0.1, 0.2),  # without it there is none
        (("compass-bias",), 0.6, 0.1),
    ]
    assert [each.prior for each in explanations._merged([(causes, None, share) for causes, _, share in listed])] == [
        None
    ] * 3


def test_a_walk_is_carried_as_a_law_that_forgets_where_that_was_fitted():
    current, walk, law = "mean-current", "random-walk", "persistent-error"
    shares = {(current, walk): 0.4, (current,): 0.3, (walk,): 0.2, (current, law): 0.1}
    found = explanations._stationary(shares, [*shares, ("compass-bias", law)])
    assert found == {(current, law): pytest.approx(0.5), (current,): 0.3, (walk,): 0.2}


@pytest.mark.parametrize(
    ("own", "order"),
    [(3.0, ["first", "unlike", "unlikely", "alike"]), (30.0, ["unlike", "first", "unlikely", "alike"])],
)
def test_causes_are_searched_beside_what_the_data_are_unlike_and_which_is_not_negligible(monkeypatch, own, order):
    """The first gains 4 nats and so do those that are not searched; another gains its own, and may go before it."""
    gains, asked = {"first": 4.0, "unlike": own}, []

    def weighed(name, log_weight, prior):
        model = SimpleNamespace(
            all_sets=lambda jobs: asked.append(name) or SimpleNamespace(name=name, posterior={("a",): 1.0}, ranking=())
        )
        return Weighed(SimpleNamespace(prior=prior), SimpleNamespace(model=model, is_known=False), None, log_weight)

    each = [
        weighed("first", 0.0, 0.5),
        weighed("unlike", -20.0, 0.3),
        weighed("unlikely", -20.0, 0.005),
        weighed("alike", -2.0, 0.2),
    ]
    names = {id(one.bound): name for one, name in zip(each, ("first", "unlike", "unlikely", "alike"), strict=True)}
    monkeypatch.setattr(explanations, "log_gain", lambda selection: gains[selection.name])
    found, selection = explanations.weighed_with_causes(each, 1)
    assert asked == ["first", "unlike"]
    assert [names[id(one.bound)] for one in found] == order
    assert {names[id(one.bound)]: one.gain for one in found} == {
        "first": 4.0,
        "unlike": own,
        "unlikely": 4.0,
        "alike": 4.0,
    }
    assert selection.name == order[0]
    assert explanations.weighed_with_causes([each[0], each[3]], 1) == ((each[0], each[3]), None)
