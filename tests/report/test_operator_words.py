"""What a diagnosis tells the operator: size, sign and remedy, as the effects declare them."""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import pandas as pd
import pytest

from missionplan.effects import CATALOGUE
from missionplan.report.diagnosis.findings import finding_in_words
from missionplan.report.diagnosis.kinds import REPORTS
from missionplan.report.diagnosis.page import _confirmed
from missionplan.results.learned import Diagnosis
from missionplan.results.learned.evidence import ExplanationOdds, ParameterEstimate, Readings


def estimate(effect: str, name: str, value: float, sd: float, unit: str) -> ParameterEstimate:
    return ParameterEstimate(effect, name, value, sd, value - 1.645 * sd, value + 1.645 * sd, unit)


def told(
    *found: ParameterEstimate,
    verdict: str = "explained",
    rivals: tuple[tuple[str, ...], ...] = (),
    measurements: tuple[str, ...] = (),
    none_of_these: float = 0.0,
    not_constant: tuple[str, ...] = (),
    made: tuple[str, ...] = (),
    changed: tuple[str, ...] = (),
    inclusion: Mapping[str, float] | None = None,
    ranking: Mapping[tuple[str, ...], float] | None = None,
    kind: str = "transit",
) -> str:
    causes = tuple(dict.fromkeys(each.effect for each in found))
    best = SimpleNamespace(parameters=found, held_out=None)
    entries = [SimpleNamespace(measurement=words) for words in measurements]
    return finding_in_words(
        SimpleNamespace(
            causes=causes,
            best=best,
            verdict=verdict,
            kind=kind,
            rivals=rivals,
            ranking=[SimpleNamespace(causes=each, posterior=share) for each, share in (ranking or {}).items()],
            next_measurements=entries,
            none_of_these=none_of_these,
            not_constant=not_constant,
            changed=changed,
            readings=Readings(confounded_with_reckoning=made, inclusion=inclusion or {}),
        )
    )


def test_a_speed_no_further_off_than_a_reckoning_was_made_in_doubt_is_no_order():
    slow = estimate("speed-scale", "fraction", -0.1, 0.01, "")
    assert "calibrate" in told(slow)
    assert told(slow, made=("speed-scale",)) == (
        "The vehicle goes 10.0 ± 1.0\u00a0% slower than it reckons. But it may be the dead reckoning itself, "
        "which was made without a logged speed: correct nothing yet, first log the vehicle's speed, or its own position, "
        "under water."
    )


@pytest.mark.parametrize(("angle", "side"), [(0.0506, "low"), (-0.0506, "high")])
def test_a_compass_that_reads_low_is_told_so(angle, side):
    words = told(estimate("compass-bias", "angle", angle, 0.0052, "rad"))
    assert words == f"The compass reads 2.9° ± 0.3° {side}: swing it, or enter the correction."


def test_a_share_is_told_in_per_cent_and_doubt_with_its_probability():
    found = estimate("speed-scale", "fraction", -0.03, 0.004, "")
    words = told(found, verdict="ambiguous", inclusion={"speed-scale": 0.84})
    assert words == (
        "It looks as if the vehicle goes 3.0 ± 0.4\u00a0% slower than it reckons (84 %). But that is not sure enough to "
        "act on: correct nothing yet, first sail legs on other headings, at another speed and of other lengths."
    )


def test_a_cause_that_may_not_be_there_is_no_order():
    """A speed scale and a current that such legs cannot tell apart: to calibrate the log would be to toss a coin."""
    found = estimate("speed-scale", "fraction", -0.13, 0.01, "")
    words = told(
        found,
        verdict="ambiguous",
        inclusion={"speed-scale": 0.6, "mean-current": 0.4},
        rivals=(("mean-current",), ("mean-current", "heavy-tails"), ("response", "mean-current"), ("random-walk",)),
        ranking={("mean-current",): 0.31, ("mean-current", "heavy-tails"): 0.09},
        measurements=("two opposite legs of 400 m",),
    )
    assert "calibrate" not in words
    assert words.startswith("It looks as if the vehicle goes 13.0 ± 1.0\u00a0% slower than it reckons (60 %). ")
    assert words.endswith(
        "But it may be mean current (31 %) or mean current and heavy tails (9 %): correct nothing yet, first two "
        "opposite legs of 400 m."
    )
    shared = told(found, verdict="ambiguous", rivals=(("speed-scale", "heavy-tails"),), inclusion={"speed-scale": 0.99})
    assert "calibrate" in shared, "every explanation has it"
    assert "It looks as if" not in shared
    assert "correct nothing" not in shared


