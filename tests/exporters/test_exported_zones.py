"""Land and zones kept out of, in every form of the plan, read back by other programs' readers."""

import json
import math
from dataclasses import replace
from types import SimpleNamespace
from xml.etree import ElementTree

import jsonschema
import numpy as np
import pytest
from made_plans import PLANS, on_earth

import missionplan
from missionplan.exporters import FORMATS, format_named
from missionplan.exporters.geojson import areas
from missionplan.phases.zones import Zone
from missionplan.results.plan_places import Fence
from missionplan.studies.export import _fences

shapely = pytest.importorskip("shapely")

SHORE = (0.0, 0.0), (900.0, 40.0), (400.0, 300.0), (850.0, 900.0), (-30.0, 700.0)  # bent inward
LAKE = (100.0, 200.0), (200.0, 210.0), (150.0, 400.0)
LANE = (1000.0, 0.0), (1000.0, 800.0), (1200.0, 800.0), (1200.0, 0.0)  # clockwise
KML = "{http://www.opengis.net/kml/2.2}"


@pytest.fixture(params=PLANS)
def plan(request):
    made = PLANS[request.param]
    if made.origin is None:
        pytest.skip("no origin")

    def ring(places):
        return tuple(on_earth(made.origin, east, north) for east, north in places)

    shore = Fence("shore", ring(SHORE), "land", holes=(ring(LAKE),))
    lane = Fence("lane", ring(LANE), since=60.0, until=3600.0, above=8.0)
    return replace(made, fences=(shore, lane))


def content(plan, name):
    return next(iter(format_named(name).files(plan, "trip").values()))


def degrees(ring):
    return [(math.degrees(longitude), math.degrees(latitude)) for latitude, longitude in ring]


def polygons(plan):
    return {
        each.name: shapely.Polygon(degrees(each.outline), [degrees(hole) for hole in each.holes])
        for each in plan.fences
    }


def same(found, wanted):
    """Whether two areas are one to half a centimetre, the date line between them or not."""
    found, wanted = (
        shapely.transform(each, lambda places: np.stack((places[:, 0] % 360.0, places[:, 1]), axis=1))
        for each in (found, wanted)
    )
    parts = shapely.get_parts(found)
    assert all(part.is_valid for part in parts)
    found = shapely.union_all(parts)
    return found.symmetric_difference(wanted).area < 5e-5 * wanted.area


@pytest.mark.parametrize("turned", range(4))
@pytest.mark.parametrize("middle", [180.5, -179.5, 179.0, -181.0, 3.0, -90.0])
def test_a_zone_on_either_side_of_the_antimeridian_covers_what_it_covers(middle, turned):
    """Four degrees wide with a hole of one, from any of its corners on; places in it and out of it are asked for."""

    def ring(half, low, high):
        corners = [(low, -half), (low, half), (high, half), (high, -half)]
        return tuple((math.radians(lat), math.radians(math.remainder(middle + east, 360.0))) for lat, east in corners)

    outline, hole = ring(2.0, 10.0, 13.0), ring(0.5, 11.0, 12.0)
    parts = areas(Fence("zone", outline[turned:] + outline[:turned], "land", holes=(hole,)))
    made = [shapely.Polygon(part[0], part[1:]) for part in parts]
    assert sum(each.area for each in made) == pytest.approx(4.0 * 3.0 - 1.0)
    assert all(abs(longitude) <= 180.0 for part in parts for ring in part for longitude, _ in ring)
    for east, lat, is_in in (
        (-1.9, 10.1, True),
        (1.9, 12.9, True),
        (0.6, 11.5, True),
        (0.4, 11.5, False),
        (2.1, 11.0, False),
    ):
        place = shapely.Point(math.remainder(middle + east, 360.0), lat)
        assert any(each.contains(place) for each in made) == is_in


def test_geojson_holds_them_with_outlines_counter_clockwise_and_their_limits(plan):
    found = {each["properties"]["name"]: each for each in json.loads(content(plan, "geojson"))["features"]}
    for name, wanted in polygons(plan).items():
        read = shapely.geometry.shape(found[name]["geometry"])
        assert same(read, wanted)
        for part in getattr(read, "geoms", [read]):
            west, _, east, _ = part.bounds
            assert east - west < 1.0  # not round the Earth
            assert part.exterior.is_ccw
            assert not any(hole.is_ccw for hole in part.interiors)
    assert found["shore"]["properties"]["kind"] == "land"
    assert (
        found["lane"]["properties"].items()
        >= {"kind": "keep-out", "from_s": 60.0, "to_s": 3600.0, "above_m": 8.0}.items()
    )


def test_kml_holds_them(plan):
    root = ElementTree.fromstring(content(plan, "kml"))
    found = {
        each.findtext(f"{KML}name"): each
        for each in root.iter(f"{KML}Placemark")
        if each.find(f".//{KML}Polygon") is not None
    }
    for name, wanted in polygons(plan).items():
        parts = []
        for part in found[name].iter(f"{KML}Polygon"):
            rings = [
                [tuple(map(float, corner.split(",")[:2])) for corner in ring.findtext(f".//{KML}coordinates").split()]
                for kind in ("outerBoundaryIs", "innerBoundaryIs")
                for ring in part.iter(f"{KML}{kind}")
            ]
            assert all(ring[0] == ring[-1] for ring in rings)
            parts.append(shapely.Polygon(rings[0], rings[1:]))
        assert same(shapely.MultiPolygon(parts), wanted)


