"""The drift afloat: exact in eddies, with the wind, with the error of a current, and found by searches."""

import json
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.path import Path as Outline

import missionplan
from missionplan.mission import Mission
from missionplan.phases.currents import Current, Leeway, layers, leeway_velocity
from missionplan.phases.ensemble import ErringCurrent, ErrorWaves
from missionplan.phases.ground import Frame, Ground
from missionplan.phases.place import Place, SeaLevel
from missionplan.phases.zones import Fence, Zone
from missionplan.results.whereabouts import AFLOAT, DriftAssumption
from missionplan.scenario.scenario import Scenario
from missionplan.studies.simulation.drift import UNSTATED_ERROR, UNSTATED_TIME, Drift, _shore, _tide
from missionplan.studies.simulation.losses import Losses, Search, encloses, read_searches
from missionplan.studies.simulation.overdue import search_areas

pytestmark = pytest.mark.usefixtures("unplanned", "unranked", "unheld")

DAY = 86_400.0
WINDY = """
name: Windy
start: 2026-06-01T08:00Z
site:
  origin: {latitude: 37.25 deg, longitude: -76.38 deg}
  depth: 30 m
  current: [{down_to: 30 m, speed: %s, toward: 60 deg}]
  wind: %s
navigation: {velocity_error: {sigma: 0.02 m/s}, surfacing_time: 60 s}
phases:
  - transit: {from: [0 m, 0 m], to: [800 m, 0 m], depth: 2 m, speed: 1.5 m/s, d_max: 300 m, arrival_radius: 150 m}
monte_carlo: {trials: 400, seed: 1}
"""


@dataclass(frozen=True)
class Eddy(Current):
    """Solid rotation about the origin, once a period [s]."""

    period: float

    def velocity(self, t, depth, position):
        return 2.0 * np.pi / self.period * np.stack((-position[1], position[0]))


def test_in_a_steady_eddy_it_stays_at_its_distance():
    """A day in an eddy of 3 km that turns in five hours: midpoints of 900 s carry it 1.4 km out."""
    begin = np.array([[3000.0, 0.0, -1500.0], [0.0, 3000.0, 1500.0]])
    (end,) = Drift(Eddy(5.0 * 3600.0), ()).places(begin, np.zeros(3), (DAY,))
    assert np.hypot(*end) == pytest.approx(np.hypot(*begin), abs=1.0)
    turned = np.exp(2j * np.pi * DAY / (5.0 * 3600.0)) * (begin[0] + 1j * begin[1])
    assert end == pytest.approx(np.stack((turned.real, turned.imag)), abs=3.0)


def test_the_fastest_wave_of_an_error_carries_a_drifter_no_further_than_its_integral():
    rate = np.array([[2e-5, 0.4], [3e-3, 40.0]])  # shape (waves, trials): hours, minutes, and far below a step
    cosine, sine = np.full((2, 2, 2), 0.05), np.full((2, 2, 2), -0.02)
    error = ErrorWaves(rate, None, cosine, sine)
    drift = Drift(ErringCurrent(layers([30.0], [0.3], [np.pi / 2]), error), (), 2)
    start, end = np.array([1000.0, 2500.0]), 40_000.0
    (there,) = drift.places(np.zeros((2, 2)), start, [end])
    waves = cosine * (np.sin(rate * end) - np.sin(rate * start)) - sine * (np.cos(rate * end) - np.cos(rate * start))
    by_hand = np.sum(waves / rate, axis=1) + np.array([[0.3], [0.0]]) * (end - start)
    assert there == pytest.approx(by_hand, abs=1e-6)


def test_leeway_goes_down_the_wind_and_to_its_right():
    wind = np.array([[0.0], [10.0]])  # blows toward north
    assert leeway_velocity(wind, 0.01, 0.004, 0.05, 0.0) == pytest.approx(np.array([[0.04], [0.15]]))
    assert leeway_velocity(np.zeros((2, 1)), 0.01, 0.004, 0.05, 0.02) == pytest.approx(0.0)


