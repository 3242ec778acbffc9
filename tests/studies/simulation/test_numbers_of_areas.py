"""What an area says of its cloud, who failed first, what the sheet takes for granted, and searches with holes."""

import json
import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from pyproj import Geod

from missionplan.errors import InputError
from missionplan.mission import Mission
from missionplan.phases.currents import layers
from missionplan.phases.recorded_currents import SeriesCurrent
from missionplan.results.failures import Failure
from missionplan.results.whereabouts import SHARES, DriftAssumption, ExpectedTime, Overdue, SearchArea
from missionplan.studies.simulation.drift import HELD, Drift, dormand_prince
from missionplan.studies.simulation.losses import Losses, Search, encloses, read_searches
from missionplan.studies.simulation.overdue import Cloud, _assumptions, _first_failures, search_areas

STILL = Drift(layers([1.0], [0.0], [0.0]), (), 3000)
ANGLE = np.radians(30.0)


@pytest.fixture(scope="module")
def cloud():
    """300 m long toward 30°, 80 m wide, about (1000, -500); lost one a second from 0 s on."""
    long, wide = np.random.default_rng(5).normal(0.0, [[300.0], [80.0]], (2, 3000))
    east = 1000.0 + long * np.sin(ANGLE) + wide * np.cos(ANGLE)
    return np.stack((east, -500.0 + long * np.cos(ANGLE) - wide * np.sin(ANGLE)))


def lost(way, cloud, after="", is_assumed=False):
    return Losses(way, after, np.arange(3000), cloud, np.arange(3000.0), is_assumed=is_assumed)


@pytest.mark.parametrize("way", ["on the seafloor", "still under way", "adrift at the surface"])
def test_an_area_tells_the_middle_the_axes_and_the_direction_of_its_cloud(cloud, way):
    found = list(search_areas([lost(way, cloud, is_assumed=True)], STILL, 5000.0, {"": 77.0}))
    hours = [0.0, 1.0, 3.0, 6.0, 12.0, 24.0] if way.startswith("adrift") else [0.0]
    assert [(area.overdue, area.share) for area in found] == [
        (3600.0 * hour, share) for hour in hours for share in SHARES
    ]
    values = np.linalg.eigvalsh(np.cov(cloud, bias=True))
    for area in found:
        assert (area.way, area.after, area.is_assumed, area.trials, area.missed) == (way, "", True, 3000, 1.0)
        assert (area.centre_east, area.centre_north) == pytest.approx(tuple(cloud.mean(axis=1)))
        assert np.hypot(area.densest_east - 1000.0, area.densest_north + 500.0) < 100.0
        scale = math.sqrt(-2.0 * math.log(1.0 - area.share))
        assert (area.half_width, area.half_length) == pytest.approx(tuple(scale * np.sqrt(values)), rel=1e-6)
        assert area.toward == pytest.approx(ANGLE, abs=0.02)
        assert area.area == pytest.approx(math.pi * area.half_length * area.half_width, rel=0.1)


def test_a_held_vehicle_is_in_a_circle_about_its_own_mooring_s_anchors(cloud):
    parts = [lost("not released", cloud, "deep"), lost("not released", cloud, "shoal")]
    found = list(search_areas(parts, STILL, 5000.0, {"deep": 40.0, "shoal": 7.0}))
    away = np.sort(np.hypot(*(cloud - cloud.mean(axis=1, keepdims=True))))
    for area, reach in zip(found, [40.0] * 3 + [7.0] * 3, strict=True):
        assert area.half_length == area.half_width == pytest.approx(np.quantile(away, area.share) + reach, abs=2.0)
        assert (area.densest_east, area.densest_north) == (area.centre_east, area.centre_north)
        ((ring,),) = area.polygons
        assert np.hypot(ring[0] - area.centre_east, ring[1] - area.centre_north) == pytest.approx(area.half_length)
        assert area.area == pytest.approx(math.pi * area.half_length**2, rel=2e-3)


@pytest.mark.parametrize("way", ["on the seafloor", "adrift at the surface"])
def test_a_search_misses_those_that_were_not_lost_yet(cloud, way):
    """All of them are in the square; those lost by 1000 s were there at its time."""
    box = 1e5 * np.array([[-1.0, 1.0, 1.0, -1.0, -1.0], [-1.0, -1.0, 1.0, 1.0, -1.0]])
    searches = [Search(((box,),), 0.6, 1000.0, way), Search(((box,),), 0.5, 2000.0, way)]
    found = list(search_areas([lost(way, cloud)], STILL, 5000.0, {}, searches))
    missed = np.where(np.arange(3000) <= 1000, 0.4, 1.0) * np.where(np.arange(3000) <= 2000, 0.5, 1.0)
    assert found[0].missed == pytest.approx(missed.mean())
    assert found[0].centre_east == pytest.approx((cloud[0] * missed).sum() / missed.sum())
    certain = [Search(((box,),), 1.0, 4000.0, way)]
    assert not list(search_areas([lost(way, cloud)], STILL, 5000.0, {}, certain))  # nowhere is left


