"""Scores of legs: closed forms, chance, a wrong mission, and the generator that shares nothing with the package."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from scipy.stats import kstest

import missionplan
from missionplan.results.score import Score

LEGS, SECONDS, SPEED = 40, 1800.0, 0.75


@dataclass(frozen=True)
class Truth:
    """How legs are made; a plain loop."""

    sigma_v: float = 0.02
    fix: float = 5.0
    compass_sd: float = 0.0
    compass: float = 0.0
    persistent: float = 0.0
    time: float = 20_000.0


def made_legs(folder: Path, truth: Truth, seed: int, legs: int = LEGS, courses: int = 6) -> Path:
    """Write legs on a star of courses: a fix before and after each, dead reckoning between."""
    generator = np.random.default_rng(seed)
    bias = truth.compass + truth.compass_sd * generator.standard_normal()
    slow = truth.persistent * generator.standard_normal(2)
    position, t, rows = np.zeros(2), 0.0, []
    fixed = position + truth.fix * generator.standard_normal(2)
    for leg in range(legs):
        course = 2.0 * np.pi * (leg % courses) / courses
        through = SPEED * SECONDS * np.array([np.sin(course), np.cos(course)])
        steered = course + bias
        moved = SPEED * SECONDS * np.array([np.sin(steered), np.cos(steered)])
        error = slow + truth.sigma_v * generator.standard_normal(2)
        position = position + moved + error * SECONDS
        reckoned, end = fixed + through, position + truth.fix * generator.standard_normal(2)
        rows.append([t, t + SECONDS, *fixed, *reckoned, *end])
        t += SECONDS + 300.0
        kept = np.exp(-(SECONDS + 300.0) / truth.time)
        slow = kept * slow + truth.persistent * np.sqrt(1.0 - kept**2) * generator.standard_normal(2)
        fixed = end
    folder.mkdir(parents=True, exist_ok=True)
    header = "t_start_s,t_end_s,x_start_m,y_start_m,x_dr_m,y_dr_m,x_end_m,y_end_m"
    (folder / "legs.csv").write_text("\n".join([header, *(",".join(f"{v:.6f}" for v in row) for row in rows)]) + "\n")
    (folder / "dataset.yaml").write_text("kind: transit\nname: made\nfile: legs.csv\n")
    return folder


def mission(sigma_v: float = 0.02, effects: list[object] | None = None, fix: float = 5.0) -> missionplan.Mission:
    return missionplan.Mission.from_data(
        {
            "name": "legs",
            "navigation": {
                "velocity_error": {"sigma": f"{sigma_v} m/s"},
                "surfacing_time": "5 min",
                "fix_error": f"{fix} m",
            },
            "phases": [
                {
                    "transit": {
                        "from": ["0 m", "0 m"],
                        "to": ["5 km", "0 m"],
                        "speed": "0.75 m/s",
                        "d_max": "1 km",
                        "arrival_radius": "20 m",
                    }
                }
            ],
            "effects": effects or [],
        }
    )


COMPASS = [{"compass-bias": {"angle": {"mean": "0 deg", "sd": "2 deg"}}}]
PERSISTENT = [{"persistent-error": {"sigma": "0.05 m/s", "time": "20000 s"}}]


def test_independent_errors_have_the_moments_of_the_closed_form(tmp_path: Path) -> None:
    """Without effects a leg errs by σ_v²T² + 2σ_fix² on each axis, and legs that share a fix by −σ_fix² together."""
    found = missionplan.score(mission(), made_legs(tmp_path, Truth(), 1)).datasets[0]
    variance = (0.02 * SECONDS) ** 2 + 2.0 * 5.0**2
    assert found.whole.sd == pytest.approx(np.sqrt(variance), rel=1e-6)
    assert found.whole.mean == pytest.approx(0.0, abs=1e-9)
    second = np.sqrt(variance - 5.0**4 / variance)
    assert found.one_step.sd[2:4] == pytest.approx(second, rel=1e-6)
    first_error = found.measured[0]
    assert found.one_step.mean[2] == pytest.approx(-(5.0**2) / variance * first_error, rel=1e-6)


def test_crps_and_log_score_of_a_normal_distribution(tmp_path: Path) -> None:
    """Gneiting et al. 2005, Mon. Weather Rev. 133, Eq. 5."""
    found = missionplan.score(mission(), made_legs(tmp_path, Truth(), 2)).datasets[0].whole
    z = found.z
    from scipy.stats import norm

    crps = found.sd * (z * (2.0 * norm.cdf(z) - 1.0) + 2.0 * norm.pdf(z) - 1.0 / np.sqrt(np.pi))
    assert found.crps == pytest.approx(float(crps.mean()), rel=1e-9)
    assert found.log_score == pytest.approx(float(np.mean(norm.logpdf(z) - np.log(found.sd))), rel=1e-9)


def test_yardsticks_are_what_they_are_called(tmp_path: Path) -> None:
    folder = made_legs(tmp_path, Truth(persistent=0.05), 3)
    found = missionplan.score(mission(), folder).datasets[0].one_step
    errors = missionplan.score(mission(), folder).datasets[0].measured.reshape(-1, 2)
    last = np.concatenate([errors[:1], errors[1:] - errors[:-1]])
    mean = np.concatenate([errors[:1], errors[1:] - np.cumsum(errors, axis=0)[:-1] / np.arange(1, LEGS)[:, None]])
    for name, left in (("last_leg", last), ("mean_of_past", mean)):
        assert found.yardsticks[name].rmse == pytest.approx(float(np.sqrt(np.mean(np.sum(left**2, axis=1)))), rel=1e-9)
    assert found.skill("last_leg") == pytest.approx(1.0 - found.rmse / found.yardsticks["last_leg"].rmse)


def test_a_known_compass_is_learned_from_the_past(tmp_path: Path) -> None:
    """With the past the error of a leg shrinks to that of its own; without, the compass's stays."""
    found = missionplan.score(mission(effects=COMPASS), made_legs(tmp_path, Truth(compass_sd=np.radians(2.0)), 4))
    ahead, whole = found.datasets[0].one_step, found.datasets[0].whole
    assert ahead.sd[-1] < whole.sd.max()
    across = SPEED * SECONDS * np.radians(2.0)
    alone = np.sqrt((0.02 * SECONDS) ** 2 + 2.0 * 5.0**2)
    assert whole.sd.max() == pytest.approx(np.hypot(across, alone), rel=0.05)
    assert ahead.sd[-1] == pytest.approx(alone, rel=0.1)