def test_a_wind_from_the_south_drives_it_north():
    drift = Drift(
        layers([1.0], [0.0], [0.0]), (Leeway(layers([np.inf], [10.0], [np.pi + np.pi]), 0.02, 0.0, 0.0, 0.0),)
    )
    (end,) = drift.places(np.zeros((2, 1)), np.zeros(1), (1000.0,))
    assert end == pytest.approx(np.array([[0.0], [200.0]]), abs=1e-9)


@pytest.fixture
def windy(tmp_path: Path):
    def load(speed: str, wind: str):
        path = tmp_path / "windy.yaml"
        path.write_text(WINDY % (speed, wind), encoding="utf-8")
        return missionplan.load(path)

    return load


def test_the_scatter_of_leeway_is_that_of_the_file_and_its_side_is_by_chance(windy):
    mission = windy("0 m/s", "{speed: 8 m/s, from: 180 deg}")
    blown = Scenario.at_means(mission).sampled(seed=3, block=0).leeway
    velocity = blown.surface_velocity(np.zeros(4096), np.zeros(4096), np.zeros((2, 4096)))
    assert velocity[1].mean() == pytest.approx(0.0107 * 8.0 + 0.0447, abs=4 * 0.054 / 64)
    assert velocity[1].std() == pytest.approx(0.054, rel=0.05)
    assert velocity[0].mean() == pytest.approx(0.0, abs=4 * 0.063 / 64)
    assert velocity[0].std() == pytest.approx(np.hypot(0.054, 0.0041 * 8.0), rel=0.05)
    assert Scenario.at_means(mission).leeway.surface_velocity(np.zeros(1), np.zeros(1), np.zeros((2, 1)))[
        :, 0
    ] == pytest.approx([0.0, 0.0107 * 8.0 + 0.0447], abs=1e-12)


def test_the_wind_moves_the_vehicle_while_it_waits_for_a_fix(windy):
    calm, blown = (windy("0 m/s", f"{{speed: {speed} m/s, from: 270 deg}}") for speed in (0, 20))
    miss = [
        missionplan.simulate(each, sheet=False).phases[0].quantities["arrival_error_m"].mean for each in (calm, blown)
    ]
    assert miss[1] > miss[0] + 5.0


def test_a_wind_is_read_from_a_record_with_dates(windy, tmp_path):
    (tmp_path / "wind.csv").write_text(
        "t_s,east_m_s,north_m_s\n2026-06-01T08:00Z,0,6\n2026-06-01T09:00Z,6,0\n", encoding="utf-8"
    )
    wind = Scenario.at_means(windy("0 m/s", "{file: wind.csv}")).wind
    assert wind.velocity(np.array([0.0, 1800.0, 9999.0]), 0.0, np.zeros((2, 3))) == pytest.approx(
        np.array([[0.0, 3.0, 6.0], [6.0, 3.0, 0.0]])
    )


def test_a_wind_is_read_from_a_field_at_one_height(windy, tmp_path):
    xarray = pytest.importorskip("xarray")
    times, lat, lon = np.arange(3), np.array([37.0, 37.5]), np.array([-77.0, -76.0])
    shape = (3, 1, 2, 2)
    data = {
        "u10": (("time", "height", "lat", "lon"), np.full(shape, 3.0), {"units": "m s-1"}),
        "v10": (("time", "height", "lat", "lon"), np.full(shape, -4.0), {"units": "m s-1"}),
    }
    axes = {
        "time": ("time", times, {"units": "hours since 2026-06-01T08:00Z"}),
        "height": ("height", [10.0], {"units": "m", "positive": "up"}),
        "lat": ("lat", lat, {"units": "degrees_north"}),
        "lon": ("lon", lon, {"units": "degrees_east"}),
    }
    xarray.Dataset(data, axes).to_netcdf(tmp_path / "wind.nc")
    wind = Scenario.at_means(windy("0 m/s", "{file: wind.nc}")).wind
    assert wind.velocity(np.array([60.0]), 0.0, np.zeros((2, 1)))[:, 0] == pytest.approx([3.0, -4.0])


