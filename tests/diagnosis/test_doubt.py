"""Ambiguous verdicts are carried as explanations, and explanations are prior odds of the next diagnosis."""

import numpy as np
import pytest
import yaml

from missionplan import diagnose
from missionplan.diagnosis.coordinates import coordinates_of, correlations, estimates
from missionplan.diagnosis.explanations import explained_missions
from missionplan.diagnosis.given.priors import given_priors
from missionplan.diagnosis.mission_in_doubt import Hypothesis, mission_in_doubt
from missionplan.effects import CATALOGUE
from missionplan.mission import Mission, load
from missionplan.montecarlo.draws import is_joint
from missionplan.report.diagnosis.kind_report import explanations_in_words
from missionplan.report.render import render_report

KIND = {"kind": "transit", "name": "legs", "noise": {"fix": "3 m"}}
EASTWARD = (0.5 * np.pi, np.radians(10.0))


def slow(t, heading):
    return -0.06 * 1.2 * np.stack([np.sin(heading), np.cos(heading)])


def slow_and_aside(t, heading):
    """What one current does as well as a slow vehicle with a little current across."""
    return slow(t, heading) + np.array([[0.0], [0.015]])


@pytest.fixture
def ambiguous(folder, transit_mission, legs):
    """Diagnose legs within a narrow range of headings of a vehicle that is slow, or meets a current."""
    place = folder(KIND, legs(30, seed=3, about=EASTWARD, error=slow_and_aside))
    return diagnose(transit_mission, place, plan=False), place


def test_an_ambiguous_verdict_is_carried_as_a_doubt(ambiguous, tmp_path):
    found, _ = ambiguous
    assert found.verdict == "ambiguous"
    file = tmp_path / "mission.yaml"
    file.write_text(yaml.safe_dump(found.extended))
    (doubt,) = load(file).doubts
    assert {("speed-scale",), ("mean-current",)} <= set(doubt.causes) <= set(found.credible_set)
    named = {each.causes: each.probability for each in found.explanations if each.causes}
    told = dict(zip(doubt.causes, doubt.probabilities, strict=False))
    assert {causes: told[causes] for causes in named} == pytest.approx(named, abs=1e-4)
    by_causes = {entry.causes: entry for entry in found.ranking}
    for explanation in doubt.explanations:
        for estimate in by_causes[explanation.causes].parameters:
            (entry,) = explanation.effects
            assert entry.parameters[estimate.name].mean == pytest.approx(estimate.value, rel=1e-3)
    likely = f"speed scale {100.0 * told['speed-scale',]:.1f} %"
    assert likely in explanations_in_words(found)
    assert likely in render_report(found).html.replace("\u202f", " ").replace("\xa0", " ")


def test_nothing_grows_on_the_same_data(ambiguous):
    found, place = ambiguous
    again = diagnose(Mission.from_data(found.extended), place, plan=False)
    assert again.verdict == "adequate"
    (doubt,) = Mission.from_data(again.extended).doubts
    assert set(doubt.causes) == {("speed-scale",), ("mean-current",)}
    before = {each.causes: each.probability for each in found.explanations}
    assert {each.causes: each.prior for each in again.explanations} == pytest.approx(before, abs=1e-3)
    assert f"(was {100.0 * before['speed-scale',]:.1f} %)" in explanations_in_words(again)


def test_data_that_can_tell_end_the_doubt(ambiguous, folder, legs):
    found, _ = ambiguous
    resolved = diagnose(Mission.from_data(found.extended), folder(KIND, legs(30, seed=5, error=slow)), plan=False)
    assert resolved.verdict == "adequate"
    assert resolved.explanations[0].causes == ("speed-scale",)
    assert resolved.explanations[0].probability > 0.999
    extended = Mission.from_data(resolved.extended)
    assert not extended.doubts
    assert [entry.effect for entry in extended.effects] == ["speed-scale"]
    (estimate,) = resolved.confirmed
    assert abs(estimate.value + 0.06) < 3.0 * estimate.sd


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
    extended = Mission.from_data(found.extended)
    (doubt,) = extended.doubts
    assert doubt.probabilities == pytest.approx((0.6, 0.4), abs=1e-4)
    assert doubt.causes == (("drag-bias",), ("depth-scale",))
    scale = extended.quantities()["effects.speed-scale.fraction"]  # the same with either: found once
    assert abs(scale.mean + 0.06) < 3.0 * scale.sd


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


def test_probabilities_are_prior_odds(ambiguous):
    found, place = ambiguous
    odds = []
    for share in (0.5, 0.1):
        data = dict(found.extended)
        first, second = data["effects"][0]["one-of"]
        data["effects"] = [{"one-of": [{**first, "probability": share}, {**second, "probability": 1.0 - share}]}]
        after = {e.causes: e.probability for e in diagnose(Mission.from_data(data), place, plan=False).explanations}
        names = [tuple(name for effect in each["effects"] for name in effect) for each in (first, second)]
        odds.append(after[names[0]] / after[names[1]])
    assert odds[0] / odds[1] == pytest.approx(9.0, rel=1e-6)