def test_a_cause_that_is_sure_is_an_order_beside_what_may_have_no_name():
    found = estimate("speed-scale", "fraction", -0.13, 0.01, "")
    words = told(found, verdict="ambiguous", inclusion={"speed-scale": 0.999}, none_of_these=0.11)
    assert "calibrate" in words
    assert words.endswith("Beside that, something that no effect of the catalogue explains may be there (11 %).")


def test_nothing_is_ordered_from_numbers_that_prove_nothing():
    found = estimate("drag-bias", "fraction", 0.2, 0.01, "")
    words = told(found, verdict="ambiguous", inclusion={"drag-bias": 0.999}, kind="summary")
    assert words.endswith(
        "But so few numbers prove nothing: correct nothing yet, first log depth and time all the way down."
    )


def test_a_cause_that_is_not_the_same_all_along_is_no_order():
    """A glider's record in the Gulf of Mexico speaks for a compass of 12°, and its halves for unlike ones."""
    found = estimate("compass-bias", "angle", 0.21, 0.035, "rad")
    words = told(found, verdict="partly-explained", not_constant=("compass-bias",), measurements=("a swing",))
    assert "swing it" not in words
    assert words.endswith("But the record does not agree on its size: correct nothing yet, first a swing.")
    words = told(found, verdict="partly-explained", not_constant=("compass-bias",))
    assert words.endswith(
        "correct nothing yet, first sail legs on other headings, at another speed and of other lengths."
    )


def test_a_law_of_the_errors_beside_a_cause_in_doubt_is_no_order_and_a_cause_beside_it_that_all_have_is_one():
    found = (
        estimate("speed-scale", "fraction", -0.13, 0.01, ""),
        estimate("persistent-error", "sigma", 0.07, 0.01, "m/s"),
    )
    words = told(*found, verdict="partly-explained", none_of_these=0.6)
    assert "surface more often" not in words
    assert "calibrate" not in words
    assert "correct nothing yet" in words
    pair = estimate("speed-scale", "fraction", -0.13, 0.01, ""), estimate("compass-bias", "angle", 0.05, 0.005, "rad")
    words = told(*pair, verdict="ambiguous", rivals=(("compass-bias", "mean-current"),), inclusion={"speed-scale": 0.8})
    assert words.startswith("The compass reads 2.9° ± 0.3° low: swing it, or enter the correction; and it looks as if ")
    assert "calibrate" not in words
    assert "correct nothing else yet" in words


def test_a_cause_in_the_place_of_which_something_without_a_name_may_be_is_no_order():
    words = told(estimate("speed-scale", "fraction", -0.13, 0.01, ""), verdict="partly-explained", none_of_these=0.6)
    assert "calibrate" not in words
    assert words.endswith(
        "But it may be something that no effect of the catalogue explains (60 %): correct nothing yet, first sail "
        "legs on other headings, at another speed and of other lengths."
    )


def test_a_current_has_a_size_and_a_direction():
    parts = [
        estimate("mean-current", "east", 0.3, 0.01, "m/s"),
        estimate("mean-current", "north", 0.0, 0.02, "m/s"),
    ]
    assert told(*parts).startswith("A current of 0.300 ± 0.010\u00a0m/s toward 90° is not in the mission: ")


def test_what_is_too_large_to_be_its_cause_is_left_to_the_verdict():
    limited = [info for info in CATALOGUE.values() if info.likeness is not None and info.finding is not None]
    assert limited
    for info in limited:
        words = told(*(estimate(info.id, name, 2.0 * info.likeness.size, 1e-3, "") for name in info.parameters))
        assert words == ""


@pytest.mark.parametrize("kind", ["transit", "descent"])
@pytest.mark.parametrize(("after", "is_told"), [(0.05, True), (0.0999, False)])
def test_a_gain_that_rounds_to_nothing_is_not_told(kind, after, is_told):
    sides = {f"residual_base_{side}_m_s": [0.0] for side in ("east", "north")}
    legs = SimpleNamespace(residuals=pd.DataFrame({"duration_s": [840.0], **sides}))
    assert bool(REPORTS[kind].gained(legs, 0.1, after)) == is_told