def test_a_current_without_error_has_the_stated_one_on_the_sheet(windy):
    calm = "{speed: 0 m/s, from: 0 deg}"
    exact, uncertain = (windy(speed, calm) for speed in ("0.3 m/s", "{mean: 0.3 m/s, sd: 0.1 m/s}"))
    drifts = [Drift.of(Scenario.at_means(each).sampled(seed=1, block=0), 1, 1500) for each in (exact, uncertain)]
    assert [drift.is_error_assumed for drift in drifts] == [True, False]
    still = Drift(drifts[0].current, (), 1500)
    (end,) = still.places(np.zeros((2, 1500)), np.zeros(1500), (DAY,))
    x = DAY / UNSTATED_TIME
    variance = 2.0 * UNSTATED_ERROR**2 * UNSTATED_TIME**2 * (x - 1.0 + np.exp(-x))  # Taylor 1921
    assert end.std(axis=1) == pytest.approx(np.sqrt(variance), rel=0.06)
    assert DriftAssumption.ERROR_OF_CURRENT in missionplan.simulate(exact, trials=200).overdue.assumptions
    assert DriftAssumption.ERROR_OF_CURRENT not in missionplan.simulate(uncertain, trials=200).overdue.assumptions


SQUARE = ((np.array([[0.0, 100.0, 100.0, 0.0, 0.0], [-100.0, -100.0, 100.0, 100.0, -100.0]]),),)


def test_a_ring_encloses_what_is_inside():
    places = np.array([[50.0, -1.0, 101.0, 50.0], [0.0, 0.0, 0.0, 120.0]])
    assert encloses(SQUARE[0][0], places).tolist() == [True, False, False, False]


def test_a_search_in_vain_leaves_what_it_would_have_missed():
    """Half of those adrift were in the square at its time, and four of five there would have been seen."""
    rng = np.random.default_rng(4)
    place = rng.uniform(-100.0, 100.0, (2, 4000))
    lost = Losses("adrift at the surface", "", np.arange(4000), place, np.zeros(4000), is_assumed=False)
    drift = Drift(layers([1.0], [0.0], [0.0]), (), 4000)
    areas = list(search_areas([lost], drift, 7200.0, {}, [Search(SQUARE, 0.8, 3600.0)]))
    share = np.mean(place[0] > 0.0)
    assert areas[-1].missed == pytest.approx(1.0 - 0.8 * share)
    assert areas[-1].densest_east < 0.0
    earlier = list(search_areas([lost], drift, 7200.0, {}, [Search(SQUARE, 0.8, -10.0)]))
    assert earlier[-1].missed == 1.0, "nothing was lost yet"
    sonar = list(search_areas([lost], drift, 7200.0, {}, [Search(SQUARE, 0.8, 3600.0, "on the seafloor")]))
    assert sonar[-1].missed == 1.0


def test_searches_are_read_with_every_problem(windy, tmp_path):
    mission = windy("0.1 m/s", "{speed: 5 m/s, from: 0 deg}")
    path = tmp_path / "searched.geojson"
    ring = "[[-76.39,37.24],[-76.37,37.24],[-76.37,37.26],[-76.39,37.24]]"

    def collection(*features: tuple[float, str, str]) -> str:
        return json.dumps(
            {
                "type": "FeatureCollection",
                "features": [
                    {
                        "type": "Feature",
                        "properties": {"probability_of_detection": detection, "time": time},
                        "geometry": {"type": "Polygon", "coordinates": [json.loads(ring)]},
                    }
                    for detection, time, ring in features
                ],
            }
        )

    path.write_text(collection((0.7, "2026-06-01T12:00Z", ring)), encoding="utf-8")
    (search,) = read_searches(path, mission)
    assert (search.time, search.detection) == (4.0 * 3600.0, 0.7)
    wrong = (70.0, "2026-06-01T12:00Z", ring), (0.7, "2026-06-01T12:00Z", "[[0, 0]]")
    path.write_text(collection(*wrong), encoding="utf-8")
    with pytest.raises(missionplan.InputError) as caught:
        missionplan.simulate(mission, searched=path)
    assert [problem.key for problem in caught.value.problems] == ["features[0]", "features[1]"]


