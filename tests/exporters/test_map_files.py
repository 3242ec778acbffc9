"""GPX, KML, GeoJSON, GeoPackage, CSV and JSON, read back by other programs' readers: every number is the plan's."""

import io
import json
import math
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
from made_plans import GEOD, PLANS, metres_apart

from missionplan.exporters import FORMATS, format_named
from missionplan.exporters.geojson import COLOURS, feature, kml_colour, line_feature, parts, simplestyle
from missionplan.exporters.kml import kml
from missionplan.results.plan_states import ACTIONS, states_of


@pytest.fixture(params=PLANS)
def plan(request):
    return PLANS[request.param]


def content(plan, name):
    (found,) = format_named(name).files(plan, "trip").values()
    return found


def off(plan, point, latitude, longitude):
    assert -180.0 <= longitude <= 180.0
    return metres_apart(plan.origin, point.east, point.north, latitude, longitude)


def of_waypoint(transit, waypoint):
    """Every number that is to be said of a waypoint, to the digits that are written."""
    under_way = waypoint.kind != "start"
    return {
        "east_m": waypoint.east,
        "north_m": waypoint.north,
        "course_deg": round(math.degrees(waypoint.course), 3) if under_way else None,
        "leg_m": round(waypoint.length, 3),
        "depth_m": transit.depth,
        "speed_m_s": transit.speed,
        "duration_s": round(waypoint.duration, 1),
        "duration_p99_s": round(waypoint.duration_p99, 1) if under_way else None,
        "time_out_s": math.ceil(1.1 * max(waypoint.duration, waypoint.duration_p99)) if under_way else None,
        "surface_time_s": transit.surfacing.surface_time if under_way else None,
        "elapsed_s": round(waypoint.elapsed, 1),
        "radius_m": transit.arrival_radius if waypoint.kind == "arrival" else None,
        "release_time_s": None,
        "hold_s": None,
        "galvanic_release_s": None,
    }


NOT_OF_A_MOORING = ("course_deg", "leg_m", "speed_m_s", "duration_s", "duration_p99_s", "time_out_s", "surface_time_s")


def of_mooring(mooring):
    return {
        **dict.fromkeys(NOT_OF_A_MOORING),
        "east_m": mooring.east,
        "north_m": mooring.north,
        "depth_m": mooring.water_depth,
        "elapsed_s": mooring.elapsed,
        "radius_m": mooring.radius,
        "release_time_s": mooring.release_time,
        "hold_s": mooring.hold,
        "galvanic_release_s": mooring.galvanic_release,
    }


def of_course(transit):
    """Every number that is to be said of a transit as a whole."""
    rule = transit.surfacing
    whole = transit.goal.elapsed - transit.start.elapsed + rule.surface_time
    return {
        "depth_m": transit.depth,
        "speed_m_s": transit.speed,
        "surfacing_interval_m": rule.interval,
        "surfacing_interval_s": rule.interval_time,
        "surface_time_s": rule.surface_time,
        "time_out_s": math.ceil(1.1 * max(whole, transit.duration_p99)),
    }


def points(plan):
    """Each waypoint and mooring in order: name, phase, kind, numbers."""
    for phase in plan.phases:
        if phase in plan.moorings:
            yield phase, phase.name, "mooring", of_mooring(phase)
        else:
            yield from ((point, phase.name, point.kind, of_waypoint(phase, point)) for point in phase.waypoints)


def known(numbers, *without):
    return {key: value for key, value in numbers.items() if value is not None and key not in without}


def read(cells):
    """Numbers of a row as a reader gives them, None where it has none."""
    return {key: None if value is None or value != value else float(value) for key, value in cells.items()}


def is_circle(plan, ring, centre, radius):
    """Whether longitudes and latitudes [deg] lie a radius about a point, all around it."""
    middle = np.degrees([centre.longitude, centre.latitude])
    azimuth, _, distance = GEOD.inv(*np.broadcast_to(middle[:, None], (2, len(ring))), *np.array(ring)[:, :2].T)
    inside = [abs(abs(place[0]) - 180.0) > 1e-9 for place in ring]  # not where the antimeridian cuts it
    assert np.array(distance)[inside] == pytest.approx(radius, abs=0.05)
    around = np.sort(np.array(azimuth)[inside] % 360.0)
    assert np.diff([*around, around[0] + 360.0]).max() < 6.0


# tables


PLACE = ("latitude_deg", "longitude_deg")


