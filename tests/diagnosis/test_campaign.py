"""Several data sets of one campaign: one extended mission, in any order, with every hidden effect found."""

from collections.abc import Callable
from contextlib import AbstractContextManager
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

import missionplan
from missionplan.diagnosis.campaign import _place
from missionplan.mission import Mission
from missionplan.results.learned import Campaign, Diagnosis
from tests.fixtures import TRANSIT
from tests.hidden_effects.cases import draw_case

CAUSES = ("drag-bias", "clock-offset", "compass-bias", "mean-current", "persistent-error")
COMPASS = 4.0
"""Hidden in the legs [deg]."""


def write_legs(folder: Path, name: str, seed: int, legs: int = 18) -> Path:
    """Legs of a star about the origin, the compass off; by a plain loop."""
    generator, rows, t = np.random.default_rng(seed), [], 0.0
    start = np.zeros(2)
    for leg in range(legs):
        course = 2.0 * np.pi * (leg % 6) / 6
        speed, seconds = 0.75, 1200.0
        reckoned = start + speed * seconds * np.array([np.sin(course), np.cos(course)])
        turned = course + np.radians(COMPASS)
        moved = speed * seconds * np.array([np.sin(turned), np.cos(turned)])
        end = start + moved + 0.02 * seconds * generator.standard_normal(2)
        rows.append([t, t + seconds, *start, *reckoned, *end])
        start, t = end, t + seconds + 300.0
    folder.mkdir(parents=True)
    columns = ["t_start_s", "t_end_s", "x_start_m", "y_start_m", "x_dr_m", "y_dr_m", "x_end_m", "y_end_m"]
    pd.DataFrame(rows, columns=columns).to_csv(folder / "legs.csv", index=False)
    (folder / "dataset.yaml").write_text(yaml.safe_dump({"kind": "transit", "name": name, "file": "legs.csv"}))
    return folder


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Path]]:
    """A mission, dives with more drag than it has, and two logs of legs with a compass that is off."""
    root = tmp_path_factory.mktemp("campaign")
    mission, dives = draw_case(72_001, "descent", "single", "drag-bias").write(root / "dives", root / "truth")
    raw = yaml.safe_load(mission.read_text())
    raw["navigation"] = {"velocity_error": {"sigma": "0.02 m/s"}, "surfacing_time": "5 min"}
    transit = {"to": ["4 km", "0 m"], "speed": "0.75 m/s", "d_max": "1 km", "arrival_radius": "50 m"}
    raw["phases"] = [{"transit": {"from": ["0 m", "0 m"], **transit}}, *raw["phases"]]
    raw["site"].pop("current", None)  # the legs are made in still water
    path = mission.parent / "both.yaml"
    path.write_text(yaml.safe_dump(raw, sort_keys=False))
    logs = [write_legs(root / f"legs-{k}", f"legs {k}", 40 + k) for k in (1, 2)]
    return path, [dives, *logs]


@pytest.fixture(scope="module")
def found(campaign: tuple[Path, list[Path]], causes: Callable[[], AbstractContextManager[None]]) -> Campaign:
    with causes():
        return missionplan.diagnose_campaign(*campaign, plan=False)


@pytest.mark.slow
@pytest.mark.usefixtures("among_few")
def test_the_order_of_data_sets_does_not_matter(campaign: tuple[Path, list[Path]], found: Campaign) -> None:
    path, folders = campaign
    assert missionplan.diagnose_campaign(path, folders[::-1], plan=False).extended == found.extended


def test_data_sets_of_a_kind_are_taken_by_date_those_without_one_last_then_by_name(tmp_path: Path) -> None:
    folders = [write_legs(tmp_path / name, name, 50) for name in "dcba"]
    for folder, start in zip(folders, ("2026-03-01", "2026-04-01", None, None), strict=True):
        keys = yaml.safe_load((folder / "dataset.yaml").read_text())
        (folder / "dataset.yaml").write_text(yaml.safe_dump(keys | ({"start": f"{start}T00:00:00Z"} if start else {})))
    mission = Mission.from_data(TRANSIT)
    assert [each.name for each in sorted(folders, key=partial(_place, mission=mission))] == ["d", "c", "a", "b"]


def test_one_mission_carries_what_legs_and_dives_show(found: Campaign, tmp_path: Path) -> None:
    assert [each.kind for each in found.diagnoses] == ["descent", "transit", "transit"]
    assert set(found.informed_by) == {"drag-bias", "compass-bias"}
    assert found.shared == ("compass-bias",)
    assert found.diagnoses[2].verdict == "adequate"
    (angle,) = [p for p in found.diagnoses[2].confirmed if p.effect == "compass-bias"]
    (first,) = [p for p in found.diagnoses[1].best.parameters if p.effect == "compass-bias"]  # type: ignore[union-attr]
    assert angle.sd < first.sd
    assert np.degrees(angle.low) < COMPASS < np.degrees(angle.high)
    folder = found.save(tmp_path / "reports" / "campaign")
    assert "Together 3 data sets tell of drag bias, compass bias" in (folder / "report.html").read_text()
    assert missionplan.load(folder / "mission.yaml").effects
    history = missionplan.history(tmp_path / "reports")
    assert {key[0] for key in history.parameters} == {"drag-bias", "compass-bias"}