@pytest.mark.parametrize("wind", ["{low: 3 m/s, high: 8 m/s}", "{mean: 12 m/s, sd: 2 m/s}"])
def test_areas_hold_losses_that_drift_by_the_published_equations(windy, wind):
    """A thousand losses carried a minute at a time, with draws of their own: current, wind, leeway to the left or right."""
    mission = windy("{mean: 0.2 m/s, sd: 0.08 m/s}", f"{{speed: {wind}, from: {{mean: 200 deg, sd: 25 deg}}}}")
    sheet = missionplan.simulate(with_a_tide(mission), trials=3000).overdue
    rng, n = np.random.default_rng(99), 1000
    speed = rng.uniform(3.0, 8.0, n) if "low" in wind else rng.normal(12.0, 2.0, n)
    course = np.radians(20.0 + rng.normal(0.0, 25.0, n))
    down = 0.0107 * speed + 0.0447 + rng.normal(0.0, 0.054, n)
    right = np.where(rng.random(n) < 0.5, 1.0, -1.0) * 0.0041 * speed + rng.normal(0.0, 0.054, n)
    water = np.maximum(rng.normal(0.2, 0.08, n), -1.0)
    east = water * np.sin(np.radians(60.0)) + down * np.sin(course) + right * np.cos(course)
    north = water * np.cos(np.radians(60.0)) + down * np.cos(course) - right * np.sin(course)
    for hours in (6.0, 24.0):
        areas = {area.share: area for area in sheet.areas if area.way == AFLOAT and area.overdue == 3600.0 * hours}
        x, y = rng.uniform(0.0, 800.0, n), np.zeros(n)
        for minute in range(int((sheet.worry_after - 600.0 * rng.random() + 3600.0 * hours) / 60.0)):
            tide = 0.3 * np.cos(2.0 * np.pi * (60.0 * minute + 30.0) / 44_714.16)
            x, y = x + 60.0 * east, y + 60.0 * (north + tide)
        inside = {share: np.mean(_holds(area, np.stack((x, y)))) for share, area in areas.items()}
        assert 0.44 < inside[0.5] < 0.56
        assert 0.87 < inside[0.9] < 0.93
        assert 0.925 < inside[0.95] < 0.975


def with_a_tide(mission):
    """M2 of 0.3 m/s toward north, greatest at the mission's start."""
    return Mission.from_data({**mission.raw, "effects": [{"tidal-current": {"m2_north": "0.3 m/s"}}]})


def test_layers_are_not_held_for_a_day_and_a_tide_is(windy):
    """In a tidal bay layers that stay would carry a vehicle 17 km in a day that the tide brings back."""
    mission = windy("{mean: 0.2 m/s, sd: 0.08 m/s}", "{speed: 0 m/s, from: 0 deg}")
    steady, tidal = (missionplan.simulate(each, trials=400).overdue for each in (mission, with_a_tide(mission)))
    hours = [[area.overdue / 3600.0 for area in each.areas if area.way == AFLOAT][::3] for each in (steady, tidal)]
    assert hours == [[0.0, 1.0, 3.0, 6.0], [0.0, 1.0, 3.0, 6.0, 12.0, 24.0]]
    assert DriftAssumption.STEADY_LAYERS in steady.assumptions
    assert DriftAssumption.STEADY_LAYERS not in tidal.assumptions