def test_a_geopackage_holds_them_in_a_layer_of_their_own(plan, tmp_path):
    pyogrio = pytest.importorskip("pyogrio")
    path = tmp_path / "trip.gpkg"
    path.write_bytes(content(plan, "gpkg"))
    meta, _, geometry, columns = pyogrio.raw.read(path, layer="zones")
    read = dict(zip(meta["fields"], columns, strict=True))
    for name, kind, above, found in zip(read["name"], read["kind"], read["above_m"], geometry, strict=True):
        assert same(shapely.from_wkb(found), polygons(plan)[name])
        assert kind == {"shore": "land", "lane": "keep-out"}[name]
        assert above == 8.0 if name == "lane" else math.isnan(above)


def test_json_holds_all_of_them(plan):
    data = json.loads(content(plan, "json"))
    jsonschema.validate(data, missionplan.schema("plan"))
    for each in data["fences"]:
        outline, *holes = ([corner[::-1] for corner in ring] for ring in (each["outline_deg"], *each["holes_deg"]))
        assert same(shapely.Polygon(outline, holes), polygons(plan)[each["name"]])
        assert all(degrees == round(degrees, 8) for corner in outline for degrees in corner)  # a millimetre
    shore, lane = data["fences"]
    assert (shore["kind"], shore["from_s"], shore["above_m"]) == ("land", None, None)
    assert (lane["kind"], lane["from_s"], lane["to_s"], lane["above_m"], lane["below_m"]) == (
        "keep-out",
        60,
        3600,
        8,
        None,
    )


def test_a_fence_of_an_autopilot_is_an_outline_to_keep_out_of_and_the_rest_is_said(plan):
    for name, text in format_named("qgc").files(plan, "trip").items():
        fence = json.loads(text)["geoFence"]
        assert (fence["version"], fence["circles"]) == (2, [])
        for written, wanted in zip(fence["polygons"], polygons(plan).values(), strict=True):
            assert (written["version"], written["inclusion"]) == (1, False)
            corners = written["polygon"]
            assert 3 <= len(corners) <= 255
            assert corners[0] != corners[-1]  # an autopilot counts vertices, and closes the polygon itself
            assert same(shapely.Polygon([corner[::-1] for corner in corners]), shapely.Polygon(wanted.exterior)), name
    said = " ".join(format_named("qgc").lost(plan))
    assert "times and depths of zones kept out of: fenced at all of them (lane)" in said
    assert "water inside land and zones: fenced with them (shore)" in said
    assert "corners" not in said
    whole = replace(plan, fences=(replace(plan.fences[0], holes=()),))
    assert "fenced" not in " ".join(format_named("qgc").lost(whole))  # neither a hole nor a time of its own
    many = replace(plan, fences=(replace(plan.fences[1], outline=tuple((1e-5 * k, 1e-9 * k * k) for k in range(256))),))
    assert "(lane 256)" in " ".join(format_named("qgc").lost(many))


@pytest.mark.parametrize("name", sorted(set(FORMATS) - {"svg"}))
def test_a_format_holds_them_or_says_that_it_does_not(plan, name):
    said = " ".join(format_named(name).lost(plan))
    holds = name in ("json", "geojson", "kml", "gpkg", "qgc")
    assert ("land and zones kept out of (shore, lane)" in said) != holds
    bare = " ".join(format_named(name).lost(replace(plan, fences=())))
    assert "zones" not in bare
    assert "FENCE" not in bare


def test_a_zone_of_the_mission_is_the_fence_of_its_plan_corner_by_corner_with_all_its_limits():
    """In two parts, the first with a hole; the mission's plane is that of the exporters' tests."""
    origin = PLANS["west"].origin
    parts = shapely.MultiPolygon([shapely.Polygon(SHORE, [LAKE]), shapely.Polygon(LANE)])
    limits = {"since": 60.0, "until": 3600.0, "above": 8.0, "below": 2.0}
    site = SimpleNamespace(origin=SimpleNamespace(latitude=origin[0], longitude=origin[1]))
    for is_land, kind in ((False, "keep-out"), (True, "land")):
        place = SimpleNamespace(zones=[Zone(parts, "bay", is_land, **limits)])
        shore, lane = _fences(SimpleNamespace(mission=SimpleNamespace(site=site), place=place))
        assert {(each.name, each.kind) for each in (shore, lane)} == {("bay", kind)}
        assert [{name: getattr(each, name) for name in limits} for each in (shore, lane)] == [limits, limits]
        for ring, corners in zip((shore.outline, *shore.holes, lane.outline), (SHORE, LAKE, LANE), strict=True):
            wanted = [on_earth(origin, *corner) for corner in corners]
            np.testing.assert_allclose(ring, wanted, atol=1e-9)
