"""What a crew reads of the next trial, and of what the data cannot tell apart."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest
import yaml

from missionplan.report.diagnosis import page as diagnosis_page
from missionplan.report.diagnosis import plan
from missionplan.report.diagnosis.findings import how_sure
from missionplan.report.diagnosis.page import answer
from missionplan.report.diagnosis.plan import next_trial_pointer, next_trial_section, next_trial_told, next_trial_words
from missionplan.results.learned.evidence import Readings
from missionplan.results.learned.next_trial import NextTrial, OutcomeRule, TrialOutcome, ValuedDesign

LEGS = ValuedDesign("two opposite legs of 400 m", 28.0, 3.1, 1.4, 1.2, 0.1, 0.9)
FOUND = NextTrial(
    decides="d_max_m",
    unit="min",
    choice=2700.0,
    loss=132.0,
    tried=(300.0, 3000.0),
    success=1.0,
    failure_loss=1600.0,
    perfect=1.4,
    designs=(LEGS,),
    best=LEGS,
    outcomes=(
        TrialOutcome(0.44, ("mean-current",), 2700.0, 0.0),
        TrialOutcome(0.37, ("speed-scale",), 3000.0, 3.2),
    ),
    rule=OutcomeRule("speed-scale", "fraction", "", -0.12, False, ("speed-scale",), 3000.0, 0.98),
    trial={"name": "Trial", "phases": [{"transit": {"name": "leg-1"}}]},
)


def test_the_file_of_the_trial_tells_its_crew_what_the_outcomes_would_mean() -> None:
    text = str(FOUND.files()["next-trial.yaml"])
    notes = [line for line in text.splitlines() if line.startswith("#")]
    assert "28 min and 3.1 W h" in notes[1]
    assert "# - mean current (44 %): keep 2700 m" in notes
    assert "# - speed scale (37 %): choose 3000 m, which saves 3.2 min a mission" in notes
    assert notes[-1] == (
        "# In short: choose 3000 m where the diagnosis has speed-scale.fraction below -0.12, else keep."
    )
    assert yaml.safe_load(text) == FOUND.trial


def test_a_choice_at_the_end_of_those_tried_is_said_to_be() -> None:
    assert "one d_max for all transits is best at 2.70\u00a0km (success > 99.9 %, 132 min" in next_trial_words(FOUND)
    assert "3.00\u00a0km (the longest tried; success" in next_trial_words(replace(FOUND, choice=3000.0))
    anchors = replace(FOUND, decides="anchor_wet_weight_n", choice=18.0, tried=(3.5, 18.0), best=None)
    assert "the anchor's wet weight is best at 18\u00a0N (the heaviest tried; success" in next_trial_words(anchors)


def test_what_settles_what_to_do_about_the_vehicle_is_the_cheapest_that_nearly_does() -> None:
    longer, swing = replace(LEGS, minutes=90.0, right=0.92), replace(LEGS, name="a swing", minutes=20.0, right=0.6)
    found = replace(FOUND, designs=(longer, LEGS, swing), right=0.6)
    assert found.settling is LEGS
    assert replace(found, right=0.89).settling is None
    assert NextTrial().settling is None
    said = str(next_trial_section(found)[0].blocks)
    assert "is right with 60" in said
    assert "what is known now, after it with 90" in said
    slower = str(next_trial_section(replace(found, best=longer))[0].blocks)
    assert "after two opposite legs of 400 m, which takes 28" in slower


def test_where_nothing_is_saved_what_settles_it_is_recommended() -> None:
    found = replace(FOUND, best=None, outcomes=(), rule=None, right=0.6)
    (section,) = next_trial_section(found)
    assert section.heading == "The next trial"
    assert "as in next-trial.yaml in this folder: takes 28" in str(section.blocks[0])
    (of_campaign,) = next_trial_section(found, "the folder 2-transit")
    assert "as in next-trial.yaml in the folder 2-transit: takes 28" in str(of_campaign.blocks[0])
    assert "next-trial.yaml in the report's folder: takes 28" in next_trial_told(found)
    assert "next-trial.yaml in the report's folder 2-transit: takes 28" in next_trial_told(found, "2-transit")
    assert "For the plan no trial is worth it" in next_trial_told(found)
    assert next_trial_pointer(found)[0].startswith("Two opposite legs of 400 m: the trial worth making next")
    notes = [line for line in str(found.files()["next-trial.yaml"]).splitlines() if line.startswith("#")]
    assert notes[-1].endswith("is then right with 90 %, not 60 %.")


def test_what_to_do_next_names_the_trial() -> None:
    assert next_trial_pointer(FOUND)[0].startswith("Two opposite legs of 400 m: the trial worth making next")
    assert "No trial is worth it" in next_trial_pointer(replace(FOUND, best=None, right=0.9))[0]
    assert next_trial_pointer(NextTrial(reason="no vehicle")) == next_trial_pointer(None) == []


def diagnosed(**given: Any) -> Any:
    best = SimpleNamespace(causes=("speed-scale",), posterior=0.64, held_out=None, parameters=())
    usual = {
        "causes": ("speed-scale",),
        "best": best,
        "none_of_these": 0.1,
        "nothing": 0.6,
        "provenance": SimpleNamespace(options={}),
        "exact": (),
        "coverage": None,
        "explanations": (),
        "verdict": "ambiguous",
        "untestable": {},
        "readings": Readings(),
        "levels": (),
    }
    return SimpleNamespace(**{**usual, **given})


def held(cause: str, probability: float) -> Any:
    return SimpleNamespace(causes=(cause,), probability=probability, prior=None)


@pytest.mark.parametrize("explanations", [(), (held("speed-scale", 0.64), held("mean-current", 0.36))])
def test_nothing_is_told_where_the_probabilities_are_those_of_the_table(explanations: Any) -> None:
    assert len(how_sure(diagnosed(explanations=explanations))) == 1


def test_a_cause_that_changes_with_time_leaves_no_structure_along_nothing() -> None:
    found = diagnosed(
        verdict="partly-explained",
        discrepancy=SimpleNamespace(axis=None, resembles=None),
        not_constant=("speed-scale",),
        changed=(),
        known=(),
        suspect_labels="",
        learned_from=("a leg",),
        ranking=(),
        misfit="",
        last_part=None,
        kind="transit",
        rivals=(),
    )
    told = answer(found)
    assert "None" not in told
    assert "but not all of it. Speed scale is not constant over the record" in told


@pytest.mark.parametrize(
    ("verdict", "score", "expected"),
    [
        ("adequate", 0.3, "none is needed: the data look as the mission expects"),
        ("adequate", 3.4, "likeliest, heavy tails, has a probability of 70.0 %, and that there is some cause 40.0 %,"),
        ("unexplained", 3.4, "none fits what the data show"),
    ],
)
def test_what_is_not_claimed_is_told_with_its_weight(verdict: str, score: float, expected: str) -> None:
    best = SimpleNamespace(causes=("heavy-tails",), score=score, posterior=0.7, held_out=None)
    words = how_sure(diagnosed(verdict=verdict, causes=(), best=best))
    assert expected in words[0]


def adequate(score: float, last_part: SimpleNamespace | None = None) -> Any:
    """Return an adequate diagnosis whose likeliest cause has a score, and what was kept away from it."""
    return diagnosed(
        verdict="adequate",
        causes=(),
        best=SimpleNamespace(causes=("heavy-tails",), score=score, parameters=(), held_out=None),
        suspect_labels="",
        learned_from=("a leg",),
        misfit="",
        known=(),
        confirmed=(),
        last_part=last_part,
        discrepancy=SimpleNamespace(axis=None, resembles=None),
        kind="transit",
    )


@pytest.mark.parametrize(
    ("score", "expected"),
    [
        (0.3, "nothing in them asks for a cause."),
        (3.4, "what speaks for a cause (heavy tails) is too weak to claim it."),
    ],
)
def test_an_adequate_model_is_not_said_to_be_beyond_doubt(score: float, expected: str) -> None:
    found = adequate(score)
    assert answer(found) == f"The mission's model is adequate for these data: {expected}"
    found.nothing = 0.3
    assert answer(found).startswith("These data leave open whether the mission's model is adequate: that it lacks")
    assert "lacks something (heavy tails, it may be) has a probability of 70.0 %, too little" in answer(found)


@pytest.mark.parametrize("within", [True, False])
def test_what_was_kept_away_is_said_to_be_beyond_chance_where_it_is(within: bool, monkeypatch: Any) -> None:
    monkeypatch.setattr(diagnosis_page, "told", lambda last: "covers 1 of 9.")
    found = adequate(0.3, SimpleNamespace(kind="transit", groups=9, is_within_chance=within))
    kept = " Kept away from all this, the last 9 legs: the extended mission covers 1 of 9."
    assert (f"{kept} Chance does not allow such coverages." in answer(found)) is not within
    assert kept in answer(found)


def test_a_trial_pays_for_itself_in_what_is_saved_and_its_rule_says_the_side() -> None:
    """28 min and 3.1 W h: 1.2 min a mission make 24 missions, 0.3 W h make 11; a trial no dearer than one, the first."""
    said = next_trial_words(FOUND)
    assert "takes 28.0 min and 3.10 W h, and saves 1.2 min a mission on average (± 0.1 min)" in said
    assert "The trial pays for itself after 24 missions." in said
    energy = replace(FOUND, unit="W h", best=replace(LEGS, saving=0.3))
    assert "after 11 missions" in next_trial_words(energy)
    assert "with the first mission" in next_trial_words(replace(FOUND, best=replace(LEGS, saving=28.0)))
    (section,) = next_trial_section(FOUND)
    table, rule = section.blocks[3:5]
    assert [[cell.replace("\u00a0", " ") for cell in row] for row in table.rows] == [
        ["mean current", "44 %", "2.70 km", "nothing"],
        ["speed scale", "37 %", "3.00 km", "3.2 min"],
    ]
    assert rule.startswith("If the speed scale (fraction) comes out below -0.12") or "below −0.12" in rule
    above = replace(
        FOUND, rule=OutcomeRule("compass-bias", "angle", "rad", 0.05, True, ("compass-bias",), 3000.0, 0.98)
    )
    assert "comes out above 2.9°, take it for compass bias and choose 3.00" in next_trial_section(above)[0].blocks[4]
    (row,) = section.blocks[-1].rows
    assert row[:5] == ["Two opposite legs of 400 m", "28", "3.1", "1.4", "1.2 ± 0.1"]
    slight = [replace(LEGS, saving=saving) for saving in (0.29, 0.31)]  # three standard errors are 0.3
    (*_, table) = next_trial_section(replace(FOUND, designs=(LEGS, *slight)))[0].blocks
    assert [row[4] for row in table.rows] == ["1.2 ± 0.1", "nothing", "0.31 ± 0.1"]
    for more in (0, 1, 3):
        many = tuple(replace(LEGS, minutes=float(k)) for k in range(plan._LISTED + more))
        table = plan._designs(replace(FOUND, designs=many))
        assert len(table.rows) == plan._LISTED
        assert (f" {more} more in next-trials.csv." in table.caption) == (" more in" in table.caption) == (more > 0)
