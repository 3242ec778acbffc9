"""The ledger of assumptions: what each is worth, against closed forms, and a headline that is green only where none turns it."""

import copy
import math
from collections import defaultdict
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest
import scipy

import missionplan
from missionplan.montecarlo.statistics import Probability
from missionplan.rendering import render
from missionplan.report.explained import first_do
from missionplan.report.render import terminal_view
from missionplan.results.decision import Assumption
from missionplan.results.failures import SUCCESS, Counted, CountedKind
from missionplan.scenario.scenario import Scenario
from missionplan.studies.judgement import Doubt, _spoilt, doubts_of, ledger
from missionplan.studies.simulation.trial_block import run_block

pytestmark = pytest.mark.usefixtures("unplanned", "unranked", "unheld")

ONE_LEG = """
name: One leg across an exact current
site:
  depth: 30 m
  current: [{down_to: 30 m, speed: %s, toward: 90 deg}]
  wind: {speed: 0 m/s, from: 0 deg}
navigation: {velocity_error: {sigma: 0.001 m/s}, surfacing_time: 1 s, fix_error: 0.1 m, max_legs: 1}
phases:
  - transit: {name: out, from: [0 m, 0 m], to: [0 m, 1000 m], speed: 1 m/s, d_max: 1200 m, arrival_radius: 60 m}
requirements: [{quantity: out.arrived, probability: 0.9}]
monte_carlo: {trials: 400, seed: 1}
"""


@pytest.fixture
def one_leg(tmp_path: Path):
    def load(speed: str) -> missionplan.Mission:
        path = tmp_path / "one-leg.yaml"
        path.write_text(ONE_LEG % speed, encoding="utf-8")
        return missionplan.load(path)

    return load


def test_a_current_that_is_not_exact_is_worth_what_the_normal_distribution_says(one_leg):
    """1000 s at 0.1 m/s times z, within 60 m: P(|z| < 0.6)."""
    mission = one_leg("0 m/s")
    (found,) = ledger(mission, seed=3)
    expected = 2.0 * scipy.stats.norm.cdf(0.6) - 1.0
    assert found.success == pytest.approx(expected, abs=0.08)
    assert found.worth == pytest.approx(expected - 1.0, abs=0.08)
    assert found.missed == ("out.arrived",)
    assert found.turns


def test_a_longer_run_of_the_mission_is_counted_over_the_ledger_s_own_trials(one_leg):
    """So that what is put off is compared on the same draws: as where the ledger runs the mission itself."""
    mission = one_leg("0 m/s").with_({"navigation.velocity_error.sigma": "0.04 m/s"})
    run = run_block(Scenario.at_means(mission).sampled(seed=3, block=0, size=1000), 3, 0, 1000)
    (found,) = ledger(mission, 3, run)
    assert 0.0 < found.success < found.success - found.worth < 1.0
    assert (found,) == ledger(mission, 3)


def test_the_headline_is_green_only_where_no_assumption_could_turn_it(one_leg):
    shown = terminal_view(missionplan.simulate(one_leg("0 m/s"), assumptions=True))
    assert shown.verdict == "undecided"
    assert "But this assumes that the layers flow just as fast as stated" in shown.sentence
    stated = one_leg("{mean: 0 m/s, sd: 0.01 m/s}")
    assert ledger(stated, seed=3) == ()
    outcome = missionplan.simulate(stated, assumptions=True)
    assert terminal_view(outcome).verdict == "good"
    assert outcome.summary()["decision"]["assumes"] == []


def test_what_is_taken_for_granted_is_named(tmp_path):
    path = tmp_path / "bare.yaml"
    path.write_text(
        "name: bare\nnavigation: {velocity_error: {sigma: 0.02 m/s}, surfacing_time: 60 s}\nsite: {depth: 20 m}\n"
        "phases: [{transit: {from: [0 m, 0 m], to: [0 m, 800 m], speed: 1 m/s, d_max: 400 m, arrival_radius: 50 m}}]\n",
        encoding="utf-8",
    )
    expected = ["there is no current", "there is no wind", "fixes are exact"]
    assert [doubt.what for doubt in doubts_of(missionplan.load(path))] == expected
    found = ledger(missionplan.load(path), seed=1)
    assert {each.what for each in found} == set(expected)
    assert not any(math.isnan(each.worth) for each in found)


