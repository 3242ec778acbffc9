"""Missions over a grid of depths and past land: reasons, places, and the mooring's depth and slope."""

import json
import math

import numpy as np
import pytest
import yaml

from missionplan.errors import InputError
from missionplan.mission import load
from missionplan.results.failures import Counted, CountedKind, Failure
from missionplan.scenario.scenario import Scenario, leg_spread
from missionplan.studies.simulation import block_statistics, trial_block
from missionplan.studies.simulation.block_statistics import failures_by_step
from missionplan.studies.simulation.simulate import simulate, simulate_block
from missionplan.studies.validate import check_place, tracks_lost

shapely = pytest.importorskip("shapely")

MISSION = {
    "vehicle": {
        "hull": {"length": "1.12 m", "diameter": "0.12 m"},
        "mass": "10.2 kg",
        "net_buoyancy": "0.9 N",
        "anchor": {"diameter": "0.12 m", "flooded_mass": "2.6 kg"},
    },
    "site": {
        "water": {"density": "1000 kg/m^3", "viscosity": "1.1e-6 m^2/s"},
        "current": [{"down_to": "200 m", "speed": {"mean": "0.2 m/s", "sd": "0.05 m/s"}, "toward": "90 deg"}],
        "bathymetry": {"file": "slope.xyz", "projection": "local"},
    },
    "navigation": {"velocity_error": {"sigma": "0.03 m/s"}, "surfacing_time": "30 s", "fix_error": "3 m"},
    "phases": [
        {
            "transit": {
                **{"name": "out", "from": ["0 m", "0 m"], "to": ["1000 m", "0 m"], "speed": "1.2 m/s"},
                **{"d_max": "300 m", "arrival_radius": "20 m", "depth": "5 m"},
            }
        },
        {"moor": {"radius": "40 m", "anchor_wet_weight": "12 N", "line_length": "5 m", "hold": "10 min"}},
    ],
}


@pytest.fixture
def write(tmp_path):
    """Write the mission over a bottom whose depth is a function of east and north, with polygons of boxes."""

    def make(depth=lambda x, y: 20.0 + 0.03 * x, land=(), keep_out=(), **site):
        x, y = np.meshgrid(np.arange(-1000.0, 2001.0, 50.0), np.arange(-1500.0, 1501.0, 50.0))
        np.savetxt(tmp_path / "slope.xyz", np.stack([a.ravel() for a in (x, y, -depth(x, y))], axis=1), fmt="%.4f")
        data = json.loads(json.dumps(MISSION))
        for key, boxes in (("land", land), ("keep_out", keep_out)):
            if boxes:
                shape = shapely.geometry.mapping(shapely.union_all([shapely.box(*box) for box in boxes]))
                (tmp_path / f"{key}.geojson").write_text(json.dumps(shape))
                data["site"][key] = {"file": f"{key}.geojson", "projection": "local"}
        data["site"] |= site
        path = tmp_path / "m.yaml"
        path.write_text(yaml.safe_dump(data))
        return load(path)

    return make


def failing(block):
    return {str(step): int(failed.sum()) for step, failed in failures_by_step(block).items() if failed.any()}


def test_the_anchor_goes_down_to_the_depth_where_it_lands(write):
    mission = write()
    block = simulate_block(mission, seed=1, block=0, trials=500)
    moor = block.phases[1]
    landed = moor.anchor
    descent = moor.quantities["descent_time_s"]
    fall = np.polyfit(20.0 + 0.03 * landed[0], descent, 1)
    flat = simulate_block(write(lambda x, y: 50.0 + 0.0 * x), seed=1, block=0, trials=500).phases[1]
    shallow = simulate_block(write(lambda x, y: 49.0 + 0.0 * x), seed=1, block=0, trials=500).phases[1]
    a_metre = np.nanmean(flat.quantities["descent_time_s"] - shallow.quantities["descent_time_s"])
    assert fall[0] == pytest.approx(a_metre, rel=0.02)
    assert np.nanstd(descent - np.polyval(fall, 20.0 + 0.03 * landed[0])) < 0.05 * np.nanstd(descent)


def test_a_sloping_grid_is_the_mission_with_that_depth_and_slope(write):
    angle = math.degrees(math.atan(0.03))
    on_grid = simulate_block(write(), seed=3, block=0, trials=300).phases[1]
    given = json.loads(json.dumps(MISSION))
    del given["site"]["bathymetry"]
    given["site"] |= {"depth": "50 m", "slope": {"angle": f"{angle} deg", "toward": "90 deg"}}
    by_hand = simulate_block(type(write()).from_data(given), seed=3, block=0, trials=300).phases[1]
    for name in ("holding_margin", "nose_altitude_m"):
        assert np.nanmean(on_grid.quantities[name]) == pytest.approx(np.nanmean(by_hand.quantities[name]), rel=0.01)


