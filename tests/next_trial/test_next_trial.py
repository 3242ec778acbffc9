"""The next trial: a log on one heading cannot tell a compass from a current; the trials offered can."""

from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import yaml

from missionplan.datasets.legs import read_transit
from missionplan.diagnosis.diagnose import diagnose
from missionplan.diagnosis.next_trial import Valuation
from missionplan.diagnosis.next_trial.belief import right_about_vehicle, to_do
from missionplan.diagnosis.next_trial.experiment import Draws
from missionplan.diagnosis.next_trial.leg_trials import LegTrials
from missionplan.mission import Mission, load
from missionplan.report.diagnosis.plan import next_trial_section
from missionplan.results.learned import Diagnosis
from missionplan.results.learned.next_trial import NextTrial
from tests.hidden_effects.cases import draw_case

from .sea import Truth, Vehicle, mission, sail, write_log

LEGS = 14
CAUSES = ("mean-current", "compass-bias", "compass-deviation", "persistent-error")
"""Which one heading cannot tell."""
VEHICLE = Vehicle()


def sailed(folder: Path, truth: Truth, headings: np.ndarray, seed: int = 1) -> Diagnosis:
    """Diagnosis of made-up legs, with the value of further trials."""
    rows = sail(truth, VEHICLE, headings, np.full(len(headings), 800.0), 0.0, np.random.default_rng(seed))
    made = Mission.from_data(mission(VEHICLE))
    return diagnose(made, write_log(folder, VEHICLE, rows), plan=False, next_trial=True)


@pytest.fixture(scope="module")
def one_way(tmp_path_factory: pytest.TempPathFactory, causes: Callable[[], AbstractContextManager[None]]) -> Diagnosis:
    """Legs to the north alone by a compass that is 5° off."""
    with causes():
        return sailed(tmp_path_factory.mktemp("one-way"), Truth(compass=np.radians(5.0)), np.zeros(LEGS))


@pytest.fixture(scope="module")
def next_trial(one_way: Diagnosis) -> NextTrial:
    """Trials after that log."""
    assert one_way.next_trial is not None
    assert one_way.next_trial.reason is None
    return one_way.next_trial


def information(found: NextTrial, name: str) -> float:
    """Expected information of the design whose words begin so [nats]."""
    return next(each.information for each in found.designs if each.name.startswith(name))


def test_what_one_heading_cannot_tell_is_open(next_trial: NextTrial) -> None:
    sets = {causes for causes, _ in next_trial.explanations}
    assert {("compass-bias",), ("mean-current",)} <= sets
    assert sum(probability for _, probability in next_trial.explanations) == pytest.approx(1.0)


def test_legs_on_the_same_heading_tell_little_and_all_round_much(next_trial: NextTrial) -> None:
    onward = information(next_trial, "one long leg")
    back = information(next_trial, "two opposite legs of 800 m")
    star = information(next_trial, "a star of six legs of 800 m")
    assert onward < 0.5 * back
    assert back < star
    assert star > 0.5  # most of what the explanations' probabilities leave open


def test_a_swing_of_the_compass_tells_which_it_is(next_trial: NextTrial) -> None:
    swing = next(each for each in next_trial.designs if "swing of the compass" in each.name)
    assert swing.information > 0.5
    assert swing.energy_wh is None


def test_what_the_crew_then_does_is_right_more_often(next_trial: NextTrial) -> None:
    """By what is known now the likeliest thing to do is done; a swing settles whether the compass is to be swung."""
    shares: dict[bool, float] = {}
    for causes, share in next_trial.explanations:
        about_compass = any(cause.startswith("compass") for cause in causes)
        shares[about_compass] = shares.get(about_compass, 0.0) + share
    assert next_trial.right <= max(shares.values()) + 1e-9
    named = {each.name: each.right for each in next_trial.designs}
    swing = next(right for name, right in named.items() if "swing of the compass" in name)
    onward = next(right for name, right in named.items() if name.startswith("one long leg"))
    assert swing > 0.9 * (1.0 - next_trial.right) + next_trial.right - 0.1
    assert next_trial.right - 0.03 <= onward < swing


def test_the_right_thing_to_do_by_hand() -> None:
    """Three sets of which two ask for the same: 0.3 + 0.3 go before 0.4, and data that tell all leave no error."""
    draws = Draws(np.array([0, 1, 2]), (np.zeros((1, 0)),) * 3, np.array([0.4, 0.3, 0.3]))
    asked = [frozenset(), frozenset({"swing it"}), frozenset({"swing it"})]
    assert right_about_vehicle(asked, draws, draws.weight) == pytest.approx(0.6)
    assert right_about_vehicle(asked, draws, np.eye(3)) == pytest.approx(1.0)
    assert to_do(("mean-current", "persistent-error")) == frozenset()
    assert to_do(("compass-bias", "mean-current")) == to_do(("compass-bias",)) != frozenset()