def test_csv(plan):
    table = pd.read_csv(io.StringIO(content(plan, "csv")), comment="#")
    for row, (point, phase, kind, numbers) in zip(table.to_dict("records"), points(plan), strict=True):
        assert (row.pop("name"), row.pop("phase"), row.pop("kind")) == (point.name, phase, kind)
        assert [row[key] for key in PLACE] == [round(row[key], 8) for key in PLACE]  # a millimetre
        assert off(plan, point, *(row.pop(key) for key in PLACE)) < 0.02
        assert read(row) == pytest.approx(numbers, abs=1e-9)


def test_json(plan):
    data = json.loads(content(plan, "json"))
    assert data["start_utc"] == "2026-06-01T12:34:56+00:00"
    assert list(data["origin"].values()) == pytest.approx(np.degrees(plan.origin), abs=1e-12)
    assert data["origin"]["latitude_deg"] == pytest.approx(math.degrees(plan.origin[0]))
    told = [(state["name"], state["kind"], state["phase"], state["does"]) for state in data["states"]]
    assert told == [(state.name, state.kind, state.phase or None, ACTIONS[state.kind]) for state in states_of(plan)]
    assert {phase for _, _, phase, _ in told} == {"ingress", "moor", "egress", None}
    there, moor, back = data["phases"]
    for held, transit in zip((there, back), plan.transits, strict=True):
        for row, point in zip(held.pop("waypoints"), transit.waypoints, strict=True):
            assert (row.pop("name"), row.pop("kind")) == (point.name, point.kind)
            assert off(plan, point, row.pop("latitude_deg"), row.pop("longitude_deg")) < 0.02
            expected = of_waypoint(transit, point)
            assert row == pytest.approx({key: expected[key] for key in row}, abs=1e-9)
            kept = {"east_m", "north_m", "course_deg", "leg_m", "duration_s", "duration_p99_s", "time_out_s"}
            assert set(row) == {*kept, "elapsed_s"}
        rule = transit.surfacing
        surfacing = held.pop("surfacing")
        assert [tuple(pair) for pair in surfacing.pop("table_m")] == list(rule.table)
        assert surfacing == {
            "interval_m": rule.interval,
            "interval_time_s": rule.interval_time,
            "surface_time_s": rule.surface_time,
            "surface_time_p99_s": rule.surface_time_p99,
            "extra_time_s": rule.extra_time,
            "extra_time_error_s": rule.extra_time_error,
        }
        assert held == {
            "name": transit.name,
            "kind": "transit",
            "depth_m": transit.depth,
            "speed_m_s": transit.speed,
            "arrival_radius_m": transit.arrival_radius,
            "duration_p99_s": transit.duration_p99,
            "time_out_s": of_course(transit)["time_out_s"],
        }
    (mooring,) = plan.moorings
    assert off(plan, mooring, moor.pop("latitude_deg"), moor.pop("longitude_deg")) < 0.02
    assert moor == {
        "name": "moor",
        "kind": "mooring",
        "east_m": mooring.east,
        "north_m": mooring.north,
        "radius_m": mooring.radius,
        "water_depth_m": mooring.water_depth,
        "line_length_m": mooring.line_length,
        "anchor_wet_weight_n": mooring.anchor_wet_weight,
        "release_time_s": mooring.release_time,
        "release_time_p99_s": mooring.release_time_p99,
        "hold_s": mooring.hold,
        "galvanic_release_s": mooring.galvanic_release,
        "elapsed_s": mooring.elapsed,
    }


# maps


def test_gpx(plan):
    gpxpy = pytest.importorskip("gpxpy")
    gpx = gpxpy.parse(content(plan, "gpx"))
    assert gpx.time == plan.start
    assert [(route.name, route.number) for route in gpx.routes] == [("ingress", 1), ("egress", 2)]
    for route, transit in zip(gpx.routes, plan.transits, strict=True):
        expected = known(of_course(transit), "depth_m", "speed_m_s", "surface_time_s")
        assert extensions(route) == {**expected, "arrival_radius_m": transit.arrival_radius}
        said = f"at {transit.depth} m and {transit.speed} m/s, surfacing every {transit.surfacing.interval:g} m"
        assert route.description == said
        for point, waypoint in zip(route.points, transit.waypoints, strict=True):
            of_gpx(plan, point, waypoint, waypoint.kind, of_waypoint(transit, waypoint))
    for point, mooring in zip(gpx.waypoints, plan.moorings, strict=True):
        of_gpx(plan, point, mooring, "mooring", of_mooring(mooring))


def of_gpx(plan, point, planned, kind, numbers):
    assert (point.name, point.type) == (planned.name, kind)
    assert off(plan, planned, point.latitude, point.longitude) < 0.02
    assert -point.elevation == numbers["depth_m"]
    assert extensions(point) == pytest.approx(known(numbers, "east_m", "north_m"))