EFFECTS = {
    "one": [{"compass-bias": {"angle": {"mean": "3 deg", "sd": "1 deg"}}}, {"fix-error": {"sd": "20 m"}}],
    "two": [
        {"mean-current": {"east": {"mean": "0.1 m/s", "sd": "0.1 m/s"}, "north": {"mean": "0 m/s", "sd": "1 m/s"}}}
    ],
}
PAIR = {"between": ["effects.mean-current.east", "effects.mean-current.north"], "rho": 0.5}


def hypothesis(name, probability, base):
    effects = [{"speed-scale": {"fraction": 0.01}}, *EFFECTS.get(name, [])]
    data = base | {"effects": effects} | ({"correlations": [PAIR]} if name == "two" else {})
    return Hypothesis((name,), probability, data)


@pytest.fixture
def base():
    transit = {
        "name": "out",
        "from": ["0 m", "0 m"],
        "to": ["1 km", "0 m"],
        "speed": "1 m/s",
        "d_max": "1 km",
        "arrival_radius": "50 m",
    }
    navigation = {"velocity_error": {"sigma": "0.03 m/s"}, "surfacing_time": "90 s"}
    return {"navigation": navigation, "phases": [{"transit": transit}]}


def test_hypotheses_are_written_with_what_they_have_in_common_outside(base):
    found = [hypothesis("two", 0.5, base), hypothesis("one", 0.3, base), hypothesis("none", 0.2, base)]
    mission = Mission.from_data(mission_in_doubt(found))
    assert [entry.effect for entry in mission.effects if entry.explanation is None] == ["speed-scale"]
    (doubt,) = mission.doubts
    assert doubt.probabilities == pytest.approx((0.5, 0.3, 0.2))
    assert doubt.causes == (("mean-current",), ("compass-bias", "fix-error"), ())
    assert not mission.correlations
    assert [each.rho for each in doubt.explanations[0].correlations] == [0.5]


def test_explanations_become_plain_effects_and_back(base):
    found = [hypothesis("two", 0.5, base), hypothesis("one", 0.3, base), hypothesis("none", 0.2, base)]
    each = explained_missions(Mission.from_data(mission_in_doubt(found)))
    assert [explained.prior for explained in each] == pytest.approx([0.5, 0.3, 0.2])
    assert [dict(explained.mission.raw) for explained in each] == [dict(one.extended) for one in found]


def test_rounded_probabilities_never_sum_to_more_than_one(base):
    thirds = [hypothesis(name, 1.0 / 3.0, base) for name in ("two", "one")]
    (doubt,) = Mission.from_data(mission_in_doubt(thirds)).doubts
    assert sum(each.probability for each in doubt.explanations) <= 1.0


def test_correlations_of_an_amplitude_and_its_phase_are_those_of_draws():
    coordinates = (
        *coordinates_of(CATALOGUE["inertial-current"], ("amplitude",)),
        *coordinates_of(CATALOGUE["compass-bias"]),
    )
    rng = np.random.default_rng(1)
    factor = np.array([[0.01, 0.0, 0.0], [0.006, 0.008, 0.0], [-0.003, 0.004, 0.005]])
    mean = np.array([0.2, 0.1, 0.05])
    cosine, sine, angle = mean[:, None] + factor @ rng.standard_normal((3, 200_000))
    drawn = np.corrcoef([np.hypot(cosine, sine), np.arctan2(sine, cosine), angle])
    found = correlations(coordinates, mean, factor @ factor.T)
    names = [f"{each.effect}.{each.name}" for each in estimates(coordinates, mean, factor @ factor.T)]
    for correlation in found:
        row, column = (names.index(name) for name in correlation.between)
        assert correlation.rho == pytest.approx(drawn[row, column], abs=0.01)
    assert len(found) == 3


def test_correlations_that_rounding_makes_impossible_are_made_smaller():
    coordinates = [
        each for name in ("compass-bias", "speed-scale", "mean-current") for each in coordinates_of(CATALOGUE[name])
    ]
    one = np.ones((len(coordinates), 1))
    assert is_joint(correlations(coordinates, one[:, 0], one @ one.T))  # of rank one


def test_effects_of_explanations_that_may_not_hold_are_no_given_effects(base):
    mission = Mission.from_data(mission_in_doubt([hypothesis("two", 0.5, base), hypothesis("one", 0.5, base)]))
    wanted = [CATALOGUE[name] for name in ("speed-scale", "compass-bias", "mean-current", "fix-error")]
    assert [each.effect for each in given_priors(mission, wanted)] == ["speed-scale"]
    known = mission.knowing(mission.doubts[0].place, 1)
    assert [each.effect for each in given_priors(known, wanted)] == ["speed-scale", "compass-bias", "fix-error"]
