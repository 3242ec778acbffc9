"""The second round of docs/loop.md: a current hidden behind a log that may be wrong is found, carried and resolved."""

from pathlib import Path

import numpy as np
import pytest
import yaml

import missionplan
from missionplan import score, simulate
from missionplan.diagnosis.diagnose import diagnose
from missionplan.mission import Mission, load
from missionplan.results.learned import Diagnosis

from .loop import write_first, write_second, write_third

FILES = Path(missionplan.__file__).parent / "starter" / "loop"


@pytest.fixture(scope="module")
def first() -> Diagnosis:
    """Diagnosis of the first log, with the next trial."""
    return diagnose(load(FILES / "mission.yaml"), FILES / "first-log", plan=False, next_trial=True)


@pytest.fixture(scope="module")
def second() -> Diagnosis:
    """Diagnosis of both logs."""
    return diagnose(load(FILES / "mission.yaml"), FILES / "both-logs", plan=False, next_trial=True)


def test_the_files_are_those_of_the_made_up_sea(tmp_path: Path) -> None:
    write_first(tmp_path)
    write_second(tmp_path, yaml.safe_load((FILES / "next-trial.yaml").read_text(encoding="utf-8")))
    write_third(tmp_path)
    made = sorted(path.relative_to(tmp_path) for path in tmp_path.rglob("*") if path.is_file())
    assert len(made) == 7
    for path in made:
        assert (tmp_path / path).read_text(encoding="utf-8") == (FILES / path).read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_first_log_leaves_open_which_it_is(first: Diagnosis) -> None:
    assert first.verdict == "ambiguous"
    assert {("speed-scale",), ("mean-current",)} <= set(first.credible_set)


@pytest.mark.slow
def test_the_doubt_is_carried_into_the_plan(first: Diagnosis) -> None:
    carried = Mission.from_data(first.extended)
    (doubt,) = carried.doubts
    assert {("speed-scale",), ("mean-current",)} <= set(doubt.causes)
    outcome = simulate(carried, trials=400, sheet=False)
    back = next(phase for phase in outcome.phases if phase.name == "back").quantities["duration_s"]
    assert (back.p95 - back.p05) / 60.0 > 15.0  # a current would carry it home, a log that is wrong would not


@pytest.mark.slow
def test_the_trial_goes_both_ways_and_the_one_in_the_files_saves_nearly_as_much(first: Diagnosis) -> None:
    found = first.next_trial
    assert found is not None
    assert found.best is not None
    reached = [0.0, *(float(leg.to[1]) for leg in Mission.from_data(found.trial or {}).transits)]
    assert np.diff(reached).min() < -1.0 < 1.0 < np.diff(reached).max()
    assert 0.0 < found.best.saving <= found.perfect * 1.1
    opposite = next(each for each in found.designs if each.name == "two opposite legs of 1.6 km")
    assert opposite.saving > 0.8 * found.best.saving
    assert opposite.minutes < found.best.minutes * 1.01
    assert len(load(FILES / "next-trial.yaml").transits) == 2
    choices = {outcome.causes: outcome.choice for outcome in found.outcomes if outcome.saving > 0.1}
    assert ("speed-scale",) in choices  # with which another d_max is best


@pytest.mark.slow
def test_the_report_tells_the_trial_and_its_outcomes(first: Diagnosis, tmp_path: Path) -> None:
    folder = first.save(tmp_path / "report")
    report = (folder / "report.html").read_text(encoding="utf-8")
    assert "The trial pays for itself after" in report
    assert "If it then looks most like" in report
    assert "no data set of their own" in report  # fewer than eight legs
    assert first.next_trial is not None
    assert load(folder / "next-trial.yaml").transits == Mission.from_data(first.next_trial.trial or {}).transits
    rule = first.next_trial.rule
    assert rule is not None
    assert (rule.effect, rule.above) == ("speed-scale", False)
    assert -0.16 < rule.threshold < -0.08
    probability = sum(outcome.probability for outcome in first.next_trial.outcomes)
    assert 0.8 < probability <= 1.0 + 1e-9


@pytest.mark.slow
def test_the_trial_resolves_the_doubt(second: Diagnosis) -> None:
    assert second.verdict == "explained"
    assert second.causes == ("mean-current",)
    assert second.best is not None
    north = next(each for each in second.best.parameters if each.name == "north")
    assert north.low < -0.15 < north.high
    assert second.next_trial is not None
    assert second.next_trial.best is None  # the choice is made


@pytest.mark.slow
def test_the_mission_predicts_what_it_has_not_seen_better_each_time(first: Diagnosis, second: Diagnosis) -> None:
    missions = [load(FILES / "mission.yaml"), Mission.from_data(first.extended), Mission.from_data(second.extended)]
    found = [
        score(mission, FILES / "third-log").summary()["datasets"][0]["predictions"]["whole"] for mission in missions
    ]
    errors, logs = [each["rmse"] for each in found], [each["log_score"] for each in found]
    assert errors[2] < 0.5 * errors[1] < errors[0]
    assert logs[2] > logs[1] > logs[0] + 3.0
    coverage = found[2]["coverage_90"]
    assert coverage["low"] <= 0.9 <= coverage["high"]