def extensions(point):
    texts = [element.text for element in point.extensions]
    assert texts == [f"{float(text):.10g}" for text in texts]  # no digits that say nothing
    return {element.tag.split("}")[-1]: float(element.text) for element in point.extensions}


def test_geojson(plan):
    collection = json.loads(content(plan, "geojson"))
    assert collection["mission_sha256"] == plan.digest
    features = iter(collection["features"])
    for phase in plan.phases:
        transit = phase if phase in plan.transits else None
        if transit:
            geometry, own = next_of(features, "planned track", "ingress" if transit is plan.phases[0] else "egress")
            assert own == {"name": f"{transit.name}: planned track", **of_course(transit)}
            lines = coordinates(geometry, "LineString", crosses(transit))
            places = [place for line in lines for place in line if abs(place[0]) != 180.0]
            assert len(lines) == 1 + crosses(transit)
            for place, waypoint in zip(places, transit.waypoints, strict=True):
                assert off(plan, waypoint, place[1], place[0]) < 0.02
        for point in transit.waypoints if transit else (phase,):
            geometry, own = next_of(features, "waypoint" if transit else "mooring", phase.name)
            assert own.pop("name") == point.name
            assert own.pop("waypoint", "mooring") == getattr(point, "kind", "mooring")
            numbers = of_waypoint(transit, point) if transit else of_mooring(point)
            assert off(plan, point, *reversed(geometry["coordinates"])) < 0.02
            assert off(plan, point, own.pop("latitude_deg"), own.pop("longitude_deg")) < 0.02
            assert own == pytest.approx(numbers, abs=1e-9)
        radius = transit.arrival_radius if transit else phase.radius
        kind = "arrival circle" if transit else "mooring circle"
        geometry, own = next_of(features, kind, phase.name)
        assert own == {"name": f"{phase.name}: {kind}, {radius:.3g} m", "radius_m": radius}
        goal = transit.goal if transit else phase
        areas = coordinates(geometry, "Polygon", abs(across(plan) - goal.east) < radius)
        assert all(ring[0] == ring[-1] for (ring,) in areas)
        is_circle(plan, [place for (ring,) in areas for place in ring], goal, radius)
    assert next(features, None) is None


def next_of(features, kind, phase):
    """Geometry of the next feature, and its own properties: not those by which viewers colour it."""
    feature = next(features)
    own = dict(feature["properties"])
    assert (own.pop("kind"), own.pop("phase")) == (kind, phase)
    style = {key: own.pop(key) for key in list(own) if key.startswith(("stroke", "fill", "marker"))}
    assert COLOURS[kind] in style.values()
    return feature["geometry"], own


def coordinates(geometry, kind, cut):
    """Coordinates of the parts of a geometry, which has several where the antimeridian cuts it."""
    assert geometry["type"] == (f"Multi{kind}" if cut else kind)
    return geometry["coordinates"] if cut else [geometry["coordinates"]]


def across(plan):
    """How far the antimeridian is east of the origin [m]."""
    latitude, longitude = np.degrees(plan.origin)
    azimuth, _, distance = GEOD.inv(longitude, latitude, 180.0, latitude)
    return distance * np.sin(np.radians(azimuth))


def crosses(transit):
    """How often a transit goes from one side of the antimeridian to the other."""
    longitudes = np.array([waypoint.longitude for waypoint in transit.waypoints])
    longitudes = (longitudes + np.pi) % (2.0 * np.pi) - np.pi
    return int((np.abs(np.diff(longitudes)) > np.pi).sum())


def test_the_antimeridian_cuts_what_it_is_to_cut():
    assert [crosses(transit) for transit in PLANS["date line"].transits] == [1, 1]
    assert abs(across(PLANS["circles on it"]) - PLANS["circles on it"].moorings[0].east) < 15.0


@pytest.mark.parametrize("side", [180.0, -180.0])
def test_a_line_that_ends_on_the_antimeridian_is_cut_there(side):
    """A point on it has either sign, so that a line may go on along it."""
    assert parts([[side, 1.0], [-side, 3.0]]) == [[[side, 1.0], [side, 1.0]], [[-side, 1.0], [-side, 3.0]]]
    assert parts([[0.9 * side, 0.0], [-0.9 * side, 4.0]]) == [
        [[0.9 * side, 0.0], [side, 2.0]],
        [[-side, 2.0], [-0.9 * side, 4.0]],
    ]
    assert parts([[side, 1.0], [0.5 * side, 3.0]]) == [[[side, 1.0], [0.5 * side, 3.0]]]


