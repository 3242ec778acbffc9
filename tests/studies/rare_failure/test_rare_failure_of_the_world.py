"""Rare failures by ground, coast, zones and equipment, against closed forms: one leg, whose end is normal."""

import json
import math

import numpy as np
import pytest
import scipy

from missionplan.mission import Mission
from missionplan.studies.rare_failure import find_rare_failure

pytest.importorskip("shapely")

SIDE = 0.03 * 1000.0 / 1.2
"""Standard deviation across the course after a leg of 1000 m [m]."""
FAR = 4.4 * SIDE


def mission(folder, *, site, hazards=()):
    transit = {"name": "out", "from": ["0 m", "0 m"], "to": ["1000 m", "0 m"], "speed": "1.2 m/s", "depth": "5 m"}
    return Mission.from_data(
        {
            "vehicle": {"hull": {"length": "1 m", "diameter": "0.1 m"}, "reliability": list(hazards)},
            "start": "2026-06-01T09:00Z",
            "site": site,
            "navigation": {"velocity_error": {"sigma": "0.03 m/s"}, "surfacing_time": "60 s", "fix_error": "0 m"},
            "phases": [{"transit": {**transit, "d_max": "2 km", "arrival_radius": "400 m"}}],
        }
    )


def box(folder, west, south, east, north, **properties):
    ring = [[west, south], [east, south], [east, north], [west, north], [west, south]]
    shape = {"type": "Feature", "properties": properties, "geometry": {"type": "Polygon", "coordinates": [ring]}}
    (folder / "zone.geojson").write_text(json.dumps(shape))
    return {"file": str(folder / "zone.geojson"), "projection": "local"}


def grid(folder, depth, step=40.0):
    x, y = np.meshgrid(np.arange(-490.0, 1500.0, step), np.arange(-470.0, 500.0, step))
    table = np.stack([a.ravel() for a in (x, y, -depth(x, y))], axis=1)
    np.savetxt(folder / "bottom.xyz", table, fmt="%.5f")
    return {"file": str(folder / "bottom.xyz"), "projection": "local"}


def rise(x, y):
    """Level at 12 m until 40 m from where it is too shallow, then 1 in 10 up."""
    return np.clip(5.05 - 0.1 * (y - FAR), -5.0, 12.0)


CASES = {
    "on-land": lambda folder: {"land": box(folder, -500.0, FAR, 2000.0, 900.0)},
    "keep-out": lambda folder: {"keep_out": box(folder, -500.0, FAR, 2000.0, 900.0, **{"to": "2026-06-01T12:00Z"})},
    "aground": lambda folder: {"bathymetry": grid(folder, rise)},
    "left the grid of depths": lambda folder: {
        "bathymetry": grid(folder, lambda x, y: np.where(y < FAR + 1.0, 30.0, np.nan))
    },
}


@pytest.mark.parametrize(
    "reason", [*list(CASES)[:1], *(pytest.param(each, marks=pytest.mark.slow) for each in list(CASES)[1:])]
)
def test_a_leg_that_ends_too_far_to_the_side_meets_the_limit_as_often_as_a_normal_says(tmp_path, reason):
    found = find_rare_failure(mission(tmp_path, site=CASES[reason](tmp_path)), seed=5, precision="30%")
    exact = scipy.special.ndtr(-4.4)
    assert found.probability.low / 1.2 < exact < found.probability.high * 1.2
    assert [mode.step for mode in found.modes] == [f"out: {reason}"]
    assert found.variation < 0.4


@pytest.mark.slow
def test_a_tide_that_is_too_low_is_found_over_level_ground(tmp_path):
    site = {"bathymetry": grid(tmp_path, lambda x, y: 9.05 + 0.0 * x), "tide_height": {"mean": "0 m", "sd": "0.9 m"}}
    found = find_rare_failure(mission(tmp_path, site=site), seed=6, precision="30%")
    exact = scipy.special.ndtr(-4.0 / 0.9)
    assert found.probability.low / 1.2 < exact < found.probability.high * 1.2


def test_equipment_is_driven_by_its_cumulative_hazard_whatever_its_law(tmp_path):
    hazards = [
        {"per": "hour", "rate": "2e-6 1/h"},
        {"per": "km", "shape": 2.0, "scale": "1000 km"},
        {"per": "surfacing", "rate": 1e-6},
    ]
    found = find_rare_failure(mission(tmp_path, site={}, hazards=hazards), seed=7, precision="30%")
    hours = (1000.0 / 1.2 + 60.0) / 3600.0
    exact = -math.expm1(-(2e-6 * hours + 1e-6 + 1e-6))
    assert found.probability.low / 1.2 < exact < found.probability.high * 1.2
    assert [mode.step for mode in found.modes] == ["out: equipment"]


def test_ways_without_a_margin_are_bounded_one_by_one(tmp_path):
    site = {"current": [{"down_to": "20 m", "speed": "0 m/s", "toward": "0 deg"}]}
    hazards = [{"per": "surfacing", "rate": 1e-6}]
    found = find_rare_failure(mission(tmp_path, site=site, hazards=hazards), seed=5, precision="30%")
    told = {way.way: way for way in found.ways}
    assert 0.0 < told["out: current faster than the vehicle"].bound < 0.003