def test_of_sets_that_are_left_out_only_what_is_done_anyway_is_right() -> None:
    """A compass of 0.6 of nine tenths; of the tenth left out a third asks to swing it too, whatever a trial tells."""
    draws = Draws(np.array([0, 1]), (np.zeros((1, 0)),) * 2, np.array([0.6, 0.4]))
    sets = [(("compass-bias",), 0.6), (("mean-current",), 0.4)]
    believed = tuple(SimpleNamespace(causes=causes, explanation=SimpleNamespace(probability=p)) for causes, p in sets)
    left = {to_do(("compass-bias",)): 0.03, to_do(("speed-scale",)): 0.07}
    value = SimpleNamespace(believed=believed, draws=draws, left=left)
    assert Valuation.right(value, draws.weight) == pytest.approx(0.9 * 0.6 + 0.03)
    assert Valuation.right(value, np.eye(2)) == pytest.approx(0.9 + 0.03)


def test_repeats_tell_more_and_take_longer(next_trial: NextTrial) -> None:
    named = {each.name: each for each in next_trial.designs}
    once, twice = named["a box of 800 m"], named["a box of 800 m, 2 times"]
    assert twice.information > once.information
    assert twice.minutes == pytest.approx(2.0 * once.minutes, rel=0.1)
    legs = 4.0 * (800.0 / VEHICLE.speed + 60.0) / 60.0
    assert once.minutes == pytest.approx(legs, rel=0.1)


def test_twelve_short_legs_settle_in_less_time_what_six_long_ones_do(next_trial: NextTrial) -> None:
    """Random errors are those of each leg, however long it is."""
    named = {each.name: each for each in next_trial.designs}
    short, long = named["a star of six legs of 330 m, 2 times"], named["a star of six legs of 1.6 km"]
    assert short.minutes < 0.85 * long.minutes
    assert short.right > max(long.right - 0.02, next_trial.right + 0.1)


def test_half_of_a_figure_of_eight_is_sailed_at_another_speed_or_depth(tmp_path: Path) -> None:
    """On the same four headings, so that neither is taken for a compass or a current."""
    raw = mission(VEHICLE)
    raw["phases"][0]["transit"]["depth"] = "20 m"  # type: ignore[index]
    made = Mission.from_data(raw)
    rows = sail(Truth(), VEHICLE, np.zeros(LEGS), np.full(LEGS, 800.0), 0.0, np.random.default_rng(1))
    data = read_transit(write_log(tmp_path, VEHICLE, rows), made)
    trials = LegTrials(SimpleNamespace(mission=made, data=replace(data, depth=np.full(LEGS, 20.0))))  # type: ignore[arg-type]
    numbers = {name: number for number, name in enumerate(trials.designs)}
    slow, shallow = (
        Mission.from_data(trials.trial(numbers[f"a figure of eight of 330 m, half of it at {other}"])).transits
        for other in ("0.77 m/s", "14 m depth")
    )
    assert [leg.speed for leg in slow] == pytest.approx([1.1] * 4 + [0.77] * 4)
    assert [leg.depth for leg in shallow] == pytest.approx([20.0] * 4 + [14.0] * 4)


def test_every_design_is_a_mission_that_can_be_sailed(one_way: Diagnosis, tmp_path: Path) -> None:
    """Of one leg a transit, whatever the leg's error."""
    folder = one_way.save(tmp_path / "report")
    table = (folder / "next-trials.csv").read_text(encoding="utf-8")
    assert "a star of six legs" in table
    report = (folder / "report.html").read_text(encoding="utf-8")
    assert "nats" in report
    data = yaml.safe_load((folder / "diagnosis.json").read_text(encoding="utf-8"))
    assert data["next_trial"]["decides"] == "d_max_m"
    trial = folder / "next-trial.yaml"
    assert trial.exists() == (one_way.next_trial is not None and one_way.next_trial.trial is not None)
    if trial.exists():
        assert len(load(trial).transits) in (1, 2, 4, 6, 8, 12, 16)


@pytest.mark.slow
def test_a_choice_that_cannot_change_needs_no_trial(tmp_path: Path) -> None:
    found = sailed(tmp_path, Truth(), np.radians(90.0 * (np.arange(24) % 4))).next_trial
    assert found is not None
    assert found.best is None
    (section,) = next_trial_section(found)
    assert section.heading == "No trial is worth it"
    assert "the choice" in str(section.blocks[0])


@pytest.mark.slow
def test_a_longer_line_tells_a_late_clock_from_a_slow_line(tmp_path: Path) -> None:
    """Hidden dives with one length of line: which of the two it is changes no anchor, and a longer line tells."""
    case = draw_case(5, "descent", "tie")
    made, data = case.write(tmp_path / "case", tmp_path / "truth")
    found = diagnose(load(made), data, plan=False, next_trial=True).next_trial
    assert found is not None
    likeliest = sorted(found.explanations, key=lambda each: -each[1])[:2]
    assert {causes for causes, _ in likeliest} == {("line-payout",), ("clock-offset",)}
    assert sum(probability for _, probability in likeliest) > 0.8
    named = {each.name: each.information for each in found.designs}
    longer = max(value for name, value in named.items() if "with a line of" in name)
    same = max(value for name, value in named.items() if "of line" in name)
    assert longer > 2.0 * same
    assert any("separation heard" in name for name in named)
    assert found.best is None