def test_beyond_a_record_there_are_areas_for_six_hours(windy, tmp_path):
    data = dict(windy("0 m/s", "{speed: 0 m/s, from: 0 deg}").raw)
    rows = "t_s,depth_m,east_m_s,north_m_s\n0,0,0.1,0\n7200,0,0.2,0\n"
    (tmp_path / "current.csv").write_text(rows, encoding="utf-8")
    data["site"] = {**data["site"], "current": {"file": str(tmp_path / "current.csv"), "outside": "hold"}}
    sheet = missionplan.simulate(Mission.from_data(data), trials=400).overdue
    assert sheet.worry_after < 7200.0
    last = max(area.overdue for area in sheet.areas)
    assert last == 6.0 * 3600.0
    assert DriftAssumption.BEYOND_RECORD in sheet.assumptions


def _holds(area, places):
    return np.any(
        [np.logical_xor.reduce([Outline(r.T).contains_points(places.T) for r in rings]) for rings in area.polygons],
        axis=0,
    )


def test_a_coast_stops_a_drifter():
    """Land from 1000 m east on: who drifts there at 0.5 m/s stays, who passes south of it goes on."""
    shapely = pytest.importorskip("shapely")
    land = Zone(shapely.box(1000.0, 0.0, 5000.0, 5000.0), "coast", is_land=True)
    shore = Place(fence=Fence((land,)))
    drift = Drift(layers([1.0], [0.5], [np.pi / 2.0]), (), 2, shore=shore)
    first, last = drift.places(np.array([[0.0, 0.0], [100.0, -100.0]]), np.zeros(2), (1000.0, 6000.0))
    assert first == pytest.approx(np.array([[500.0, 500.0], [100.0, -100.0]]))
    assert last == pytest.approx(np.array([[1000.0, 3000.0], [100.0, -100.0]]))


def test_a_drifter_is_left_by_the_ebb_where_the_water_has_gone():
    """Over 5 m with a draught of 1 m, and a sea that falls by 1 cm/s: after 400 s at 0.5 m/s, until which it drifts."""
    low, high = np.array([-500.0, -500.0]), np.array([1500.0, 500.0])
    axes = np.meshgrid(*(np.linspace(a, b, 5) for a, b in zip(low, high, strict=True)))
    places = np.stack([axis.ravel() for axis in axes])
    frame = Frame.fitted(low, high, places, (places - low[:, None]) / 100.0)
    ebb = SeaLevel(time=np.array([0.0, 800.0]), height=np.array([0.0, -8.0]))
    shore = Place(Ground(np.full((11, 21), 5.0, dtype=np.float32), frame), sea_level=ebb, draught=1.0)
    drift = Drift(layers([1.0], [0.5], [np.pi / 2.0]), (), 1, shore=shore)
    first, last = drift.places(np.zeros((2, 1)), np.zeros(1), (300.0, 800.0))
    assert first[:, 0] == pytest.approx([150.0, 0.0])
    assert last[:, 0] == pytest.approx([200.0, 0.0], abs=2.0)
    range_ = Zone(None, "range", is_land=False)
    assert _shore(replace(shore, clearance=3.0, fence=Fence((range_,)))) == shore
    assert _shore(Place(fence=Fence((range_,)))) is None


def test_a_tide_at_the_surface_is_the_sum_of_its_waves_under_way():
    """A sixth of a period on: half of each cosine and 0.866 of each sine."""
    waves = {"a": {3600.0: (0.1, 0.2, 0.3, 0.4)}, "b": {7200.0: (0.0, 0.0, 1.0, 0.0)}}
    effects = [SimpleNamespace(drift=lambda own=own: SimpleNamespace(waves=own)) for own in waves.values()]
    root = 0.75**0.5
    found = _tide(effects, np.array([600.0]))[:, 0]
    assert found == pytest.approx([0.05 + 0.2 * root, 0.15 + 0.4 * root + root])
