"""Vehicles that are diagnosed mission after mission: levels at their dates, trends and jumps that are told."""

import numpy as np
import pytest

from . import __main__ as fleets
from .dives import Diving


@pytest.mark.parametrize("way", fleets.WAYS)
def test_vehicles_change_as_they_are_said_to(way):
    rng = np.random.default_rng(3)
    found, at = fleets.levels_of(rng, way, fleets.COMPASS)
    steps = np.diff(found[fleets.COMPASS])
    assert set(fleets.levels_of(rng, way, fleets.DRAG)[0]) == {fleets.DRAG}
    assert not np.diff(found[fleets.LOG]).any()
    moved = {"constant": 0, "drifting": fleets.MISSIONS - 1, "jumping": 1, "redrawn": fleets.MISSIONS - 1}[way]
    assert np.count_nonzero(steps) == moved
    assert (at is None) == (way != "jumping")
    assert at is None or steps[at - 1] != 0.0


def test_dives_have_their_date_and_are_parted_into_a_light_and_a_heavy_one():
    vehicle = Diving(np.random.default_rng(3), {fleets.DRAG: np.array([0.2, 0.3])})
    record = vehicle.record(1)
    halves = vehicle.halves(record)
    assert record[2]["start"].startswith("2026-02-09")
    assert sorted(row for _, rows, _ in halves for row in rows) == sorted(record[1])
    for _, _, told in halves:
        assert len({run["anchor_wet_weight"] for run in told["runs"].values()}) == 2


@pytest.mark.slow
def test_levels_are_told_mission_after_mission():
    """One vehicle a way of those of ``python -m tests.fleets``, whose figures validation/measured/calibration.json has."""
    found = [fleets.run(seed) for seed in range(4)]
    held = np.concatenate([(*fleet.held, *fleet.beside) for fleet in found])
    assert held.mean() > 0.8
    assert np.mean([gain for fleet in found for gain in fleet.gains]) > -0.5
    assert not any(fleet.false_trend for fleet in found)
