"""The last share of a record is kept away from the diagnosis, and scored."""

import shutil
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import fields
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import missionplan
from missionplan.datasets.legs import read_transit
from missionplan.diagnosis import diagnose as diagnosing
from missionplan.diagnosis.scoring import scored_record
from missionplan.diagnosis.scoring.holdout import _kept
from missionplan.diagnosis.scoring.predictive import Ensemble, Noise, Part
from missionplan.results.learned import Diagnosis
from tests.diagnosis.scoring.test_score_legs import Truth, made_legs, mission

CAUSES = ("compass-bias", "mean-current")
SLOW = 4e5
"""Correlation time of a persistent error that outlasts the record [s]."""


@pytest.fixture(scope="module")
def trial(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The starter's sea trial: 32 legs with a compass bias of 3 degrees that the mission does not hold."""
    folder = tmp_path_factory.mktemp("holdout") / "trial"
    missionplan.init(folder)
    return folder


@pytest.fixture(scope="module")
def found(trial: Path, causes: Callable[[], AbstractContextManager[None]]) -> Diagnosis:
    """Without the last 13 legs."""
    with causes():
        return missionplan.diagnose(trial / "mission.yaml", trial / "sea-trial", plan=False, holdout=0.4)


def test_the_extended_mission_predicts_what_was_held_out(found: Diagnosis, tmp_path: Path) -> None:
    assert found.causes == ("compass-bias",)
    assert len(found.residuals) == 19
    last = found.last_part
    assert last is not None
    assert last.groups == 13
    assert last.labels[0] == "20"
    assert last.whole.rmse < 0.8 * last.whole.yardsticks["no_effects"].rmse
    assert last.is_within_chance
    saved = found.save(tmp_path / "report")
    assert (saved / "score.json").is_file()
    assert "the last 13 legs" in (saved / "report.html").read_text()


@pytest.fixture
def scrambled(trial: Path, tmp_path: Path) -> Path:
    """The sea trial with other errors in its last legs."""
    folder = shutil.copytree(trial / "sea-trial", tmp_path / "sea-trial")
    table = folder / "legs.csv"
    lines = table.read_text().splitlines()
    x_end = lines[0].split(",").index("x_end_m")
    for row in range(len(lines) - 10, len(lines)):
        cells = lines[row].split(",")
        cells[x_end] = str(float(cells[x_end]) + 50.0)
        lines[row] = ",".join(cells)
    table.write_text("\n".join(lines) + "\n")
    return folder


def test_the_diagnosis_is_given_what_comes_before(
    trial: Path, scrambled: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All that it learns from: the first 19 legs, whatever the last ones are."""
    whole, given = diagnosing.weighed, []

    def stopped(*arguments: object) -> None:
        given.append(whole(*arguments)[0].bound)  # type: ignore[arg-type]
        raise missionplan.RunError("stopped here")

    monkeypatch.setattr(diagnosing, "weighed", stopped)
    for folder in (trial / "sea-trial", scrambled):
        with pytest.raises(missionplan.RunError, match="stopped here"):
            missionplan.diagnose(trial / "mission.yaml", folder, plan=False, holdout=0.4)
    first, again = (each.data for each in given)
    assert first.n == again.n == len(given[0].model.data.labels) == 19
    for name in {field.name for field in fields(first)} - {"notices"}:  # which tell of the whole record
        np.testing.assert_array_equal(getattr(again, name), getattr(first, name), name)


@pytest.mark.slow
@pytest.mark.usefixtures("among_few")
def test_what_is_held_out_changes_nothing_before(found: Diagnosis, trial: Path, scrambled: Path) -> None:
    """Scrambled errors in the last legs leave the diagnosis bit for bit."""
    again = missionplan.diagnose(trial / "mission.yaml", scrambled, plan=False, holdout=0.4)
    assert again.extended == found.extended
    assert np.any(again.last_part.measured != found.last_part.measured)  # type: ignore[union-attr]


@pytest.mark.parametrize(("share", "said"), [(0.01, "at least 8 and 8"), (0.9, "at least 8 and 8"), (1.5, "between 0")])
def test_a_part_too_short_is_refused(trial: Path, share: float, said: str) -> None:
    with pytest.raises(missionplan.InputError, match=said):
        missionplan.diagnose(trial / "mission.yaml", trial / "sea-trial", plan=False, holdout=share)


@pytest.mark.parametrize(("dives", "share", "kept"), [(7, 0.3, 5), (8, 0.3, 6), (10, 0.8, 2)])
def test_the_share_that_is_kept_is_rounded(dives: int, share: float, kept: int) -> None:
    assert _kept(SimpleNamespace(dives=range(dives)), share) == kept  # type: ignore[arg-type]


def test_an_error_that_halves_from_group_to_group_by_hand() -> None:
    """Two draws of a constant beside a Markov error of variance 1: the last known value tells all of the next."""
    covariance = 0.5 ** np.abs(np.subtract.outer(np.arange(4), np.arange(4)))
    draws = np.array([[0.0], [1.0]]) * np.ones(4)
    parts = (Part(1.0, draws, (Noise(1.0, covariance, np.ones(1), np.zeros(4)),)),)
    known = Ensemble(np.array([3.0, 2.0, 0.0, 0.0]), np.arange(4), parts).after(2)
    (part,) = known.parts
    np.testing.assert_allclose(part.draws, [[1.0, 0.5], [0.5 * 1.0 + 1.0, 0.25 * 1.0 + 1.0]], rtol=1e-8)
    np.testing.assert_allclose(np.diag(part.noises[0].covariance), [0.75, 1.0 - 0.25**2], rtol=1e-8)
    assert known.groups.tolist() == [0, 1]


def test_where_nothing_is_uncertain_the_past_is_that_of_the_whole_record(tmp_path: Path) -> None:
    truth = Truth(persistent=0.05, time=SLOW)
    plan = mission(effects=[{"persistent-error": {"sigma": "0.05 m/s", "time": f"{SLOW} s"}}])
    record = read_transit(made_legs(tmp_path / "legs", truth, 7), plan)
    whole, part = scored_record(record, plan, 1), scored_record(record, plan, 1, past=24)
    assert part.groups == 16
    for name in ("one_step", "whole"):
        np.testing.assert_allclose(getattr(part, name).mean, getattr(whole, name).mean[48:], atol=1e-6)
        np.testing.assert_allclose(getattr(part, name).sd, getattr(whole, name).sd[48:], rtol=1e-6)


@pytest.mark.slow
def test_a_persistent_error_is_remembered_over_the_split(tmp_path: Path) -> None:
    """The first leg that is kept away errs as the last one before it did, which a record of its own would not know."""
    plan = mission(effects=[{"persistent-error": {"sigma": "0.1 m/s", "time": f"{SLOW} s"}}])
    folder = made_legs(tmp_path / "legs", Truth(persistent=0.1, time=SLOW), 7)
    last = missionplan.diagnose(plan, folder, plan=False, holdout=0.4).last_part
    assert last is not None
    first, measured = last.one_step.mean[:2], last.measured[:2]
    assert np.hypot(*measured) > 100.0
    assert np.hypot(*(measured - first)) < 0.5 * np.hypot(*measured)
    assert last.one_step.sd[0] < 0.5 * last.whole.sd[0]
