"""What a result tells the crew to do: was and now by the mission's own keys, in every summary."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

import missionplan
from missionplan.montecarlo.statistics import wilson
from missionplan.report import explained
from missionplan.report.render import terminal_view
from missionplan.results.decision import Assumption, Change, MemberOutcome, changes_of, written
from missionplan.results.learned import Campaign, Diagnosis
from missionplan.results.simulation import Outcome

MISSIONS = Path(__file__).parents[2] / "missions"
DATA = {
    "site": {"current": [{"speed": "0.2 m/s"}]},
    "phases": [{"transit": {"name": "out", "d_max": "300 m"}}, {"moor": {"line_length": "5 m"}}],
}


def test_what_a_mission_has_at_a_key_is_found_by_phase_and_list():
    assert written(DATA, "out.d_max") == "300 m"
    assert written(DATA, "moor.line_length") == "5 m"
    assert written(DATA, "site.current[0].speed") == "0.2 m/s"
    assert written(DATA, "site.current[3].speed") is None
    assert written(DATA, "energy.hotel") is None


def test_only_what_differs_changes():
    (change,) = changes_of(DATA, {"out.d_max": "400 m", "moor.line_length": "5 m"})
    assert (change.key, change.was, change.now) == ("out.d_max", "300 m", "400 m")


def test_every_summary_has_the_decision_that_the_terminal_shows():
    sweep = missionplan.sweep_dmax(MISSIONS / "fig8.yaml", trials=50, method="analytic")
    outcome = missionplan.simulate(MISSIONS / "chesapeake.yaml", trials=100, sheet=False)
    for result in (sweep, outcome):
        decision = result.summary()["decision"]
        assert decision["do"] == terminal_view(result).sentence
        assert set(decision) >= {"do", "sure", "assumes", "changes", "not_in_this_probability"}
    assert outcome.summary()["decision"]["sure"]["value"] == outcome.total.events["success"].value
    (change,) = sweep.summary()["decision"]["changes"]
    assert (change["key"], change["was"]) == ("ingress.d_max", "4 nmi")
    assert float(change["now"].removesuffix(" m")) == pytest.approx(sweep.middle.recommended.d_max, abs=0.1)


def plain(text):
    return text.replace("\u00a0", " ")


def test_members_and_assumptions_are_told_by_the_worst_and_the_one_that_turns_the_answer():
    shares = {"calm": wilson(970, 1000), "storm": wilson(300, 1000), "tide": wilson(900, 1000)}
    members = [MemberOutcome(name, 0.25, good) for name, good in shares.items()]
    assert plain(explained.members_in_words(members, "arrives")) == (
        "It depends on the forecast: it arrives 30 % of the time in storm and 97.0 % in calm."
    )
    assert "as often" in explained.members_in_words([members[0], replace(members[0], name="like it")], "arrives")
    assert explained.members_in_words(members[:1], "arrives") == ""
    (section,) = explained.members_section(members, "plan", "arrives", "")
    assert [[plain(cell) for cell in row] for row in section.blocks[0].rows] == [
        ["storm", "25.0 %", "30 ± 3 %"], ["tide", "25.0 %", "90.0 ± 1.9 %"], ["calm", "25.0 %", "97.0 % (95.7 to 97.9 %)"],
    ]  # fmt: skip
    assert section.heading == "Which member of the current's ensemble spoils the plan"
    sailed = [
        SimpleNamespace(causes=(each.name,), probability=0.25, success=each.good, trials=each.name != "tide")
        for each in members
    ]
    assert Outcome.sailed.fget(SimpleNamespace(members=sailed)) == (
        members[0],
        members[1],
    )  # no trial sails in the tide
    assumed = (
        Assumption("it is calm", "a swell", -0.012, 0.938),
        Assumption("the log is right", "2 % more", -0.55, 0.4, ("out.arrived",)),
    )
    (section,) = explained._section(assumed, assumed[1:])
    assert [plain(cell) for cell in section.blocks[0].rows[1]] == [
        "the log is right",
        "2 % more",
        "40 %",
        "-55 %",
        "could turn the answer",
    ]
    assert (section.heading, section.blocks[0].rows[0][4]) == ("1 of its assumptions could turn this", "")
    assert explained._turning_in_words(assumed[1:]) == (
        " But this assumes that the log is right: with 2 % more it succeeds 40 % of the time and misses what is required of arrival (out)."
    )
    assert explained._heading(assumed[:1], 0) == "None of these assumptions alone could turn this"


@pytest.mark.parametrize(
    ("good", "likely", "required", "hangs"),
    [
        (300, 0.2, 0.8, True),  # short of what is required
        (300, 0.04, 0.8, False),  # too unlikely
        (830, 0.2, 0.8, False),  # enough
        (830, 0.2, None, True),  # one in ten more fails: a mission for each
        (940, 0.2, None, False),  # no more than chance
    ],
)
def test_an_explanation_or_a_member_turns_an_answer_as_an_assumption_does(good, likely, required, hangs):
    doubts = [(1.0 - likely, wilson(970, 1000)), (likely, wilson(good, 1000))]
    assert explained.hangs_on_doubt(wilson(950, 1000), doubts, required) is hangs
    tried = [SimpleNamespace(probability=share, success=each, trials=1000) for share, each in doubts]
    asked = [SimpleNamespace(quantity="total.success", required=required)] if required else []
    total = SimpleNamespace(events={"success": wilson(950, 1000)})
    outcome = SimpleNamespace(requirements=asked, explanations=tried[1:], members=tried[:1], total=total)
    assert explained.outcome_hangs_on_doubt(outcome) is hangs


def test_what_a_diagnosis_is_sure_of():
    """Effects confirmed without doubt; the probability of causes alone that are claimed; data sets that told anything new."""
    estimates = tuple(SimpleNamespace(effect=effect) for effect in ("compass-bias", "fix-error", "compass-bias"))
    odds = (
        SimpleNamespace(causes=("compass-bias",), probability=0.7),
        SimpleNamespace(causes=("fix-error", "compass-bias"), probability=0.26),
    )
    best = SimpleNamespace(posterior=0.8)

    def diagnosis(**given):
        found = Diagnosis.__new__(Diagnosis)
        usual = {"confirmed": estimates, "explanations": odds, "ranking": (best,), "causes": (), "none_of_these": 0.1, "data": "log",
                 "learned_from": ("a",), "provenance": None}  # fmt: skip
        vars(found).update({**usual, **given})
        return found

    assert diagnosis().borne_out == ("compass-bias",)
    assert diagnosis(explanations=()).borne_out == ("compass-bias", "fix-error")
    assert diagnosis().certainty == {"posterior": None, "none_of_these": 0.1}
    assert diagnosis(causes=("speed-scale",)).certainty == {"posterior": 0.8, "none_of_these": 0.1}
    known = diagnosis(causes=("speed-scale",), learned_from=(), data="old")
    both = Campaign(None, (diagnosis(causes=("speed-scale",)), known))
    assert both.informed_by == {"speed-scale": ("log",), "compass-bias": ("log",), "fix-error": ("log",)}
    assert both.shared == ()


def test_what_a_mission_has_is_found_by_a_phases_place_where_its_name_is_no_key():
    data = {"phases": [{"transit": {"speed": "1 m/s"}}, {"moor": {"name": "moor 1.5 m", "line_length": "5 m"}}]}
    values = {"phases[1].line_length": "6 m", "transit.speed": "1 m/s", "phases[2].hold": "1 h"}
    assert changes_of(data, values) == (
        Change("phases[1].line_length", "5 m", "6 m"),
        Change("phases[2].hold", None, "1 h"),
    )
