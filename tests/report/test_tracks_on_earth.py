"""GeoJSON by its schema (RFC 7946), KML by the order of elements that its schema (OGC 07-147r2) asks for."""

import io
import json
import math
from dataclasses import replace
from datetime import UTC, datetime
from xml.etree import ElementTree

import jsonschema
import numpy as np
import pytest
from outcome_example import example
from pyproj import Geod

from missionplan.exporters.geojson import COLOURS, circle, longitudes_latitudes, parts
from missionplan.report.page import BLUE, GREEN, ORANGE, PINK, SKY, YELLOW
from missionplan.report.simulation.tracks import SAMPLES, sample_trials, track_geojson, track_kml, track_points

POSITION = {"type": "array", "minItems": 2, "maxItems": 2, "items": {"type": "number"}}
LINE = {"type": "array", "minItems": 2, "items": POSITION}
RING = {"type": "array", "minItems": 4, "items": POSITION}
GEOMETRIES = {"Point": POSITION, "LineString": LINE, "Polygon": {"type": "array", "minItems": 1, "items": RING}}
SCHEMA = {
    "$schema": "https://json-schema.org/draft/2020-12/schema",
    "type": "object",
    "required": ["type", "features"],
    "not": {"required": ["crs"]},
    "properties": {
        "type": {"const": "FeatureCollection"},
        "features": {
            "type": "array",
            "minItems": 1,
            "items": {
                "type": "object",
                "required": ["type", "geometry", "properties"],
                "properties": {
                    "type": {"const": "Feature"},
                    "properties": {"type": ["object", "null"]},
                    "geometry": {
                        "oneOf": [
                            {
                                "type": "object",
                                "required": ["type", "coordinates"],
                                "properties": {"type": {"const": kind}, "coordinates": coordinates},
                            }
                            for kind, coordinates in GEOMETRIES.items()
                        ]
                    },
                },
            },
        },
    },
}
KML = "{http://www.opengis.net/kml/2.2}"
ORDER = {
    "kml": ["Document"],
    "Document": ["name", "description", "Style", "Folder"],
    "Folder": ["name", "Placemark"],
    "Placemark": [
        *("name", "TimeStamp", "TimeSpan", "styleUrl", "ExtendedData", "LineString", "Polygon", "Point"),
    ],
    "TimeStamp": ["when"],
    "TimeSpan": ["begin", "end"],
    "ExtendedData": ["Data"],
    "Data": ["value"],
    "Style": ["IconStyle", "LineStyle", "PolyStyle"],
    "IconStyle": ["color", "scale"],
    "LineStyle": ["color", "width"],
    "PolyStyle": ["fill"],
    "LineString": ["tessellate", "coordinates"],
    "Polygon": ["tessellate", "outerBoundaryIs"],
    "outerBoundaryIs": ["LinearRing"],
    "LinearRing": ["coordinates"],
    "Point": ["coordinates"],
}


@pytest.fixture(scope="module")
def outcome():
    return example()


@pytest.fixture(scope="module")
def collection(outcome):
    return json.loads(track_geojson(outcome))


def features(collection, kind):
    return [feature for feature in collection["features"] if feature["properties"]["kind"] == kind]


def test_geojson_is_valid(collection):
    jsonschema.validate(collection, SCHEMA)


def test_geojson_holds_tracks_circles_and_goals(collection):
    assert len(features(collection, "median track")) == 1
    assert len(features(collection, "sample track")) == SAMPLES
    assert [feature["properties"]["share"] for feature in features(collection, "CEP")] == [0.5, 0.95] * 2
    assert len(features(collection, "mooring ellipse")) == 2
    assert len(features(collection, "goal")) == 3


def test_polygons_are_closed_and_run_counter_clockwise(collection):
    for feature in collection["features"]:
        if feature["geometry"]["type"] == "Polygon":
            (ring,) = feature["geometry"]["coordinates"]
            assert ring[0] == ring[-1]
            x, y = (np.array(ring) - ring[0]).T
            assert np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]) > 0.0


