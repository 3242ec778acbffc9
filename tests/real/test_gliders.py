"""Navigation logs of two gliders, shared beside the repository; skipped if absent."""

from pathlib import Path

import pytest

from missionplan import diagnose
from missionplan.mission import load

DATA = Path(__file__).parents[2].parent / "shared" / "data"


@pytest.fixture(scope="module")
def diagnosed():
    def run(name):
        folder = DATA / name
        if not folder.is_dir():
            pytest.skip(f"no measured data: {folder}")
        return diagnose(load(folder / "mission.yaml"), folder, plan=False)

    return run


@pytest.mark.slow
def test_modena_has_persistence_and_an_inertial_current(diagnosed):
    found = diagnosed("modena")
    assert {"persistent-error", "inertial-current"} <= set(found.causes)
    assert not {"tidal-current", "compass-bias", "compass-deviation", "speed-scale"} & set(found.causes)
    assert found.base_discrepancy.log_bayes_factor > 3.0
    # yardsticks: unweighted mean of past velocity errors 1.53 km, last leg's error 0.451 km
    assert found.calibration["next_leg_mean_so_far_rms_m"] == pytest.approx(1530.0, rel=0.01)
    assert found.calibration["next_leg_last_leg_rms_m"] == pytest.approx(451.0, rel=0.01)
    assert found.calibration["next_leg_model_rms_m"] <= 400.0


def test_saanich_is_adequate(diagnosed):
    found = diagnosed("saanich")
    assert found.verdict == "adequate"
    assert () in found.credible_set


@pytest.mark.slow
def test_modena_extended_on_legs_1_to_60_predicts_the_rest():
    """Better than the last leg does, with 90 % intervals whose binomial interval holds 0.90."""
    folder = DATA / "modena"
    if not folder.is_dir():
        pytest.skip(f"no measured data: {folder}")
    last = diagnose(load(folder / "mission.yaml"), folder, plan=False, holdout=0.38).last_part
    assert last.groups == 37
    assert last.one_step.skill("last_leg") > 0.1
    covered = last.summary()["predictions"]["one_step"]["coverage_90"]
    assert covered["low"] <= 0.9 <= covered["high"]
    assert last.is_within_chance
