"""GPX, KML, GeoJSON, GeoPackage and CSV, read back by other programs' readers."""

import io
import json
import math

import numpy as np
import pandas as pd
import pytest
from planned_missions import all_plans, metres_apart

from missionplan.exporters.formats import format_named


@pytest.fixture(scope="module")
def plans(tmp_path_factory):
    return all_plans(tmp_path_factory.mktemp("starter"))


@pytest.fixture(params=["chesapeake", "starter", "table"])
def plan(plans, request):
    return plans[request.param]


def content(plan, name):
    (found,) = format_named(name).files(plan, "trip").values()
    return found


def test_csv(plan):
    table = pd.read_csv(io.StringIO(content(plan, "csv")), comment="#")
    points = [point for phase in plan.phases for point in getattr(phase, "waypoints", (phase,))]
    assert len(table) == len(points)
    for row, point in zip(table.itertuples(), points, strict=True):
        assert metres_apart(plan, point, row.latitude_deg, row.longitude_deg) < 0.1
        assert (row.east_m, row.north_m) == pytest.approx((point.east, point.north), abs=1e-3)
    for transit in plan.transits:
        rows = table[table["phase"] == transit.name]
        assert set(rows["depth_m"]) == {transit.depth}
        assert set(rows["speed_m_s"]) == {transit.speed}
        assert rows["time_out_s"].iloc[1:].tolist() == [leg.time_out for leg in transit.legs]
    (moored,) = [table[table["kind"] == "mooring"]]
    assert moored["release_time_s"].tolist() == pytest.approx([m.release_time for m in plan.moorings], abs=0.05)


def test_gpx(plan):
    gpxpy = pytest.importorskip("gpxpy")
    gpx = gpxpy.parse(content(plan, "gpx"))
    assert plan.digest in gpx.description
    assert [route.name for route in gpx.routes] == [transit.name for transit in plan.transits]
    for route, transit in zip(gpx.routes, plan.transits, strict=True):
        held = extensions(route)
        assert held["surfacing_interval_m"] == pytest.approx(transit.surfacing.interval, rel=1e-4)
        for point, waypoint in zip(route.points, transit.waypoints, strict=True):
            assert metres_apart(plan, waypoint, point.latitude, point.longitude) < 0.1
            assert -point.elevation == pytest.approx(transit.depth)
            assert extensions(point)["speed_m_s"] == pytest.approx(transit.speed)
    for point, mooring in zip(gpx.waypoints, plan.moorings, strict=True):
        assert extensions(point)["release_time_s"] == pytest.approx(mooring.release_time, abs=0.05)


def extensions(point):
    return {element.tag.split("}")[-1]: float(element.text) for element in point.extensions}


def test_geojson(plan):
    geopandas = pytest.importorskip("geopandas")
    text = content(plan, "geojson")
    assert json.loads(text)["mission_sha256"] == plan.digest
    frame = geopandas.read_file(io.StringIO(text))
    assert {kind.removeprefix("Multi") for kind in frame.geom_type} == {"Point", "LineString", "Polygon"}
    assert frame.total_bounds[[0, 2]] == pytest.approx(np.clip(frame.total_bounds[[0, 2]], -180.0, 180.0), abs=0.0)
    assert frame.geometry.is_valid.all()
    for transit in plan.transits:
        own = frame[frame["phase"] == transit.name]
        for waypoint in transit.waypoints:
            (place,) = own[own["name"] == waypoint.name].geometry
            assert metres_apart(plan, waypoint, place.y, place.x) < 0.1
        (track,) = own[own["kind"] == "planned track"].itertuples()
        assert track.surfacing_interval_m == pytest.approx(transit.surfacing.interval)
        assert (track.depth_m, track.speed_m_s) == (transit.depth, transit.speed)
        assert len(getattr(track.geometry, "geoms", [track.geometry])) == 1 + _crosses(transit)
        whole = [place for part in getattr(track.geometry, "geoms", [track.geometry]) for place in part.coords]
        assert len(whole) == len(transit.waypoints) + 2 * _crosses(transit)
    assert frame[frame.geom_type == "LineString"]["stroke"].str.fullmatch("#[0-9a-f]{6}").all()


def _crosses(transit):
    """How often a transit goes from one side of the antimeridian to the other."""
    east = [waypoint.longitude > 0.0 for waypoint in transit.waypoints]
    return sum(
        first is not second and abs(a.longitude - b.longitude) > math.pi
        for first, second, a, b in zip(east, east[1:], transit.waypoints, transit.waypoints[1:], strict=False)
    )


def test_kml(plan):
    fastkml = pytest.importorskip("fastkml")
    kml = fastkml.KML.from_string(content(plan, "kml").encode(), strict=True)
    (document,) = kml.features
    assert plan.digest in document.description
    marks = [mark for folder in document.features for mark in folder.features]
    named = {mark.name: mark for mark in marks}
    for transit in plan.transits:
        for waypoint in transit.waypoints:
            place = named[waypoint.name].geometry
            assert metres_apart(plan, waypoint, place.y, place.x) < 0.1
            data = {item.name: item.value for item in named[waypoint.name].extended_data.elements}
            assert float(data["depth_m"]) == pytest.approx(transit.depth)
            assert float(data["speed_m_s"]) == pytest.approx(transit.speed)
        track = named[f"{transit.name}: planned track"]
        data = {item.name: item.value for item in track.extended_data.elements}
        assert float(data["surfacing_interval_m"]) == pytest.approx(transit.surfacing.interval)
    styles = {f"#{style.id}" for style in document.styles}
    assert {mark.style_url.url for mark in marks} <= styles


def test_geopackage(plan, tmp_path):
    geopandas, pyogrio = pytest.importorskip("geopandas"), pytest.importorskip("pyogrio")
    path = tmp_path / "trip.gpkg"
    path.write_bytes(content(plan, "gpkg"))
    assert {name for name, _ in pyogrio.list_layers(path)} == {"waypoints", "courses", "circles"}
    info = pyogrio.read_info(path, layer="waypoints")
    assert info["layer_metadata"]["mission_sha256"] == plan.digest
    waypoints = geopandas.read_file(path, layer="waypoints")
    assert waypoints.crs.to_epsg() == 4326
    points = [point for phase in plan.phases for point in getattr(phase, "waypoints", (phase,))]
    for row, point in zip(waypoints.itertuples(), points, strict=True):
        assert metres_apart(plan, point, row.geometry.y, row.geometry.x) < 0.1
    courses = geopandas.read_file(path, layer="courses")
    assert courses["surfacing_interval_m"].tolist() == pytest.approx([t.surfacing.interval for t in plan.transits])
    assert courses["depth_m"].tolist() == pytest.approx([t.depth for t in plan.transits])
    assert courses["speed_m_s"].tolist() == pytest.approx([t.speed for t in plan.transits])
    circles = geopandas.read_file(path, layer="circles")
    assert circles.geometry.is_valid.all()
    assert len(circles) == len(plan.phases)