@pytest.mark.slow
def test_dives_say_nothing_of_the_compass(campaign: tuple[Path, list[Path]]) -> None:
    """Legs and dives have no effect in common: together they give what each gives alone."""
    path, (dives, log, _) = campaign
    together = missionplan.diagnose_campaign(path, [log, dives], plan=False)
    alone = missionplan.diagnose(path, log, plan=False)
    assert together.diagnoses[1].causes == alone.causes
    assert together.diagnoses[1].best == alone.best


def test_a_data_set_given_twice_is_refused(campaign: tuple[Path, list[Path]]) -> None:
    path, folders = campaign
    with pytest.raises(missionplan.InputError, match="each one once"):
        missionplan.diagnose_campaign(path, [folders[0], folders[0]])


@pytest.mark.slow
def test_a_doubt_that_the_dives_leave_outlasts_the_legs(campaign: tuple[Path, list[Path]], tmp_path: Path) -> None:
    """Dives of one line cannot tell a slow line from a late clock, and legs have no say in it."""
    mission, dives = draw_case(5, "descent", "tie").write(tmp_path / "dives", tmp_path / "truth")
    raw = yaml.safe_load(mission.read_text())
    raw["navigation"] = {"velocity_error": {"sigma": "0.02 m/s"}, "surfacing_time": "5 min"}
    transit = {"to": ["4 km", "0 m"], "speed": "0.75 m/s", "d_max": "1 km", "arrival_radius": "50 m"}
    raw["phases"] = [{"transit": {"from": ["0 m", "0 m"], **transit}}, *raw["phases"]]
    raw["site"].pop("current", None)
    (mission.parent / "both.yaml").write_text(yaml.safe_dump(raw, sort_keys=False))
    found = missionplan.diagnose_campaign(mission.parent / "both.yaml", [dives, campaign[1][1]], plan=False)
    assert found.diagnoses[1].causes == ("compass-bias",)
    after, before = (each["posterior"].draws for each in (found.extended, found.diagnoses[0].extended))
    for name in ("line-payout", "clock-offset"):
        assert 0.05 < before.probability(name) < 0.95
        assert after.probability(name) == pytest.approx(before.probability(name), abs=0.02)
    assert after.probability("compass-bias") > 0.95
    page = (found.save(tmp_path / "report") / "report.html").read_text()
    assert "Still in doubt: " in page


def test_each_record_of_legs_or_dives_keeps_a_part_away_and_trials_follow_the_last(
    campaign: tuple[Path, list[Path]], found: Campaign, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What each is asked for, and which mission it is laid against; the answers are those without."""
    asked, answers = [], iter(found.diagnoses)

    def one(mission: missionplan.Mission, folder: Path, **options: object) -> Diagnosis:
        asked.append((folder.name, options["holdout"], options["next_trial"], len(mission.effects)))
        return next(answers)

    monkeypatch.setattr("missionplan.diagnosis.campaign.diagnose", one)
    path, folders = campaign
    together = missionplan.diagnose_campaign(path, folders, plan=False, holdout=0.3, next_trial=True)
    assert [each[:3] for each in asked] == [
        (folders[0].name, 0.3, False), ("legs-1", 0.3, False), ("legs-2", 0.3, True),
    ]  # fmt: skip
    assert asked[0][3] < asked[1][3]
    assert together.provenance.options["holdout"] == 0.3


@pytest.mark.slow
def test_the_last_part_of_each_log_is_kept_away_and_trials_follow_the_last(
    campaign: tuple[Path, list[Path]], tmp_path: Path
) -> None:
    """Two logs of 30 legs, of which 21 each are learned from."""
    path, _ = campaign
    logs = [write_legs(tmp_path / f"legs-{k}", f"legs {k}", 40 + k, legs=30) for k in (1, 2)]
    found = missionplan.diagnose_campaign(path, logs, plan=False, holdout=0.3, next_trial=True)
    parts = [each.last_part for each in found.diagnoses]
    assert [part.groups for part in parts if part is not None] == [9, 9]
    assert [len(each.residuals) for each in found.diagnoses] == [21, 21]
    assert found.diagnoses[0].next_trial is None
    assert found.diagnoses[1].next_trial is not None
    assert found.provenance.options["holdout"] == 0.3