def scores(tmp_path: Path, truth: Truth, effects: list[object], sigma_v: float, records: int) -> list[Score]:
    return [
        missionplan.score(mission(sigma_v, effects), made_legs(tmp_path / str(seed), truth, 100 + seed))
        for seed in range(records)
    ]


@pytest.mark.parametrize(
    ("truth", "effects", "records", "most"),
    [
        pytest.param(Truth(compass_sd=np.radians(2.0)), COMPASS, 25, 5, marks=pytest.mark.slow),
        pytest.param(Truth(persistent=0.05), PERSISTENT, 25, 5, marks=pytest.mark.slow),
        (Truth(persistent=0.05), PERSISTENT, 8, 3),
    ],
    ids=["compass", "persistent", "few-persistent"],
)
def test_a_true_mission_is_calibrated(
    tmp_path: Path, truth: Truth, effects: list[object], records: int, most: int
) -> None:
    """Made by other code: transforms are uniform, coverage is nominal, and few records are outside chance."""
    found = scores(tmp_path, truth, effects, 0.02, records)
    pit = np.concatenate([each.datasets[0].one_step.pit for each in found])
    assert kstest(pit, "uniform").pvalue > 1e-3
    count = len(pit)
    for share in (0.5, 0.9):
        inside = np.mean(np.abs(pit - 0.5) <= 0.5 * share)
        assert inside == pytest.approx(share, abs=4.0 * np.sqrt(share * (1.0 - share) / count))
    assert sum(not each.is_within_chance for each in found) <= most  # 0.05 each: more in one of 140 runs or fewer


@pytest.mark.parametrize(
    ("truth", "effects", "sigma_v"),
    [
        (Truth(compass=np.radians(8.0)), [], 0.02),
        (Truth(persistent=0.1), [], 0.02),
        (Truth(sigma_v=0.06), [], 0.02),
        (Truth(sigma_v=0.005, fix=1.0), [], 0.02),
        (Truth(persistent=0.15), PERSISTENT, 0.02),
    ],
    ids=["compass", "persistence", "too-sure", "too-doubtful", "too-little-persistence"],
)
def test_a_wrong_mission_is_found_out(tmp_path: Path, truth: Truth, effects: list[object], sigma_v: float) -> None:
    found = scores(tmp_path, truth, effects, sigma_v, 2)
    assert not any(each.is_within_chance for each in found)