def test_water_that_is_taken_as_still_turns_the_answer_of_a_vehicle_that_cannot_correct(one_leg):
    """1000 s in a current of up to 0.5 m/s, within 60 m: 0.12; an effect that is the current answers for it."""
    mission = one_leg("0 m/s").with_({"site.current": None})
    (still,) = ledger(mission, seed=1)
    assert still.what == "there is no current"
    assert still.success == pytest.approx(0.12, abs=0.05)
    assert still.turns
    stated = mission.with_({"effects": [{"mean-current": {"east": "0 m/s", "north": "0 m/s"}}]})
    assert not list(doubts_of(stated))
    flow = {"mean-current": {"east": "0 m/s", "north": "0 m/s"}}
    for probability, doubts in ((0.05, ["there is no current"]), (0.6, [])):  # of a current that may be
        one_of = {"one-of": [{"probability": probability, "effects": [flow]}]}
        assert [each.what for each in doubts_of(mission.with_({"effects": [one_of]}))] == doubts


def test_water_of_which_a_mission_says_nothing_is_doubted_too(one_leg):
    """1000 s in a current of up to 0.5 m/s, within 60 m: 0.12 still; without `site` there is no wind either."""
    mission = one_leg("0 m/s").with_({"site": None, "requirements": None})
    still, calm = ledger(mission, seed=1)
    assert (still.what, still.success) == ("there is no current", pytest.approx(0.12, abs=0.05))
    assert (calm.what, calm.turns) == ("there is no wind", False)
    shown = terminal_view(missionplan.simulate(mission, assumptions=True))
    assert shown.verdict == "undecided"
    assert "anywhere it fails more often than not: it succeeds" in shown.sentence.replace("\u00a0", " ")


@pytest.mark.parametrize(
    ("success", "is_required", "turns"),
    [(0.95, False, False), (0.85, False, True), (0.55, False, True), (0.85, True, False), (0.45, True, True)],
)
def test_failures_that_cost_as_much_as_the_mission_turn_what_no_requirement_decides(success, is_required, turns):
    """One in ten, of ten missions each, is a mission for each mission."""
    assert Assumption("it is calm", "a swell", success - 1.0, success, is_required=is_required).turns is turns


def test_the_phase_that_is_spoilt_is_the_one_that_loses_more_than_before():
    def lost(**shares):
        of = {
            Counted(CountedKind.FAILURE, phase, "not arrived"): Probability(s, 0.0, 1.0) for phase, s in shares.items()
        }
        return {**of, SUCCESS: Probability(0.5, 0.0, 1.0)}

    assert _spoilt(lost(out=0.4, moor=0.0), lost(out=0.4, moor=0.3)) == "moor"
    assert _spoilt(lost(out=0.4), lost(out=0.45, back=0.1)) == "back"
    assert _spoilt(lost(out=0.4), lost(out=0.3)) == ""


def test_a_tide_that_sets_in_is_worth_what_its_integral_says(one_leg):
    """A sin ωt for 2000 s: A ωT²/2 = 281 s A, within 60 m for 0.21 m/s, of a square of 1 m/s π 0.21² = 0.14."""
    layers = {"30 m": "0 m/s", "60 m": "0.5 m/s"}  # it runs in the upper one
    flow = [
        {"down_to": depth, "speed": {"mean": speed, "sd": "1 mm/s"}, "toward": "0 deg"}
        for depth, speed in layers.items()
    ]
    far = {"site.depth": "60 m", "site.current": flow, "out.to": ["0 m", "2 km"], "out.d_max": "2 km"}
    (tide,) = ledger(one_leg("0 m/s").with_(far), seed=3)
    assert (tide.what, tide.missed) == ("the current stays as at the start", ("out.arrived",))
    assert (tide.success - tide.worth, tide.success) == pytest.approx((1.0, 0.14), abs=0.06)


def test_an_anchor_that_would_slide_on_clay_is_named():
    """0.83 m/s asks for a factor of 0.42 of this anchor: of 0.2 to 0.6, somewhat less than half hold."""
    layers = [{"down_to": "20 ft", "speed": "0 m/s"}, {"down_to": "40 ft", "speed": "0.83 m/s"}]
    mission = missionplan.load("missions/chesapeake.yaml")
    required = [{"quantity": "total.success", "probability": 0.9}]
    current = [{**each, "toward": "60 deg"} for each in layers]
    mission = mission.with_({"site.current": current, "requirements": required})
    (held,) = (each for each in ledger(mission, seed=1) if each.what == "the anchor stays where it lies")
    assert held.success == pytest.approx(0.45, abs=0.15)
    assert (held.turns, held.spoils) == (True, "moor")
    for each in (held, replace(held, missed=(), missed_of=())):  # whether it is required or not
        judged = SimpleNamespace(requirements=(), assumed=(each,))
        assert [first_do(judged, name) for name in ("ingress", "moor")] == [
            None,
            " first pull such an anchor over the site's bottom (vehicle.anchor.holding_factor);",
        ]


