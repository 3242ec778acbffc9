"""GeoJSON by its schema (RFC 7946), KML by the order of elements that its schema (OGC 07-147r2) asks for."""

import json
import math
from xml.etree import ElementTree

import jsonschema
import numpy as np
import pytest
from outcome_example import example
from pyproj import Geod

from missionplan.report.geography.geojson import SAMPLES, longitudes_latitudes, track_geojson
from missionplan.report.geography.kml import track_kml

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
    "Placemark": ["name", "styleUrl", "LineString", "Polygon", "Point"],
    "Style": ["LineStyle", "PolyStyle"],
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


def test_longitudes_run_on_across_the_antimeridian():
    places = longitudes_latitudes(
        np.array([[-5000.0, 5000.0], [0.0, 0.0]]), (math.radians(-17.0), math.radians(179.99))
    )
    assert places[0][0] < 180.0 < places[1][0] < 180.1


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
