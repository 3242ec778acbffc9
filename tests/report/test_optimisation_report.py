"""Numbers of the report of `optimise`, read back from a result made by hand: cost, front, obstacles, what binds."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure

from missionplan.montecarlo.statistics import Statistic, wilson
from missionplan.report import optimisation as report
from missionplan.results.decision import Axis
from missionplan.results.optimisation import Obstacle, Optimised, Relaxation, Tried
from missionplan.results.simulation import RequirementOutcome

NAN = math.nan
DATA = {
    "vehicle": {"energy": {"capacity": "60 W*h"}},
    "requirements": [{"quantity": "total.duration", "at_most": "2 h", "probability": 0.9}],
}
SPEED = Axis(("out.speed", "back.speed"), ("1 m/s", "1.2 m/s", "1.4 m/s"), ("1", "1.2", "1.4"), (1.0, 1.2, 1.4), "m/s")
ANCHOR = Axis(("vehicle",), ({}, {}), ("light", "heavy"))
KEY = SPEED.name


def tried(speed, anchor, successes, energy, duration, feasible, on_front, trials=1000):
    return Tried({KEY: speed, "vehicle": anchor}, wilson(successes, 1000), energy, duration, {"total.duration 1": 0.02}, feasible, on_front, trials)  # fmt: skip


TRIED = (
    tried("1 m/s", "light", 900, 20.0, 7200.0, False, True, 128),
    tried("1.2 m/s", "light", 960, 24.0, 6300.0, True, True),
    tried("1.4 m/s", "heavy", 970, 33.0, 5400.0, True, False),
    tried("1.4 m/s", "light", 0, NAN, NAN, False, False),
)


def checked(successes, trials=4000):
    energy = Statistic(24.31, 1.9, 20.0, 24.0, 28.0, 0.03, trials)
    duration = Statistic(6300.0, 60.0, 6200.0, 6300.0, 6400.0, 1.0, trials)
    item = RequirementOutcome(
        "total.duration", "at_most", 7200.0, "s", 0.9, wilson(successes, trials), met=True, undecided=False
    )
    total = SimpleNamespace(
        name="total",
        quantities={"energy_wh": energy, "duration_s": duration},
        events={"success": wilson(successes, trials)},
    )
    return SimpleNamespace(
        total=total,
        requirements=(item,),
        provenance=SimpleNamespace(trials=trials, data=DATA),
        sailed=(),
        members=(),
        explanations=(),
        phases=(),
        assumed=(),
    )


def found(**changes):
    provenance = SimpleNamespace(
        data=DATA, mission="made", trials=4000, seed=7, options={"choose": ["out.speed=1:2:1 m/s"]}
    )
    given = {
        "provenance": provenance, "aim": "energy", "axes": (SPEED, ANCHOR), "chosen": {KEY: "1.2 m/s", "vehicle": "light"},
        "feasible": True, "mission": {}, "checked": checked(3840), "fresh": checked(3800), "tried": TRIED, "relaxations": (),
        "obstacles": (), "combinations": 6, "search_trials": 11_000, "check_trials": 8000, "relaxation_trials": 2048,
    }  # fmt: skip
    return Optimised(**{**given, **changes})


def test_keys_that_take_the_same_value_change_each_in_the_mission():
    """``out.speed+back.speed`` is a column of a table, and no key."""
    chosen = found()
    assert chosen.recommended_values == {**dict.fromkeys(SPEED.keys, "1.2 m/s"), ANCHOR.keys[0]: "light"}
    assert found(feasible=False).recommended_values == {}


def test_what_fails_more_often_than_not_is_no_choice():
    hopeless = found(fresh=checked(0))
    assert report.answer(hopeless).startswith("Nothing to choose: the mission fails more often than not.")
    assert report.page(hopeless).verdict == "bad"


def plain(text):
    return text.replace("\u00a0", " ").replace("\u202f", " ")


def sections(part, result):
    return {section.heading: section.blocks for section in part(result)}


def test_the_headline_has_the_cost_of_the_choice_and_how_often_fresh_trials_succeed():
    words = plain(report.answer(found()))
    assert words.startswith(
        "The least energy, 24.31 ± 0.03 W h, is had with speed (out, back) 1.2 m/s and vehicle light."
    )
    assert "on 4000 fresh trials too, of which 95.0 ± 0.7 % succeed." in words
    assert words.endswith("No requirement binds: relaxing any by 1 % saves nothing.")
    words = plain(report.answer(found(aim="duration")))
    assert words.startswith("The least time, 1.7500 ± 0.0003 h, is had with")


def test_the_requirement_that_binds_is_the_one_that_saves_most():
    one = Relaxation("out.arrived", "94 % required instead of 95 %", 0.4, 0.02, {KEY: "1 m/s", "vehicle": "light"})
    two = Relaxation("total.duration", "its bound 1 % wider", 1.3, 0.11, {KEY: "1 m/s", "vehicle": "heavy"})
    none = replace(one, quantity="moor.offset", saved=0.0, error=0.0)
    result = found(relaxations=(one, two, none))
    assert plain(report.answer(result)).endswith(
        "The total duration binds: with its bound 1 % wider, 1.30 ± 0.11 W h less would do."
    )
    ((title, (table,)),) = sections(report._relaxed, result).items()
    assert title == "2 requirements bind"
    assert [[plain(cell) for cell in row[2:]] for row in table.rows] == [
        ["0.40 ± 0.02 W h", "1 m/s, light"], ["1.30 ± 0.11 W h", "1 m/s, heavy"], ["nothing", ""],
    ]  # fmt: skip
    assert not sections(report._relaxed, found(relaxations=(none,)))
    assert "1 requirement binds" in sections(report._relaxed, found(relaxations=(one,)))


@pytest.mark.parametrize(
    ("would_do", "limit", "words"),
    [(7391.0, 7200.0, "2.06 h instead of 2 h"), (6991.0, 7200.0, "1.94 h instead of 2 h")],
)
def test_an_obstacle_says_a_bound_that_is_rounded_away_from_the_one_that_does_not_do(would_do, limit, words):
    each = Obstacle("total.duration", 0.9, wilson(500, 1000), "total.duration_s", limit, would_do, alone=True)
    result = found(feasible=False, obstacles=(each,), checked=None, fresh=None)
    said = plain(report.answer(result))
    assert "The obstacle is the total duration, which is met with 50 ± 3 %, 90 % required" in said
    assert f"({words} would do)" in said
    assert said.endswith("What comes nearest: speed (out, back) 1.2 m/s and vehicle light.")
    ((_, (table,)),) = sections(report._obstacles, result).items()
    assert [plain(cell) for cell in table.rows[0][1:]] == ["90 %", "50 ± 3 %", "2 h", words.partition(" instead")[0]]
    both = found(
        feasible=False, obstacles=(replace(each, alone=False), replace(each, alone=False, would_do=NAN, limit=NAN))
    )
    said = plain(report.answer(both))
    assert said.count("where all others are") == 0
    assert said.count("would do)") == 1
    assert plain(sections(report._obstacles, both)["What stands in the way"][0].rows[1][3]) == "–"


def test_a_choice_at_the_end_of_its_numbers_is_said_to_be_at_its_bound():
    def where(speed):
        (table,) = report._choice(found(chosen={KEY: speed, "vehicle": "heavy"})).blocks
        return [[plain(cell) for cell in row] for row in table.rows]

    assert where("1.2 m/s") == [
        ["speed (out, back)", "1.2 m/s", "1 to 1.4 m/s", ""],
        ["vehicle", "heavy", "light to heavy", ""],
    ]
    assert [where(speed)[0][3] for speed in ("1 m/s", "1.4 m/s")] == ["at its bound"] * 2


def test_the_checks_have_both_seeds_beside_what_is_required():
    ((_, (table,)),) = sections(report._checks, found()).items()
    assert [plain(cell) for cell in table.rows[0][1:]] == ["90 %", "96.0 ± 0.6 %", "95.0 ± 0.7 %"]
    assert not sections(report._checks, found(fresh=None))
    told = {name: plain(value) for name, value in report._numbers(found())}
    assert told == {
        "P(success), fresh trials": "95.0 ± 0.7 %",
        "Combinations to choose from": "6",
        "Trials of the search": "11 000",
    }
    assert len(report._numbers(found(fresh=None))) == 2
    assert "11000 trials searched the 6 combinations, 8000 more checked the choice, and 2048" in plain(
        report._effort(found()).blocks[0]
    )
    assert report.page(found()).rerun.endswith("--choose 'out.speed=1:2:1 m/s' --aim energy --trials 4000 --seed 7")


def test_the_front_is_in_the_order_of_energy_with_its_own_numbers():
    ((title, (table,)),) = sections(report._front, found(tried=TRIED[::-1])).items()
    assert title == "On the front of what was tried: 2"
    assert [[plain(cell) for cell in row] for row in table.rows] == [
        ["1 m/s", "light", "90.0 %", "20 W h", "2 h", "not met"], ["1.2 m/s", "light", "96.0 %", "24 W h", "1.75 h", "met"],
    ]  # fmt: skip


@pytest.mark.parametrize(("aim", "costs"), [("energy", [20.0, 24.0, 33.0]), ("duration", [2.0, 1.75, 1.5])])
def test_points_of_the_front_lie_at_cost_and_success(aim, costs):
    axes = Figure().add_subplot()
    report.draw_front(axes, found(aim=aim))
    drawn = {line.get_label(): np.array(line.get_data()) for line in axes.get_lines()}
    assert drawn["misses a requirement"] == pytest.approx(np.array([[costs[0]], [90.0]]))
    assert drawn["meets all requirements"] == pytest.approx(np.array([costs[1:], [96.0, 97.0]]))
    assert drawn["chosen"] == pytest.approx(np.array([[costs[1]], [96.0]]))
    low, high = axes.get_ylim()
    assert low < 90.0 < 100.0 < high
    report.draw_front(axes := Figure().add_subplot(), found(aim=aim, feasible=False))
    assert "chosen" not in [line.get_label() for line in axes.get_lines()]
    assert report.front_figure(found(tried=TRIED[3:])) is None