def test_nothing_is_lost_over_a_flat_bottom_and_the_numbers_are_those_of_a_depth(write):
    flat = simulate_block(write(lambda x, y: 40.0 + 0.0 * x), seed=2, block=0, trials=200)
    given = json.loads(json.dumps(MISSION))
    del given["site"]["bathymetry"]
    given["site"]["depth"] = "40 m"
    plain = simulate_block(type(write()).from_data(given), seed=2, block=0, trials=200)
    for one, other in zip(flat.phases, plain.phases, strict=True):
        for name, values in one.quantities.items():
            assert values == pytest.approx(other.quantities[name], rel=1e-5, nan_ok=True), name


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"depth": lambda x, y: np.where(np.abs(x - 500.0) < 60.0, 3.0, 40.0)}, "out: aground"),
        ({"depth": lambda x, y: np.where(np.abs(x - 500.0) < 60.0, -2.0, 40.0)}, "out: aground"),
        ({"land": [(480.0, -2000.0, 520.0, 2000.0)]}, "out: on-land"),
        ({"land": [(900.0, -200.0, 1200.0, 200.0)]}, "out: on-land"),
        ({"keep_out": [(480.0, -2000.0, 520.0, 2000.0)]}, "out: keep-out"),
        ({"depth": lambda x, y: np.where(x > 500.0, np.nan, 40.0)}, "out: left the grid of depths"),
        (
            {"depth": lambda x, y: np.where(x > 700.0, 5.9, 40.0)},
            "moor: line and vehicle longer than the water is deep",
        ),
    ],
)
def test_every_trial_is_lost_where_none_can_pass(write, changes, reason):
    depth = changes.pop("depth", lambda x, y: 40.0 + 0.0 * x)
    assert failing(simulate_block(write(depth, **changes), seed=1, block=0, trials=100)) == {reason: 100}


def test_the_clearance_decides(write):
    depth = lambda x, y: 6.0 + 0.0 * x  # noqa: E731
    lost = failing(simulate_block(write(depth, clearance="1 m"), seed=1, block=0, trials=50))
    assert lost == {"out: aground": 50}
    kept = failing(simulate_block(write(depth, clearance="0.9 m"), seed=1, block=0, trials=50))
    assert "out: aground" not in kept


def test_the_result_says_where_and_on_which_leg(write):
    mission = write(lambda x, y: 40.0 + 0.0 * x, land=[(480.0, -2000.0, 520.0, 2000.0)])
    outcome = simulate(mission, trials=60, seed=1, sheet=False)
    (contact,) = outcome.summary()["contacts"]
    assert contact["phase"] == "out"
    assert contact["cause"] == "on-land"
    assert contact["legs"] == {"2": 60}
    assert contact["east_m"] == pytest.approx(480.0, abs=0.1)
    assert abs(contact["north_m"]) < 20.0
    assert outcome.total.events["success"].value == 0.0


def test_depth_at_the_mooring_stands_for_the_site(write):
    assert Scenario.at_means(write(tide_height="1 m")).drawn.site.depth == pytest.approx(51.0, abs=0.01)


@pytest.mark.parametrize(
    ("boxes", "key"),
    [
        ([(980.0, -30.0, 1030.0, 30.0)], "out.to"),
        ([(-30.0, -30.0, 30.0, 30.0)], "out.from"),
        ([(480.0, -2500.0, 520.0, 2500.0)], "out.to"),
        ([(480.0, -2500.0, 520.0, -400.0), (480.0, 400.0, 520.0, 2500.0)], None),  # a strait 800 m wide
        ([(980.0, -30.0, 999.0, 30.0), (1001.0, -30.0, 1030.0, 30.0)], None),  # a metre to spare on each side
    ],
)
def test_what_no_trial_can_reach_is_refused(write, boxes, key):
    means = Scenario.at_means(write(lambda x, y: 40.0 + 0.0 * x, land=boxes))
    if key is None:
        check_place(means)
        return
    with pytest.raises(InputError) as caught:
        check_place(means)
    assert key in {problem.key for problem in caught.value.problems}