def test_an_assumption_that_cannot_be_run_is_not_passed_over(one_leg, monkeypatch):
    wrong = Doubt("the keel is even", "another", {"vehicle.keel": "uneven"})
    monkeypatch.setattr("missionplan.studies.judgement.doubts_of", lambda _: iter([wrong]))
    outcome = missionplan.simulate(one_leg("0 m/s"), assumptions=True)
    (found,) = outcome.assumed
    assert math.isnan(found.worth)
    assert "could not be run" in render(outcome).html


def test_each_assumption_is_put_off_by_its_usual_size():
    """Of what the file gives as exact: one layer of two, no wind, no fix error, holding, flooding and the line."""
    data = copy.deepcopy(dict(missionplan.load(Path(__file__).parents[3] / "missions" / "chesapeake.yaml").raw))
    data["site"]["current"][1]["speed"] = {"mean": "0.2 m/s", "sd": "0 m/s"}
    data["navigation"]["fix_error"] = "0 m"
    data["vehicle"]["anchor"]["holding_factor"] = 0.3
    data["phases"][1]["moor"] |= {"line_material": None}
    found = {doubt.what: dict(doubt.changes) for doubt in doubts_of(missionplan.Mission.from_data(data))}
    fastest, quarter = 0.4 * 1852.0 / 3600.0, f"{math.pi / 2.0!r} rad"  # of both layers, 0.4 kn
    strength = {"low": f"{-fastest!r} m/s", "high": f"{fastest!r} m/s"}
    tide = {"m2_east": strength, "m2_north": strength, "m2_east_phase": quarter, "m2_north_phase": quarter}
    winds = {"speed": {"low": "0 m/s", "high": "12 m/s"}, "from": {"low": "0 deg", "high": "360 deg"}}
    assert found == {
        "the layers flow just as fast as stated": {"site.current[1].speed": {"mean": "0.2 m/s", "sd": "0.1 m/s"}},
        "the current stays as at the start": {"effects": [{"tidal-current": tide}]},
        "there is no wind": {"site.wind": winds},
        "fixes are exact": {"navigation.fix_error": "5 m"},
        "the anchor holds just as its holding factor says": {
            "vehicle.anchor.holding_factor": {"median": 0.3, "factor": 1.4}
        },
        "the anchor is full of water at once": {"vehicle.anchor.flooding_time": "10 s"},
        "the line has no weight (moor)": {"moor.line_material": "polyester"},
    }
    data["phases"][1]["moor"]["line_diameter"] = "0 m"
    bare = {doubt.what: dict(doubt.changes) for doubt in doubts_of(missionplan.Mission.from_data(data))}
    assert bare["the line has neither weight nor drag (moor)"] == {
        "moor.line_material": "polyester",
        "moor.line_diameter": "2 mm",
    }


@pytest.mark.parametrize(("before", "missed"), [(0.85, ()), (0.9, ("out.arrived",))])
def test_a_requirement_that_is_missed_anyway_turns_on_no_assumption(one_leg, monkeypatch, before, missed):
    runs = iter((before, 0.5))

    def probabilities(*_, **__):
        share = SimpleNamespace(value=next(runs))
        return defaultdict(lambda: share)

    monkeypatch.setattr("missionplan.studies.judgement.event_probabilities", probabilities)
    (found,) = ledger(one_leg("0 m/s"), seed=3)
    assert (found.missed, found.worth) == (missed, pytest.approx(0.5 - before))


def test_every_assumption_says_what_settles_it():
    missions = (missionplan.load(path) for path in ("missions/chesapeake.yaml", "missions/anchor-design.yaml"))
    bare = missionplan.load("missions/fig8.yaml")
    assert all(doubt.first for mission in (*missions, bare) for doubt in doubts_of(mission))


@pytest.mark.parametrize(
    ("reached", "then", "is_missed"), [(0.905, 0.85, True), (0.905, 0.889, False), (0.96, 0.85, False)]
)
def test_what_all_trials_meet_is_missed_though_the_first_of_them_miss_it_by_chance(
    one_leg, monkeypatch, reached, then, is_missed
):
    """Of the ledger's trials 89 % arrive as the mission stands: less than the 90 % required, which all trials reach."""
    ran = (
        {each: Probability(share, share, share) for each in (SUCCESS, Counted.requirement(0))} for share in (0.89, then)
    )
    monkeypatch.setattr("missionplan.studies.judgement.event_probabilities", lambda *_, **__: next(ran))
    whole = SimpleNamespace(probability=Probability(reached, reached, reached))
    (found,) = ledger(one_leg("0 m/s"), 1, None, (whole,))
    assert found.missed == (("out.arrived",) if is_missed else ())
