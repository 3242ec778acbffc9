"""Scores of dives: calibration on dives that share no code with the package, and a drag that is wrong."""

from pathlib import Path

import pytest

import missionplan
from missionplan.results.score import Score
from tests.hidden_effects.cases import draw_case


def scored(tmp_path: Path, seed: int, scenario: str, effect: str | None = None) -> Score:
    case = draw_case(seed, "descent", scenario, effect)
    mission, dataset = case.write(tmp_path / str(seed), tmp_path / "truth")
    return missionplan.score(mission, dataset)


@pytest.mark.slow
def test_dives_without_an_effect_are_within_chance(tmp_path: Path) -> None:
    found = [scored(tmp_path, 71_000 + k, "control") for k in range(6)]
    assert sum(not each.is_within_chance for each in found) <= 2
    values = [each.datasets[0] for each in found]
    inside = sum(each.one_step.inside_90 for each in values) / sum(len(each.measured) for each in values)
    assert inside == pytest.approx(0.9, abs=0.12)


@pytest.mark.parametrize("seed", [pytest.param(72_000, marks=pytest.mark.slow), 72_001])
def test_a_drag_that_is_wrong_is_found_out_and_learned_from_the_past(tmp_path: Path, seed: int) -> None:
    found = scored(tmp_path, seed, "single", "drag-bias")
    assert not found.is_within_chance
    assert found.datasets[0].one_step.rmse < found.datasets[0].whole.rmse