def test_the_share_of_tracks_lost_is_told_beforehand(write):
    partly = write(lambda x, y: 40.0 + 0.0 * x, land=[(480.0, 2.0, 520.0, 2500.0)])
    check_place(Scenario.at_means(partly))
    (notice,) = tracks_lost(Scenario.at_means(partly))
    share = float(notice.split("ahead ")[1].split(" %")[0])
    lost = simulate(partly, trials=600, seed=5, sheet=False).contacts[0].lost
    assert abs(share / 100.0 - lost.value) < 0.08
    assert "on-land" in notice


def test_tracks_lost_in_several_ways_are_told_together(write, monkeypatch):
    flags = np.arange(100) < np.array([[30], [0], [12]])
    reasons = (("out", Failure.ON_LAND), ("out", Failure.AGROUND), ("home", Failure.AGROUND))
    lost = {Counted(CountedKind.FAILURE, *reason): each for reason, each in zip(reasons, flags, strict=True)}
    lost[Counted(CountedKind.FAILURE, "home", Failure.NOT_ARRIVED)] = np.ones(100, dtype=bool)  # is no place's
    monkeypatch.setattr(trial_block, "run_block", lambda *_, **__: None)
    monkeypatch.setattr(block_statistics, "failures_by_step", lambda _: lost)
    (notice,) = tracks_lost(Scenario.at_means(write()))
    assert "42 % would be lost: 30 % out: on-land, 12 % home: " in notice


def test_a_transit_goes_by_its_points_and_leg_numbers_go_on(write):
    land = [(480.0, -2500.0, 520.0, 100.0)]
    direct = write(lambda x, y: 40.0 + 0.0 * x, land=land)
    around = direct.with_({"out.via": [["500 m", "400 m"]]})
    lost = failing(simulate_block(around, seed=1, block=0, trials=300))
    assert "out: on-land" not in lost
    assert failing(simulate_block(direct, seed=1, block=0, trials=300))["out: on-land"] == 300
    block = simulate_block(around, seed=1, block=0, trials=300).phases[0]
    least = math.hypot(500.0, 400.0) * 2.0
    assert least - 60.0 < np.nanmedian(block.quantities["distance_m"]) < 1.2 * least


def test_the_way_round_is_found_and_clear_by_the_drift(write):
    around = write(lambda x, y: 40.0 + 0.0 * x, land=[(480.0, -2500.0, 520.0, 300.0)]).with_({"out.via": "auto"})
    means = Scenario.at_means(around)
    ways, margin = means.ways(around.transits[0]), leg_spread(means, around.transits[0])
    line = shapely.linestrings([(0.0, 0.0), *ways, (1000.0, 0.0)])
    kept = shapely.distance(line, shapely.box(480.0, -2500.0, 520.0, 300.0))
    assert 0.75 * margin < kept < 1.5 * margin
    shortest = 2.0 * math.hypot(480.0, 300.0) + 40.0
    assert shortest < line.length < shortest + 4.0 * margin
    check_place(means)
    assert "out: on-land" not in failing(simulate_block(around, seed=1, block=0, trials=300))


def test_shoals_are_gone_round_too(write):
    shoal = lambda x, y: np.where((np.abs(x - 500.0) < 60.0) & (y < 500.0), 2.0, 40.0)  # noqa: E731
    around = write(shoal).with_({"out.via": "auto"})
    assert len(Scenario.at_means(around).ways(around.transits[0])) >= 1
    assert "out: aground" not in failing(simulate_block(around, seed=1, block=0, trials=200))
    with pytest.raises(InputError):
        check_place(Scenario.at_means(write(shoal)))


def test_maps_and_exports_hold_depths_and_fences(write, tmp_path):
    from missionplan.exporters import geojson, kml

    mission = write(
        lambda x, y: 40.0 + 0.01 * x,
        land=[(480.0, 300.0, 520.0, 900.0)],
        origin={"latitude": "37 deg", "longitude": "-76 deg"},
    )
    outcome = simulate(mission, trials=60, seed=1, sheet=False)
    assert outcome.chart.depth.shape == (150, 150)
    assert [kind for kind, _ in outcome.chart.shapes] == ["land"]
    (text,) = geojson.files(outcome.plan, "m").values()
    (fence,) = [each for each in json.loads(text)["features"] if each["properties"]["kind"] == "land"]
    ring = shapely.Polygon(fence["geometry"]["coordinates"][0])
    assert ring.exterior.is_ccw
    assert ring.bounds[0] == pytest.approx(
        -76.0 + math.degrees(480.0 / 6378137.0) / math.cos(math.radians(37.0)), abs=2e-5
    )
    (text,) = kml.files(outcome.plan, "m").values()
    assert "Keep out" in text
    assert "mission" in {path.stem for path in (outcome.save(tmp_path / "out") / "figures").iterdir()}