def test_viewers_colour_lines_areas_and_points():
    """simplestyle 1.1; KML writes alpha, blue, green, red."""
    line = {"stroke": "#56b4e9", "stroke-width": 1.0, "stroke-opacity": 0.4}
    assert simplestyle("sample track", "LineString") == line
    area = {"stroke": "#e69f00", "stroke-width": 2.0, "fill": "#e69f00", "fill-opacity": 0.05}
    assert simplestyle("mooring circle", "Polygon") == area
    assert simplestyle("mooring", "Point") == {"marker-color": "#cc79a7", "marker-size": "small"}
    assert kml_colour("mooring circle") == "ff009fe6"
    assert kml_colour("sample track", 102) == "66e9b456"


def test_forms_without_positions_on_earth_need_no_origin():
    need = {name: format_named(name).NEEDS_ORIGIN for name in FORMATS}
    assert {name for name in need if not need[name]} == {"csv", "json", "svg", "moos"}
    plan = replace(PLANS["west"], origin=None)
    for name in ("csv", "json"):
        assert "731.5" in content(plan, name)


def test_geojson_is_what_other_programs_read(plan):
    geopandas = pytest.importorskip("geopandas")
    frame = geopandas.read_file(io.StringIO(content(plan, "geojson")))
    assert frame.geometry.is_valid.all()
    assert len(frame) == 7 + 1 + 2 + 3


def test_kml(plan):
    fastkml = pytest.importorskip("fastkml")
    kml = fastkml.KML.from_string(content(plan, "kml").encode(), strict=True)
    (document,) = kml.features
    assert plan.digest in document.description
    for folder, phase in zip(document.features, plan.phases, strict=True):
        marks = iter(folder.features)
        transit = phase if phase in plan.transits else None
        if transit:
            track = next(marks)
            assert track.name == f"{phase.name}: planned track"
            assert data_of(track) == of_course(transit)
            lines = [line.coords for line in (track.geometry.geoms if crosses(transit) else [track.geometry])]
            places = [place for line in lines for place in line if abs(place[0]) != 180.0]
            assert len(lines) == 1 + crosses(transit)
            for place, waypoint in zip(places, transit.waypoints, strict=True):
                assert off(plan, waypoint, place[1], place[0]) < 0.02
        for point in transit.waypoints if transit else (phase,):
            mark = next(marks)
            assert mark.name == point.name
            numbers = of_waypoint(transit, point) if transit else of_mooring(point)
            held = data_of(mark)
            assert off(plan, point, mark.geometry.y, mark.geometry.x) < 0.02
            assert off(plan, point, held.pop("latitude_deg"), held.pop("longitude_deg")) < 0.02
            assert held == pytest.approx(known(numbers))
        ring = next(marks)
        radius = transit.arrival_radius if transit else phase.radius
        assert ring.name.endswith(f"circle, {radius:.3g} m")
        goal = transit.goal if transit else phase
        areas = ring.geometry.geoms if abs(across(plan) - goal.east) < radius else [ring.geometry]
        is_circle(plan, [place for area in areas for place in area.exterior.coords], goal, radius)
        assert next(marks, None) is None
    styles = {f"#{style.id}" for style in document.styles}
    assert {mark.style_url.url for folder in document.features for mark in folder.features} <= styles