def test_a_circle_on_earth_has_its_radius_on_the_ellipsoid(collection):
    (feature,) = (f for f in features(collection, "arrival circle") if f["properties"]["phase"] == "ingress")
    (goal,) = (f for f in features(collection, "goal") if f["properties"]["phase"] == "ingress")
    centre = goal["geometry"]["coordinates"]
    ring = np.array(feature["geometry"]["coordinates"][0])
    distance = Geod(ellps="WGS84").inv(*np.broadcast_to(centre, ring.shape).T, *ring.T)[2]
    assert np.allclose(distance, 15.0, atol=0.02)


def test_longitudes_come_back_across_the_antimeridian():
    places = longitudes_latitudes(
        np.array([[-5000.0, 5000.0], [0.0, 0.0]]), (math.radians(-17.0), math.radians(179.99))
    )
    assert 179.9 < places[0][0] < 180.0
    assert -180.0 < places[1][0] < -179.9
    (west, east) = parts(places)
    assert west[-1][0] == 180.0
    assert east[0] == [-180.0, west[-1][1]]
    geod = Geod(ellps="WGS84")
    assert sum(geod.line_length(*np.transpose(part)) for part in (west, east)) == pytest.approx(10_000.0, abs=0.1)


def test_an_area_across_the_antimeridian_is_cut_in_two():
    """Both halves are closed, counter-clockwise, and together as large as the circle (a chord polygon of 72 sides)."""
    ring = longitudes_latitudes(circle((0.0, 0.0), 3000.0), (math.radians(-17.0), math.radians(179.99)))
    halves = parts(ring, closed=True)
    assert len(halves) == 2
    assert all(half[0] == half[-1] for half in halves)
    assert all(len({place[0] > 0.0 for place in half}) == 1 for half in halves)
    areas = [Geod(ellps="WGS84").polygon_area_perimeter(*np.transpose(half))[0] for half in halves]
    assert min(areas) > 0.0
    assert sum(areas) == pytest.approx(0.5 * 72 * math.sin(2.0 * math.pi / 72) * 3000.0**2, rel=1e-4)


def test_what_does_not_cross_stays_whole():
    ring = longitudes_latitudes(circle((0.0, 0.0), 3000.0), (math.radians(45.0), math.radians(-124.0)))
    assert parts(ring, closed=True) == [ring] == parts(ring)


def test_kml_has_its_elements_in_the_order_of_the_schema(outcome):
    root = ElementTree.fromstring(track_kml(outcome))
    assert root.tag == f"{KML}kml"
    for element in root.iter():
        children = [child.tag.removeprefix(KML) for child in element]
        order = ORDER.get(element.tag.removeprefix(KML), [])
        assert [order.index(child) for child in children] == sorted(order.index(child) for child in children)


def test_kml_styles_exist_and_names_and_coordinates_are_filled(outcome):
    root = ElementTree.fromstring(track_kml(outcome))
    styles = {f"#{style.get('id')}" for style in root.iter(f"{KML}Style")}
    assert {link.text for link in root.iter(f"{KML}styleUrl")} <= styles
    for coordinates in root.iter(f"{KML}coordinates"):
        for place in coordinates.text.split():
            longitude, latitude = map(float, place.split(","))
            assert -77.0 < longitude < -76.0
            assert 37.0 < latitude < 38.0


def test_a_name_that_xml_cannot_hold_is_mended():
    root = ElementTree.fromstring(track_kml(example(name="a <b> & \x00c\x1b ]]> \ud800")))
    assert root.find(f"{KML}Document/{KML}name").text == "a <b> & \ufffdc\ufffd ]]> \ufffd"


def test_colours_are_those_of_the_figures():
    shown = {"median track": ORANGE, "sample track": SKY, "CEP": BLUE, "mooring ellipse": PINK}
    shown |= {"arrival circle": GREEN, "mooring circle": YELLOW}
    assert {kind: COLOURS[kind] for kind in shown} == {kind: colour.lower() for kind, colour in shown.items()}


