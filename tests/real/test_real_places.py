"""Forty missions across real coasts and depths, without errors, against geometry and interpolation of other libraries."""

import json
from pathlib import Path

import numpy as np
import pytest
import yaml

from missionplan.errors import InputError
from missionplan.mission import load
from missionplan.scenario.scenario import Scenario
from missionplan.studies.simulation.block_statistics import failures_by_step
from missionplan.studies.simulation.simulate import simulate_block
from missionplan.studies.validate import check_place

shapely = pytest.importorskip("shapely")

PLACES = Path(__file__).parents[3] / "shared/data/place"
pytestmark = pytest.mark.skipif(not PLACES.is_dir(), reason=f"no coasts and depths at {PLACES}")
BOXES = {"chesapeake": (36.82, 37.58, -76.58, -75.82), "bergen-hardanger": (60.02, 60.58, 4.85, 5.95)}
DEPTH, HULL, CLEARANCE = 4.0, 0.2, 1.0


def mission(folder, origin, goal, **site):
    """A mission from the origin to a goal, both by latitude and longitude, straight and without errors."""
    at = [{"latitude": f"{each[0]} deg", "longitude": f"{each[1]} deg"} for each in (origin, goal)]
    data = {
        "site": {"origin": at[0], **site},
        "vehicle": {"hull": {"length": "2 m", "diameter": f"{HULL} m"}},
        "navigation": {"velocity_error": {"sigma": "0 m/s"}, "surfacing_time": "60 s"},
        "phases": [
            {
                "transit": {
                    **{"from": at[0], "to": at[1], "speed": "1.5 m/s", "depth": f"{DEPTH} m"},
                    **{"d_max": "2 km", "arrival_radius": "5 m"},
                }
            }
        ],
    }
    path = folder / "m.yaml"
    path.write_text(yaml.safe_dump(data))
    return load(path, allow_outside=True)


def reasons(loaded):
    steps = failures_by_step(simulate_block(loaded, seed=1, block=0, trials=1))
    return [step.name for step, failed in steps.items() if failed.any()]


def is_refused(loaded):
    try:
        check_place(Scenario.at_means(loaded))
    except InputError:
        return True
    return False


def straight(origin, goal, step=1.0):
    """Points along the straight way in the plane about its start, latitude and longitude [deg]."""
    from pyproj import Geod

    geod = Geod(ellps="WGS84")
    azimuth, _, length = geod.inv(origin[1], origin[0], goal[1], goal[0])
    along = np.arange(0.0, length, step)
    longitude, latitude, _ = geod.fwd(*(np.full(along.size, each) for each in (origin[1], origin[0], azimuth)), along)
    return np.asarray(latitude), np.asarray(longitude)


def drawn_missions(box, count, seed):
    rng = np.random.default_rng(seed)
    south, north, west, east = box
    for _ in range(count):
        origin = rng.uniform(south, north), rng.uniform(west, east)
        away = rng.uniform(-0.1, 0.1, 2) * np.array([1.0, 1.5])
        goal = np.clip(origin[0] + away[0], south, north), np.clip(origin[1] + away[1], west, east)
        yield origin, (float(goal[0]), float(goal[1]))


@pytest.mark.parametrize("name", BOXES)
def test_missions_past_a_real_coast_are_lost_where_their_straight_way_meets_land(tmp_path, name):
    parts = [json.loads((PLACES / f"ne_10m_{kind}_{name}.geojson").read_text()) for kind in ("land", "minor_islands")]
    together = {"type": "FeatureCollection", "features": [each for part in parts for each in part["features"]]}
    (tmp_path / "land.geojson").write_text(json.dumps(together))
    land = shapely.union_all([shapely.geometry.shape(each["geometry"]) for each in together["features"]])
    told = []
    for origin, goal in drawn_missions(BOXES[name], 13, 4):
        latitude, longitude = straight(origin, goal, 5.0)
        way = shapely.linestrings(longitude, latitude)
        if 0.0 < shapely.distance(way, land) < 2e-5:
            continue  # within two metres: which of the two is a matter of the plane
        loaded = mission(tmp_path, origin, goal, land={"file": "land.geojson"})
        crosses = bool(shapely.intersects(way, land))
        assert reasons(loaded) == (["on-land"] if crosses else [])
        assert is_refused(loaded) == crosses
        told.append(crosses)
    assert len(told) >= 12
    assert 0 < sum(told) < len(told)


def test_missions_over_a_real_grid_run_aground_where_other_interpolation_says_so(tmp_path):
    import xarray
    from scipy.interpolate import RegularGridInterpolator

    with xarray.open_dataset(PLACES / "gebco_2020_oresund.nc") as data:
        latitude, longitude = (data[key].to_numpy().astype(float) for key in ("lat", "lon"))
        elevation = data["elevation"].to_numpy().astype(float)
    height = RegularGridInterpolator((latitude, longitude), elevation)
    told = []
    for origin, goal in drawn_missions((55.25, 56.25, 12.25, 13.05), 60, 9):
        if np.ravel(height(origin))[0] > -8.0:
            continue
        depth = -height(np.stack(straight(origin, goal), axis=1))
        spare = depth.min() - (DEPTH + HULL / 2.0 + CLEARANCE)
        if abs(spare) < 0.05:
            continue
        grid = {"file": str(PLACES / "gebco_2020_oresund.nc")}
        loaded = mission(tmp_path, origin, goal, bathymetry=grid, depth_datum="MSL", clearance=f"{CLEARANCE} m")
        assert reasons(loaded) == (["aground"] if spare < 0.0 else [])
        if spare > 1.0:
            assert not is_refused(loaded)
        told.append(spare < 0.0)
        if len(told) == 16:
            break
    assert len(told) == 16
    assert 0 < sum(told) < len(told)


def test_the_shortest_way_round_keeps_clear_of_a_real_coast(tmp_path):
    land = {"file": str(PLACES / "ne_10m_land_chesapeake.geojson")}
    # from the bay round Cape Charles into the ocean
    origin, goal = (37.20, -76.10), (37.20, -75.85)
    loaded = mission(tmp_path, origin, goal, land=land)
    assert is_refused(loaded)
    round_it = loaded.with_({"transit.via": "auto", "navigation.velocity_error": {"sigma": "0.02 m/s"}})
    assert not is_refused(round_it)
    assert len(Scenario.at_means(round_it).ways(round_it.transits[0])) >= 1
    steps = failures_by_step(simulate_block(round_it, seed=1, block=0, trials=200))
    assert sum(int(failed.sum()) for failed in steps.values()) == 0