def test_a_track_in_kml_tells_when_it_begins_and_ends_and_is_drawn_as_its_kind_is():
    """A span for what lasts, a stamp for what has one time, nothing for what has none; lists are no data."""
    times, elapsed = ["2026-06-01T12:00:00Z", "2026-06-01T12:10:00Z", "2026-06-01T12:30:00Z"], [3.0, 603.25, 1803.5]
    line = [[-76.0, 37.0], [-76.1, 37.1], [-76.2, 37.3]]
    marks = [
        line_feature(line, kind, name=kind, elapsed_s=elapsed, coordTimes=times, phase="out", depth_m=2.0, trial=7)
        for kind in ("planned track", "median track", "sample track")
    ]
    fixed = feature("Point", line[0], "fix", name="fix", time=times[1], elapsed_s=603.25, note=None)
    untimed = feature("Point", line[0], "anchor", name="anchor")
    root = ElementTree.fromstring(kml("made", "words", {"all": [*marks, fixed, untimed]}))
    found = root.findall(".//{*}Placemark")
    data = [{each.get("name"): each.find("{*}value").text for each in mark.findall(".//{*}Data")} for mark in found]
    for mark, held in zip(found[:3], data[:3], strict=True):
        assert (mark.find("{*}TimeSpan/{*}begin").text, mark.find("{*}TimeSpan/{*}end").text) == (times[0], times[2])
        assert (float(held["begin_s"]), float(held["end_s"])) == (3.0, 1803.5)
        assert not {"elapsed_s", "coordTimes"} & set(held)
        assert (float(held["depth_m"]), held["trial"], held["phase"]) == (2.0, "7", "out")
    assert found[3].find("{*}TimeStamp/{*}when").text == times[1]
    assert float(data[3]["elapsed_s"]) == 603.25
    assert "note" not in data[3]
    assert found[4].find("{*}TimeStamp") is None
    assert found[4].find("{*}TimeSpan") is None
    styles = {each.get("id"): each for each in root.findall(".//{*}Style")}
    assert set(styles) == {"planned-track", "median-track", "sample-track", "fix", "anchor"}
    drawn = {
        key: (each.find("{*}LineStyle/{*}color").text, float(each.find("{*}LineStyle/{*}width").text))
        for key, each in styles.items()
    }
    assert drawn["planned-track"] == ("ff666666", 2.0)
    assert drawn["median-track"] == ("ff005ed5", 3.0)
    assert drawn["sample-track"] == ("66e9b456", 1.0)  # four tenths as dense: many lie over each other
    assert drawn["fix"] == ("ff739e00", 2.0)
    assert {each.find("{*}IconStyle/{*}color").text for each in styles.values()} == {
        "ff666666",
        "ff005ed5",
        "ffe9b456",
        "ff739e00",
        "ffa779cc",
    }
    assert {each.find("{*}PolyStyle/{*}fill").text for each in styles.values()} == {"0"}


def data_of(mark):
    held = {item.name: item.value for item in mark.extended_data.elements}
    return {key: float(value) for key, value in held.items() if key not in ("name", "phase", "kind")}


def test_geopackage(plan, tmp_path):
    geopandas, pyogrio = pytest.importorskip("geopandas"), pytest.importorskip("pyogrio")
    path = tmp_path / "trip.gpkg"
    path.write_bytes(content(plan, "gpkg"))
    assert {name for name, _ in pyogrio.list_layers(path)} == {"waypoints", "courses", "circles"}
    info = pyogrio.read_info(path, layer="waypoints")
    assert info["layer_metadata"]["mission_sha256"] == plan.digest
    waypoints, courses, circles = (
        geopandas.read_file(path, layer=name) for name in ("waypoints", "courses", "circles")
    )
    assert {layer.crs.to_epsg() for layer in (waypoints, courses, circles)} == {4326}
    for row, (point, phase, kind, numbers) in zip(waypoints.to_dict("records"), points(plan), strict=True):
        assert (row.pop("name"), row.pop("phase"), row.pop("kind")) == (point.name, phase, kind)
        place = row.pop("geometry")
        assert off(plan, point, place.y, place.x) < 0.02
        assert off(plan, point, row.pop("latitude_deg"), row.pop("longitude_deg")) < 0.02
        assert read(row) == pytest.approx(numbers, abs=1e-9)
    for row, transit in zip(courses.to_dict("records"), plan.transits, strict=True):
        line = row.pop("geometry")
        places = [place for part in getattr(line, "geoms", [line]) for place in part.coords if abs(place[0]) != 180.0]
        for place, waypoint in zip(places, transit.waypoints, strict=True):
            assert off(plan, waypoint, place[1], place[0]) < 0.02
        assert row == {"phase": transit.name, **of_course(transit)}
    assert circles.geometry.is_valid.all()
    for row, phase in zip(circles.to_dict("records"), plan.phases, strict=True):
        goal, radius = (phase, phase.radius) if phase in plan.moorings else (phase.goal, phase.arrival_radius)
        kind = "mooring circle" if phase in plan.moorings else "arrival circle"
        assert (row["phase"], row["kind"], row["radius_m"]) == (phase.name, kind, radius)
        area = row["geometry"]
        ring = [place for part in getattr(area, "geoms", [area]) for place in part.exterior.coords]
        is_circle(plan, ring, goal, radius)


@pytest.mark.parametrize("legs", [0, 1, 2])
def test_a_course_of_one_leg_is_a_line_and_a_point_is_none(legs):
    plan = PLANS["west"]
    there, *others = plan.phases
    short = replace(there, waypoints=there.waypoints[: legs + 1], aim=None)
    features = json.loads(content(replace(plan, phases=(short, *others)), "geojson"))["features"]
    lines = [
        each["geometry"]["coordinates"] for each in features if each["properties"]["name"] == "ingress: planned track"
    ]
    assert [len(line) for line in lines] == [legs + 1] * (legs > 0)