def test_points_of_less_weight_count_less_in_the_axes(cloud):
    weights = np.arange(3000.0) / np.arange(3000.0).sum()
    found = Cloud(cloud, weights)
    assert found.centre == pytest.approx(np.average(cloud, axis=1, weights=weights))
    assert found.axes[0] ** 2 == pytest.approx(np.linalg.eigvalsh(np.cov(cloud, aweights=weights, bias=True, ddof=0)))


def test_who_never_ends_failed_where_and_as_he_failed_first():
    yes, no = np.arange(6) < 3, np.arange(6) >= 3
    first = {Failure.NOT_ARRIVED: np.arange(6) == 0, Failure.EQUIPMENT: np.arange(6) == 1}
    left = {"adrift": np.arange(6) == 1, "sunk": np.zeros(6, dtype=bool)}
    phases = [
        SimpleNamespace(name="out", failures=first, left=left),
        SimpleNamespace(name="moor", failures={Failure.NOT_SURFACED: yes}, left={}),
    ]
    found = dict(_first_failures(SimpleNamespace(phases=phases), np.ones(6, dtype=bool)))
    assert {key: flags.tolist() for key, flags in found.items()} == {
        ("out", Failure.NOT_ARRIVED): (np.arange(6) == 0).tolist(),
        ("out", f"{Failure.EQUIPMENT}, adrift"): (np.arange(6) == 1).tolist(),
        ("moor", Failure.NOT_SURFACED): (np.arange(6) == 2).tolist(),
    }
    assert not dict(_first_failures(SimpleNamespace(phases=phases), no))  # they came back after all


def test_each_assumption_is_said_where_it_is_made_and_nowhere_else():
    wind = SeriesCurrent(np.array([0.0, 500.0]), np.zeros(1), *np.zeros((2, 2, 1)))
    told = SimpleNamespace(leeway="blown", wind=None)
    sure = replace(STILL, shore="a coast")
    cases = [
        (told, sure, 1000.0, None),
        (SimpleNamespace(leeway=None, wind=None), sure, 1000.0, DriftAssumption.NO_WIND),
        (told, replace(sure, is_error_assumed=True), 1000.0, DriftAssumption.ERROR_OF_CURRENT),
        (told, replace(sure, is_steady=True), 1000.0, DriftAssumption.STEADY_LAYERS),
        (told, replace(sure, ends=900.0), 1000.0, DriftAssumption.BEYOND_RECORD),
        (told, replace(sure, ends=1100.0), 1000.0, None),
        (SimpleNamespace(leeway="blown", wind=wind), sure, 1000.0, DriftAssumption.BEYOND_RECORD),
        (SimpleNamespace(leeway="blown", wind=wind), sure, 400.0, None),
        (told, STILL, 1000.0, DriftAssumption.NO_LAND),
    ]
    for scenario, drift, last, said in cases:
        assert list(_assumptions(scenario, drift, last)) == ([said] if said else [])
    assert replace(STILL, is_steady=True).known_until(1000.0) == 1000.0 + HELD
    assert replace(STILL, ends=700.0).known_until(1000.0) == 700.0 + HELD


def test_the_hour_to_worry_is_the_largest_share_that_the_trials_tell():
    for p999, p99, told in ((9.0, 8.0, (0.999, 9.0)), (math.nan, 8.0, (0.99, 8.0)), (math.nan, math.nan, (0.95, 7.0))):
        times = (ExpectedTime("one", 1.0, 1.0, 2.0, 3.0, 4.0, 5.0), ExpectedTime("back", 1.0, 6.0, 7.0, p99, p999, 5.0))
        found = Overdue(times, {}, ())
        assert (found.worry_share, found.worry_after) == told


def test_an_area_with_a_hole_is_less_by_it():
    outer = np.array([[0.0, 100.0, 100.0, 0.0, 0.0], [0.0, 0.0, 50.0, 50.0, 0.0]])
    hole, apart = 0.5 * outer + 10.0, outer + 1000.0
    area = SearchArea("still under way", "", 0.0, 0.5, ((outer, hole), (apart,)), *([0.0] * 8), 3, is_assumed=False)
    assert area.area == pytest.approx(5000.0 - 1250.0 + 5000.0)
    inside = Search(((outer, hole), (apart,)), 0.7, 0.0).missed(
        np.array([[5.0, 30.0, 1050.0, 500.0], [5.0, 20.0, 1020.0, 0.0]])
    )
    assert inside == pytest.approx([0.3, 1.0, 0.3, 1.0])
    slanted = np.array([[0.0, 10.0, 4.0, 0.0], [0.0, 2.0, 9.0, 0.0]])
    assert encloses(slanted, np.array([[4.0, 1.0, 8.0], [4.0, 3.0, 5.5]])).tolist() == [True, False, False]