def test_the_median_track_has_times_and_its_fixes_are_points(outcome, collection):
    median, _ = sample_trials(outcome)
    points = track_points(outcome, median)
    (line,) = features(collection, "median track")
    assert len(line["geometry"]["coordinates"]) == len(line["properties"]["elapsed_s"]) == len(points)
    assert line["properties"]["elapsed_s"] == sorted(line["properties"]["elapsed_s"])
    assert "coordTimes" not in line["properties"]  # the mission has no start
    surfacings = features(collection, "surfacing")
    assert len(surfacings) == sum(point.kind == "surfacing" for point in points) > 2
    assert {feature["properties"]["depth_m"] for feature in surfacings if "depth_m" in feature["properties"]} == {
        2.0,
        12.192,
    }
    assert len(features(collection, "anchor")) == 1


def test_surfacings_are_counted_and_each_has_its_fix(outcome):
    trial = next(each for each in np.flatnonzero(outcome.tracks.success) if each % 3)
    names = [point.name.removeprefix("ingress: ") for point in track_points(outcome, int(trial))]
    assert names[:5] == ["start", "surfacing 1", "fix 1", "surfacing 2", "fix 2"]
    assert names[8:11] == ["moor: anchor", "moor: surfacing", "egress: start"]


def test_planned_tracks_and_waypoints_are_there(collection):
    tracks = features(collection, "planned track")
    assert [track["properties"]["name"] for track in tracks] == ["ingress: planned track", "egress: planned track"]
    assert [track["properties"]["time_out_s"] > 1000.0 for track in tracks] == [True, True]
    assert len(features(collection, "waypoint")) == 12
    assert all(feature["properties"]["marker-color"].startswith("#") for feature in features(collection, "waypoint"))


def test_a_mission_with_a_start_has_times_in_utc(outcome):
    start = datetime(2026, 6, 1, 12, 0, tzinfo=UTC)
    dated = replace(outcome, plan=replace(outcome.plan, start=start))
    (line,) = features(json.loads(track_geojson(dated)), "median track")
    times = [datetime.fromisoformat(text) for text in line["properties"]["coordTimes"]]
    elapsed = [(time - start).total_seconds() for time in times]
    assert np.allclose(elapsed, line["properties"]["elapsed_s"], atol=1.0)
    fastkml = pytest.importorskip("fastkml")
    kml = fastkml.KML.from_string(track_kml(dated).encode(), strict=True)
    marks = [mark for folder in kml.features[0].features for mark in folder.features]
    (track,) = (mark for mark in marks if mark.name.startswith("median track"))
    assert (track.begin.dt, track.end.dt) == (times[0], times[-1])
    surfaced = [mark.time_stamp.dt for mark in marks if ": surfacing" in mark.name]
    assert set(surfaced) <= set(times)
    assert len(surfaced) > 2


def test_other_programs_read_both(outcome):
    geopandas, fastkml = pytest.importorskip("geopandas"), pytest.importorskip("fastkml")
    frame = geopandas.read_file(io.StringIO(track_geojson(outcome)))
    assert frame.geometry.is_valid.all()
    assert {"planned track", "median track", "sample track", "surfacing", "fix", "CEP", "mooring ellipse"} <= set(
        frame["kind"]
    )
    names = set(frame["name"])
    assert {"ingress: arrival circle, 15 m", "moor: mooring ellipse 95 %"} <= names
    kml = fastkml.KML.from_string(track_kml(outcome).encode(), strict=True)
    (document,) = kml.features
    assert outcome.plan.digest in document.description
    marks = {mark.name for folder in document.features for mark in folder.features}
    assert {"ingress: planned track", "ingress: surfacing 1", "ingress: arrival circle, 15 m"} <= marks
    assert {name for name in names if "CEP" in name} == {name for name in marks if "CEP" in name} != set()


def test_a_mission_without_an_origin_has_no_tracks_on_earth():
    assert track_geojson(example(origin=False)) is None
    assert track_kml(example(origin=False)) is None