def test_every_finding_can_be_written():
    for info in CATALOGUE.values():
        for sign in (1.0, -1.0):
            found = [
                estimate(info.id, name, sign * 0.7 * (parameter.scale or parameter.median), 1e-3, parameter.unit)
                for name, parameter in info.parameters.items()
            ]
            words = told(*found)
            assert "{" not in words
            if info.tier == "physical":
                assert words.endswith(".")
                assert info.finding.remedy


@pytest.mark.parametrize(
    ("effect", "name", "value", "unit", "words"),
    [
        ("reynolds-drag", "exponent", -0.167, "", "The drag coefficient falls as the towing speed rises, as its power −0.167 ±"),
        ("reynolds-drag", "exponent", 0.167, "", "The drag coefficient rises with the towing speed, as its power 0.167 ±"),
        ("jet-suction", "decay", 5.0, "", "Under way the jet's suction on the hull takes thrust away: "),
        ("axial-flow", "mass_factor", 1.4, "", "After each change of shaft rate the thrust overshoots, "),
        ("quadratic-damping", "rate", 2.5, "1/m", "Large swings lose more of their height than small ones, "),
        ("thrust-asymmetry", "fraction", -0.2, "", "Astern, the thrust is 20.0 ± 0.5\u00a0% greater than ahead"),
    ],
)  # fmt: skip
def test_tank_effects_have_size_sign_and_remedy(effect, name, value, unit, words):
    written = told(estimate(effect, name, value, 0.005, unit))
    assert written.startswith(words)
    assert CATALOGUE[effect].finding.remedy in written


def test_what_the_mission_has_in_doubt_is_not_said_to_be_confirmed():
    """A jump of the compass in an earlier mission, or a compass that was always off: later legs cannot tell them."""
    slow, angle = (
        estimate("speed-scale", "fraction", -0.06, 0.005, ""),
        estimate("compass-jump", "angle", 0.015, 0.004, "rad"),
    )
    moment = estimate("compass-jump", "moment", 1.4e4, 3.3e4, "s")
    explanations = (
        ExplanationOdds(("speed-scale", "compass-jump"), 0.4, 0.5),
        ExplanationOdds(("speed-scale", "compass-bias"), 0.5, 0.47),
        ExplanationOdds(("speed-scale",), 0.1, 0.03),
    )
    known = (slow, angle, moment)
    diagnosis = SimpleNamespace(known=known, confirmed=known, explanations=explanations, borne_out=("speed-scale",))
    diagnosis.probability_of = partial(Diagnosis.probability_of, diagnosis)
    assert Diagnosis.borne_out.fget(diagnosis) == ("speed-scale",)
    assert diagnosis.probability_of("speed-scale") == pytest.approx(1.0)
    assert diagnosis.probability_of("compass-jump") == 0.5
    assert diagnosis.probability_of("leeway") == 1.0
    assert _confirmed(diagnosis) == (
        " Confirmed: speed scale is −0.060 ± 0.005, was −0.060 ± 0.005. In doubt is compass jump (50.0 %) or compass bias "
        "(47.0 %)."
    )
    diagnosis.explanations, diagnosis.borne_out = (), ("speed-scale", "compass-jump")
    assert Diagnosis.borne_out.fget(diagnosis) == ("speed-scale", "compass-jump")
    words = _confirmed(diagnosis)
    assert "angle of compass jump is 0.9° ± 0.2°" in words
    assert "moment" not in words
    diagnosis.known = (replace(slow, value=-0.04), angle, moment)
    moved = "Moved, within what the mission allows for: speed scale is −0.060 ± 0.005, was −0.040 ± 0.005."
    assert _confirmed(diagnosis) == f" Confirmed: angle of compass jump is 0.9° ± 0.2°, was 0.9° ± 0.2°. {moved}"


@pytest.mark.parametrize(("angle", "is_gone"), [(0.0099, True), (-0.0099, True), (0.0109, False)])
def test_an_effect_that_the_mission_has_and_the_vehicle_no_longer_is_no_order_to_correct_it(angle, is_gone):
    """A compass that was swung, or whose correction was entered, after the last mission: neither is to be undone."""
    words = told(estimate("compass-bias", "angle", angle, 0.0052, "rad"), changed=("compass-bias",))
    assert ("swing it" in words) == (not is_gone)
    assert (
        words.startswith("Compass bias, which the mission has, is gone, as after a correction: correct nothing more")
        == is_gone
    )