def test_effects_are_worth_what_they_predict(tmp_path: Path) -> None:
    found = missionplan.score(mission(effects=PERSISTENT), made_legs(tmp_path, Truth(persistent=0.05), 5)).datasets[0]
    ahead = found.one_step
    assert ahead.rmse < ahead.yardsticks["no_effects"].rmse
    assert ahead.log_score > ahead.yardsticks["no_effects"].log_score
    assert ahead.log_score > ahead.yardsticks["last_leg"].log_score
    assert ahead.rmse < 1.02 * ahead.yardsticks["random_walk"].rmse


def test_explanations_in_doubt_are_weighed_by_the_past(tmp_path: Path) -> None:
    """A compass that is off by 6 degrees or persistent errors: after some legs the predictions are those of the truth."""
    known = [{"compass-bias": {"angle": "6 deg"}}]
    doubt = [{"one-of": [{"probability": 0.5, "effects": known}, {"probability": 0.5, "effects": PERSISTENT}]}]
    folder = made_legs(tmp_path, Truth(compass=np.radians(6.0)), 6)
    both, right = (missionplan.score(mission(effects=each), folder).datasets[0] for each in (doubt, known))
    assert both.one_step.mean[-20:] == pytest.approx(right.one_step.mean[-20:], abs=1.0)
    assert both.whole.mean == pytest.approx(0.5 * right.whole.mean, abs=2.0)
    assert np.all(both.whole.sd > right.whole.sd)


def test_the_vehicles_own_filter_is_a_yardstick(tmp_path: Path) -> None:
    """The Kalman filter of the vehicle, run along the log, predicts as the mission it was built from does."""
    raw = mission(effects=PERSISTENT).raw
    with_filter = missionplan.Mission.from_data(
        {**raw, "navigation": {**raw["navigation"], "drift_compensation": "filter"}}  # type: ignore[dict-item]
    )
    ahead = missionplan.score(with_filter, made_legs(tmp_path, Truth(persistent=0.05), 7)).datasets[0].one_step
    assert ahead.yardsticks["vehicle"].rmse == pytest.approx(ahead.rmse, rel=0.03)


def test_a_log_without_data_sets_or_of_another_kind_is_refused(tmp_path: Path) -> None:
    with pytest.raises(missionplan.InputError, match="at least one data set"):
        missionplan.score(mission())
    (tmp_path / "dataset.yaml").write_text("kind: drag\nname: tank\nfile: drag.csv\n")
    with pytest.raises(missionplan.InputError, match="drag"):
        missionplan.score(mission(), tmp_path)


def test_files_of_a_score(tmp_path: Path) -> None:
    first, second = (made_legs(tmp_path / str(k), Truth(), k) for k in (8, 9))
    found = missionplan.score(mission(), first, second)
    folder = found.save(tmp_path / "report")
    assert {"report.html", "score.json", "scores.csv", "residuals.csv"} <= {path.name for path in folder.iterdir()}
    assert len(found.to_frame()) == 4
    assert yaml.safe_load((folder / "score.json").read_text())["command"] == "score"
    assert (
        "This mission" in (folder / "report.html").read_text() or "this mission" in (folder / "report.html").read_text()
    )


def test_the_answer_is_marked_by_what_is_better_and_tells_of_intervals_that_are_far_off(tmp_path: Path) -> None:
    score = missionplan.score(mission(), made_legs(tmp_path / "log", Truth(), seed=3))
    assert 'class="good"' in score.save(tmp_path / "good").joinpath("report.html").read_text(encoding="utf-8")
    (found,) = score.datasets
    ahead = found.one_step
    yardsticks = {**ahead.yardsticks, "last_leg": replace(ahead.yardsticks["last_leg"], rmse=0.5 * ahead.rmse)}
    worse = replace(ahead, yardsticks=yardsticks, inside_50=len(ahead.z) // 5)
    changed = replace(score, datasets=(replace(found, one_step=worse),))
    page = changed.save(tmp_path / "worse").joinpath("report.html").read_text(encoding="utf-8")
    assert 'class="undecided' in page
    assert "its 50\u00a0% intervals 20\u00a0%" in page
    assert "without its effects" not in page