def test_searched_polygons_lie_where_they_are_on_earth_and_are_in_the_order_of_time(tmp_path):
    """Across the date line, by another library's geodesics; a hole, two parts and a way of their own come along."""
    where = {"latitude": "-17.5 deg", "longitude": "179.999 deg"}
    phases = [
        {
            "transit": {
                "from": ["0 m", "0 m"],
                "to": ["1 km", "0 m"],
                "speed": "1 m/s",
                "d_max": "300 m",
                "arrival_radius": "50 m",
            }
        }
    ]
    mission = Mission.from_data({"start": "2026-06-01T08:00Z", "site": {"origin": where}, "phases": phases,
                                 "navigation": {"velocity_error": {"sigma": "0.02 m/s"}, "surfacing_time": "60 s"}})  # fmt: skip
    wanted = np.array([[500.0, 800.0, -300.0, 500.0], [100.0, 900.0, 400.0, 100.0]])
    lon, lat, _ = Geod(ellps="WGS84").fwd(
        np.full(4, 179.999), np.full(4, -17.5), np.degrees(np.arctan2(*wanted)), np.hypot(*wanted)
    )
    assert np.ptp(lon) > 300.0  # on both sides of it
    ring = np.stack((lon, lat), axis=1).tolist()

    def feature(time, kind, coordinates, **more):
        return {"type": "Feature", "properties": {"probability_of_detection": 0.7, "time": time, **more},
                "geometry": {"type": kind, "coordinates": coordinates}}  # fmt: skip

    path = tmp_path / "searched.geojson"
    late = feature("2026-06-01T12:00+02:00", "MultiPolygon", [[ring, ring], [ring]], way="on the seafloor")
    path.write_text(
        json.dumps({"type": "FeatureCollection", "features": [late, feature("2026-06-01T09:30Z", "Polygon", [ring])]})
    )
    first, last = read_searches(path, mission)
    assert (first.time, last.time, first.way, last.way) == (5400.0, 7200.0, "adrift at the surface", "on the seafloor")
    assert [len(rings) for rings in last.polygons] == [2, 1]
    assert first.polygons[0][0] == pytest.approx(wanted, abs=0.5)
    for latitude, longitude, words in ((91.0, 0.0, "in this order"), (0.0, 361.0, "in this order")):
        wrong = [[0.0, 0.0], [1.0, 1.0], [longitude, latitude]]
        path.write_text(json.dumps(feature("2026-06-01T09:30Z", "Polygon", [wrong])))
        with pytest.raises(Exception, match=words):
            read_searches(path, mission)


RING = [[[10.0, 0.0], [10.1, 0.0], [10.1, 0.1], [10.0, 0.0]]]
GOOD = {
    "type": "Feature",
    "properties": {"probability_of_detection": 0.7, "time": "2026-06-01T09:30Z"},
    "geometry": {"type": "Polygon", "coordinates": RING},
}


@pytest.mark.parametrize(
    ("document", "words"),
    [
        ("{", "is not valid JSON"),
        ({"type": "FeatureCollection", "features": []}, "expected GeoJSON with one or more features"),
        ([GOOD], "expected GeoJSON with one or more features"),
        (GOOD | {"properties": None}, "probability_of_detection: given None, expected a number from 0 to 1"),
        (GOOD | {"properties": ["time"]}, "probability_of_detection: given None, expected a number from 0 to 1"),
        (GOOD | {"properties": {"probability_of_detection": 0.7}}, "time: missing"),
        (GOOD | {"properties": GOOD["properties"] | {"time": "noon"}}, "time: expected a date and time"),
        (GOOD | {"properties": GOOD["properties"] | {"way": "lost"}}, "way: given 'lost', expected one of"),
        (GOOD | {"geometry": {"type": "Point", "coordinates": [10.0, 0.0]}}, "given 'Point', expected a Polygon"),
        (GOOD | {"geometry": {"type": "Polygon", "coordinates": [[[10.0, 0.0]]]}}, "a ring has three or more points"),
    ],
)
def test_searches_that_cannot_be_read_are_refused(tmp_path, document, words):
    mission = Mission.from_data({"start": "2026-06-01T08:00Z",
                                 "site": {"origin": {"latitude": "0 deg", "longitude": "10 deg"}}})  # fmt: skip
    path = tmp_path / "searched.geojson"
    path.write_text(document if isinstance(document, str) else json.dumps(document))
    with pytest.raises(InputError, match=words):
        read_searches(path, mission)


def test_the_integration_is_of_fifth_order():
    """Of exp(-t²) from 0 to 1 with four fixed steps: halving them divides the error by some 32."""
    exact = math.sqrt(math.pi) / 2.0 * math.erf(1.0)
    errors = []
    for step in (0.25, 0.125):
        (end,) = dormand_prince(lambda t, y: np.exp(-(t**2)) + 0.0 * y, np.zeros(1), step, step, 1.0)
        errors.append(abs(end - exact))
    assert errors[0] < 1e-5
    assert errors[0] / errors[1] > 24.0
    (grown,) = dormand_prince(lambda t, y: 3.0 * y, np.ones(1), 0.5, 1.0, 1e-9)
    assert grown == pytest.approx(math.exp(3.0), rel=1e-7)
